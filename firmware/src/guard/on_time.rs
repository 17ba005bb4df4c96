//! The limit of the ON time. Each block OFF cancels one block ON, so that bursts count by the
//! excess of ON over OFF.

use crate::seam::config::Config;
use crate::seam::fault::Fault;

/// Timer of the drive's ON time.
#[derive(Clone, Debug)]
pub struct OnTime {
    /// Largest number of blocks ON; `u32::MAX` without a limit.
    most: u32,
    on: u32,
}

impl OnTime {
    /// Builds a timer with the configured limit.
    pub fn build(config: &Config, block_s: f32) -> Self {
        let Some(on_time_s) = config.limits.on_time_s else { return OnTime { most: u32::MAX, on: 0 } };
        OnTime { most: (on_time_s / block_s) as u32, on: 0 }
    }

    /// Counts one block, and returns a fault if the drive was ON for too long.
    pub fn inspect(&mut self, driving: bool) -> Option<Fault> {
        self.on = if driving { self.on.saturating_add(1) } else { self.on.saturating_sub(1) };
        (self.on > self.most).then_some(Fault::OnTimeExceeded)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bursts_count_by_the_excess_of_on_over_off() {
        let faults = |on: u32, off: u32, blocks: u32| {
            let mut clock = OnTime { most: 1000, on: 0 };
            (0..blocks).position(|n| clock.inspect(n % (on + off) < on).is_some())
        };
        assert_eq!(faults(1, 0, 2000), Some(1000));
        assert_eq!(faults(10, 10, 100_000), None);
        // One more ON than OFF in 21 blocks: 991 such periods and the last burst.
        assert!(faults(11, 10, 100_000).is_some_and(|blocks| (20_700..21_000).contains(&blocks)));
        assert_eq!(OnTime { most: u32::MAX, on: u32::MAX - 1 }.inspect(true), None);
    }
}
