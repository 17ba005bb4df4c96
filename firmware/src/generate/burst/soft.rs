//! The soft edge: a raised cosine along a ramp, which an opposite gate turns round. `envelope = (1 - cos(pi ramp)) / 2`.

use core::ops::Range;

use super::Burst;
use crate::generate::nco::Stretch;
use crate::generate::shape::sine::Steady;
use crate::seam::phasor::Phasor;

/// Levels beyond this are the upper end of an edge.
const UPPER: f32 = 0.999;

impl Burst {
    /// Goes along the edge for some samples, up where the gate is open, and stays at its end. Returns how far it has come.
    ///
    /// The level is `(1 - cos(x)) / 2 = sin^2(x / 2)`, whose sine is swung; down, it is that of `-x`.
    pub(super) fn rise(&mut self, open: bool, edge: u32, span: Range<usize>) -> u32 {
        let half_angle = u64::from(self.half_turn_step * self.ramp) << 31;
        let word = u64::from(self.half_turn_step) << 31;
        let (start, room, end) =
            if open { (half_angle, edge - self.ramp, 1.0) } else { (half_angle.wrapping_neg(), self.ramp, 0.0) };
        let moving = span.len().min(room as usize);
        let mut sine = Steady::new(&Stretch { phase: start.wrapping_add(word), word, step: 0 }).swing(Phasor::new(1.0, 0.0));
        if let Some((levels, rest)) = self.levels.get_mut(span).and_then(|levels| levels.split_at_mut_checked(moving)) {
            for place in levels.iter_mut() {
                let half = sine.take();
                *place = half * half;
            }
            // Rounding may not make it louder than one, which it could at the upper end.
            let up_to_one = |level: &mut f32| *level = if *level < 1.0 { *level } else { 1.0 };
            let is_upper = |level: &&mut f32| **level > UPPER;
            levels.iter_mut().take_while(is_upper).for_each(up_to_one);
            levels.iter_mut().rev().take_while(is_upper).for_each(up_to_one);
            if moving == room as usize {
                levels.last_mut().into_iter().for_each(|last| *last = end);
                rest.fill(end);
            }
        }
        self.ramp = if open { self.ramp + moving as u32 } else { self.ramp - moving as u32 };
        self.ramp
    }
}
