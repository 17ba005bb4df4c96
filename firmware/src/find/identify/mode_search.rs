//! Search for the number of resonances in a spectrum, and their values.
//!
//! One more resonance is assumed at the line with the largest residual, and all resonances are
//! fitted together. The fit is accepted if each resonance exceeds seven standard deviations and if
//! the variance of the residual is halved, or if that falls to a twentieth. Fewer resonances do not
//! explain several that overlap: a fit with a weak one is therefore kept as a start while its
//! residual is more than ten times the expected one. The result is the last fit without a weak
//! resonance. The search ends when the residual is within the noise of the converters, or with four
//! resonances. Each block does as much work as its time permits.

use heapless::Vec;

use crate::find::identify::pole_fit::{Circuit, Pole, PoleFit, Solution};
use crate::find::scan::spectrum::Spectrum;
use crate::seam::transducer::{Deviations, LockQuality, MOST_MODES, Transducer};

/// Maximum iterations of a fit.
const ITERATIONS: u8 = 12;
/// Displacement of the resonances per iteration below which a fit has converged, in widths.
const CONVERGED_WIDTHS: f32 = 3e-4;
/// The same for a fit whose residual shows one more resonance: that one will move all others.
const ROUGH_WIDTHS: f32 = 0.03;
/// Residual variance that shows one more resonance, relative to that which needs no explanation.
const ROUGH_VARIANCE_RATIO: f32 = 10.0;
/// Minimum strength of a resonance, in standard deviations.
const MIN_STRENGTH_SIGMAS: f32 = 7.0;
/// Maximum residual variance with one more resonance, relative to that without it.
const MAX_VARIANCE_RATIO: f32 = 0.5;
/// Residual variance, relative to that without the resonance, below which the standard deviation of
/// its strength does not count: two that overlap share theirs in many ways.
const CERTAIN_VARIANCE_RATIO: f32 = 0.05;
/// Tangent of the maximum angle between the admittances of two resonances, 60 degrees: skew of the
/// sense channels turns both. A fit that turns one further describes no resonance.
const MAX_TURN: f32 = 1.7;
/// Number of iterations after which one more resonance must have reduced the variance.
const PATIENCE_ITERATIONS: u8 = 1;
/// Maximum residual variance after [`PATIENCE_ITERATIONS`] iterations, relative to that without the
/// resonance.
const PATIENCE_VARIANCE_RATIO: f32 = 0.5;
/// Squared residual of a line, relative to the mean of the others, above which a resonance is
/// assumed there.
const OUTLIER_SQUARE_RATIO: f32 = 10.0;
/// Noise of the converters that needs no explanation, steps: one, and rounding, is 1.04.
const NOISE_STEPS: f32 = 1.2;
/// Residual that needs no explanation, relative to the largest line.
const UNEXPLAINED_REL: f32 = 3e-4;
/// Maximum distance of a resonance from the centre of the spectrum, in half spans; a single
/// resonance may be farther.
pub(crate) const MAX_DISTANCE_HALF_SPANS: f32 = 2.0;

#[derive(Clone, Debug, PartialEq)]
enum Stage {
    /// Finds the line with the largest residual.
    Seek {
        best: (f32, usize),
        sum: f32,
        largest: f32,
    },
    /// Assumes one more resonance at this line.
    Assume {
        line: usize,
    },
    /// Adds the lines to the fit; `iterations` remain.
    Fit {
        iterations: u8,
    },
    /// Solves the fit.
    Solve {
        iterations: u8,
    },
    /// Reads the circuit from the solution.
    Read {
        iterations: u8,
    },
    /// Decides between another iteration, acceptance and the end.
    Decide {
        iterations: u8,
    },
    /// Computes the standard deviations of the fitted resonances, one after the other.
    Deviate {
        next: usize,
    },
    /// Keeps the fit if it reduces the variance enough.
    Keep,
    Done,
}

/// Mode search in progress.
#[derive(Clone, Debug)]
pub(crate) struct ModeSearch {
    nominal_q: f32,
    /// Noise of the current of a sample that needs no explanation, A.
    noise_a: f32,
    /// Expected variance of the current of a line, A^2: by the noise of the converters.
    unexplained: f32,
    /// The same, with the error of the model.
    tolerated: f32,
    most: usize,
    stage: Stage,
    line: usize,
    fit: PoleFit,
    solution: Option<Solution>,
    /// Circuit of the present fit.
    fitted: Circuit,
    deviations: Vec<Deviations, MOST_MODES>,
    /// Last fit kept, and the variance of its residual, A^2.
    found: Circuit,
    found_variance: f32,
    /// Last fit kept without a weak resonance: the result.
    certain: Found,
    /// `true` if a resonance of the present fit is weak.
    has_weak: bool,
    /// `true` while resonances are fitted that another spectrum has shown.
    refits: bool,
}

/// Result of a search.
#[derive(Clone, Debug)]
struct Found {
    circuit: Circuit,
    /// Standard deviations of its resonances.
    deviations: Vec<Deviations, MOST_MODES>,
    /// Variance of the residual, A^2.
    variance: f32,
}

impl Found {
    /// Creates a result without resonances: only the clamped capacitance and the known poles.
    fn none_of(circuit: &Circuit) -> Self {
        let circuit = Circuit { poles: Vec::new(), ..circuit.clone() };
        Found { circuit, deviations: Vec::new(), variance: f32::INFINITY }
    }
}

/// Resolution of the converters, and the nominal quality factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nominal {
    /// Volts per step and amperes per step.
    pub(crate) steps: (f32, f32),
    /// Nominal quality factor, correct within a factor of four.
    pub q: f32,
}

impl ModeSearch {
    /// Creates an idle search; it [starts](Self::restart) with its first spectrum.
    pub(crate) fn new(nominal: &Nominal, bare: Circuit) -> Self {
        ModeSearch {
            nominal_q: nominal.q,
            noise_a: NOISE_STEPS * nominal.steps.1,
            unexplained: 0.0,
            tolerated: 0.0,
            most: 0,
            stage: Stage::Done,
            line: 0,
            fit: PoleFit::new(bare, nominal.steps.0 / nominal.steps.1),
            solution: None,
            fitted: Circuit::default(),
            deviations: Vec::new(),
            found: Circuit::default(),
            found_variance: f32::INFINITY,
            certain: Found::none_of(&Circuit::default()),
            has_weak: false,
            refits: false,
        }
    }

    /// Starts from a bare capacitance, and finds up to `most` resonances. The spectrum contains
    /// `samples` samples in `blocks` blocks.
    pub(crate) fn restart(&mut self, bare: &Circuit, most: usize, blocks: u32, samples: u32) {
        self.refit(bare, blocks, samples);
        (self.most, self.refits) = (most, false);
        self.stage = Stage::Seek { best: (0.0, 0), sum: 0.0, largest: 0.0 };
    }

    /// Fits the modes of `found` again, to another spectrum, and then seeks further ones.
    pub(crate) fn refit(&mut self, found: &Circuit, blocks: u32, samples: u32) {
        // Noise of variance s^2 gives a sum of B phasors of N samples each a variance 4 B s^2 / N.
        self.unexplained = 4.0 * self.noise_a * self.noise_a * (blocks as f32) * (blocks as f32) / samples.max(1) as f32;
        self.tolerated = self.unexplained;
        self.most = MOST_MODES - found.known.len();
        self.begin(found, ITERATIONS);
        self.certain = Found::none_of(found);
        self.found.clone_from(&self.certain.circuit);
        self.found_variance = f32::INFINITY;
        self.refits = true;
    }

    /// Returns `true` if the search has ended.
    pub(crate) fn is_over(&self) -> bool {
        self.stage == Stage::Done
    }

    /// Does the work of one block.
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
                self.stage = Stage::Decide { iterations };
            }
            &Stage::Decide { iterations } => self.decide(iterations),
            &Stage::Deviate { next } => self.deviate(next, spectrum),
            Stage::Keep => self.keep(),
            Stage::Done => {}
        }
    }

    /// Returns the circuit and the standard deviations of each of its resonances.
    pub(crate) fn found(&self) -> (&Circuit, &[Deviations]) {
        (&self.certain.circuit, &self.certain.deviations)
    }

    /// Returns the quality of a lock on one of the resonances found, as far as the fit shows it.
    pub(crate) fn quality(&self, which: usize) -> LockQuality {
        LockQuality::new(0.0, self.certain.circuit.others_share(which), fpu::sqrtf(self.certain.variance / self.tolerated))
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
        self.tolerated = self.unexplained + UNEXPLAINED_REL * UNEXPLAINED_REL * largest;
        let shows = self.found_variance > self.tolerated || best.0 > self.tolerated.max(OUTLIER_SQUARE_RATIO * others);
        if self.found.poles.len() < self.most && shows {
            self.stage = Stage::Assume { line: best.1 };
        } else {
            self.stage = Stage::Done;
        }
    }

    fn assume(&mut self, spectrum: &Spectrum, line: usize) {
        let offset_hz = spectrum.offset_hz(line);
        // The nominal Q, or the Q of a resonance two lines wide if that is lower.
        let mut assumed = self.found.clone();
        let q = self.nominal_q.min(0.5 * (assumed.nominal_hz + offset_hz) / spectrum.spacing_hz());
        // There is room: `seek` checked the count.
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

    fn decide(&mut self, iterations: u8) {
        let hopeless =
            iterations <= ITERATIONS - PATIENCE_ITERATIONS && self.fit.variance() > PATIENCE_VARIANCE_RATIO * self.found_variance;
        let tolerance = if self.shows_more(self.unexplained) { ROUGH_WIDTHS } else { CONVERGED_WIDTHS };
        match self.solution.take() {
            None => self.stage = Stage::Done,
            Some(_) if hopeless => self.stage = Stage::Done,
            Some(Solution { circuit, moved }) if iterations > 1 && moved > tolerance => self.begin(&circuit, iterations - 1),
            Some(solution) => {
                self.deviations.clear();
                self.fitted = solution.circuit;
                self.has_weak = false;
                self.stage = Stage::Deviate { next: 0 };
            }
        }
    }

    /// Returns `true` if the residual of the present fit is far above this variance, A^2, so that
    /// there may be one more resonance.
    fn shows_more(&self, variance: f32) -> bool {
        self.fit.variance() > ROUGH_VARIANCE_RATIO * variance && self.found.poles.len() < self.most
    }

    fn deviate(&mut self, next: usize, spectrum: &Spectrum) {
        let Some(&Transducer { lm_h, deviations, .. }) = self.fit.deviate(&self.fitted, next) else { return };
        let offset_hz = self.fitted.poles.get(next).map_or(f32::NAN, |pole| pole.offset_hz);
        let reach_hz = 0.5 * spectrum.lines() as f32 * spectrum.spacing_hz();
        let distance_hz = (offset_hz - spectrum.centre_hz()).abs();
        // There is room for one entry per pole.
        let _ = self.deviations.push(deviations);
        let count = self.fitted.poles.len();
        let is_certain = self.refits || self.fit.variance() < CERTAIN_VARIANCE_RATIO * self.found_variance;
        let weak = MIN_STRENGTH_SIGMAS * deviations.lm_h > lm_h && !(count > 1 && is_certain) || self.is_turned(next);
        self.has_weak |= weak;
        if count > 1 && (weak && !self.shows_more(self.tolerated) || distance_hz > MAX_DISTANCE_HALF_SPANS * reach_hz) {
            self.stage = Stage::Done;
        } else if next + 1 < count {
            self.stage = Stage::Deviate { next: next + 1 };
        } else {
            self.stage = Stage::Keep;
        }
    }

    /// Returns `true` if the admittance of a fitted resonance points away from that of the
    /// strongest one.
    fn is_turned(&self, which: usize) -> bool {
        let conductances = || self.fitted.poles.iter().map(|pole| pole.conductance);
        let strongest = conductances().reduce(|a, b| if a.norm_sqr() > b.norm_sqr() { a } else { b }).unwrap_or_default();
        conductances().nth(which).is_some_and(|conductance| {
            let along = conductance * strongest.conj();
            along.im.abs() > MAX_TURN * along.re
        })
    }

    fn keep(&mut self) {
        let variance = self.fit.variance();
        let better = variance <= MAX_VARIANCE_RATIO * self.found_variance;
        if better {
            self.found.clone_from(&self.fitted);
            self.found_variance = variance;
            if !self.has_weak {
                self.certain = Found { circuit: self.fitted.clone(), deviations: self.deviations.clone(), variance };
            }
            self.refits = false;
            self.line = 0;
        }
        if better && self.found.poles.len() < self.most {
            self.stage = Stage::Seek { best: (0.0, 0), sum: 0.0, largest: 0.0 };
        } else {
            self.stage = Stage::Done;
        }
    }
}
