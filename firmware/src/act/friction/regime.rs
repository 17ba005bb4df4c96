//! By amplitude, by bursts, or not at all: how a friction ratio is had.
//!
//! Both ways have the same mean, so that going from one to the other does not change it:
//!
//! * by **amplitude**, at the velocity ratio that the inverse law says. It takes the least power, and is exact within a carrier period.
//! * by **bursts** of the maximum amplitude, whose ratio is the floor `r_on`: `r = 1 - (1 - r_on) (on + dead)`, with the ON time and the dead time as
//!   parts of the period. This holds for duties from a fifth to 0.85; beyond, an edge is as long as what is left.
//!
//! Close to the velocity threshold, where the tip is hardly faster than the belt, the friction of a stiff contact falls by twice the part by
//! which the velocity ratio is wrong: 0.04 for 2 %. There bursts are the better way, where their duty allows it.
//!
//! What is left of one way is only changed where the other one is better by a margin.

use super::inverse::Solution;
use crate::seam::config::Prefer;

/// Duties that bursts are used at.
const DUTIES: (f32, f32) = (0.2, 0.85);
/// By how much a duty may be outside before bursts are left.
const MARGIN: f32 = 0.03;
/// Velocity ratio from which bursts are better, and below which they are not any more.
const THRESHOLD: (f32, f32) = (0.9, 0.85);
/// A target ratio is refused if it is below the floor by more than this.
const TOLERANCE: f32 = 2e-3;
/// Authority that was lost is regained below this velocity ratio of the maximum amplitude.
const REGAINED: f32 = 0.98;

/// How the ratio is had.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Regime {
    /// Silence: all the friction there is.
    #[default]
    Silent,
    /// A steady drive at this velocity ratio.
    Amplitude(f32),
    /// Bursts of the maximum amplitude, ON for this part of their period.
    Bursts(f32),
}

/// Why the friction ratio misses its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Short {
    /// The belt is faster than the tip can be.
    NoAuthority,
    /// The target is below the floor, above one, or not a number.
    Unreachable,
}

/// The choice.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Choice {
    prefer: Prefer,
    regime: Regime,
    short: Option<Short>,
}

impl Choice {
    /// Silent, to begin with.
    pub(crate) fn new(prefer: Prefer) -> Self {
        Choice { prefer, ..Choice::default() }
    }

    /// How the ratio is had.
    pub(crate) fn regime(&self) -> Regime {
        self.regime
    }

    /// Why the friction ratio misses its target; `None` if it does not.
    pub(crate) fn short(&self) -> Option<Short> {
        self.short
    }

    /// Chooses for a target ratio: `least_xi` is the velocity ratio of the maximum amplitude, and `dead` the dead time of bursts as a part of their
    /// period, if there can be any.
    pub(crate) fn choose(&mut self, target: f32, least_xi: f32, solution: &Solution, dead: Option<f32>) {
        let gone = self.short == Some(Short::NoAuthority);
        let authority = least_xi < if gone { REGAINED } else { 1.0 };
        (self.regime, self.short) = if target == 1.0 {
            (Regime::Silent, None)
        } else if target.is_nan() || target > 1.0 {
            (Regime::Silent, Some(Short::Unreachable))
        } else if !authority {
            (Regime::Silent, Some(Short::NoAuthority))
        } else if target < solution.floor - TOLERANCE {
            (Regime::Amplitude(least_xi), Some(Short::Unreachable))
        } else {
            (self.between(target, solution, dead), None)
        };
    }

    fn between(&self, target: f32, solution: &Solution, dead: Option<f32>) -> Regime {
        let by_amplitude = Regime::Amplitude(solution.xi);
        let Some(dead) = dead else { return by_amplitude };
        let on = (1.0 - target) / (1.0 - solution.floor) - dead;
        let bursting = matches!(self.regime, Regime::Bursts(_));
        let margin = if bursting { MARGIN } else { 0.0 };
        let possible = (DUTIES.0 - margin..=DUTIES.1 + margin).contains(&on);
        let better = self.prefer == Prefer::Bursts || solution.xi > if bursting { THRESHOLD.1 } else { THRESHOLD.0 };
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

    /// Up and down through all ratios: the mean ratio is the target on either side of every change, and each regime is left once only.
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
                    let reachable = target >= solution.floor - TOLERANCE;
                    assert!((got - target.max(solution.floor)).abs() < 2.1e-3, "{target} {lambda}: {choice:?} {got}");
                    assert_eq!(choice.short, (!reachable).then_some(Short::Unreachable), "{target} {lambda}");
                }
                // Out of silence and into it again, besides.
                assert!(changed <= changes + 3, "{prefer:?} {lambda}: {changed}");
            }
        }
    }

    /// A ratio that trembles where one way ends does not go from one to the other and back.
    #[test]
    fn there_is_a_margin() {
        let lambda = 0.3;
        let floor = solve(0.5, lambda, LEAST_XI).floor;
        for duty in [DUTIES.0, DUTIES.1] {
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
    fn what_cannot_be_says_so() {
        let solution = solve(0.3, 1.0, LEAST_XI);
        let mut choice = Choice::new(Prefer::Amplitude);
        let mut chosen = |target, least_xi, solution: &Solution| {
            choice.choose(target, least_xi, solution, None);
            (choice.regime(), choice.short())
        };
        assert_eq!(chosen(1.0, LEAST_XI, &solution), (Regime::Silent, None));
        assert_eq!(chosen(f32::NAN, LEAST_XI, &solution), (Regime::Silent, Some(Short::Unreachable)));
        assert_eq!(chosen(1.1, LEAST_XI, &solution), (Regime::Silent, Some(Short::Unreachable)));
        assert_eq!(chosen(0.05, LEAST_XI, &solution), (Regime::Amplitude(LEAST_XI), Some(Short::Unreachable)));
        assert_eq!(chosen(-1.0, LEAST_XI, &solution), (Regime::Amplitude(LEAST_XI), Some(Short::Unreachable)));
        let none = solve(0.3, 1.0, 1.0);
        assert_eq!(chosen(0.3, 1.0, &none), (Regime::Silent, Some(Short::NoAuthority)));
        // It has to come back by a margin, and a speed that is not a number is no authority.
        assert_eq!(chosen(0.3, 0.99, &solve(0.3, 1.0, 0.99)), (Regime::Silent, Some(Short::NoAuthority)));
        assert_eq!(chosen(0.99, 0.97, &solve(0.99, f32::INFINITY, 0.97)).1, None);
        assert_eq!(chosen(0.3, f32::NAN, &none), (Regime::Silent, Some(Short::NoAuthority)));
    }
}
