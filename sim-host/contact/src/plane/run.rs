//! A run with bristles from its start: each stretch of the timeline is a passage, and equal
//! stretches share one passage.

use super::super::SolveError;
use super::super::problem::Problem;
use super::super::timeline::{Stretch, Timeline};
use super::panel::{Bristles, Passage, Sums};
use super::passage::{Found, of_stretch};
use super::{Direction, Moment};

/// Number of stretches between two pauses.
const STRETCHES_PER_PAUSE: u32 = 256;

/// Means over the window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Means {
    pub(super) friction: f64,
    pub(super) power: Option<f64>,
    pub(super) transverse_square: f64,
    pub(super) error: f64,
    /// Number of panels of the stretches that were solved.
    pub(super) panels: u32,
    /// Coulomb force at the end of the window, N; the reference for the friction ratio.
    pub(super) coulomb_n: f64,
}

/// State of a run.
struct Run<'a> {
    problem: &'a Problem,
    bristles: Bristles,
    period_s: f64,
    /// Force of the bristles along and across, N.
    force_n: [f64; 2],
    /// Displacement of the vibration, m.
    displacement_m: f64,
    /// Passages of stretches that may recur: template, Coulomb force, N, and passage.
    known: Vec<(usize, f64, Found)>,
    panels: u32,
}

impl<'a> Run<'a> {
    fn new(problem: &'a Problem, direction: Direction) -> Self {
        let sign = problem.sign.factor();
        let direction = Direction { along: sign * direction.along, across: sign * direction.across };
        Run {
            problem,
            bristles: Bristles {
                law: problem.law,
                coulomb_n: problem.coulomb_n,
                sliding_m_per_s: problem.sliding_m_per_s,
                direction,
            },
            period_s: 1.0 / problem.waveform.frequency_hz(),
            force_n: [problem.start.force_n, 0.0],
            displacement_m: problem.start.x_m,
            known: Vec::new(),
            panels: 0,
        }
    }

    /// Begins a stretch and applies its Coulomb force.
    fn begin(&mut self, stretch: &Stretch) {
        if let Some(coulomb_n) = stretch.load {
            self.bristles.coulomb_n = coulomb_n;
        }
    }

    /// Advances to the end of a stretch, and returns its sums and their error.
    fn pass(&mut self, stretch: &Stretch) -> Result<(Sums, f64), SolveError> {
        let coulomb_n = self.bristles.coulomb_n;
        let again = stretch.template.and_then(|template| {
            self.known.iter().find(|(which, load, _)| *which == template && *load == coulomb_n).map(|(_, _, found)| *found)
        });
        let found = match again {
            Some(found) => found,
            None => {
                let found = of_stretch(&self.bristles, stretch, self.period_s, (&[], &mut |_, _| ()))?;
                self.panels += found.panels;
                self.known.extend(stretch.template.map(|template| (template, coulomb_n, found)));
                found
            }
        };
        Ok((self.go(&found.passage), found.error))
    }

    /// Returns the force of the bristles over the Coulomb force.
    fn force(&self) -> [f64; 2] {
        self.force_n.map(|force_n| force_n / self.bristles.coulomb_n)
    }

    fn go(&mut self, passage: &Passage) -> Sums {
        let start = self.force();
        self.force_n = passage.end(start).map(|force| force * self.bristles.coulomb_n);
        self.displacement_m += passage.travel_m;
        passage.sums(&self.bristles, start)
    }

    /// Returns the moment `at_s` into a stretch, at whose beginning the run is.
    fn moment(&self, stretch: &Stretch, (at_s, passage): (f64, &Passage)) -> Moment {
        let coulomb_n = self.bristles.coulomb_n;
        let u = stretch.forcing.value(at_s);
        let rates = self.bristles.rates(u);
        let friction = self.bristles.friction(&rates, passage.end(self.force()));
        Moment {
            time_s: stretch.start_s + at_s,
            displacement_m: self.displacement_m + passage.travel_m,
            vibration_m_per_s: u,
            slip_m_per_s: rates.slip,
            friction_n: friction.map(|part| part * coulomb_n),
        }
    }
}

/// Computes the means of a problem; `pause` is called from time to time.
pub(super) fn means(problem: &Problem, direction: Direction, pause: &dyn Fn()) -> Result<Means, SolveError> {
    let mut run = Run::new(problem, direction);
    let (mut open, mut error, mut done) = (false, 0.0f64, 0u32);
    // Integrals over the window: of time, of F along the sliding, of F w, and of the square of F
    // across.
    let mut sums = [Sum::default(); 4];
    for stretch in Timeline::new(&problem.up_to_window()) {
        if done.is_multiple_of(STRETCHES_PER_PAUSE) {
            pause();
        }
        done = done.wrapping_add(1);
        if stretch.closes {
            break;
        }
        open |= stretch.opens;
        run.begin(&stretch);
        let (added, off) = run.pass(&stretch)?;
        error = error.max(off);
        if open {
            let coulomb_n = run.bristles.coulomb_n;
            let square = coulomb_n * coulomb_n * added.square;
            let parts = [added.time_s, coulomb_n * added.friction, coulomb_n * added.power, square];
            sums.iter_mut().zip(parts).for_each(|(sum, part)| sum.add(part));
        }
    }
    let [time_s, along, work, square] = sums.map(Sum::total);
    let coulomb_n = run.bristles.coulomb_n;
    let sliding_j = coulomb_n * problem.sliding_m_per_s * time_s;
    Ok(Means {
        friction: along / (coulomb_n * time_s),
        power: (sliding_j != 0.0).then(|| work / sliding_j),
        transverse_square: square / (coulomb_n * coulomb_n * time_s),
        error: error.max(ROUND_OFF),
        panels: run.panels,
        coulomb_n,
    })
}

/// Compensated sum of very many terms (Neumaier 1974).
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    value: f64,
    lost: f64,
}

impl Sum {
    fn add(&mut self, part: f64) {
        let next = self.value + part;
        let (large, small) = if self.value.abs() >= part.abs() { (self.value, part) } else { (part, self.value) };
        self.lost += (large - next) + small;
        self.value = next;
    }

    fn total(self) -> f64 {
        self.value + self.lost
    }
}

/// Round-off of the means of a run.
const ROUND_OFF: f64 = 1e-14;

/// Returns moments of the last period of the run, both ends included, in `parts` steps.
pub(super) fn last_period(
    problem: &Problem,
    direction: Direction,
    parts: u32,
    pause: &dyn Fn(),
) -> Result<Vec<Moment>, SolveError> {
    let mut run = Run::new(problem, direction);
    let part_s = run.period_s / f64::from(parts);
    let from_s = (problem.duration_s - run.period_s).max(0.0);
    let mut moments: Vec<Moment> = Vec::new();
    let mut done = 0u32;
    for stretch in Timeline::new(run.problem) {
        if done.is_multiple_of(STRETCHES_PER_PAUSE) {
            pause();
        }
        done = done.wrapping_add(1);
        run.begin(&stretch);
        let end_s = stretch.start_s + stretch.length_s;
        // Time difference below which two moments count as the same.
        let same_s = 1e-6 * part_s;
        if end_s < from_s + same_s {
            run.pass(&stretch)?;
            continue;
        }
        let into = (0..=parts).map(|part| from_s + f64::from(part) * part_s - stretch.start_s);
        let into = into.filter(|into_s| (-same_s..=stretch.length_s + same_s).contains(into_s));
        let wanted: Vec<f64> = into.map(|into_s| into_s.clamp(0.0, stretch.length_s)).collect();
        let mut seen = |at_s: f64, passage: &Passage| {
            let moment = run.moment(&stretch, (at_s, passage));
            // The common moment of two stretches is reported once, unless friction or forcing jumps
            // there.
            let again = moments.last().is_some_and(|last| {
                let same = (last.vibration_m_per_s - moment.vibration_m_per_s).abs() < 1e-9 * problem.waveform.amplitude();
                (last.time_s - moment.time_s).abs() < same_s && same
            });
            if !again {
                moments.push(moment);
            }
        };
        let found = of_stretch(&run.bristles, &stretch, run.period_s, (&wanted, &mut seen))?;
        run.go(&found.passage);
    }
    Ok(moments)
}
