//! Strokes: whole half cycles of drive that bring the vibration from one level to another.
//!
//! The vibration is expressed as the steady drive that would hold it, `R` (V). At the resonance, under a drive of `u` for `n` half cycles,
//!
//! ```text
//! R1 = R0 q^n + u (1 - q^n),    q = exp(-1 / h),    h = 2 f tau half cycles a time constant
//! ```
//!
//! to all orders but the resonance's own detuning: the component that turns against it adds up to nothing over a half cycle. So
//! `u = (R1 - R0 q^n) / (1 - q^n)` lands exactly, and the fewest half cycles that keep `|u|` within a ceiling are, of a drive `V` from rest and
//! back, with the headroom `H = ceiling / V`,
//!
//! ```text
//! up:  n >= -h ln(1 - 1 / H),    down:  n >= h ln(1 + 1 / H)
//! ```
//!
//! the time-optimal (bang-bang) bounds, rounded up. Of as many half cycles, `u_up - u_down = V`: with odd numbers of all three the volt-seconds
//! of boost, drive and brake cancel; with even numbers each cancels by itself.
//!
//! Another mode at a distance of `df` rings to the steps of a stroke, too, by `r = (Cm2 / Cm) f / (2 Q df)` of what the drive holds for each step of the drive. What the
//! step at the beginning leaves, the one at the end takes away if whole beats of `1 / df` lie between: where a stroke would leave more than [`LEFT`], it lasts as many beats.
//!
//! Valid where the ring is linear and driven at its resonance; a Coulomb load of a sixth of the drive moves `u` by 2 % at a headroom of five.

/// A boost that takes longer than so many time constants is none: the drive by itself is at 95 % then.
const LONGEST: f32 = 3.0;
/// Odd numbers where a brake may have as many half cycles as the boost, and loses no more than so many.
const LOST: u32 = 1;
/// Part of the vibration that another mode may be left with by a stroke of the highest voltage.
const LEFT: f32 = 0.02;

/// Another mode, as a stroke sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Beside {
    /// Half cycles of the drive in a beat with it.
    pub(crate) beat: f32,
    /// Its motional capacitance relative to that of the mode that is driven.
    pub(crate) strength: f32,
}

/// So many half cycles, and what is left after them of what rang before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stroke {
    /// Half cycles.
    pub(crate) half_cycles: u32,
    /// `q^n`.
    retained: f32,
}

impl Stroke {
    /// The drive that brings the vibration from `from` to `to`, V.
    pub(crate) fn volts(&self, from: f32, to: f32) -> f32 {
        (to - from * self.retained) / (1.0 - self.retained)
    }
}

/// The strokes of a burst, up from rest and down again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Strokes {
    /// Up and down; both are of even half cycles, or as many and odd.
    pub(crate) up: Stroke,
    /// Down.
    pub(crate) down: Stroke,
    /// Drive that they were made for, and the most that they may use, V.
    pub volts: f32,
    /// The most.
    pub(crate) ceiling: f32,
    /// The boost reaches the level.
    pub(crate) lands: bool,
    per_time_constant: f32,
}

impl Strokes {
    /// The stroke with an odd number of half cycles, or an even one: the same, or one more.
    pub(crate) fn with_parity(&self, stroke: Stroke, odd: bool) -> Stroke {
        if (stroke.half_cycles % 2 == 1) == odd {
            return stroke;
        }
        // exp(-d), error d^4 / 24.
        let d = 1.0 / self.per_time_constant;
        Stroke { half_cycles: stroke.half_cycles + 1, retained: stroke.retained * (1.0 - d * (1.0 - 0.5 * d * (1.0 - d / 3.0))) }
    }
}

/// Plans strokes, a little a block.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Planner {
    per_time_constant: f32,
    volts: f32,
    ceiling: f32,
    /// Half cycles of a beat with another mode that counts, or zero.
    beat: f32,
    /// Half cycles, as soon as they are known.
    up: u32,
    down: u32,
    retained_up: f32,
    lands: bool,
    step: Step,
}

/// What is next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Step {
    #[default]
    Up,
    Down,
    RetainedUp,
    RetainedDown,
}

impl Planner {
    /// For a drive of `volts` under a ceiling, of a ring that takes `per_time_constant` half cycles for its time constant, beside another mode or none.
    pub(crate) fn new(per_time_constant: f32, volts: f32, ceiling: f32, beside: Option<Beside>) -> Self {
        // Two steps of so many times the drive, each with r = strength beat / (2 pi h).
        let least = LEFT * core::f32::consts::PI * per_time_constant * volts / ceiling;
        let beat = beside.filter(|it| it.strength * it.beat > least).map_or(0.0, |it| it.beat);
        Planner { per_time_constant, volts, ceiling, beat, ..Planner::default() }
    }

    /// One step of it: the strokes with the last.
    pub(crate) fn step(&mut self) -> Option<Strokes> {
        let part = self.volts / self.ceiling;
        let h = self.per_time_constant;
        // Rounded up.
        let fewest = |time_constants: f32| 1 + (h * time_constants).clamp(0.0, 1e6) as u32;
        match self.step {
            Step::Up => {
                // Nothing above the drive: as long as it takes without a boost.
                let time_constants = if part < 1.0 { -libm::log1pf(-part) } else { f32::INFINITY };
                self.lands = time_constants <= LONGEST;
                self.up = self.whole_beats(fewest(if self.lands { time_constants } else { LONGEST }));
                self.lands &= self.up as f32 <= LONGEST * h + 1.0;
                self.step = Step::Down;
            }
            Step::Down => {
                let down = self.whole_beats(fewest(libm::log1pf(part)));
                let odd = self.lands && self.up % 2 == 1 && self.up <= even(down) + LOST && self.up >= down;
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

    /// At least as many half cycles, of whole beats where there are any that count.
    fn whole_beats(&self, half_cycles: u32) -> u32 {
        if self.beat > 0.0 { (libm::ceilf(half_cycles as f32 / self.beat) * self.beat + 0.5) as u32 } else { half_cycles }
    }
}

/// What is left after so many half cycles.
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
        fn of(half_cycles: u32, per_time_constant: f32) -> Self {
            Stroke { half_cycles, retained: retained(half_cycles, per_time_constant) }
        }
    }

    impl Strokes {
        /// All steps at once.
        pub(in crate::generate::burst) fn of(per_time_constant: f32, volts: f32, ceiling: f32) -> Self {
            let mut planner = Planner::new(per_time_constant, volts, ceiling, None);
            (0..4).find_map(|_| planner.step()).unwrap()
        }
    }

    /// The flagship stack at 3 V under 15.466 V, with an ideal amplifier: 9 half cycles at 15.35 V, and 9 at 12.35 V.
    #[test]
    fn the_flagship_takes_nine_half_cycles_each_way() {
        let h = 2.0 * 64.6 / core::f32::consts::PI;
        let strokes = Strokes::of(h, 3.0, 15.466);
        let (up, down) = (strokes.up.volts(0.0, 3.0), strokes.down.volts(3.0, 0.0));
        assert_eq!((strokes.up.half_cycles, strokes.down.half_cycles, strokes.lands), (9, 9, true));
        // Of Q 65 it is 15.35 V.
        assert!((up - 15.263).abs() < 1e-3 && (up + down - 3.0).abs() < 1e-5, "{up} {down}");
        // Eight would need more than there is.
        assert!(Stroke::of(8, h).volts(0.0, 3.0) > 15.466);
    }

    /// Within one half cycle of the bang-bang bounds, or two where both are even; never above the ceiling; landing exactly.
    #[test]
    fn strokes_are_as_short_as_the_ceiling_allows() {
        for q in [20.0f32, 65.0, 200.0, 500.0] {
            for headroom in [1.06f32, 1.5, 2.0, 5.16, 20.0] {
                let h = 2.0 * q / core::f32::consts::PI;
                let strokes = Strokes::of(h, 3.0, 3.0 * headroom);
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

    /// By the sums over half cycles of what another mode rings to, with its own phase and without its losses.
    #[test]
    fn whole_beats_leave_another_mode_at_rest() {
        let h = 2.0 * 65.0 / core::f32::consts::PI;
        let plain = Strokes::of(h, 3.0, 15.466);
        for (beat, strength) in [(28.6, 0.3), (40.3, 0.1), (19.0, 0.5)] {
            let mut planner = Planner::new(h, 3.0, 15.466, Some(Beside { beat, strength }));
            let strokes = (0..4).find_map(|_| planner.step()).unwrap();
            // Of the drive, what two steps of this voltage leave of another mode.
            let left = |stroke: &Stroke| {
                let half_turns = core::f32::consts::PI * stroke.half_cycles as f32 / beat;
                let r = strength * beat / (core::f32::consts::TAU * h);
                2.0 * r * (stroke.volts(0.0, 3.0) / 3.0) * libm::sinf(half_turns).abs()
            };
            // Measured: at most 0.006 in place of 0.10 to 0.37.
            assert!(left(&strokes.up) < 0.008 && left(&plain.up) > 0.1, "{beat}: {} {}", left(&strokes.up), left(&plain.up));
            assert!(strokes.lands && strokes.up.volts(0.0, 3.0) < 15.466);
        }
        let mut weak = Planner::new(h, 3.0, 15.466, Some(Beside { beat: 28.6, strength: 1e-3 }));
        assert_eq!((0..4).find_map(|_| weak.step()), Some(plain));
        // A beat of four time constants.
        let mut near = Planner::new(h, 3.0, 15.466, Some(Beside { beat: 4.0 * h, strength: 0.3 }));
        assert!(!(0..4).find_map(|_| near.step()).unwrap().lands);
    }

    #[test]
    fn without_headroom_it_says_so() {
        for ceiling in [3.0, 2.0, 3.1] {
            let strokes = Strokes::of(41.0, 3.0, ceiling);
            assert!(!strokes.lands && strokes.up.half_cycles == 124, "{strokes:?}");
        }
    }

    #[test]
    fn one_more_half_cycle_keeps_as_much_as_that() {
        let strokes = Strokes::of(12.7, 3.0, 15.466);
        let other = strokes.with_parity(strokes.up, strokes.up.half_cycles.is_multiple_of(2));
        let exact = Stroke::of(strokes.up.half_cycles + 1, 12.7);
        // Measured: 1.5e-6 of 0.7.
        assert!(other.half_cycles == exact.half_cycles && (other.retained - exact.retained).abs() < 3e-6, "{other:?} {exact:?}");
    }
}
