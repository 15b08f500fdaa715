//! Threads that give way to all others of the process.

/// The calling thread gets what processor time the others leave: the user's window and drawing come first. It is only slower
/// where this cannot be had.
#[cfg(target_os = "linux")]
pub fn give_way() {
    // Linux takes priorities by thread. Lowering one's own is always allowed.
    let _ = rustix::process::setpriority_process(Some(rustix::thread::gettid()), 19);
}

/// Priorities are of whole processes here: nothing is done.
#[cfg(not(target_os = "linux"))]
pub fn give_way() {}
