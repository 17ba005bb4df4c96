//! Integral of the friction at a few moments of the window. The means between these marks
//! distinguish two runs whose means over the whole window agree by chance.
//!
//! The moments are beginnings of stretches. These do not depend on the steps or the method, so two
//! runs of a problem have marks at the same moments. If all places are taken, every second mark is
//! dropped, and from then on only every second moment is marked.

/// Largest number of marks.
const CAPACITY: usize = 8;

/// Integrals of the friction at moments of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Marks {
    marks: [(f64, f64); CAPACITY],
    count: usize,
    /// Power of two of the number of moments from one mark to the next.
    spacing: u32,
    seen: u64,
}

impl Marks {
    /// Adds the beginning of a stretch: time, s, and integral of the friction, N s.
    #[inline]
    pub fn add(&mut self, time_s: f64, friction_n_s: f64) {
        if self.seen & ((1 << self.spacing) - 1) == 0 {
            if self.count == CAPACITY {
                for place in 0..CAPACITY / 2 {
                    self.marks[place] = self.marks[2 * place];
                }
                self.count = CAPACITY / 2;
                self.spacing += 1;
            }
            self.marks[self.count] = (time_s, friction_n_s);
            self.count += 1;
        }
        self.seen += 1;
    }

    /// Returns times, s, and integrals since the beginning of the run, N s.
    pub fn get(&self) -> &[(f64, f64)] {
        &self.marks[..self.count]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_stay_evenly_spaced() {
        for moments in [1u32, 5, 16, 17, 100, 1000, 4097] {
            let mut marks = Marks::default();
            (0..moments).for_each(|moment| marks.add(f64::from(moment), 2.0 * f64::from(moment)));
            let kept = marks.get();
            assert_eq!(kept[0], (0.0, 0.0));
            assert!(kept.len() >= (moments as usize).min(CAPACITY / 2) && kept.len() <= CAPACITY, "{moments}: {kept:?}");
            for pair in kept.windows(2) {
                assert_eq!((pair[1].0 - pair[0].0, pair[1].1), (kept[1].0 - kept[0].0, 2.0 * pair[1].0), "{moments}");
            }
            assert!(f64::from(moments) - kept[kept.len() - 1].0 <= (f64::from(moments) / 4.0 * 2.0).max(1.0));
        }
    }
}
