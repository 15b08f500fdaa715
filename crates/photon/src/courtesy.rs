//! Threads that give way to all others of the process.

/// What [`give_way`] takes for threads that are to get only what the others leave.
pub const WHOLLY: i32 = 19;

/// The calling thread gets less processor time where others want it too: the user's window and drawing come first. From 0, as it is, to
/// [`WHOLLY`]. It is only slower where this cannot be had.
#[cfg(target_os = "linux")]
pub fn give_way(by: i32) {
    // Linux takes priorities by thread. Lowering one's own is always allowed.
    let _ = rustix::process::setpriority_process(Some(rustix::thread::gettid()), by);
}

/// Priorities are of whole processes here: nothing is done.
#[cfg(not(target_os = "linux"))]
pub fn give_way(_by: i32) {}
