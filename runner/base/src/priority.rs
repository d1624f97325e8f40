//! Priority of threads.

/// Niceness of a thread whose result may be late: it has a tenth of the processor time of another where both wait for it.
#[cfg(target_os = "linux")]
const NICENESS: i32 = 10;

/// Lowers the priority of this thread below that of threads that process samples, where the system has priorities of threads and allows it.
pub fn lower() {
    #[cfg(target_os = "linux")]
    {
        // Without it the thread does the same work, and samples may be late.
        let _ = rustix::process::setpriority_process(Some(rustix::thread::gettid()), NICENESS);
    }
}
