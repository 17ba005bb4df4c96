//! Restraint: HIGH or LOW friction at the D-ring of a seat belt, decided once per crash.
//!
//! The D-ring is a capstan (Euler 1769, Eytelwein 1808). While webbing slides out over it, the
//! shoulder pulls with `Fs = Fr exp(mu theta)`, where `Fr` is the force of the load limiter in the
//! retractor. Ultrasound lowers `mu`: drive OFF is HIGH friction, drive ON is LOW friction.
//!
//! | state | rule |
//! |---|---|
//! | HIGH | the default: the friction of a belt without this controller, and the result of any fault or doubt |
//! | LOW | once, for an occupant known to be light before the crash, and only while it still helps |
//! | LOW to HIGH | never: it would combine the force of HIGH with the excursion of LOW |
//!
//! ```text
//! Waiting -- force >= sensed_n for confirm_ms, and webbing comes out --> Deciding -- light, driving, force < latest_n --> Low
//!                                                                        \--- not light, or latest_ms over ---------> High
//! ```
//!
//! The mass is measured by the seat. It cannot be inferred from the crash: until the decision, a
//! light occupant in a hard crash and a heavy one in a soft crash have the same force and payout
//! (docs/evidence/crash.md). The reading in the block that detects the crash applies. It must be
//! from `least_kg` to `most_kg`, otherwise no occupant is classified as light.

use crate::seam::block::{Gate, Orders};
use crate::seam::config;
use crate::seam::error::Error;
use crate::seam::features;
use crate::seam::mode::Mode;

/// Minimum webbing payout under the force, encoder counts, if there is an encoder; a force without
/// payout is a sensor fault.
const MIN_PAYOUT_COUNTS: u32 = 2;

/// State of the decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// No crash. The force has been present for `felt` blocks, with a payout of `counts`.
    Waiting { felt: u32, counts: u32 },
    /// Crash detected; `left` blocks remain for the decision.
    Deciding { left: u32 },
    /// The friction remains HIGH.
    High,
    /// The friction remains LOW.
    Low,
}

/// Class of the occupant, by the reading of the seat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    /// Light occupant, for whom the belt should pull less.
    Light,
    /// Any other occupant.
    Other,
    /// No reading of the seat, or an implausible one.
    Unknown,
}

/// Decision and its settings.
#[derive(Clone, Debug)]
pub(crate) struct Restraint {
    _enabled: features::Friction,
    sensed_n: f32,
    confirm_blocks: u32,
    latest_blocks: u32,
    latest_n: f32,
    light_below_kg: f32,
    plausible_kg: (f32, f32),
    state: State,
}

impl Restraint {
    /// Checks the settings.
    pub(crate) fn build(restraint: &config::Restraint, block_s: f32) -> Result<Self, Error> {
        let enabled = features::friction()?;
        restraint.check()?;
        type Settings = config::Restraint;
        Settings::LATEST_N.check_within(restraint.latest_n.into(), restraint.sensed_n.into(), f64::INFINITY)?;
        let (least, most) = (restraint.least_kg, restraint.most_kg);
        Settings::MOST_KG.check_within(most.into(), least.into(), f64::INFINITY)?;
        Settings::LIGHT_BELOW_KG.check_within(restraint.light_below_kg.into(), least.into(), most.into())?;
        let blocks = |ms: f32| (ms * 1e-3 / block_s) as u32;
        Ok(Restraint {
            _enabled: enabled,
            sensed_n: restraint.sensed_n,
            // The first block with the force counts.
            confirm_blocks: blocks(restraint.confirm_ms).max(1),
            latest_blocks: blocks(restraint.latest_ms),
            latest_n: restraint.latest_n,
            light_below_kg: restraint.light_below_kg,
            plausible_kg: (least, most),
            state: State::Waiting { felt: 0, counts: 0 },
        })
    }

    /// Resets the decision.
    pub(crate) fn restart(&mut self) {
        self.state = State::Waiting { felt: 0, counts: 0 };
    }

    /// Classifies the occupant by the torso mass from the seat, kg.
    pub(crate) fn class(&self, torso_kg: Option<f32>) -> Class {
        let (least, most) = self.plausible_kg;
        match torso_kg {
            Some(kg) if (least..=most).contains(&kg) && kg < self.light_below_kg => Class::Light,
            Some(kg) if (least..=most).contains(&kg) => Class::Other,
            _ => Class::Unknown,
        }
    }

    /// Processes the readings of one block, and sets the gate of the orders by the decision.
    ///
    /// `force` is the belt force, N, and `fresh` the payout in this block, counts; `None` without a
    /// sensor.
    // Not inlined: saves instructions per block, which `docs/evidence/instructions.md` counts.
    #[inline(never)]
    pub(crate) fn decide(&mut self, orders: &Orders, force: Option<f32>, fresh: Option<u32>, mode: Mode) -> Orders {
        if let State::Waiting { felt, counts } = self.state {
            // A missing force or NaN does not indicate a crash.
            let (felt, counts) = match force {
                Some(force) if force >= self.sensed_n => (felt.saturating_add(1), counts.saturating_add(fresh.unwrap_or(0))),
                _ => (0, 0),
            };
            let comes_out = fresh.is_none() || counts >= MIN_PAYOUT_COUNTS;
            self.state = match self.class(orders.torso_kg) {
                _ if felt < self.confirm_blocks || !comes_out => State::Waiting { felt, counts },
                Class::Light => State::Deciding { left: self.latest_blocks },
                Class::Other | Class::Unknown => State::High,
            };
        }
        if let State::Deciding { left } = self.state {
            // A missing force is not a small one.
            let helps = force.is_some_and(|force| force < self.latest_n);
            self.state = match (left.checked_sub(1), mode) {
                (Some(_), Mode::Run) if helps => State::Low,
                (Some(left), _) => State::Deciding { left },
                (None, _) => State::High,
            };
        }
        Orders { gate: if self.state == State::Low { Gate::On } else { Gate::Off }, ..*orders }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seam::config;

    const LIGHT: Option<f32> = Some(14.0);

    /// Blocks of 1 ms: a crash is detected at 300 N in the second block; LOW is possible in the
    /// next ten blocks, below 2500 N.
    fn restraint() -> Restraint {
        Restraint {
            _enabled: features::Enabled,
            sensed_n: 300.0,
            confirm_blocks: 2,
            latest_blocks: 10,
            latest_n: 2500.0,
            light_below_kg: 18.0,
            plausible_kg: (5.0, 60.0),
            state: State::Waiting { felt: 0, counts: 0 },
        }
    }

    fn block(restraint: &mut Restraint, torso_kg: Option<f32>, force: Option<f32>, mode: Mode) -> Gate {
        restraint.decide(&Orders { torso_kg, ..Orders::default() }, force, None, mode).gate
    }

    /// Returns the gate for a sequence of forces.
    fn gates(torso_kg: Option<f32>, forces: &[f32]) -> std::vec::Vec<Gate> {
        let mut restraint = restraint();
        forces.iter().map(|&force| block(&mut restraint, torso_kg, Some(force), Mode::Run)).collect()
    }

    #[test]
    fn only_a_light_occupant_gets_low() {
        let forces = [0.0, 299.0, 400.0, 600.0, 900.0, 0.0, 5000.0];
        use Gate::{Off, On};
        assert_eq!(gates(LIGHT, &forces), [Off, Off, Off, On, On, On, On], "LOW stays");
        for other in [Some(18.0), Some(29.0), None, Some(f32::NAN), Some(-14.0), Some(4.9), Some(61.0), Some(f32::INFINITY)] {
            assert_eq!(gates(other, &forces), [Off; 7], "{other:?}");
        }
    }

    #[test]
    fn short_forces_are_not_a_crash() {
        assert_eq!(gates(LIGHT, &[400.0, 0.0, 400.0, 0.0, 400.0, 299.0]), [Gate::Off; 6]);
        assert_eq!(gates(LIGHT, &[f32::NAN; 6]), [Gate::Off; 6]);
    }

    /// A stuck force channel with a belt at rest is not a crash until webbing comes out.
    #[test]
    fn force_without_payout_is_not_a_crash() {
        let mut restraint = restraint();
        let orders = Orders { torso_kg: LIGHT, ..Orders::default() };
        for (fresh, gate) in [(0, Gate::Off), (0, Gate::Off), (0, Gate::Off), (1, Gate::Off), (1, Gate::On), (0, Gate::On)] {
            assert_eq!(restraint.decide(&orders, Some(900.0), Some(fresh), Mode::Run).gate, gate, "{fresh}");
        }
    }

    #[test]
    fn class_is_taken_before_the_crash() {
        let mut restraint = restraint();
        for _ in 0..2 {
            block(&mut restraint, None, Some(400.0), Mode::Run);
        }
        assert_eq!(block(&mut restraint, LIGHT, Some(400.0), Mode::Run), Gate::Off);
    }

    /// LOW may come late only if the force is known to be below its limit and the drive is running,
    /// and only until the time limit.
    #[test]
    fn low_comes_in_time_or_not_at_all() {
        for (force, mode) in
            [(Some(2500.0), Mode::Run), (None, Mode::Run), (Some(f32::NAN), Mode::Run), (Some(400.0), Mode::Lock)]
        {
            let after = |blocks: u32| {
                let mut restraint = restraint();
                block(&mut restraint, LIGHT, Some(400.0), Mode::Lock);
                block(&mut restraint, LIGHT, Some(400.0), Mode::Lock);
                (0..blocks).for_each(|_| assert_eq!(block(&mut restraint, LIGHT, force, mode), Gate::Off));
                block(&mut restraint, LIGHT, Some(400.0), Mode::Run)
            };
            assert_eq!((after(8), after(9)), (Gate::On, Gate::Off), "{force:?} {mode:?}");
        }
    }

    #[test]
    fn settings_out_of_range_are_reported() {
        let build = |change: fn(&mut config::Restraint)| {
            let mut restraint = config::Restraint::default();
            change(&mut restraint);
            match Restraint::build(&restraint, 32e-6) {
                Err(Error::OutOfRange { parameter, .. }) => parameter,
                _ => "",
            }
        };
        assert_eq!(build(|_| ()), "");
        assert_eq!(build(|restraint| restraint.sensed_n = f32::NAN), "restraint.sensed_n");
        assert_eq!(build(|restraint| restraint.confirm_ms = -1.0), "restraint.confirm_ms");
        assert_eq!(build(|restraint| restraint.latest_ms = 1e4), "restraint.latest_ms");
        assert_eq!(build(|restraint| restraint.latest_n = 10.0), "restraint.latest_n");
        assert_eq!(build(|restraint| restraint.light_below_kg = 100.0), "restraint.light_below_kg");
        assert_eq!(build(|restraint| restraint.most_kg = 4.0), "restraint.most_kg");
    }
}
