//! Division of a problem's time into stretches: each has one smooth forcing and one Coulomb force,
//! and lies inside or outside the window.

use super::forcing::Forcing;
use super::problem::Problem;

/// Smooth stretch of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Beginning of the stretch, s.
    pub start_s: f64,
    /// Length, s. Whole pieces of a periodic waveform have bit-equal lengths.
    pub length_s: f64,
    /// Index of the piece within the period, if the stretch is a whole piece; `None` if no other
    /// stretch is equal to it.
    pub template: Option<usize>,
    /// Forcing since the beginning of the stretch.
    pub forcing: Forcing,
    /// Highest frequency in the stretch, Hz: of the oscillator or its damper, of a cosine, or of
    /// the waveform to which a line belongs.
    pub fastest_hz: f64,
    /// New Coulomb force from the beginning of the stretch, N; `None` if it does not change.
    pub load: Option<f64>,
    /// `true` if the window of the means begins here.
    pub opens: bool,
    /// `true` if the window of the means ends here.
    pub closes: bool,
}

impl Stretch {
    /// Returns the number of steps in this stretch, for `per_period` steps per period of the
    /// highest frequency.
    pub fn steps(&self, per_period: u32) -> u32 {
        // A stretch of exactly one period, within round-off, has exactly `per_period` steps.
        ((f64::from(per_period) * self.fastest_hz * self.length_s - 1e-6).ceil() as u32).max(1)
    }
}

/// Event at a moment that is not the boundary of a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stop {
    Open,
    Close,
    Load(f64),
    Break,
    End,
}

/// Stretches of a problem, in order of time.
pub struct Timeline<'a> {
    problem: &'a Problem,
    stops: Vec<(f64, Stop)>,
    /// Number of stops already passed.
    passed: usize,
    now_s: f64,
    index: u64,
    /// Time difference below which two moments count as the same, s.
    same_s: f64,
}

impl<'a> Timeline<'a> {
    /// Creates the timeline of a problem, from time zero.
    pub fn new(problem: &'a Problem) -> Self {
        let (from_s, to_s) = problem.window_s;
        let mut stops = vec![(from_s, Stop::Open), (to_s, Stop::Close), (problem.duration_s, Stop::End)];
        stops.extend(problem.load_steps.iter().map(|&(at_s, force)| (at_s, Stop::Load(force))));
        stops.extend(problem.waveform.breaks().into_iter().map(|at_s| (at_s, Stop::Break)));
        // The sort is stable: events at the same moment keep the order of this list, and the end
        // comes last.
        stops.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1 == Stop::End).cmp(&(b.1 == Stop::End))));
        let same_s = 1e-9 / problem.waveform.frequency_hz();
        Timeline { problem, stops, passed: 0, now_s: 0.0, index: 0, same_s }
    }
}

impl Iterator for Timeline<'_> {
    type Item = Stretch;

    fn next(&mut self) -> Option<Stretch> {
        let (mut load, mut opens, mut closes) = (None, false, false);
        while let Some(&(at_s, stop)) = self.stops.get(self.passed).filter(|stop| stop.0 <= self.now_s + self.same_s) {
            match stop {
                Stop::Open => opens = true,
                Stop::Close => closes = true,
                Stop::Load(force) => load = Some(force),
                Stop::Break => {}
                Stop::End => return None,
            }
            self.now_s = self.now_s.max(at_s - self.same_s);
            self.passed += 1;
        }
        let mut piece = self.problem.waveform.piece(self.index);
        while piece.start_s + piece.length_s <= self.now_s + self.same_s {
            self.index += 1;
            piece = self.problem.waveform.piece(self.index);
        }
        let fresh = (piece.start_s - self.now_s).abs() <= self.same_s;
        let start_s = if fresh { piece.start_s } else { self.now_s };
        let piece_end_s = piece.start_s + piece.length_s;
        let cut = self.stops.get(self.passed).map(|stop| stop.0).filter(|&at_s| at_s < piece_end_s - self.same_s);
        let forcing = if fresh { piece.forcing } else { self.problem.waveform.forcing_from(self.index, start_s) };
        let (length_s, template) = match cut {
            None if fresh => (piece.length_s, piece.template),
            _ => (cut.unwrap_or(piece_end_s) - start_s, None),
        };
        self.now_s = cut.unwrap_or(piece_end_s);
        let forcing_hz = forcing.fastest_hz(length_s).unwrap_or(self.problem.waveform.frequency_hz());
        let fastest_hz = forcing_hz.max(self.problem.motion.fastest_hz());
        Some(Stretch { start_s, length_s, template, forcing, fastest_hz, load, opens, closes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table_4_1::table_4_1;
    use crate::{Motion, Shape, Waveform};

    fn stretches(shape: Shape, change: impl Fn(&mut Problem)) -> Vec<Stretch> {
        let mut problem = table_4_1(0.5, 20.0);
        problem.waveform = Waveform::new(shape, 1.0, 60e3, problem.duration_s);
        change(&mut problem);
        Timeline::new(&problem).collect()
    }

    #[test]
    fn stretches_are_gapless_and_the_window_opens_and_closes() {
        for shape in [
            Shape::Sine,
            Shape::Square,
            Shape::Random { hold_s: 0.7e-6, seed: 1 },
            Shape::Chirp { start_hz: 20e3, stop_hz: 200e3, sweep_s: 0.2e-3 },
        ] {
            let change = |problem: &mut Problem| {
                problem.window_s = (3.3 / 60e3, 11.0 / 60e3);
                problem.load_steps = vec![(5.0 / 60e3, 0.5), (6.21 / 60e3, 0.7)];
            };
            let all = stretches(shape, change);
            for pair in all.windows(2) {
                assert!((pair[0].start_s + pair[0].length_s - pair[1].start_s).abs() < 1e-13, "{shape:?} {pair:?}");
                assert!(pair[0].length_s > 1e-13);
            }
            let last = all[all.len() - 1];
            assert!((last.start_s + last.length_s - 20.0 / 60e3).abs() < 1e-13, "{shape:?}");
            let at = |chosen: &dyn Fn(&Stretch) -> bool| {
                all.iter().filter(|s| chosen(s)).map(|s| s.start_s * 60e3).collect::<Vec<_>>()
            };
            assert!(at(&|s| s.opens).iter().all(|t| (t - 3.3).abs() < 1e-6) && at(&|s| s.opens).len() == 1);
            assert!(at(&|s| s.closes).iter().all(|t| (t - 11.0).abs() < 1e-6) && at(&|s| s.closes).len() == 1);
            assert_eq!(at(&|s| s.load.is_some()).len(), 2);
        }
    }

    #[test]
    fn whole_pieces_are_equal() {
        let all = stretches(Shape::Square, |problem| problem.window_s = (1.0 / 60e3, 2.0 / 60e3));
        assert_eq!(all.len(), 40);
        for (index, stretch) in all.iter().enumerate() {
            assert_eq!((stretch.template, stretch.length_s), (Some(index % 2), all[0].length_s));
        }
    }

    #[test]
    fn steps_follow_the_highest_frequency() {
        for (shape, natural, steps) in [(Shape::Sine, 12e3, 16), (Shape::Sine, 90e3, 24), (Shape::Square, 12e3, 8)] {
            let set = |problem: &mut Problem| {
                let stiffness_n_per_m = 0.02 * (std::f64::consts::TAU * natural).powi(2);
                problem.motion = Motion::Sdof { mass_kg: 0.02, stiffness_n_per_m, damping_n_s_per_m: 0.0 };
            };
            assert_eq!(stretches(shape, set)[0].steps(16), steps);
        }
        assert_eq!(stretches(Shape::Square, |problem| problem.motion = Motion::Kinematic)[0].steps(16), 8);
    }
}
