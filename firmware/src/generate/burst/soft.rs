//! The soft edge: a raised cosine along a ramp, which an opposite gate reverses.
//! `envelope = (1 - cos(pi ramp)) / 2`.

use core::ops::Range;

use super::Burst;
use super::envelope::Levels;
use crate::generate::nco::Stretch;
use crate::generate::shape::sine::Steady;
use crate::seam::phasor::Phasor;

impl Burst {
    /// Advances along the edge, up if the gate is open, and stays at its end. Returns the position
    /// on the ramp.
    ///
    /// The level is `(1 - cos(x)) / 2 = sin^2(x / 2)`, from a generated sine. A falling edge has
    /// the same level with `-x` instead of `x`, so that the generator runs forwards.
    pub(super) fn rise(&mut self, open: bool, edge: u32, span: Range<usize>) -> u32 {
        let half_angle = u64::from(self.half_turn_step * self.ramp) << 31;
        let word = u64::from(self.half_turn_step) << 31;
        let (start, room, end) =
            if open { (half_angle, edge - self.ramp, 1.0) } else { (half_angle.wrapping_neg(), self.ramp, 0.0) };
        let moving = span.len().min(room as usize);
        let mut sine = Steady::new(&Stretch { phase: start.wrapping_add(word), word, step: 0 }).swing(Phasor::new(1.0, 0.0));
        let one = Levels::one(self.loudest);
        if let Some((levels, rest)) = self.levels.get_mut(span).and_then(|levels| levels.split_at_mut_checked(moving)) {
            let mut sum = 0.0;
            for place in levels.iter_mut() {
                let half = sine.take();
                sum += half * half;
                *place = (half * half * one) as i32;
            }
            if moving == room as usize {
                let end_part = (end * one) as i32;
                levels.last_mut().into_iter().for_each(|last| *last = end_part);
                rest.fill(end_part);
                sum += end * rest.len() as f32;
            }
            self.sum += sum;
        }
        self.ramp = if open { self.ramp + moving as u32 } else { self.ramp - moving as u32 };
        self.ramp
    }
}
