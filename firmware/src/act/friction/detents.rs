//! Detents of a knob: as the knob is turned, the friction rises towards each detent and falls after
//! it.
//!
//! ```text
//! r(x) = r0 + (rd - r0) (1 - d^2 (3 - 2 d)),    d = 2 |x / p - round(x / p)|,    x = x(t) + v T
//! ```
//!
//! `x(t)` is the position since power-up, `v` the speed, `p` the distance between detents, `r0` the
//! set point between them and `rd` the set point at a detent. `d` is 0 at a detent and 1 halfway to
//! the next. The cubic has zero slope at both and is within 0.01 of a raised cosine. The drive for
//! a set point needs the time `T` to be computed and to take effect, so the set point is computed
//! for the position expected after this time.
//!
//! Friction resists in both directions and pulls in neither: unlike the notch of a spring, such a
//! detent holds the knob but does not draw it in.

use crate::seam::config::{Config, Friction};
use crate::seam::error::Error;

/// Minimum distance between detents, encoder counts; fewer do not resolve the profile.
const MIN_PITCH_COUNTS: f32 = 8.0;
/// Parts per distance between detents: 2^32.
const PARTS_PER_PITCH: f32 = 4_294_967_296.0;
/// Lead time T, blocks: the drive is recomputed about every 65 blocks, as the steps of the estimate
/// show, and the tip settles in about 20.
const LEAD_BLOCKS: f32 = 90.0;

/// Detents of a knob.
#[derive(Clone, Debug)]
pub(crate) struct Detents {
    /// Parts per encoder count. Positions wrap with the detents.
    parts_per_count: u32,
    /// Parts that a knob moves during the time T, per speed, s/m.
    parts_per_speed: f32,
    ratio: f32,
}

impl Detents {
    /// Creates the detents of a friction switch; `None` without detents. They need an encoder that
    /// resolves them.
    pub(crate) fn build(config: &Config, friction: &Friction, block_s: f32) -> Result<Option<Self>, Error> {
        let pitch_m = friction.detent_pitch_m;
        if pitch_m == 0.0 {
            return Ok(None);
        }
        let metre_per_count = config.front_end.metre_per_count.ok_or(Error::DetentsWithoutEncoder)?;
        let (least_m, most_m) = (MIN_PITCH_COUNTS * metre_per_count, Friction::DETENT_PITCH_M.max as f32);
        Friction::DETENT_PITCH_M.check_within(pitch_m.into(), least_m.into(), most_m.into())?;
        let parts_per_m = PARTS_PER_PITCH / pitch_m;
        Ok(Some(Detents {
            parts_per_count: libm::roundf(parts_per_m * metre_per_count) as u32,
            parts_per_speed: parts_per_m * LEAD_BLOCKS * block_s,
            ratio: friction.detent_ratio,
        }))
    }

    /// Returns the set point of the friction ratio at this position and speed, m/s; `between` is
    /// the set point between detents.
    // Not inlined: few boards need it, and the fast memory has no room.
    #[inline(never)]
    pub(crate) fn ratio(&self, counts: i32, speed_m_per_s: f32, between: f32) -> f32 {
        // The cast saturates if the knob moves more than half the distance in the time T.
        let ahead = (speed_m_per_s * self.parts_per_speed) as i32;
        // Signed distance from the nearest detent; halfway to the next is 2^31.
        let from_detent = (counts as u32).wrapping_mul(self.parts_per_count).wrapping_add_signed(ahead) as i32;
        let away = from_detent.unsigned_abs() as f32 * (2.0 / PARTS_PER_PITCH);
        between + (self.ratio - between) * (1.0 - away * away * (3.0 - 2.0 * away))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Detents 2 mm apart, encoder with 1000 counts per millimetre; at 1 m/s a knob moves 1 mm in
    /// the time T.
    fn detents() -> Detents {
        Detents {
            parts_per_count: libm::roundf(PARTS_PER_PITCH / 2000.0) as u32,
            parts_per_speed: 0.5 * PARTS_PER_PITCH,
            ratio: 1.0,
        }
    }

    #[test]
    fn friction_is_highest_at_a_detent_and_lowest_halfway() {
        let detents = detents();
        // Resolution of a count: one part in two million, or 0.5 % of the distance after ten
        // thousand detents.
        for (turn, off) in [(-4000, 1e-6), (-2000, 1e-6), (0, 1e-6), (2000, 1e-6), (20_000_000, 5e-4), (-20_000_000, 5e-4)] {
            assert!((detents.ratio(turn, 0.0, 0.3) - 1.0).abs() < off, "{turn}: {}", detents.ratio(turn, 0.0, 0.3));
            assert!((detents.ratio(turn + 1000, 0.0, 0.3) - 0.3).abs() < off, "{turn}");
            assert!((detents.ratio(turn + 500, 0.0, 0.3) - 0.65).abs() < 10.0 * off, "{turn}");
            assert!((detents.ratio(turn - 500, 0.0, 0.3) - 0.65).abs() < 10.0 * off, "{turn}");
        }
    }

    #[test]
    fn profile_is_within_a_hundredth_of_a_raised_cosine() {
        let detents = detents();
        for counts in -3000..3000 {
            let cosine = 0.65 + 0.35 * libm::cosf(core::f32::consts::TAU * counts as f32 / 2000.0);
            let ratio = detents.ratio(counts, 0.0, 0.3);
            assert!((ratio - cosine).abs() < 0.01 && (0.3..=1.0).contains(&ratio), "{counts}: {ratio} for {cosine}");
        }
    }

    #[test]
    fn set_point_is_that_of_the_expected_position() {
        let detents = detents();
        for (speed, further) in [(0.0, 0), (0.1, 100), (-0.1, -100), (0.9, 900), (-0.9, -900)] {
            let (ahead, there) = (detents.ratio(130, speed, 0.3), detents.ratio(130 + further, 0.0, 0.3));
            assert!((ahead - there).abs() < 1e-5, "{speed}: {ahead} for {there}");
        }
        for speed in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
            assert!((0.3..=1.0).contains(&detents.ratio(130, speed, 0.3)), "{speed}");
        }
    }

    /// A detent may have less friction than the space between detents; a NaN set point remains NaN.
    #[test]
    fn detent_may_have_less_friction() {
        let low = Detents { ratio: 0.2, ..detents() };
        assert!((low.ratio(0, 0.0, 0.9) - 0.2).abs() < 1e-6 && (low.ratio(1000, 0.0, 0.9) - 0.9).abs() < 1e-6);
        assert!(low.ratio(17, 0.0, f32::NAN).is_nan());
    }
}
