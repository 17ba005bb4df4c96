//! Progress of a sweep on standard error, with the rate and the remaining time: a bar on a
//! terminal, otherwise a line every ten seconds.

use std::io::{self, IsTerminal};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Time between two lines if standard error is not a terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// Progress towards a number of points.
pub(in crate::cli) struct Progress {
    bar: Option<ProgressBar>,
    whole: u64,
    done: AtomicU64,
    began: Instant,
    last_line: Mutex<Instant>,
    quiet: bool,
}

impl Progress {
    pub(in crate::cli) fn new(whole: u64, quiet: bool) -> Self {
        let bar = (!quiet && io::stderr().is_terminal()).then(|| {
            let style = ProgressStyle::with_template("{bar:40} {pos} of {len} points  {per_sec}  {eta} remain");
            let bar = ProgressBar::new(whole);
            style.map(|style| bar.clone().with_style(style)).unwrap_or(bar)
        });
        Progress { bar, whole, done: AtomicU64::new(0), began: Instant::now(), last_line: Mutex::new(Instant::now()), quiet }
    }

    /// Counts one more finished point.
    pub(in crate::cli) fn point(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        if let Some(bar) = &self.bar {
            bar.inc(1);
        } else if !self.quiet
            && let Ok(mut last) = self.last_line.try_lock()
            && last.elapsed() >= LINE_EVERY
        {
            *last = Instant::now();
            let rate = done as f64 / self.began.elapsed().as_secs_f64();
            let left_s = self.whole.saturating_sub(done) as f64 / rate;
            say!("{done} of {} points, {rate:.1} per second, about {left_s:.0} s remain", self.whole);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
