//! Choice of the regime for a friction ratio: amplitude, bursts, or silence.
//!
//! Amplitude and bursts give the same mean friction, so a change between them does not disturb it:
//!
//! * **Amplitude**, at the velocity ratio from the inverse law. It needs the least power and acts
//!   within a carrier period.
//! * **Bursts** of the maximum amplitude, whose ratio is the floor `r_on`:
//!   `r = 1 - (1 - r_on) (on + dead)`, with ON time and dead time relative to the period. This
//!   holds for duties from 0.2 to 0.85. Outside this range the ON time or the OFF time is no longer
//!   than an edge.
//!
//! Close to the velocity threshold the tip is hardly faster than the belt. The friction ratio of a
//! stiff contact then changes by twice the relative error of the velocity ratio: by 0.04 for 2 %.
//! Bursts are more accurate there, if their duty is within its range.
//!
//! Hysteresis prevents frequent changes between amplitude and bursts.

use super::inverse::Solution;
use crate::seam::config::Prefer;

/// Minimum duty of bursts.
const MIN_DUTY: f32 = 0.2;
/// Maximum duty of bursts.
const MAX_DUTY: f32 = 0.85;
/// Hysteresis of the duty before bursts end.
const DUTY_MARGIN: f32 = 0.03;
/// Velocity ratio above which bursts start.
const BURSTS_START_XI: f32 = 0.9;
/// Velocity ratio below which bursts end.
const BURSTS_END_XI: f32 = 0.85;
/// Maximum difference of a target ratio below the floor.
const RATIO_TOLERANCE: f32 = 2e-3;
/// Velocity ratio of the maximum amplitude below which lost authority is regained.
const AUTHORITY_REGAINED_XI: f32 = 0.98;

/// Drive regime.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Regime {
    /// Silence, with full friction.
    #[default]
    Silent,
    /// Steady drive at this velocity ratio.
    Amplitude(f32),
    /// Bursts of the maximum amplitude with this duty.
    Bursts(f32),
}

/// Reason why the friction ratio misses its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MissReason {
    /// The belt is faster than the maximum tip velocity.
    NoAuthority,
    /// The target is below the floor, above one, or NaN.
    Unreachable,
}

/// Present regime, with its hysteresis.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Choice {
    prefer: Prefer,
    regime: Regime,
    miss: Option<MissReason>,
}

impl Choice {
    /// Creates a choice that starts silent.
    pub(crate) fn new(prefer: Prefer) -> Self {
        Choice { prefer, ..Choice::default() }
    }

    /// Returns the present regime.
    pub(crate) fn regime(&self) -> Regime {
        self.regime
    }

    /// Returns the reason why the friction ratio misses its target; `None` if it does not.
    pub(crate) fn miss(&self) -> Option<MissReason> {
        self.miss
    }

    /// Chooses the regime for a target ratio. `least_xi` is the velocity ratio of the maximum
    /// amplitude. `dead` is the dead time of bursts relative to their period, `None` without
    /// bursts.
    pub(crate) fn choose(&mut self, target: f32, least_xi: f32, solution: &Solution, dead: Option<f32>) {
        let gone = self.miss == Some(MissReason::NoAuthority);
        let authority = least_xi < if gone { AUTHORITY_REGAINED_XI } else { 1.0 };
        (self.regime, self.miss) = if target == 1.0 {
            (Regime::Silent, None)
        } else if target.is_nan() || target > 1.0 {
            (Regime::Silent, Some(MissReason::Unreachable))
        } else if !authority {
            (Regime::Silent, Some(MissReason::NoAuthority))
        } else if target < solution.floor - RATIO_TOLERANCE {
            (Regime::Amplitude(least_xi), Some(MissReason::Unreachable))
        } else {
            (self.between(target, solution, dead), None)
        };
    }

    fn between(&self, target: f32, solution: &Solution, dead: Option<f32>) -> Regime {
        let by_amplitude = Regime::Amplitude(solution.xi);
        let Some(dead) = dead else { return by_amplitude };
        let on = (1.0 - target) / (1.0 - solution.floor) - dead;
        let bursting = matches!(self.regime, Regime::Bursts(_));
        let margin = if bursting { DUTY_MARGIN } else { 0.0 };
        let possible = (MIN_DUTY - margin..=MAX_DUTY + margin).contains(&on);
        let better = self.prefer == Prefer::Bursts || solution.xi > if bursting { BURSTS_END_XI } else { BURSTS_START_XI };
        if possible && better { Regime::Bursts(on) } else { by_amplitude }
    }
}

#[cfg(test)]
mod tests {
    use super::super::dahl::friction_ratio;
    use super::super::inverse::solve;
    use super::*;

    const LEAST_XI: f32 = 0.217;

    fn mean(regime: Regime, lambda: f32, dead: f32) -> f32 {
        match regime {
            Regime::Silent => 1.0,
            Regime::Amplitude(xi) => friction_ratio(xi, lambda / xi),
            Regime::Bursts(on) => 1.0 - (1.0 - friction_ratio(LEAST_XI, lambda / LEAST_XI)) * (on + dead),
        }
    }

    /// The target rises and falls through all ratios. The mean ratio equals the target on either
    /// side of each change, and each regime ends only once.
    #[test]
    fn the_mean_does_not_jump() {
        for (prefer, changes) in [(Prefer::Amplitude, 4), (Prefer::Bursts, 4)] {
            for lambda in [0.03, 1.0, 30.0] {
                let mut choice = Choice::new(prefer);
                let mut changed = 0;
                let up_and_down = (0..=2000).map(|n| 0.5e-3 * (n.min(2000 - n) * 2) as f32);
                for target in up_and_down {
                    let solution = solve(target, lambda, LEAST_XI);
                    let before = core::mem::discriminant(&choice.regime);
                    choice.choose(target, LEAST_XI, &solution, Some(0.04));
                    changed += u32::from(before != core::mem::discriminant(&choice.regime));
                    let got = mean(choice.regime, lambda, 0.04);
                    let reachable = target >= solution.floor - RATIO_TOLERANCE;
                    assert!((got - target.max(solution.floor)).abs() < 2.1e-3, "{target} {lambda}: {choice:?} {got}");
                    assert_eq!(choice.miss, (!reachable).then_some(MissReason::Unreachable), "{target} {lambda}");
                }
                // Plus the changes from and to silence.
                assert!(changed <= changes + 3, "{prefer:?} {lambda}: {changed}");
            }
        }
    }

    /// A target that fluctuates at the limit of a regime does not alternate between two regimes.
    #[test]
    fn fluctuating_target_does_not_alternate_regimes() {
        let lambda = 0.3;
        let floor = solve(0.5, lambda, LEAST_XI).floor;
        for duty in [MIN_DUTY, MAX_DUTY] {
            let mut choice = Choice::new(Prefer::Bursts);
            let mut changed = 0;
            for n in 0..1000 {
                let target = 1.0 - (1.0 - floor) * (duty + if n % 2 == 0 { 0.01 } else { -0.01 });
                let before = core::mem::discriminant(&choice.regime);
                choice.choose(target, LEAST_XI, &solve(target, lambda, LEAST_XI), Some(0.0));
                changed += u32::from(before != core::mem::discriminant(&choice.regime));
            }
            assert!(changed <= 2, "{duty}: {changed}");
        }
    }

    #[test]
    fn unreachable_targets_are_reported() {
        let solution = solve(0.3, 1.0, LEAST_XI);
        let mut choice = Choice::new(Prefer::Amplitude);
        let mut chosen = |target, least_xi, solution: &Solution| {
            choice.choose(target, least_xi, solution, None);
            (choice.regime(), choice.miss())
        };
        assert_eq!(chosen(1.0, LEAST_XI, &solution), (Regime::Silent, None));
        assert_eq!(chosen(f32::NAN, LEAST_XI, &solution), (Regime::Silent, Some(MissReason::Unreachable)));
        assert_eq!(chosen(1.1, LEAST_XI, &solution), (Regime::Silent, Some(MissReason::Unreachable)));
        assert_eq!(chosen(0.05, LEAST_XI, &solution), (Regime::Amplitude(LEAST_XI), Some(MissReason::Unreachable)));
        assert_eq!(chosen(-1.0, LEAST_XI, &solution), (Regime::Amplitude(LEAST_XI), Some(MissReason::Unreachable)));
        let none = solve(0.3, 1.0, 1.0);
        assert_eq!(chosen(0.3, 1.0, &none), (Regime::Silent, Some(MissReason::NoAuthority)));
        // Authority returns with a margin; a NaN speed has no authority.
        assert_eq!(chosen(0.3, 0.99, &solve(0.3, 1.0, 0.99)), (Regime::Silent, Some(MissReason::NoAuthority)));
        assert_eq!(chosen(0.99, 0.97, &solve(0.99, f32::INFINITY, 0.97)).1, None);
        assert_eq!(chosen(0.3, f32::NAN, &none), (Regime::Silent, Some(MissReason::NoAuthority)));
    }
}
