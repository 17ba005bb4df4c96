//! Detents of a knob: the friction rises towards each, and falls again behind it, as the knob is turned.
//!
//! ```text
//! r(x) = r0 + (rd - r0) (1 - d^2 (3 - 2 d)),    d = 2 |x / p - round(x / p)|,    x = x(t) + v T
//! ```
//!
//! with the position since power-up, the distance `p` of two detents, the set point `r0` between them and `rd` at one. `d` is 0 at a detent and 1 half
//! way to the next; the cubic has no slope at either, and is within 0.01 of a raised cosine. What is asked for now is in the contact a time `T` later, when the
//! drive for it has been found and the tip has rung to it: it is that of where the knob will be.
//!
//! Friction resists either way and pulls nowhere: unlike the notch of a spring, such a detent holds the knob and does not draw it in.

use crate::seam::config::{Config, Friction};
use crate::seam::error::Error;

/// Counts of the encoder from one detent to the next, at least: of fewer no course is left.
const LEAST_COUNTS: f32 = 8.0;
/// 2^32 as a number: parts of the distance of two detents.
const PARTS: f32 = 4_294_967_296.0;
/// T: a drive is found anew every 65 blocks or so, as the steps of the estimate show, and the tip rings to it in some 20.
const LATE_BLOCKS: f32 = 90.0;

/// The detents of a knob.
#[derive(Clone, Debug)]
pub(crate) struct Detents {
    /// Parts a count, and parts that a knob of 1 m/s goes in the time T. Positions wrap with the detents.
    parts_per_count: u32,
    parts_per_speed: f32,
    ratio: f32,
}

impl Detents {
    /// Those of a friction switch, if it has any. They need an encoder that tells them apart.
    pub(crate) fn build(config: &Config, friction: &Friction, block_s: f32) -> Result<Option<Self>, Error> {
        let pitch_m = friction.detent_pitch_m;
        if pitch_m == 0.0 {
            return Ok(None);
        }
        let metre_per_count = config.front_end.metre_per_count.ok_or(Error::DetentsWithoutEncoder)?;
        let (least_m, most_m) = (LEAST_COUNTS * metre_per_count, Friction::DETENT_PITCH_M.max as f32);
        Friction::DETENT_PITCH_M.check_within(pitch_m.into(), least_m.into(), most_m.into())?;
        let parts_per_m = PARTS / pitch_m;
        Ok(Some(Detents {
            parts_per_count: libm::roundf(parts_per_m * metre_per_count) as u32,
            parts_per_speed: parts_per_m * LATE_BLOCKS * block_s,
            ratio: friction.detent_ratio,
        }))
    }

    /// The set point of the friction ratio at so many counts and this speed, m/s, where it is `between` away from the detents.
    // Not inlined: the fast memory of a board has no room for what few boards have.
    #[inline(never)]
    pub(crate) fn ratio(&self, counts: i32, speed_m_per_s: f32, between: f32) -> f32 {
        // The cast saturates: what is faster than half the distance in the time T has no course to follow.
        let ahead = (speed_m_per_s * self.parts_per_speed) as i32;
        // As a signed number it is the distance from the nearest detent: half way to the next is half the circle.
        let from_detent = (counts as u32).wrapping_mul(self.parts_per_count).wrapping_add_signed(ahead) as i32;
        let away = from_detent.unsigned_abs() as f32 * (2.0 / PARTS);
        between + (self.ratio - between) * (1.0 - away * away * (3.0 - 2.0 * away))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Detents 2 mm apart on an encoder of 1000 counts a millimetre; a knob of 1 m/s is 1 mm further after the time T.
    fn detents() -> Detents {
        Detents { parts_per_count: libm::roundf(PARTS / 2000.0) as u32, parts_per_speed: 0.5 * PARTS, ratio: 1.0 }
    }

    #[test]
    fn the_friction_is_highest_at_a_detent_and_lowest_half_way() {
        let detents = detents();
        // A count is known to a part in two million: after ten thousand detents they are where they were to half a per cent of their distance.
        for (turn, off) in [(-4000, 1e-6), (-2000, 1e-6), (0, 1e-6), (2000, 1e-6), (20_000_000, 5e-4), (-20_000_000, 5e-4)] {
            assert!((detents.ratio(turn, 0.0, 0.3) - 1.0).abs() < off, "{turn}: {}", detents.ratio(turn, 0.0, 0.3));
            assert!((detents.ratio(turn + 1000, 0.0, 0.3) - 0.3).abs() < off, "{turn}");
            assert!((detents.ratio(turn + 500, 0.0, 0.3) - 0.65).abs() < 10.0 * off, "{turn}");
            assert!((detents.ratio(turn - 500, 0.0, 0.3) - 0.65).abs() < 10.0 * off, "{turn}");
        }
    }

    #[test]
    fn it_is_within_a_hundredth_of_a_raised_cosine_and_never_outside() {
        let detents = detents();
        for counts in -3000..3000 {
            let cosine = 0.65 + 0.35 * libm::cosf(core::f32::consts::TAU * counts as f32 / 2000.0);
            let ratio = detents.ratio(counts, 0.0, 0.3);
            assert!((ratio - cosine).abs() < 0.01 && (0.3..=1.0).contains(&ratio), "{counts}: {ratio} for {cosine}");
        }
    }

    #[test]
    fn a_knob_that_turns_is_met_where_it_will_be() {
        let detents = detents();
        for (speed, further) in [(0.0, 0), (0.1, 100), (-0.1, -100), (0.9, 900), (-0.9, -900)] {
            let (ahead, there) = (detents.ratio(130, speed, 0.3), detents.ratio(130 + further, 0.0, 0.3));
            assert!((ahead - there).abs() < 1e-5, "{speed}: {ahead} for {there}");
        }
        for speed in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
            assert!((0.3..=1.0).contains(&detents.ratio(130, speed, 0.3)), "{speed}");
        }
    }

    /// A detent that is easier to turn than what is between them; and a set point that is no number stays none.
    #[test]
    fn a_detent_may_be_the_lower_one() {
        let low = Detents { ratio: 0.2, ..detents() };
        assert!((low.ratio(0, 0.0, 0.9) - 0.2).abs() < 1e-6 && (low.ratio(1000, 0.0, 0.9) - 0.9).abs() < 1e-6);
        assert!(low.ratio(17, 0.0, f32::NAN).is_nan());
    }
}
