//! The friction's integral at a few moments of the window: the means between them tell two runs apart where the mean of the whole window
//! agrees by chance.
//!
//! The moments are beginnings of stretches, which are the same whatever the steps and the method, so the marks of two runs of a problem
//! are at the same moments. When all places are taken every second mark is dropped, and from then on every second moment is left out.

/// Places for marks.
const PLACES: usize = 8;

/// Integrals of the friction at moments of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Marks {
    marks: [(f64, f64); PLACES],
    count: usize,
    /// Moments between two marks are 2 to this power.
    spacing: u32,
    seen: u64,
}

impl Marks {
    /// A stretch begins at this time, s, at this integral of the friction, N s.
    #[inline]
    pub fn add(&mut self, time_s: f64, friction_n_s: f64) {
        if self.seen & ((1 << self.spacing) - 1) == 0 {
            if self.count == PLACES {
                for place in 0..PLACES / 2 {
                    self.marks[place] = self.marks[2 * place];
                }
                self.count = PLACES / 2;
                self.spacing += 1;
            }
            self.marks[self.count] = (time_s, friction_n_s);
            self.count += 1;
        }
        self.seen += 1;
    }

    /// Times, s, and integrals since the beginning of the run, N s.
    pub fn get(&self) -> &[(f64, f64)] {
        &self.marks[..self.count]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_stay_evenly_spaced_however_many_moments_there_are() {
        for moments in [1u32, 5, 16, 17, 100, 1000, 4097] {
            let mut marks = Marks::default();
            (0..moments).for_each(|moment| marks.add(f64::from(moment), 2.0 * f64::from(moment)));
            let kept = marks.get();
            assert_eq!(kept[0], (0.0, 0.0));
            assert!(kept.len() >= (moments as usize).min(PLACES / 2) && kept.len() <= PLACES, "{moments}: {kept:?}");
            for pair in kept.windows(2) {
                assert_eq!((pair[1].0 - pair[0].0, pair[1].1), (kept[1].0 - kept[0].0, 2.0 * pair[1].0), "{moments}");
            }
            assert!(f64::from(moments) - kept[kept.len() - 1].0 <= (f64::from(moments) / 4.0 * 2.0).max(1.0));
        }
    }
}
