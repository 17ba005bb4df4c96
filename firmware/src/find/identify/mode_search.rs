//! How many resonances a spectrum shows, and which.
//!
//! Where the lines stand out most of what is explained so far, one more resonance is assumed, and all of them are fitted together. It is
//! accepted if each of them is there by seven standard deviations and if it halves what is left. That ends when what is left is no more than
//! the converters' noise may be, or with four. A block does as much of it as one has time for.

use heapless::Vec;

use crate::find::identify::pole_fit::{Circuit, Pole, PoleFit, Solution};
use crate::find::scan::spectrum::Spectrum;
use crate::seam::transducer::{Deviations, MOST_MODES, Transducer};

/// Most iterations of a fit.
const ITERATIONS: u8 = 12;
/// Resonances stand still if they move by less than this part of their width.
const STANDS_STILL: f32 = 3e-4;
/// The least strength of a resonance in standard deviations.
const SIGNIFICANT: f32 = 7.0;
/// One more resonance leaves at most this part of the variance.
const HALVES: f32 = 0.5;
/// After so many iterations of [`ITERATIONS`] one more resonance must have begun to explain something.
const PATIENCE: u8 = 4;
const BEGUN: f32 = 0.9;
/// A line stands out if its square is so many times the mean of the others'.
const STANDS_OUT: f32 = 10.0;
/// What needs no explanation: noise of the converters, steps; and a part of the largest line.
const NOISE_STEPS: f32 = 3.0;
const PART: f32 = 3e-3;
/// How far beyond the lines a resonance may be that is only seen from one side, parts of half their span.
const BEYOND: f32 = 2.0;

#[derive(Clone, Debug, PartialEq)]
enum Stage {
    /// Looks for the line that stands out most.
    Seek {
        best: (f32, usize),
        sum: f32,
        largest: f32,
    },
    /// Assumes one more resonance, at this line.
    Assume {
        line: usize,
    },
    /// So many iterations are left.
    Fit {
        iterations: u8,
    },
    /// Solves what has been gathered.
    Solve {
        iterations: u8,
    },
    /// Reads the circuit that the solution is, and then goes on from there.
    Read {
        iterations: u8,
    },
    Go {
        iterations: u8,
    },
    /// States the deviations of what has been fitted, one resonance after the other.
    State {
        next: usize,
    },
    /// Keeps all of it, if it explains enough.
    Keep,
    Done,
}

/// The search, in progress.
#[derive(Clone, Debug)]
pub(crate) struct ModeSearch {
    nominal_q: f32,
    /// Noise of a sample's current that needs no explanation, A.
    amperes: f32,
    /// Variance of a line's current that needs no explanation, A^2.
    unexplained: f32,
    most: usize,
    stage: Stage,
    line: usize,
    fit: PoleFit,
    solution: Option<Solution>,
    /// Of the present fit.
    fitted: Circuit,
    deviations: Vec<Deviations, MOST_MODES>,
    found: Circuit,
    found_deviations: Vec<Deviations, MOST_MODES>,
    found_variance: f32,
}

/// Steps of the converters, and the nominal Q.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nominal {
    /// Volts and amperes a step.
    pub(crate) steps: (f32, f32),
    /// Quality factor, within a factor of four.
    pub q: f32,
}

impl ModeSearch {
    /// A search by a bare capacitance, that [begins](Self::restart) with its first spectrum.
    pub(crate) fn new(nominal: &Nominal, bare: Circuit) -> Self {
        ModeSearch {
            nominal_q: nominal.q,
            amperes: NOISE_STEPS * nominal.steps.1,
            unexplained: 0.0,
            most: 0,
            stage: Stage::Done,
            line: 0,
            fit: PoleFit::new(bare, nominal.steps.0 / nominal.steps.1),
            solution: None,
            fitted: Circuit::default(),
            deviations: Vec::new(),
            found: Circuit::default(),
            found_deviations: Vec::new(),
            found_variance: f32::INFINITY,
        }
    }

    /// Begins from scratch. `samples` are all that the spectrum has taken, in `blocks`.
    pub(crate) fn restart(&mut self, bare: &Circuit, blocks: u32, samples: u32) {
        self.again(bare, blocks, samples);
        self.most = MOST_MODES;
        self.stage = Stage::Seek { best: (0.0, 0), sum: 0.0, largest: 0.0 };
    }

    /// Fits the same modes again to another spectrum.
    pub(crate) fn again(&mut self, found: &Circuit, blocks: u32, samples: u32) {
        // Of noise of variance s^2, a sum of B phasors of N samples each has 4 B s^2 / N.
        self.unexplained = 4.0 * self.amperes * self.amperes * (blocks as f32) * (blocks as f32) / samples.max(1) as f32;
        self.most = found.poles.len();
        self.begin(found, ITERATIONS);
        self.found.clone_from(found);
        self.found.poles.clear();
        self.deviations.clear();
        self.found_deviations.clear();
        self.found_variance = f32::INFINITY;
    }

    /// Whether it is over.
    pub(crate) fn is_over(&self) -> bool {
        self.stage == Stage::Done
    }

    /// Does a block's worth of it.
    pub(crate) fn step(&mut self, spectrum: &Spectrum) {
        match &self.stage {
            &Stage::Seek { best, sum, largest } => self.seek(spectrum, best, sum, largest),
            &Stage::Assume { line } => self.assume(spectrum, line),
            &Stage::Fit { iterations } => self.fit(spectrum, iterations),
            &Stage::Solve { iterations } => {
                if self.fit.solve() {
                    self.stage = Stage::Read { iterations };
                }
            }
            &Stage::Read { iterations } => {
                self.solution = self.fit.solution();
                self.stage = Stage::Go { iterations };
            }
            &Stage::Go { iterations } => self.go_on(iterations),
            &Stage::State { next } => self.state(next, spectrum),
            Stage::Keep => self.keep(),
            Stage::Done => {}
        }
    }

    /// What was found.
    pub(crate) fn found(&self) -> (&Circuit, &[Deviations]) {
        (&self.found, &self.found_deviations)
    }

    fn seek(&mut self, spectrum: &Spectrum, best: (f32, usize), sum: f32, largest: f32) {
        let (offset_hz, line) = (spectrum.offset_hz(self.line), spectrum.at(self.line));
        let left = (line.i - self.found.current(offset_hz, line.v)).norm_sqr();
        let best = if left > best.0 { (left, self.line) } else { best };
        let (sum, largest) = (sum + left, largest.max(line.i.norm_sqr()));
        self.line += 1;
        if self.line < spectrum.lines() {
            self.stage = Stage::Seek { best, sum, largest };
            return;
        }
        let others = (sum - best.0) / (spectrum.lines() - 1) as f32;
        let unexplained = self.unexplained + PART * PART * largest;
        let shows = self.found_variance > unexplained || best.0 > unexplained.max(STANDS_OUT * others);
        self.stage = Stage::Done;
        if self.found.poles.len() < self.most && shows {
            self.stage = Stage::Assume { line: best.1 };
        }
    }

    fn assume(&mut self, spectrum: &Spectrum, line: usize) {
        let offset_hz = spectrum.offset_hz(line);
        // The nominal Q, or that of a width of two lines, whichever is less sharp.
        let q = self.nominal_q.min(0.5 * (self.found.nominal_hz + offset_hz) / spectrum.spacing_hz());
        let mut assumed = self.found.clone();
        // There is room: there are less than the most.
        let _ = assumed.poles.push(Pole { offset_hz, q, ..Pole::default() });
        self.begin(&assumed, ITERATIONS);
    }

    fn begin(&mut self, assumed: &Circuit, iterations: u8) {
        self.fit.restart(assumed);
        self.line = 0;
        self.stage = Stage::Fit { iterations };
    }

    fn fit(&mut self, spectrum: &Spectrum, iterations: u8) {
        if self.fit.add(spectrum.offset_hz(self.line), &spectrum.at(self.line)) {
            self.line += 1;
        }
        if self.line < spectrum.lines() {
            return;
        }
        self.stage = Stage::Solve { iterations };
    }

    fn go_on(&mut self, iterations: u8) {
        let hopeless = iterations <= ITERATIONS - PATIENCE && self.fit.variance() > BEGUN * self.found_variance;
        match self.solution.take() {
            None => self.stage = Stage::Done,
            Some(_) if hopeless => self.stage = Stage::Done,
            Some(Solution { circuit, moved }) if iterations > 1 && moved > STANDS_STILL => self.begin(&circuit, iterations - 1),
            Some(solution) => {
                self.deviations.clear();
                self.fitted = solution.circuit;
                self.stage = Stage::State { next: 0 };
            }
        }
    }

    fn state(&mut self, next: usize, spectrum: &Spectrum) {
        let Some(&Transducer { lm_h, deviations, .. }) = self.fit.state(&self.fitted, next) else { return };
        let offset_hz = self.fitted.poles.get(next).map_or(f32::NAN, |pole| pole.offset_hz);
        let reach_hz = 0.5 * spectrum.lines() as f32 * spectrum.spacing_hz();
        let beside_hz = (offset_hz - spectrum.centre_hz()).abs();
        // There is room: there are as many as poles.
        let _ = self.deviations.push(deviations);
        let count = self.fitted.poles.len();
        if SIGNIFICANT * deviations.lm_h > lm_h || (count > 1 && beside_hz > BEYOND * reach_hz) {
            self.stage = Stage::Done;
        } else if next + 1 < count {
            self.stage = Stage::State { next: next + 1 };
        } else {
            self.stage = Stage::Keep;
        }
    }

    fn keep(&mut self) {
        let variance = self.fit.variance();
        self.stage = Stage::Done;
        if variance <= HALVES * self.found_variance {
            self.found.clone_from(&self.fitted);
            self.found_deviations.clone_from(&self.deviations);
            self.found_variance = variance;
            self.line = 0;
            if self.found.poles.len() < self.most {
                self.stage = Stage::Seek { best: (0.0, 0), sum: 0.0, largest: 0.0 };
            }
        }
    }
}
