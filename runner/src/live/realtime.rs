//! Real-time scheduling, locked memory and processor affinity.

/// Priority among real-time threads (1 to 99): below the threads of the operating system.
#[cfg(target_os = "linux")]
const PRIORITY: u8 = 50;

/// Requests first-in-first-out scheduling of this thread, locked memory and one processor, and reports which of them were
/// granted.
#[cfg(target_os = "linux")]
#[must_use]
pub fn request(realtime: bool, core: Option<usize>) -> String {
    let mut results = Vec::new();
    if realtime {
        results.push(request_fifo_scheduling());
        results.push(lock_memory());
    }
    results.extend(core.map(bind_to_processor));
    if results.is_empty() { "ordinary scheduling".to_owned() } else { results.join("; ") }
}

#[cfg(target_os = "linux")]
fn request_fifo_scheduling() -> String {
    use thread_priority::{
        RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
        set_thread_priority_and_policy, thread_native_id,
    };
    let priority = ThreadPriorityValue::try_from(PRIORITY).map(ThreadPriority::Crossplatform);
    let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    let result = priority
        .map_err(|e| e.to_string())
        .and_then(|p| set_thread_priority_and_policy(thread_native_id(), p, fifo).map_err(|e| format!("{e:?}")));
    match result {
        Ok(()) => format!("SCHED_FIFO, priority {PRIORITY}"),
        Err(error) => format!("SCHED_FIFO not granted ({error}); it requires the capability CAP_SYS_NICE"),
    }
}

#[cfg(target_os = "linux")]
fn lock_memory() -> String {
    use nix::sys::mman::{MlockAllFlags, mlockall};
    match mlockall(MlockAllFlags::MCL_CURRENT) {
        Ok(()) => "memory locked".to_owned(),
        Err(error) => format!("memory not locked ({error}); it requires a higher limit of locked memory (ulimit -l)"),
    }
}

#[cfg(target_os = "linux")]
fn bind_to_processor(core: usize) -> String {
    use nix::sched::{CpuSet, sched_setaffinity};
    let mut set = CpuSet::new();
    let result = set.set(core).and_then(|()| sched_setaffinity(nix::unistd::Pid::from_raw(0), &set));
    match result {
        Ok(()) => format!("on processor {core} only"),
        Err(error) => format!("not bound to processor {core} ({error})"),
    }
}

/// Returns a note that real-time scheduling is available on Linux only.
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
