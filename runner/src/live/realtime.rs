//! Real-time scheduling, locked memory and processor affinity.

/// Priority among the real-time threads: above the ordinary, below the kernel's own.
#[cfg(target_os = "linux")]
const PRIORITY: u8 = 50;

/// Requests first-in-first-out scheduling of this thread, locked memory and one processor, and reports which of them were
/// granted.
#[cfg(target_os = "linux")]
#[must_use]
pub fn request(realtime: bool, core: Option<usize>) -> String {
    let mut results = Vec::new();
    if realtime {
        results.push(first_in_first_out());
        results.push(locked_memory());
    }
    results.extend(core.map(only_on));
    if results.is_empty() { "ordinary scheduling".to_owned() } else { results.join("; ") }
}

#[cfg(target_os = "linux")]
fn first_in_first_out() -> String {
    use thread_priority::{
        RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
        set_thread_priority_and_policy, thread_native_id,
    };
    let priority = ThreadPriorityValue::try_from(PRIORITY).map(ThreadPriority::Crossplatform);
    let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    let set = priority
        .map_err(|e| e.to_string())
        .and_then(|p| set_thread_priority_and_policy(thread_native_id(), p, fifo).map_err(|e| format!("{e:?}")));
    match set {
        Ok(()) => format!("SCHED_FIFO, priority {PRIORITY}"),
        Err(error) => format!("SCHED_FIFO not permitted ({error}); allowed with the capability CAP_SYS_NICE"),
    }
}

#[cfg(target_os = "linux")]
fn locked_memory() -> String {
    use nix::sys::mman::{MlockAllFlags, mlockall};
    match mlockall(MlockAllFlags::MCL_CURRENT) {
        Ok(()) => "memory locked".to_owned(),
        Err(error) => format!("memory not locked ({error}); allowed with a higher limit of locked memory (ulimit -l)"),
    }
}

#[cfg(target_os = "linux")]
fn only_on(core: usize) -> String {
    use nix::sched::{CpuSet, sched_setaffinity};
    let mut set = CpuSet::new();
    let done = set.set(core).and_then(|()| sched_setaffinity(nix::unistd::Pid::from_raw(0), &set));
    match done {
        Ok(()) => format!("on processor {core} only"),
        Err(error) => format!("not bound to processor {core} ({error})"),
    }
}

/// Reports that other systems have no real-time scheduling.
#[cfg(not(target_os = "linux"))]
#[must_use]
pub fn request(realtime: bool, core: Option<usize>) -> String {
    if realtime || core.is_some() {
        "ordinary scheduling: real-time scheduling, locked memory and processor affinity are available on Linux only"
            .to_owned()
    } else {
        "ordinary scheduling".to_owned()
    }
}
