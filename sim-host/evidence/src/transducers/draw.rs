//! The random set: transducers of six kinds, with wrong nominal values.
//!
//! Transducer `n` is determined by `n` alone. Its circuit is drawn within the ranges of its kind,
//! log-uniformly, until its resonance is observable, `M = Q k^2 / (1 - k^2) >= 0.5` (IEEE 177), and
//! its resistance is at least a tenth of the amplifier's source resistance.
//!
//! The wider set has other seeds, and ranges of the circuit that begin at two thirds and end at 1.5
//! times these; one constant was changed because of it (see the page).
//!
//! | nominal value | error, log-uniform | for every sixth transducer of a kind, of which only the band is known |
//! |---|---|---|
//! | resonance | 3 %; window 3.75 % | 8 %; window 10 % |
//! | Q | a factor of 3 | always 160 |
//! | Lm | a factor of 2 | not given |
//! | C0 | 30 % | not given |

use std::f64::consts::TAU;

use crate::random::Random;

/// Smallest figure of merit of a transducer of the set.
pub const MIN_FIGURE_OF_MERIT: f64 = 0.5;
/// Smallest motional resistance, ohm: a tenth of the source resistance of the scenes' amplifier.
pub const MIN_RM_OHM: f64 = 0.03;
/// Seed of the first transducer of the wider set.
const WIDER_SEED: u64 = 1 << 32;
/// Factor by which the ranges of the wider set begin lower and end higher.
const WIDER_FACTOR: f64 = 1.5;
/// Largest coupling of the wider set.
const MAX_COUPLING: f64 = 0.8;
/// Largest motional inductance of a mode in a scene, H.
const MAX_LM_H: f64 = 1e4;
/// Interval between transducers of a kind of which only the band is known.
const BAND_ONLY_INTERVAL: u32 = 6;
/// Nominal Q of a transducer of which only the band is known: the middle of the occurring range.
pub const GUESSED_Q: f64 = 160.0;
/// Largest number of steps of a scene's coarse scan, which together with the window limits a
/// nominal Q.
const MAX_SCAN_STEPS: f64 = 400.0;

/// Kind of transducer, with the ranges of its circuit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kind {
    /// Name of the kind in tables.
    pub name: &'static str,
    /// Series resonance, Hz.
    pub hz: (f64, f64),
    /// Quality factor at series resonance.
    pub q: (f64, f64),
    /// Effective coupling.
    pub coupling: (f64, f64),
    /// Clamped capacitance, F.
    pub c0_f: (f64, f64),
    /// Number of further modes.
    pub modes: usize,
}

/// Kinds of the set. The ranges of the last two cover those of all others.
pub const KINDS: [Kind; 6] = [
    Kind { name: "Langevin", hz: (18e3, 60e3), q: (100.0, 2000.0), coupling: (0.1, 0.4), c0_f: (1e-9, 15e-9), modes: 0 },
    Kind { name: "PMN-PT stack", hz: (20e3, 100e3), q: (5.0, 200.0), coupling: (0.3, 0.75), c0_f: (30e-9, 3e-6), modes: 0 },
    Kind { name: "welder with horn", hz: (18e3, 40e3), q: (300.0, 5000.0), coupling: (0.03, 0.2), c0_f: (2e-9, 50e-9), modes: 0 },
    Kind {
        name: "weakly coupled ring",
        hz: (20e3, 100e3),
        q: (100.0, 5000.0),
        coupling: (0.02, 0.1),
        c0_f: (0.3e-9, 20e-9),
        modes: 0,
    },
    Kind { name: "two modes", hz: (18e3, 100e3), q: (5.0, 5000.0), coupling: (0.02, 0.75), c0_f: (0.3e-9, 3e-6), modes: 1 },
    Kind { name: "three modes", hz: (18e3, 100e3), q: (5.0, 5000.0), coupling: (0.02, 0.75), c0_f: (0.3e-9, 3e-6), modes: 2 },
];

/// Further mode of a transducer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FurtherMode {
    /// Series resonance of the mode, Hz: 0.3 % to 15 % above or below the working mode.
    pub hz: f64,
    /// Quality factor of the mode: a fifth to five times that of the working mode.
    pub q: f64,
    /// Motional capacitance over that of the working mode: 1 % to 30 %.
    pub share: f64,
}

/// Nominal values of a transducer in the controller's settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nominal {
    /// Nominal resonance, Hz.
    pub hz: f64,
    /// Frequency window on each side, relative.
    pub span: f64,
    /// Nominal quality factor.
    pub q: f64,
    /// Nominal motional inductance, H, if one is given.
    pub lm_h: Option<f64>,
    /// Nominal clamped capacitance, F, if one is given.
    pub c0_f: Option<f64>,
}

/// Transducer of the set.
#[derive(Clone, Debug, PartialEq)]
pub struct Transducer {
    /// Number of the transducer in the set, from zero.
    pub number: u32,
    /// Kind of the transducer.
    pub kind: &'static Kind,
    /// Series resonance, Hz.
    pub hz: f64,
    /// Quality factor at series resonance.
    pub q: f64,
    /// Effective coupling.
    pub coupling: f64,
    /// Clamped capacitance, F.
    pub c0_f: f64,
    /// Further modes of the transducer.
    pub modes: Vec<FurtherMode>,
    /// `true` if only the band of the transducer is known.
    pub band_only: bool,
    /// Nominal values of the transducer.
    pub nominal: Nominal,
}

impl Transducer {
    /// Draws transducer `number`; the kinds alternate.
    pub fn draw(number: u32) -> Self {
        Transducer::draw_from(Random::new(number.into()), number, 1.0)
    }

    /// Draws transducer `number` of the wider set.
    pub fn draw_wider(number: u32) -> Self {
        Transducer::draw_from(Random::new(WIDER_SEED + u64::from(number)), number, WIDER_FACTOR)
    }

    /// Draws a transducer from ranges whose ends are a factor further out.
    fn draw_from(mut random: Random, number: u32, factor: f64) -> Self {
        let kinds = KINDS.len() as u32;
        let kind = &KINDS[(number % kinds) as usize];
        let mut transducer = loop {
            let wider = |(from, to): (f64, f64)| (from / factor, to * factor);
            let coupling = (kind.coupling.0 / factor, (kind.coupling.1 * factor).min(MAX_COUPLING));
            let [hz, q, coupling, c0_f] =
                [wider(kind.hz), wider(kind.q), coupling, wider(kind.c0_f)].map(|(from, to)| random.log(from, to));
            let nominal = Nominal { hz, span: 0.0, q, lm_h: None, c0_f: None };
            let mut drawn = Transducer { number, kind, hz, q, coupling, c0_f, modes: Vec::new(), band_only: false, nominal };
            if drawn.figure_of_merit() < MIN_FIGURE_OF_MERIT || drawn.rm_ohm() < MIN_RM_OHM {
                continue;
            }
            drawn.modes = (0..kind.modes).map(|_| random.further(drawn.hz, drawn.q)).collect();
            if drawn.modes.iter().all(|mode| drawn.lm_h() / mode.share * (drawn.hz / mode.hz).powi(2) < MAX_LM_H) {
                break drawn;
            }
        };
        transducer.band_only = number / kinds % BAND_ONLY_INTERVAL == BAND_ONLY_INTERVAL - 1;
        transducer.nominal = random.nominal(&transducer);
        transducer
    }

    /// Returns the motional capacitance, F: `C0 k^2 / (1 - k^2)`.
    pub fn cm_f(&self) -> f64 {
        self.c0_f * self.coupling.powi(2) / (1.0 - self.coupling.powi(2))
    }

    /// Returns the motional inductance, H.
    pub fn lm_h(&self) -> f64 {
        1.0 / ((TAU * self.hz).powi(2) * self.cm_f())
    }

    /// Returns the motional resistance, ohm.
    pub fn rm_ohm(&self) -> f64 {
        1.0 / (TAU * self.hz * self.cm_f() * self.q)
    }

    /// Returns the figure of merit, `M = 1 / (omega C0 Rm)`.
    pub fn figure_of_merit(&self) -> f64 {
        self.q * self.cm_f() / self.c0_f
    }
}

/// Draws parts of a transducer.
impl Random {
    /// Draws a further mode near a resonance, Hz, with a quality factor.
    fn further(&mut self, hz: f64, q: f64) -> FurtherMode {
        let side = if self.toss() { -1.0 } else { 1.0 };
        let apart = side * self.log(0.003, 0.15);
        let (mode_q, share) = (q * 5.0f64.powf(self.side()), self.log(0.01, 0.3));
        FurtherMode { hz: hz * (1.0 + apart), q: mode_q.max(2.0), share }
    }

    /// Draws wrong nominal values.
    fn nominal(&mut self, of: &Transducer) -> Nominal {
        let [hz, q, lm, c0] = [self.side(), self.side(), self.side(), self.side()];
        if of.band_only {
            return Nominal { hz: of.hz * (1.0 + 0.08 * hz), span: 0.1, q: GUESSED_Q, lm_h: None, c0_f: None };
        }
        let span = 0.0375;
        // Limits of a scene: a Q of at least 2, and the steps of the scan.
        let q = (of.q * 3f64.powf(q)).clamp(2.0, MAX_SCAN_STEPS / (2.0 * span));
        let lm_h = Some(of.lm_h() * 2f64.powf(lm));
        Nominal { hz: of.hz * (1.0 + 0.03 * hz), span, q, lm_h, c0_f: Some(of.c0_f * 1.3f64.powf(c0)) }
    }
}
