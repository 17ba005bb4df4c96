//! Record of a contact study: the last periods step by step, and the extremes of the whole run in
//! bins. Its size is bounded for runs of any length.

use contact::State;

/// Number of periods that are recorded step by step.
const LAST_PERIODS: f64 = 4.0;
/// Maximum number of states of the last periods; whenever it is reached, every second state is
/// dropped.
const MAX_STATES: usize = 1 << 14;
/// Approximate maximum number of bins of the whole run.
const BINS: f64 = 1000.0;
/// Number of periods below which a bin is shorter than a period.
const FEW_PERIODS: f64 = 50.0;

/// Playback of a run.
#[derive(Clone, Debug)]
pub struct Playback {
    duration_s: f64,
    frequency_hz: f64,
    /// States of the last periods.
    last: Vec<State>,
    every: u32,
    skipped: u32,
    in_last_periods: bool,
    bin_s: f64,
    bins: Vec<Bin>,
    open: Bin,
    /// Time after which the open bin is full, s.
    full_s: f64,
    /// Beginning of the last periods, s.
    last_from_s: f64,
    /// Previous state; its time is NaN before the first.
    before: State,
}

/// Returns the time after which a bin is full; a step that ends with the bin, within round-off,
/// belongs to it.
fn full_s(bin: &Bin, bin_s: f64) -> f64 {
    bin.end_s + 1e-9 * bin_s
}

/// Range of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Smallest value.
    pub least: f64,
    /// Largest value.
    pub most: f64,
}

/// Part of a run.
#[derive(Clone, Copy, Debug)]
pub struct Bin {
    /// End of the bin, s.
    pub end_s: f64,
    /// Range of the friction, N.
    pub friction_n: Range,
    /// Range of the velocity x', m/s.
    pub velocity_m_per_s: Range,
    /// Range of the displacement x, m.
    pub displacement_m: Range,
    /// Integral of friction over the bin by the trapezoidal rule, N s.
    friction_n_s: f64,
    /// Length of the recorded part of the bin, s.
    seen_s: f64,
}

impl Range {
    const NOTHING: Range = Range { least: f64::INFINITY, most: f64::NEG_INFINITY };

    /// Returns the middle of the range.
    pub fn middle(&self) -> f64 {
        0.5 * (self.least + self.most)
    }

    /// Multiplies the range by a factor.
    pub fn times(&self, factor: f64) -> Range {
        Range { least: factor * self.least, most: factor * self.most }
    }

    #[inline]
    fn take(&mut self, value: f64) {
        // `f64::min` handles NaN and takes three times as long.
        self.least = if value < self.least { value } else { self.least };
        self.most = if value > self.most { value } else { self.most };
    }
}

impl Bin {
    fn until(end_s: f64) -> Self {
        let nothing = Range::NOTHING;
        Bin { end_s, friction_n: nothing, velocity_m_per_s: nothing, displacement_m: nothing, friction_n_s: 0.0, seen_s: 0.0 }
    }

    /// Returns the mean friction in the bin, N.
    pub fn mean_friction_n(&self) -> f64 {
        self.friction_n_s / self.seen_s
    }
}

impl Playback {
    /// Creates an empty playback for a run of this duration, with periods of this frequency.
    pub fn new(duration_s: f64, frequency_hz: f64) -> Self {
        let periods = duration_s * frequency_hz;
        let bin_s = if periods < FEW_PERIODS { duration_s / BINS } else { (periods / BINS).ceil().max(1.0) / frequency_hz };
        let open = Bin::until(bin_s);
        Playback {
            duration_s,
            frequency_hz,
            last: Vec::new(),
            every: 1,
            skipped: 0,
            in_last_periods: false,
            bin_s,
            bins: Vec::new(),
            full_s: full_s(&open, bin_s),
            open,
            last_from_s: duration_s - (LAST_PERIODS + 1e-9) / frequency_hz,
            before: State { time_s: f64::NAN, ..State::default() },
        }
    }

    /// Records a state; returns `true` if a bin is full. If time decreases, another run begins.
    #[inline]
    pub fn add(&mut self, state: &State) -> bool {
        let step_s = state.time_s - self.before.time_s;
        if step_s < 0.0 {
            *self = Playback::new(self.duration_s, self.frequency_hz);
        }
        self.skipped += 1;
        if self.skipped >= self.every || (state.time_s >= self.last_from_s && !self.in_last_periods) {
            self.record(state);
        }
        let full = state.time_s > self.full_s;
        if full {
            self.turn(state.time_s);
        }
        let open = &mut self.open;
        open.friction_n.take(state.force_n);
        open.velocity_m_per_s.take(state.v_m_per_s);
        open.displacement_m.take(state.x_m);
        // The first state has no step.
        if step_s > 0.0 {
            open.friction_n_s += 0.5 * step_s * (self.before.force_n + state.force_n);
            open.seen_s += step_s;
        }
        self.before = *state;
        full
    }

    /// Ends the recording.
    pub fn finish(&mut self) {
        let end_s = self.before.time_s;
        if self.open.seen_s > 0.0 {
            self.bins.push(Bin { end_s, ..self.open });
            self.open = Bin::until(end_s + self.bin_s);
        }
        let from_s = end_s - (LAST_PERIODS + 1e-9) / self.frequency_hz;
        self.last.retain(|state| state.time_s >= from_s);
    }

    /// Returns the last periods, step by step or nearly so; for a closed form, one steady period.
    pub fn last_periods(&self) -> &[State] {
        &self.last
    }

    /// Returns the bins of the whole run.
    pub fn bins(&self) -> &[Bin] {
        &self.bins
    }

    fn record(&mut self, state: &State) {
        if state.time_s >= self.last_from_s && !self.in_last_periods {
            self.in_last_periods = true;
            self.last.clear();
            self.every = 1;
        }
        self.skipped = 0;
        self.last.push(*state);
        if self.last.len() >= MAX_STATES {
            let mut odd = false;
            self.last.retain(|_| {
                odd = !odd;
                odd
            });
            self.every = self.every.saturating_mul(2);
        }
    }

    fn turn(&mut self, time_s: f64) {
        let bin = self.open;
        if bin.seen_s > 0.0 {
            self.bins.push(bin);
        }
        // A step may be longer than a bin.
        let ahead = ((time_s - bin.end_s) / self.bin_s - 1e-9).floor().max(0.0) + 1.0;
        self.open = Bin::until(bin.end_s + ahead * self.bin_s);
        self.full_s = full_s(&self.open, self.bin_s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Records a run of `periods` periods of 1 Hz with `steps` steps each.
    fn recorded(periods: u32, steps: u32) -> Playback {
        let mut playback = Playback::new(f64::from(periods), 1.0);
        for step in 1..=periods * steps {
            let time_s = f64::from(step) / f64::from(steps);
            let (v_m_per_s, x_m) = (std::f64::consts::TAU * time_s).sin_cos();
            playback.add(&State { time_s, x_m, v_m_per_s, force_n: 2.0 + v_m_per_s });
        }
        playback.finish();
        playback
    }

    #[test]
    fn the_last_periods_are_whole_and_the_bins_cover_the_run() {
        let playback = recorded(200, 64);
        assert_eq!(playback.last_periods().len(), 4 * 64 + 1);
        assert_eq!((playback.bins().len(), playback.bins().last().unwrap().end_s), (200, 200.0));
        for bin in &playback.bins()[1..] {
            assert!((bin.mean_friction_n() - 2.0).abs() < 1e-12 && bin.displacement_m == Range { least: -1.0, most: 1.0 });
        }
    }

    #[test]
    fn memory_is_bounded() {
        for (periods, steps) in [(100_000, 16), (3, 1_000_000), (30_000, 100)] {
            let playback = recorded(periods, steps);
            assert!(playback.last_periods().len() <= MAX_STATES && playback.bins().len() <= 1001, "{periods} {steps}");
            assert!(playback.last_periods().len() > 60, "{periods} {steps}");
        }
    }

    #[test]
    fn a_run_that_restarts_is_recorded_again() {
        let mut playback = Playback::new(10.0, 1.0);
        for time_s in [1.0, 5.0, 9.9, 0.5, 1.0] {
            playback.add(&State { time_s, force_n: time_s, ..State::default() });
        }
        playback.finish();
        assert_eq!(playback.last_periods().iter().map(|state| state.time_s).collect::<Vec<_>>(), [0.5, 1.0]);
        assert!(playback.bins().iter().all(|bin| bin.friction_n.most <= 1.0));
    }
}
