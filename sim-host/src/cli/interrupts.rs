//! Requests to end this program: Ctrl-C, SIGTERM, and the hang-up of a closed terminal.
//!
//! The first one sets a flag, so that what is under way ends in order: a drive is silenced, a result is written and marked as interrupted.
//! Requests that follow at once are the same request: a terminal that closes sends two, one by the kernel and one by the shell. A later
//! one ends the program, whatever is under way.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::Exit;

/// How long after the first request further ones are taken for the same.
const SAME: Duration = Duration::from_secs(1);

/// Sets `stop` at the first request to end.
pub(super) fn set(stop: &'static AtomicBool) -> std::io::Result<()> {
    set_apart(stop, stop)
}

/// The same, with `end` set as well where the request is not Ctrl-C, which may end no more than what is under way. Whoever goes on takes `stop` back.
pub(super) fn set_apart(stop: &'static AtomicBool, end: &'static AtomicBool) -> std::io::Result<()> {
    let mut first = Instant::now();
    listen(move |is_ctrl_c| {
        let again = stop.swap(true, Ordering::Relaxed);
        if !is_ctrl_c {
            end.store(true, Ordering::Relaxed);
        }
        if !again {
            first = Instant::now();
        } else if first.elapsed() >= SAME {
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
    // A program that is started with `nohup` is to outlive the terminal.
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

/// Whether this program was started with the hang-up signal ignored, as far as the system says so.
#[cfg(unix)]
fn ignores_hang_up() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    mask & 1 << (signal_hook::consts::SIGHUP - 1) != 0
}
