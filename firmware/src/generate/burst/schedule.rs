//! Schedule of the gate, in samples.

use heapless::Vec;

use super::Burst;
use super::duty::Dithered;
use crate::seam::config::{self, MAX_WINDOWS, Schedule as ScheduleConfig};
use crate::seam::error::Error;

/// Schedule of the gate, in samples.
#[derive(Clone, Debug)]
pub(super) enum Schedule {
    Continuous,
    Windows {
        windows: Vec<(u64, u64), MAX_WINDOWS>,
        /// Sample at which the schedule started. It has been added to the windows.
        from: u64,
    },
    Periodic {
        period: u64,
        on: u64,
        /// First sample of the latest period.
        begins: u64,
        /// Mean of `on`, if it is set while running.
        dithered: Option<Dithered>,
    },
}

impl Schedule {
    pub(super) fn build(config: &ScheduleConfig, sample_hz: f64) -> Result<Self, Error> {
        let samples = |seconds: f64| libm::round(seconds * sample_hz) as u64;
        Ok(match config {
            ScheduleConfig::Continuous => Schedule::Continuous,
            ScheduleConfig::Windows(windows) => {
                let windows: Vec<_, MAX_WINDOWS> = windows.iter().map(|&(on, off)| (samples(on), samples(off))).collect();
                let in_order = windows.iter().all(|w| w.0 < w.1) && windows.windows(2).all(|pair| pair[0].1 <= pair[1].0);
                if !in_order {
                    return Err(Error::BurstWindows);
                }
                Schedule::Windows { windows, from: 0 }
            }
            &ScheduleConfig::Periodic { period_s, duty } => {
                config::Burst::PERIOD_S.check_within(period_s, 1.0 / sample_hz, f64::INFINITY)?;
                let period = samples(period_s);
                Schedule::Periodic { period, on: libm::round(duty * period as f64) as u64, begins: 0, dithered: None }
            }
        })
    }

    /// Starts the schedule at a sample: windows and periods are counted from this sample.
    pub(super) fn begin(&mut self, sample: u64) {
        match self {
            Schedule::Continuous => (),
            Schedule::Windows { windows, from } => {
                let later = sample - *from;
                windows.iter_mut().for_each(|(on, off)| (*on, *off) = (*on + later, *off + later));
                *from = sample;
            }
            Schedule::Periodic { begins, .. } => *begins = sample,
        }
    }

    /// Sets the mean ON time of a periodic gate, samples, spread over `spread`, from the next
    /// period on.
    pub(super) fn set_on(&mut self, samples: f32, spread: f32) {
        if let Schedule::Periodic { dithered, .. } = self {
            *dithered = Some(Dithered::continuing(*dithered, samples, spread));
        }
    }

    /// Returns `true` if the gate is open at sample `now`, and the number of samples for which it
    /// stays so.
    pub(super) fn gate(&mut self, now: u64) -> (bool, u64) {
        match self {
            Schedule::Continuous => (true, u64::MAX),
            Schedule::Windows { windows, .. } => windows
                .iter()
                .find_map(|&(on, off)| match now {
                    n if n < on => Some((false, on - n)),
                    n if n < off => Some((true, off - n)),
                    _ => None,
                })
                .unwrap_or((false, u64::MAX)),
            Schedule::Periodic { period, on, begins, dithered } => {
                // Usually the same period, or the next: a 64-bit division takes longer than the
                // rest.
                let mut phase = now.wrapping_sub(*begins);
                if phase >= *period {
                    phase = if phase < 2 * *period { phase - *period } else { phase % *period };
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

impl Burst {
    /// Starts the schedule at a sample.
    pub(crate) fn begin_schedule(&mut self, sample: u64) {
        self.schedule.begin(sample);
    }

    /// Returns `true` if the schedule repeats a burst.
    pub(crate) fn repeats(&self) -> bool {
        matches!(self.schedule, Schedule::Periodic { .. })
    }

    /// Sets the mean ON time of periodic bursts, samples, from the next period on.
    pub(crate) fn set_on(&mut self, samples: f32) {
        self.schedule.set_on(samples, self.period_of_drive);
    }
}
