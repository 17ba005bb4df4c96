//! When the gate is open, in samples since the first.

use heapless::Vec;

use crate::config::{MAX_WINDOWS, Schedule as ScheduleConfig};
use crate::error::{Error, in_range};

/// The longest time a schedule can name, s (three years).
const LONGEST_S: f64 = 1e8;

/// The gate's schedule, in samples.
#[derive(Clone, Debug)]
pub(super) enum Schedule {
    Continuous,
    Windows(Vec<(u64, u64), MAX_WINDOWS>),
    Periodic {
        period: u64,
        on: u64,
        /// A beginning of a period, the last that was needed.
        begins: u64,
        /// What `on` is to be on an average, where that is set while running.
        dithered: Option<Dithered>,
    },
}

/// An ON time that is spread from period to period. A burst lasts whole periods of the drive, which may keep step with those of the schedule: what is
/// spread evenly over one of them is rounded right on an average.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dithered {
    /// Samples, on an average and from the least to the most.
    mean: f32,
    spread: f32,
    /// In steps of the golden section, 2^32 a turn: evenly spread over any number of periods.
    turn: u32,
}

impl Dithered {
    fn next(&mut self, period: u64) -> u64 {
        const GOLDEN: u32 = 0x9e37_79b9;
        self.turn = self.turn.wrapping_add(GOLDEN);
        let part = (self.turn >> 8) as f32 / (1 << 24) as f32;
        libm::roundf(self.mean + (part - 0.5) * self.spread).clamp(0.0, period as f32) as u64
    }
}

impl Schedule {
    pub(super) fn build(config: &ScheduleConfig, sample_hz: f64) -> Result<Self, Error> {
        let samples =
            |parameter, seconds| in_range(parameter, seconds, 0.0, LONGEST_S).map(|s| libm::round(s * sample_hz) as u64);
        Ok(match config {
            ScheduleConfig::Continuous => Schedule::Continuous,
            ScheduleConfig::Windows(windows) => {
                let windows = windows
                    .iter()
                    .map(|&(on, off)| Ok((samples("burst.on_s", on)?, samples("burst.off_s", off)?)))
                    .collect::<Result<Vec<_, MAX_WINDOWS>, Error>>()?;
                let in_order = windows.iter().all(|w| w.0 < w.1) && windows.windows(2).all(|pair| pair[0].1 <= pair[1].0);
                if !in_order {
                    return Err(Error::BurstWindows);
                }
                Schedule::Windows(windows)
            }
            &ScheduleConfig::Periodic { period_s, duty } => {
                in_range("burst.duty", duty, 0.0, 1.0)?;
                in_range("burst.period_s", period_s, 1.0 / sample_hz, LONGEST_S)?;
                let period = samples("burst.period_s", period_s)?;
                Schedule::Periodic { period, on: libm::round(duty * period as f64) as u64, begins: 0, dithered: None }
            }
        })
    }

    /// From the next period on, a gate that repeats is open for so many samples on an average, spread over `spread`.
    pub(super) fn set_on(&mut self, samples: f32, spread: f32) {
        if let Schedule::Periodic { dithered, .. } = self {
            let turn = dithered.map_or(0, |dithered| dithered.turn);
            *dithered = Some(Dithered { mean: samples, spread, turn });
        }
    }

    /// Whether the gate is open at sample `now`, and for how many samples it stays so.
    pub(super) fn gate(&mut self, now: u64) -> (bool, u64) {
        match self {
            Schedule::Continuous => (true, u64::MAX),
            Schedule::Windows(windows) => windows
                .iter()
                .find_map(|&(on, off)| match now {
                    n if n < on => Some((false, on - n)),
                    n if n < off => Some((true, off - n)),
                    _ => None,
                })
                .unwrap_or((false, u64::MAX)),
            Schedule::Periodic { period, on, begins, dithered } => {
                // Mostly the same period, or the next: a division of 64 bits takes longer than the rest.
                let mut phase = now.wrapping_sub(*begins);
                if phase >= *period {
                    phase = if phase < 2 * *period { phase - *period } else { now % *period };
                    *begins = now - phase;
                    if let Some(dithered) = dithered {
                        *on = dithered.next(*period);
                    }
                }
                if phase < *on { (true, *on - phase) } else { (false, *period - phase) }
            }
        }
    }
}
