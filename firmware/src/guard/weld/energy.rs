//! The energy budget: the largest electrical energy for each metre of belt.
//!
//! ```text
//! E(n + 1) = max(0, E(n) + P T - e dx),    P = Re(V I*) / 2
//! ```
//!
//! with the new ground `dx` of the block and the limit `e`, J/m. Over any stretch `dx` of belt the
//! drive gets at most `e (dx + L)`, with the contact length `L` = `CONTACT_M`; more is a fault. A
//! belt at rest gets `e L` in total, a belt slower than `P / e` not much more. The budget depends
//! on the encoder: a false count must be detected by the force channel, or is ended by
//! `limits.on_time_s`.

use crate::seam::config::Config;
use crate::seam::error::Error;
use crate::seam::fault::Fault;

/// Length of the contact along the belt, m (thesis 3.2: a tip of 10 mm).
pub(crate) const CONTACT_M: f32 = 0.01;

/// State of the energy budget.
#[derive(Clone, Debug)]
pub(crate) struct EnergyPerLength {
    block_s: f32,
    /// Energy allowed for one count of new ground, J; infinite without a limit.
    joule_per_count: f32,
    most_j: f32,
    spent_j: f32,
}

impl EnergyPerLength {
    /// Builds the budget. Returns an error if a limit is set but the length of a count is not.
    pub(crate) fn build(config: &Config, block_s: f32) -> Result<Self, Error> {
        let limit = config.limits.energy_j_per_m;
        let joule_per_count = match (limit, config.front_end.metre_per_count) {
            (Some(joule), Some(metre)) => joule * metre,
            (Some(_), None) => return Err(Error::EnergyWithoutBelt),
            (None, _) => f32::INFINITY,
        };
        let most_j = limit.map_or(f32::INFINITY, |joule| joule * CONTACT_M);
        Ok(EnergyPerLength { block_s, joule_per_count, most_j, spent_j: 0.0 })
    }

    /// Adds one block: its power, W, and its new ground, counts.
    pub(super) fn step(&mut self, power_w: f32, fresh: u32) -> Option<Fault> {
        if self.most_j == f32::INFINITY {
            return None;
        }
        let spent_j = self.spent_j + power_w * self.block_s - fresh as f32 * self.joule_per_count;
        // An energy that is not a number is kept, and is over the limit below.
        self.spent_j = if spent_j < 0.0 { 0.0 } else { spent_j };
        let within = self.spent_j <= self.most_j;
        if !within {
            // The fault ends the drive; the next drive starts from zero.
            self.spent_j = 0.0;
        }
        (!within).then_some(Fault::EnergyPerLength)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a budget of 100 J/m at 100 counts/mm: 1 mJ a count, and 1 J for the contact length.
    fn budget() -> EnergyPerLength {
        EnergyPerLength { block_s: 32e-6, joule_per_count: 1e-3, most_j: 1.0, spent_j: 0.0 }
    }

    #[test]
    fn a_belt_at_rest_gets_the_energy_of_the_contact_length() {
        let mut budget = budget();
        // At 500 W, 1 J is spent in 2 ms.
        let blocks = (0..1000).position(|_| budget.step(500.0, 0).is_some());
        assert_eq!(blocks, Some(62));
    }

    #[test]
    fn a_moving_belt_allows_speed_times_limit() {
        // A count every 10 blocks is 31 mm/s, which allows 3.1 W.
        for (watt, trips) in [(3.1, false), (3.3, true)] {
            let mut budget = budget();
            let tripped = (0..300_000).any(|n: u32| budget.step(watt, u32::from(n.is_multiple_of(10))).is_some());
            assert_eq!(tripped, trips, "{watt} W");
        }
    }

    #[test]
    fn a_nan_power_is_over_the_limit() {
        assert_eq!(budget().step(f32::NAN, 1), Some(Fault::EnergyPerLength));
    }

    fn built(joule_per_metre: Option<f32>, metre: Option<f32>) -> Result<EnergyPerLength, Error> {
        let mut config = crate::board::parameters::tests::config();
        (config.limits.energy_j_per_m, config.front_end.metre_per_count) = (joule_per_metre, metre);
        EnergyPerLength::build(&config, 32e-6)
    }

    #[test]
    fn a_limit_needs_the_length_of_a_count() {
        assert_eq!(built(Some(100.0), None).err(), Some(Error::EnergyWithoutBelt));
        // Without a limit no power is a fault.
        for metre in [None, Some(1e-5)] {
            let mut free = built(None, metre).unwrap();
            assert_eq!([1e9, f32::INFINITY, f32::NAN].map(|watt| free.step(watt, 0)), [None; 3]);
        }
    }

    #[test]
    fn the_limit_is_per_metre() {
        // One count a block: 1 mJ in 32 us is 31.25 W. A metre without drive restores the budget,
        // but saves nothing beyond it.
        for (watt, trips) in [(31.0, false), (31.5, true)] {
            let mut budget = built(Some(100.0), Some(1e-5)).unwrap();
            assert_eq!((0..1000).find_map(|_| budget.step(0.0, 1000)), None);
            assert_eq!((0..150_000).any(|_| budget.step(watt, 1).is_some()), trips, "{watt} W");
        }
    }

    #[test]
    fn the_full_budget_is_allowed_and_a_fault_resets_it() {
        let mut budget = EnergyPerLength { block_s: 1.0, joule_per_count: 1.0, most_j: 4.0, spent_j: 0.0 };
        assert_eq!([2.0, 2.0].map(|watt| budget.step(watt, 0)), [None; 2]);
        assert_eq!(budget.step(0.25, 0), Some(Fault::EnergyPerLength));
        assert_eq!([4.0, 3.0].map(|watt| budget.step(watt, u32::from(watt < 4.0) * 3)), [None; 2]);
        assert_eq!(budget.step(f32::NAN, 0), Some(Fault::EnergyPerLength));
        assert_eq!(budget.step(4.0, 0), None);
    }
}
