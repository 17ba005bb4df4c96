//! What is known of the transducer, and what follows it: tracker, clamped capacitance, and the equivalent circuit that is learned on the way.

use crate::find::clamped::Clamped;
use crate::find::clamped::online::Online;
use crate::generate::amplitude::AmplitudeLoop;
use crate::generate::step::Progress;
use crate::seam::config::Config;
use crate::seam::fault::Fault;
use crate::seam::mode::Mode;
use crate::seam::transducer::Transducer;
use crate::sense::motional::Motional;
use crate::track::tracker::identified::{Known, Learning};
use crate::track::tracker::observed::Retry;
use crate::track::tracker::observer::Prior;
use crate::track::tracker::{State, Tracker};

/// How often what the observer knows of the transducer is taken, blocks.
pub(crate) const LEARN_BLOCKS: u64 = 64;
/// A resonance whose motional inductance is this many times smaller or larger than its nominal value is another one.
const SAME_MODE: f32 = 2.0;
/// Where only the band is known, the calibration's Q is taken if it is known to this part.
const CLEAR_Q: f32 = 0.3;
/// Standard deviations that this leaves room for.
const SIGMAS: f32 = 3.0;

/// The tracked transducer.
#[derive(Clone, Debug)]
#[repr(C)]
pub(crate) struct TrackedTransducer {
    /// The block in which the transducer was learned.
    learned: u64,
    /// Time constant of the resonance by the nominal Q, periods.
    nominal_periods: f32,
    /// More than the band is known.
    is_known: bool,
    /// Nominal motional inductance, H, and the standard deviation of the one that was begun with, relative.
    nominal_lm_h: Option<f32>,
    lm_deviation: f32,
    /// Variances of a block's voltage and current by noise, both components, V² and A², as measured in the self-test's silence.
    pub(crate) noise: (f32, f32),
    transducer: Option<Transducer>,
    /// The transducer that is being learned, in parts.
    learning: Learning,
    pub(crate) tracker: Tracker,
    pub(crate) online: Online,
}

impl TrackedTransducer {
    /// Nothing is known but the nominal values.
    pub(crate) fn build(config: &Config, tracker: Tracker) -> Self {
        TrackedTransducer {
            learned: 0,
            nominal_periods: config.tracking.nominal_q / core::f32::consts::PI,
            is_known: config.tracking.nominal_c0_f.is_some(),
            nominal_lm_h: config.tracking.nominal_lm_h,
            lm_deviation: 0.0,
            noise: (0.0, 0.0),
            transducer: None,
            learning: Learning::default(),
            tracker,
            online: Online::build(config),
        }
    }

    /// Forgets the transducer.
    pub(crate) fn restart(&mut self) {
        self.transducer = None;
        self.learning.abandon();
        self.tracker.restart();
    }

    /// The transducer, once identified.
    pub(crate) fn transducer(&self) -> Option<&Transducer> {
        self.transducer.as_ref()
    }

    /// The transducer as it is known by now; while it is being learned, without deviations.
    pub(crate) fn transducer_by_now(&self) -> Option<&Transducer> {
        if self.learning.is_over() { self.transducer.as_ref() } else { Some(self.learning.transducer()) }
    }

    /// Time constant of the resonance as it is known by now, periods.
    pub(crate) fn periods(&self) -> f32 {
        self.transducer_by_now().map_or(self.nominal_periods, |transducer| transducer.q / core::f32::consts::PI)
    }

    /// Blocks since the transducer was learned.
    pub(crate) fn since_learned(&self, block: u64) -> u64 {
        block - self.learned
    }

    /// Rms noise of a block's motional current, A.
    fn noise_a(&self, branch: &Motional) -> f32 {
        let (v, i) = self.noise;
        libm::sqrtf(i + branch.y0.norm_sqr() * v)
    }

    /// Takes the clamped branch, and lets the observer begin anywhere in the window.
    pub(crate) fn observe(&mut self, clamped: &Clamped) {
        let window_hz = self.tracker.window_hz();
        let known_q = core::f32::consts::PI * self.nominal_periods;
        let q = if self.is_known || clamped.q.deviation > CLEAR_Q * clamped.q.value { known_q } else { clamped.q.value };
        let prior = Prior {
            offset_hz: (0.0, window_hz),
            q,
            // Measured to a part in five hundred; the nominal value is what it is compared with once it has locked.
            lm_h: (clamped.lm_h.value, clamped.lm_h.deviation),
            axis: clamped.motional.axis,
            noise_a: self.noise_a(&clamped.motional),
        };
        self.lm_deviation = clamped.lm_h.deviation / clamped.lm_h.value;
        let modes = 1 + u8::from(clamped.second_mode.is_some());
        let known = Known { c0_f: (clamped.c0_f.value, clamped.c0_f.deviation), modes: (modes, 0) };
        self.tracker.observe(clamped.motional, known, &prior);
        let (c0, hz, q) = (clamped.c0_f, clamped.resonance_hz.value, clamped.q.value);
        self.online.seed(clamped.motional, c0.deviation / c0.value, hz, q);
    }

    /// Takes the transducer that the scan has found.
    pub(crate) fn adopt(&mut self, transducer: &Transducer, branch: Motional) {
        self.tracker.seed(transducer, branch, self.noise_a(&branch));
        self.lm_deviation = transducer.deviations.lm_h / transducer.lm_h;
        let deviation = transducer.deviations.c0_f / transducer.c0_f;
        self.online.seed(branch, deviation, transducer.series_resonance_hz, transducer.q);
        self.transducer = Some(*transducer);
        self.learning.abandon();
    }

    /// Begins to take what the observer, which is sure of it, knows of the transducer. What the loops need is taken at once, and returned.
    pub(crate) fn begin_to_learn(&mut self, block: u64) -> &Transducer {
        self.tracker.learn(&mut self.learning);
        let transducer = self.learning.transducer();
        self.tracker.set_resonance(transducer);
        self.online.set_resonance(transducer.series_resonance_hz, transducer.q);
        self.learned = block;
        transducer
    }

    /// Goes on with it.
    fn continue_learning(&mut self) {
        self.learning.advance();
        if self.learning.is_over() {
            self.transducer.get_or_insert_default().copy(self.learning.transducer());
        }
    }

    /// Takes all of it at once.
    fn learn(&mut self, block: u64) {
        self.begin_to_learn(block);
        while !self.learning.is_over() {
            self.continue_learning();
        }
    }

    /// Learns the transducer again, now and then. `following`: the resonance is tracked; `whole`: all of it in one block; `idle`: this block has
    /// time for a part of it.
    pub(crate) fn learn_on(&mut self, block: u64, following: bool, whole: bool, idle: bool) {
        if following && self.transducer.is_some() && self.since_learned(block) >= LEARN_BLOCKS && self.tracker.has_converged() {
            if whole {
                self.learn(block);
            } else {
                self.begin_to_learn(block);
            }
        } else if !self.learning.is_over() && idle {
            self.continue_learning();
        }
    }

    /// How the lock is getting on.
    pub(crate) fn progress(&mut self, mode: Mode, amplitude: &AmplitudeLoop) -> Progress {
        let locking = mode == Mode::Lock;
        match self.tracker.state() {
            _ if !self.tracker.tracks() => Progress::Busy,
            State::Disagree => Progress::Failed(Fault::TrackersDisagree),
            State::Locked if self.is_another_mode() => Progress::Failed(Fault::WrongMode),
            State::Locked if amplitude.settled() => Progress::Done,
            State::Lost if !locking => self.retry_lock(Fault::LossOfLock),
            State::TimedOut | State::Lost if locking => self.retry_lock(Fault::NoLock),
            _ => Progress::Busy,
        }
    }

    /// Seeks the lock where there is more hope, if there is any left.
    fn retry_lock(&mut self, fault: Fault) -> Progress {
        match self.tracker.retry_lock(fault == Fault::LossOfLock) {
            Some(Retry::Nearby | Retry::Window) => Progress::Back(Mode::Lock),
            Some(Retry::Calibrate) => Progress::Back(Mode::SelfTest),
            Some(Retry::Scan) => Progress::Back(Mode::Scan),
            None => Progress::Failed(fault),
        }
    }

    /// Whether it has locked to another resonance than the nominal one, by its inductance, whatever that may have been off by in the beginning.
    fn is_another_mode(&self) -> bool {
        let (Some(nominal), Some(transducer)) = (self.nominal_lm_h, self.transducer_by_now()) else { return false };
        let (ratio, off) = (transducer.lm_h / nominal, SIGMAS * self.lm_deviation);
        ratio * (1.0 + off) < 1.0 / SAME_MODE || ratio > SAME_MODE * (1.0 + off)
    }
}
