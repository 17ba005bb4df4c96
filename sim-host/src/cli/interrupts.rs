//! Requests to end this program: Ctrl-C, SIGTERM, and SIGHUP of a closed terminal.
//!
//! The first request sets a flag, so that the current work ends in order: a drive is silenced, and
//! a result is written and marked as interrupted. Requests within the following second are ignored:
//! a terminal that closes sends two, one from the kernel and one from the shell. A later request
//! ends the program immediately.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::Exit;

/// Time after the first request during which further requests are ignored.
const REPEAT_WINDOW: Duration = Duration::from_secs(1);

/// Sets `stop` at the first request to end.
pub(super) fn set(stop: &'static AtomicBool) -> std::io::Result<()> {
    set_with_end(stop, stop)
}

/// Sets `stop` at every request, and also `end` at any request but Ctrl-C.
///
/// Ctrl-C may end only the current work; a caller that continues then clears `stop`.
pub(super) fn set_with_end(stop: &'static AtomicBool, end: &'static AtomicBool) -> std::io::Result<()> {
    let mut first = Instant::now();
    listen(move |is_ctrl_c| {
        let again = stop.swap(true, Ordering::Relaxed);
        if !is_ctrl_c {
            end.store(true, Ordering::Relaxed);
        }
        if !again {
            first = Instant::now();
        } else if first.elapsed() >= REPEAT_WINDOW {
            std::process::exit(Exit::Interrupted as i32)
        }
    })
    .map_err(|error| std::io::Error::other(format!("cannot listen for Ctrl-C: {error}")))
}

#[cfg(unix)]
fn listen(mut request: impl FnMut(bool) + Send + 'static) -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    // A program that is started with `nohup` must outlive the terminal.
    if !ignores_hang_up() {
        signals.add_signal(SIGHUP)?;
    }
    std::thread::Builder::new()
        .name("interrupts".into())
        .spawn(move || signals.forever().for_each(|signal| request(signal == SIGINT)))
        .map(drop)
}

#[cfg(not(unix))]
fn listen(mut request: impl FnMut(bool) + Send + 'static) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(move || request(true))
}

/// Returns `true` if the system reports that SIGHUP was ignored when this program was started.
#[cfg(unix)]
fn ignores_hang_up() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    mask & 1 << (signal_hook::consts::SIGHUP - 1) != 0
}
