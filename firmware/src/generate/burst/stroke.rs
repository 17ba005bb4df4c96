//! Strokes: whole half cycles of drive that bring the vibration from one level to another.
//!
//! The vibration is expressed as the steady drive that would hold it, `R` (V). At the resonance,
//! under a drive of `u` for `n` half cycles,
//!
//! ```text
//! R1 = R0 q^n + u (1 - q^n),    q = exp(-1 / h),    h = 2 f tau half cycles a time constant
//! ```
//!
//! This is exact to all orders except the detuning of the resonance itself: the counter-rotating
//! component sums to zero over a half cycle. Therefore `u = (R1 - R0 q^n) / (1 - q^n)` reaches the
//! target exactly. For a drive `V` from rest and back, with the headroom `H = ceiling / V`, the
//! fewest half cycles that keep `|u|` within the ceiling are
//!
//! ```text
//! up:  n >= -h ln(1 - 1 / H),    down:  n >= h ln(1 + 1 / H)
//! ```
//!
//! These are the time-optimal (bang-bang) bounds, rounded up. With equal numbers of half cycles,
//! `u_up - u_down = V`. If the numbers of boost, drive and brake are all odd, their volt-seconds
//! cancel together; even numbers cancel each by itself.
//!
//! Another mode at a distance of `df` responds to the steps of a stroke, too. Each step excites it
//! by `r = (Cm2 / Cm) f / (2 Q df)`, relative to the vibration that a drive of this step would
//! hold. The step at the end cancels that at the beginning if whole beats of `1 / df` are between
//! them. A stroke that would leave more than [`MAX_OTHER_MODE_REL`] is therefore extended to whole
//! beats.
//!
//! Valid for a linear vibration that is driven at its resonance. A Coulomb load of a sixth of the
//! drive changes `u` by 2 % at a headroom of five.

use crate::seam::compare::larger;

/// Longest boost, time constants: the drive alone is at 95 % then.
const MAX_BOOST_TIME_CONSTANTS: f32 = 3.0;
/// Largest number of half cycles by which a brake is extended to the odd number of its boost.
const MAX_EXTRA_HALF_CYCLES: u32 = 1;
/// Part of the vibration that a stroke of the highest voltage may leave in another mode.
const MAX_OTHER_MODE_REL: f32 = 0.02;

/// Another mode, relative to the driven one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct OtherMode {
    /// Half cycles of the drive in a beat with the other mode.
    pub(crate) beat: f32,
    /// Motional capacitance, relative to that of the driven mode.
    pub(crate) strength: f32,
}

/// Room for the drive of an edge within the current limit. The current of the vibration and that of
/// the clamped branch are in quadrature: `I^2 = (S R)^2 + (B u)^2`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CurrentRoom {
    /// Square of the largest current, A².
    pub(crate) most: f32,
    /// Square of the motional current per volt, S², `S^2`.
    pub(crate) motional: f32,
    /// Square of the clamped branch's admittance, S², `B^2`.
    pub(crate) clamped: f32,
}

impl CurrentRoom {
    /// Returns the largest drive, V, during a vibration that a steady drive of `vibration` V would
    /// hold.
    // Not inlined: the fast memory of a board has no room for it.
    #[cold]
    #[inline(never)]
    pub(crate) fn volts(&self, vibration: f32) -> f32 {
        fpu::sqrtf(larger(self.most - vibration * vibration * self.motional, 0.0) / self.clamped)
    }
}

/// Number of half cycles, and the part of the earlier vibration that remains after them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stroke {
    /// Number of half cycles.
    pub(crate) half_cycles: u32,
    /// Remaining part, `q^n`.
    retained: f32,
}

impl Stroke {
    /// Returns the drive that brings the vibration from `from` to `to`, V.
    pub(crate) fn volts(&self, from: f32, to: f32) -> f32 {
        (to - from * self.retained) / (1.0 - self.retained)
    }
}

/// The strokes of a burst, up from rest and down again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Strokes {
    /// Stroke up. Both strokes have even numbers of half cycles, or the same odd number.
    pub(crate) up: Stroke,
    /// Stroke down.
    pub(crate) down: Stroke,
    /// Drive that the strokes were made for, V.
    pub volts: f32,
    /// Largest drive that the strokes may use, V.
    pub(crate) ceiling: f32,
    /// `true` if the boost reaches the level.
    pub(crate) lands: bool,
    per_time_constant: f32,
}

impl Strokes {
    /// Returns the stroke with an odd or an even number of half cycles: the same, or one more.
    pub(crate) fn with_parity(&self, stroke: Stroke, odd: bool) -> Stroke {
        if (stroke.half_cycles % 2 == 1) == odd {
            return stroke;
        }
        // exp(-d), error d^4 / 24.
        let d = 1.0 / self.per_time_constant;
        Stroke { half_cycles: stroke.half_cycles + 1, retained: stroke.retained * (1.0 - d * (1.0 - 0.5 * d * (1.0 - d / 3.0))) }
    }
}

/// Planner of strokes, one step a block.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Planner {
    per_time_constant: f32,
    volts: f32,
    ceiling: f32,
    /// Half cycles of a beat with another mode that matters, or zero.
    beat: f32,
    /// Half cycles up, once they are known.
    up: u32,
    /// Half cycles down, once they are known.
    down: u32,
    retained_up: f32,
    lands: bool,
    step: Step,
}

/// Next step of a planner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Step {
    #[default]
    Up,
    Down,
    RetainedUp,
    RetainedDown,
}

impl Planner {
    /// Creates a planner for a drive of `volts` under a ceiling, and a time constant of
    /// `per_time_constant` half cycles. `other_mode` is another mode, if any.
    pub(crate) fn new(per_time_constant: f32, volts: f32, ceiling: f32, other_mode: Option<OtherMode>) -> Self {
        // Two steps of `ceiling / volts` times the drive, each with r = strength beat / (2 pi h).
        let least = MAX_OTHER_MODE_REL * core::f32::consts::PI * per_time_constant * volts / ceiling;
        let beat = other_mode.filter(|it| it.strength * it.beat > least).map_or(0.0, |it| it.beat);
        Planner { per_time_constant, volts, ceiling, beat, ..Planner::default() }
    }

    /// Executes one step, and returns the strokes after the last one.
    pub(crate) fn step(&mut self) -> Option<Strokes> {
        let part = self.volts / self.ceiling;
        let h = self.per_time_constant;
        // Rounded up.
        let fewest = |time_constants: f32| 1 + (h * time_constants).clamp(0.0, 1e6) as u32;
        match self.step {
            Step::Up => {
                // Without headroom it takes as long as without a boost.
                let time_constants = if part < 1.0 { -libm::log1pf(-part) } else { f32::INFINITY };
                self.lands = time_constants <= MAX_BOOST_TIME_CONSTANTS;
                self.up = self.whole_beats(fewest(if self.lands { time_constants } else { MAX_BOOST_TIME_CONSTANTS }));
                self.lands &= self.up as f32 <= MAX_BOOST_TIME_CONSTANTS * h + 1.0;
                self.step = Step::Down;
            }
            Step::Down => {
                let down = self.whole_beats(fewest(libm::log1pf(part)));
                let odd = self.lands && self.up % 2 == 1 && self.up <= even(down) + MAX_EXTRA_HALF_CYCLES && self.up >= down;
                (self.up, self.down) = if odd { (self.up, self.up) } else { (even(self.up), even(down)) };
                self.step = Step::RetainedUp;
            }
            Step::RetainedUp => {
                self.retained_up = retained(self.up, h);
                self.step = Step::RetainedDown;
            }
            Step::RetainedDown => {
                self.step = Step::Up;
                return Some(Strokes {
                    up: Stroke { half_cycles: self.up, retained: self.retained_up },
                    down: Stroke {
                        half_cycles: self.down,
                        retained: if self.up == self.down { self.retained_up } else { retained(self.down, h) },
                    },
                    volts: self.volts,
                    ceiling: self.ceiling,
                    lands: self.lands,
                    per_time_constant: h,
                });
            }
        }
        None
    }

    /// Returns at least this number of half cycles, as whole beats if another mode matters.
    fn whole_beats(&self, half_cycles: u32) -> u32 {
        if self.beat > 0.0 { (libm::ceilf(half_cycles as f32 / self.beat) * self.beat + 0.5) as u32 } else { half_cycles }
    }
}

/// Returns the part that remains after this number of half cycles.
fn retained(half_cycles: u32, per_time_constant: f32) -> f32 {
    libm::expf(-(half_cycles as f32) / per_time_constant)
}

fn even(n: u32) -> u32 {
    n + n % 2
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Stroke {
        fn new(half_cycles: u32, per_time_constant: f32) -> Self {
            Stroke { half_cycles, retained: retained(half_cycles, per_time_constant) }
        }
    }

    impl Strokes {
        /// Executes all steps at once.
        pub(in crate::generate::burst) fn plan(per_time_constant: f32, volts: f32, ceiling: f32) -> Self {
            let mut planner = Planner::new(per_time_constant, volts, ceiling, None);
            (0..4).find_map(|_| planner.step()).unwrap()
        }
    }

    /// The flagship stack at 3 V under 15.466 V, with an ideal amplifier: 9 half cycles at 15.35 V,
    /// and 9 at 12.35 V.
    #[test]
    fn the_flagship_takes_nine_half_cycles_each_way() {
        let h = 2.0 * 64.6 / core::f32::consts::PI;
        let strokes = Strokes::plan(h, 3.0, 15.466);
        let (up, down) = (strokes.up.volts(0.0, 3.0), strokes.down.volts(3.0, 0.0));
        assert_eq!((strokes.up.half_cycles, strokes.down.half_cycles, strokes.lands), (9, 9, true));
        // At a Q of 65 it is 15.35 V.
        assert!((up - 15.263).abs() < 1e-3 && (up + down - 3.0).abs() < 1e-5, "{up} {down}");
        // Eight would need more than the ceiling.
        assert!(Stroke::new(8, h).volts(0.0, 3.0) > 15.466);
    }

    /// Within one half cycle of the bang-bang bounds, or two if both are even; never above the
    /// ceiling; the target is reached exactly.
    #[test]
    fn strokes_are_as_short_as_the_ceiling_allows() {
        for q in [20.0f32, 65.0, 200.0, 500.0] {
            for headroom in [1.06f32, 1.5, 2.0, 5.16, 20.0] {
                let h = 2.0 * q / core::f32::consts::PI;
                let strokes = Strokes::plan(h, 3.0, 3.0 * headroom);
                let bounds = (-h * libm::logf(1.0 - 1.0 / headroom), h * libm::logf(1.0 + 1.0 / headroom));
                for (stroke, bound, from, to) in [(strokes.up, bounds.0, 0.0, 3.0), (strokes.down, bounds.1, 3.0, 0.0)] {
                    let n = stroke.half_cycles as f32;
                    assert!(n >= bound && n <= bound + 2.0, "Q {q}, H {headroom}: {n} for {bound}");
                    let u = stroke.volts(from, to);
                    let retained = libm::expf(-n / h);
                    assert!(u.abs() <= 3.0 * headroom * 1.0001, "{u}");
                    assert!((from * retained + u * (1.0 - retained) - to).abs() < 1e-5);
                }
                assert!(strokes.lands && (strokes.up.half_cycles + strokes.down.half_cycles).is_multiple_of(2));
            }
        }
    }

    /// Sums the response of another mode over half cycles, with its own phase and without its
    /// losses.
    #[test]
    fn whole_beats_leave_another_mode_at_rest() {
        let h = 2.0 * 65.0 / core::f32::consts::PI;
        let plain = Strokes::plan(h, 3.0, 15.466);
        for (beat, strength) in [(28.6, 0.3), (40.3, 0.1), (19.0, 0.5)] {
            let mut planner = Planner::new(h, 3.0, 15.466, Some(OtherMode { beat, strength }));
            let strokes = (0..4).find_map(|_| planner.step()).unwrap();
            // Vibration of another mode after two steps of this voltage, relative to the drive.
            let left = |stroke: &Stroke| {
                let half_turns = core::f32::consts::PI * stroke.half_cycles as f32 / beat;
                let r = strength * beat / (core::f32::consts::TAU * h);
                2.0 * r * (stroke.volts(0.0, 3.0) / 3.0) * libm::sinf(half_turns).abs()
            };
            // Measured: at most 0.006 instead of 0.10 to 0.37.
            assert!(left(&strokes.up) < 0.008 && left(&plain.up) > 0.1, "{beat}: {} {}", left(&strokes.up), left(&plain.up));
            assert!(strokes.lands && strokes.up.volts(0.0, 3.0) < 15.466);
        }
        let mut weak = Planner::new(h, 3.0, 15.466, Some(OtherMode { beat: 28.6, strength: 1e-3 }));
        assert_eq!((0..4).find_map(|_| weak.step()), Some(plain));
        // A beat of four time constants.
        let mut near = Planner::new(h, 3.0, 15.466, Some(OtherMode { beat: 4.0 * h, strength: 0.3 }));
        assert!(!(0..4).find_map(|_| near.step()).unwrap().lands);
    }

    #[test]
    fn without_headroom_strokes_do_not_land() {
        for ceiling in [3.0, 2.0, 3.1] {
            let strokes = Strokes::plan(41.0, 3.0, ceiling);
            assert!(!strokes.lands && strokes.up.half_cycles == 124, "{strokes:?}");
        }
    }

    #[test]
    fn one_more_half_cycle_retains_the_exact_part() {
        let strokes = Strokes::plan(12.7, 3.0, 15.466);
        let other = strokes.with_parity(strokes.up, strokes.up.half_cycles.is_multiple_of(2));
        let exact = Stroke::new(strokes.up.half_cycles + 1, 12.7);
        // Measured: an error of 1.5e-6 of 0.7.
        assert!(other.half_cycles == exact.half_cycles && (other.retained - exact.retained).abs() < 3e-6, "{other:?} {exact:?}");
    }
}
