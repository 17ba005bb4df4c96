//! Belt motion from its encoder: payout, speed, and new ground under the tip.
//!
//! Payout is counts times metres per count. **New ground** is a count beyond the farthest position
//! since the belt was last drawn back by `PLAY_M`. A belt that swings by less than that stays in
//! place as far as its heat is concerned.
//!
//! Speed is the counts between two edges divided by the time between them,
//! `v = m (c2 - c1) / (t2 - t1)`. The edges are 5 ms apart, or 200 counts if that is sooner. Edges
//! are resolved to a block, so that the error of the speed is 0.6 % (32 us in 5 ms) or 0.5 %.
//! Without new counts, the speed is at most one count in the time since the last edge.

use crate::seam::block::BeltSense;
use crate::seam::config::Config;

/// Distance by which a belt is drawn back before its payout counts as new ground again, m: a fifth
/// of a contact of 10 mm.
pub(crate) const PLAY_M: f32 = 2e-3;
/// The same distance, counts, if the length of a count is not configured.
const PLAY_COUNTS: i32 = 200;
/// Duration of a speed measurement, s.
const SPEED_S: f32 = 5e-3;
/// Number of counts that ends a speed measurement earlier.
const SPEED_COUNTS: i32 = 200;

/// Position and speed of the belt, from the counts of its encoder.
#[derive(Clone, Debug)]
pub struct Belt {
    /// Length of a count, m; zero if it is not configured.
    metre_per_count: f32,
    block_s: f32,
    play: i32,
    speed_blocks: u32,
    /// `true` if an encoder is configured or has been read.
    expected: bool,
    counter: Option<Counter>,
    /// New ground in the last block, counts.
    fresh: u32,
    /// Blocks since the last new ground.
    still: u32,
}

/// State of the encoder, in raw counts.
#[derive(Clone, Copy, Debug)]
struct Counter {
    last: i32,
    furthest: i32,
    /// Position at the start of the present speed measurement.
    anchor: i32,
    /// Blocks since that start.
    since_anchor: u32,
    since_edge: u32,
    /// Speed, counts per block.
    speed: Option<f32>,
}

impl Belt {
    /// Creates a belt with the configured length of a count.
    pub fn build(config: &Config, block_s: f32) -> Self {
        Belt::of(config.front_end.metre_per_count.unwrap_or(0.0), block_s)
    }

    /// Creates a belt with this length of a count, m; zero if it is not configured. The belt then
    /// has an encoder only once it is read.
    pub(crate) fn of(metre_per_count: f32, block_s: f32) -> Self {
        let configured = metre_per_count > 0.0;
        Belt {
            metre_per_count,
            block_s,
            play: if configured { (PLAY_M / metre_per_count) as i32 } else { PLAY_COUNTS },
            speed_blocks: (SPEED_S / block_s) as u32,
            expected: configured,
            counter: None,
            fresh: 0,
            still: 0,
        }
    }

    /// Processes the reading of one block. After a broken line, the next reading is the new origin
    /// of new ground and speed.
    pub fn update(&mut self, sense: Option<BeltSense>) {
        if sense.is_none() && !self.expected {
            return;
        }
        self.expected = true;
        self.fresh = 0;
        match (sense.filter(|sense| !sense.broken), &mut self.counter) {
            (None, counter) => *counter = None,
            (Some(sense), Some(counter)) => {
                self.fresh = counter.advance(sense.counts, self.play);
                counter.measure(self.speed_blocks);
            }
            (Some(sense), counter) => *counter = Some(Counter::from(sense.counts)),
        }
        self.still = if self.fresh > 0 { 0 } else { self.still.saturating_add(1) };
    }

    /// Returns `true` if an encoder is configured or has been read.
    pub(crate) fn is_expected(&self) -> bool {
        self.expected
    }

    /// Returns `true` if an expected encoder is missing or has a broken line.
    pub(crate) fn is_lost(&self) -> bool {
        self.expected && self.counter.is_none()
    }

    /// Returns the new ground in the last block, counts.
    pub(crate) fn fresh_counts(&self) -> u32 {
        self.fresh
    }

    /// Returns the position, counts since power-up; `None` without an encoder.
    pub(crate) fn counts(&self) -> Option<i32> {
        self.counter.map(|counter| counter.last)
    }

    /// Returns the number of blocks since the last new ground or since power-on.
    pub(crate) fn still_blocks(&self) -> u32 {
        self.still
    }

    /// Returns the speed, m/s, with an error below one per cent; negative when drawn back. `None`
    /// while it is unknown.
    pub(crate) fn speed_m_per_s(&self) -> Option<f32> {
        let counter = self.counter.filter(|_| self.metre_per_count > 0.0)?;
        Some(counter.limited_speed()? * self.metre_per_count / self.block_s)
    }
}

impl Counter {
    fn from(counts: i32) -> Self {
        Counter { last: counts, furthest: counts, anchor: counts, since_anchor: 0, since_edge: 0, speed: None }
    }

    /// Advances to the next reading. Returns the new ground, counts.
    fn advance(&mut self, counts: i32, play: i32) -> u32 {
        self.since_edge = if counts == self.last { self.since_edge.saturating_add(1) } else { 0 };
        self.since_anchor = self.since_anchor.saturating_add(1);
        self.last = counts;
        let beyond = counts.wrapping_sub(self.furthest);
        if beyond > 0 {
            self.furthest = counts;
        } else if beyond < -play {
            self.furthest = counts.wrapping_add(play);
        }
        beyond.max(0) as u32
    }

    /// Measures the speed at an edge, if the last measurement is old enough.
    fn measure(&mut self, blocks: u32) {
        let moved = self.last.wrapping_sub(self.anchor);
        if self.since_edge == 0 && (self.since_anchor >= blocks || moved.unsigned_abs() >= SPEED_COUNTS as u32) {
            self.speed = Some(moved as f32 / self.since_anchor as f32);
            (self.anchor, self.since_anchor) = (self.last, 0);
        }
    }

    /// Returns the speed, counts per block, limited to one count in the time since the last edge.
    fn limited_speed(&self) -> Option<f32> {
        let silent = self.since_edge as f32;
        self.speed.map(|speed| if (speed * silent).abs() > 1.0 { (1.0 / silent).copysign(speed) } else { speed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLOCK_S: f32 = 32e-6;

    /// Creates a belt with 100 counts per millimetre.
    fn belt() -> Belt {
        Belt::of(1e-5, BLOCK_S)
    }

    /// Moves a belt at `speed`, m/s, for `blocks` blocks from `position`, counts. Updates the
    /// position and returns the new ground.
    fn moves(belt: &mut Belt, position: &mut f64, speed: f64, blocks: usize) -> u32 {
        let mut fresh = 0;
        for _ in 0..blocks {
            *position += speed * 1e5 * f64::from(BLOCK_S);
            belt.update(Some(BeltSense { counts: position.floor() as i64 as i32, broken: false }));
            fresh += belt.fresh_counts();
        }
        fresh
    }

    /// Measured from 3 to 2500 mm/s in both directions: at most 0.66 % off.
    #[test]
    fn the_speed_is_known_to_a_per_cent_at_any_speed() {
        for speed in [0.003, 0.0101, 0.025, 0.038, 0.0683, 0.3, 2.5, -0.038] {
            let (mut belt, mut position) = (belt(), 0.3);
            moves(&mut belt, &mut position, speed, 1000);
            for _ in 0..500 {
                moves(&mut belt, &mut position, speed, 1);
                let known = f64::from(belt.speed_m_per_s().unwrap());
                assert!((known / speed - 1.0).abs() < 7e-3, "{speed}: {known}");
            }
        }
    }

    #[test]
    fn speed_is_unknown_at_first_and_falls_without_counts() {
        let (mut belt, mut position) = (belt(), 0.0);
        moves(&mut belt, &mut position, 0.038, 150);
        assert_eq!(belt.speed_m_per_s(), None);
        moves(&mut belt, &mut position, 0.038, 200);
        // One count in 10 ms is 1 mm/s.
        moves(&mut belt, &mut position, 0.0, 313);
        let speed = belt.speed_m_per_s().unwrap();
        assert!(speed > 0.0 && speed <= 1.01e-3, "{speed}");
    }

    #[test]
    fn payout_is_counted_when_the_counter_wraps() {
        let (mut belt, mut position) = (belt(), f64::from(i32::MAX) - 100.0);
        let fresh = moves(&mut belt, &mut position, 0.1, 1000);
        // The belt moves 3.2 mm in a thousand blocks, less one block, which sets the reference.
        let payout_m = f64::from(fresh) * 1e-5;
        assert!((payout_m - 3.1968e-3).abs() < 1.1e-5, "{payout_m}");
    }

    #[test]
    fn swinging_is_not_new_ground_but_drawing_back_is() {
        let (mut belt, mut position) = (belt(), 0.0);
        moves(&mut belt, &mut position, 0.038, 1000);
        for _ in 0..20 {
            // 1.9 mm back and forth.
            assert_eq!(moves(&mut belt, &mut position, -0.0594, 1000), 0);
            assert!(moves(&mut belt, &mut position, 0.0594, 1000) <= 1);
        }
        assert!(belt.still_blocks() >= 900, "{}", belt.still_blocks());
        // The belt moves back by 20 mm. After 2 mm, forward motion counts as new ground again.
        moves(&mut belt, &mut position, -0.625, 1000);
        let fresh = moves(&mut belt, &mut position, 0.625, 1000);
        assert!((1798..=1802).contains(&fresh), "{fresh}");
    }

    #[test]
    fn broken_line_is_a_lost_sensor_without_motion() {
        let mut belt = belt();
        assert!(belt.is_lost());
        for counts in 0..10 {
            belt.update(Some(BeltSense { counts, broken: false }));
        }
        assert!(!belt.is_lost());
        belt.update(Some(BeltSense { counts: 500, broken: true }));
        assert!(belt.is_lost() && belt.fresh_counts() == 0);
        belt.update(Some(BeltSense { counts: 900, broken: false }));
        assert_eq!((belt.is_lost(), belt.fresh_counts()), (false, 0));
        belt.update(None);
        assert!(belt.is_lost());
    }
}
