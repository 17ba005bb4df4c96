//! Progress on standard error, in simulated seconds or runs: a bar on a terminal, otherwise a line
//! every ten seconds. Work without a known end shows its duration.

use std::io::{self, IsTerminal};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Time between two lines if standard error is not a terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);
/// Steps of the bar.
const STEPS: u64 = 1000;
/// Time between two pictures of work without a known end.
const FRAME_EVERY: Duration = Duration::from_millis(100);

/// Does some work without a known end, and shows its duration on a terminal.
pub(super) fn timed<T>(what: String, quiet: bool, work: impl FnOnce() -> T) -> T {
    let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
    let style = ProgressStyle::with_template("{spinner} {msg}  {elapsed}");
    let bar = style.map(|style| bar.clone().with_style(style)).unwrap_or(bar).with_message(what);
    bar.enable_steady_tick(FRAME_EVERY);
    let done = work();
    bar.finish_and_clear();
    done
}

/// Progress towards a simulated time, s, or towards a number of runs.
pub(super) struct Progress {
    bar: Option<ProgressBar>,
    began: Instant,
    last_line: Instant,
    whole: f64,
    runs: bool,
    quiet: bool,
}

impl Progress {
    pub(super) fn new(duration_s: f64, runs: u32, quiet: bool) -> Self {
        let bar = (!quiet && io::stderr().is_terminal()).then(|| {
            let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {elapsed} of about {duration}");
            let bar = ProgressBar::new(STEPS);
            style.map(|style| bar.clone().with_style(style)).unwrap_or(bar)
        });
        let (runs, whole) = (runs > 1, if runs > 1 { runs.into() } else { duration_s });
        Progress { bar, began: Instant::now(), last_line: Instant::now(), whole, runs, quiet }
    }

    /// Shows the simulated time, s, or the number of runs that has been reached.
    pub(super) fn at(&mut self, reached: f64) {
        // Runs are doubled until their interval is known.
        while self.runs && reached > self.whole {
            self.whole *= 2.0;
        }
        if let Some(bar) = &self.bar {
            bar.set_position((STEPS as f64 * reached / self.whole) as u64);
        } else if !self.quiet && self.last_line.elapsed() >= LINE_EVERY {
            self.last_line = Instant::now();
            let left_s = self.began.elapsed().as_secs_f64() * (self.whole / reached - 1.0);
            match self.runs {
                true => say!("{reached} of {} runs, about {left_s:.0} s remain", self.whole),
                false => say!("simulated {reached:.2} s of {} s, about {left_s:.0} s remain", self.whole),
            }
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
