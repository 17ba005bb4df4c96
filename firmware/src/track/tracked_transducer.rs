//! What is known of the transducer, and what follows it: tracker, clamped capacitance, and the equivalent circuit that is learned on the way.

use crate::find::clamped::online::{Online, Update};
use crate::find::clamped::{Clamped, Measured};
use crate::find::lanes::Lanes;
use crate::find::scan::ring_down::RingDown;
use crate::generate::amplitude::AmplitudeLoop;
use crate::generate::step::Progress;
use crate::seam::compare::{larger, smaller};
use crate::seam::config::Config;
use crate::seam::fault::{Fault, Limit};
use crate::seam::mode::Mode;
use crate::seam::transducer::Transducer;
use crate::sense::motional::Motional;
use crate::track::tracker::identified::{FROM_AFAR, Known, Learning};
use crate::track::tracker::observed::{NEARBY, Retry};
use crate::track::tracker::observer::Prior;
use crate::track::tracker::{State, Tracker};

/// How often what the observer knows of the transducer is taken, blocks.
pub(crate) const LEARN_BLOCKS: u64 = 64;
/// A resonance whose motional inductance is this many times smaller or larger than its nominal value is another one.
const SAME_MODE: f32 = 2.0;
/// Where only the band is known, the calibration's Q is taken if it is known to this part.
const CLEAR_Q: f32 = 0.3;
/// A lock that was further off than this before the clamped branch was measured at the lock point is not alone, or was not measured well: bandwidths, and Hz.
const ALONE: (f32, f32) = (0.006, 1.0);
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
    pub(crate) tracker: Tracker,
    pub(crate) online: Online,
    transducer: Option<Transducer>,
    /// The last one that was tracked without a doubt: resonance, Hz, Q, and Lm, H.
    remembered: Option<[f32; 3]>,
    /// The transducer that is being learned, in parts.
    learning: Learning,
    /// The mode that disturbs the driven one most: its series resonance, Hz, and its motional capacitance relative to that of the driven one.
    pub(crate) beside: Option<(f32, f32)>,
    /// The lock was not where the branch that it began with had put it: another resonance is near by.
    is_uncertain: bool,
    /// Nor has a scan found another one.
    is_unexplained: bool,
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
            remembered: None,
            learning: Learning::default(),
            tracker,
            online: Online::build(config),
            beside: None,
            is_uncertain: false,
            is_unexplained: false,
        }
    }

    /// Forgets the transducer.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    pub(crate) fn restart(&mut self) {
        let certain = self.transducer.take_if(|_| !self.is_uncertain);
        let remembered = certain.map(|known| [known.series_resonance_hz, known.q, known.lm_h]);
        self.remembered = remembered.or(self.remembered);
        (self.transducer, self.beside) = (None, None);
        (self.is_uncertain, self.is_unexplained) = (false, false);
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

    /// Resonance, Hz, and Q of the transducer that was tracked last, if this is the same, by its resonance and its Lm as seen from afar.
    fn remembers(&self, clamped: &Clamped) -> Option<(f32, f32)> {
        let off = |found: &Measured, known: f32, rest: f32| (found.value - known).abs() > SIGMAS * found.deviation + rest * known;
        let [hz, q, lm_h] = self.remembered?;
        let same = !off(&clamped.resonance_hz, hz, NEARBY) && !off(&clamped.lm_h, lm_h, SIGMAS * FROM_AFAR);
        same.then_some((hz, q))
    }

    /// Takes the clamped branch, and lets the observer begin where the same transducer was tracked last, or anywhere in the window.
    pub(crate) fn observe(&mut self, clamped: &Clamped) {
        let window_hz = self.tracker.window_hz();
        let known_q = core::f32::consts::PI * self.nominal_periods;
        let q = if self.is_known || clamped.q.deviation > CLEAR_Q * clamped.q.value { known_q } else { clamped.q.value };
        let remembered = self.remembers(clamped);
        let prior = Prior {
            offset_hz: remembered.map_or((0.0, window_hz), |(hz, _)| self.tracker.near(hz)),
            q: remembered.map_or(q, |(_, q)| q),
            // Measured to a part in five hundred; the nominal value is what it is compared with once it has locked.
            lm_h: (clamped.lm_h.value, clamped.lm_h.deviation),
            axis: clamped.motional.axis,
            noise_a: self.noise_a(&clamped.motional),
        };
        self.lm_deviation = larger(clamped.lm_h.deviation / clamped.lm_h.value, FROM_AFAR);
        let modes = 1 + u8::from(clamped.second_mode.is_some());
        let known = Known { c0_f: (clamped.c0_f.value, clamped.c0_f.deviation), modes: (modes, 0), ..Known::default() };
        self.tracker.observe(clamped.motional, known, &prior);
        let (c0, hz, q) = (clamped.c0_f, clamped.resonance_hz.value, clamped.q.value);
        self.online.seed(clamped.motional, c0.deviation / c0.value, hz, q);
        self.beside = clamped.second_mode;
    }

    /// Takes the transducer that the scan has found.
    pub(crate) fn adopt(&mut self, found: &RingDown, beside: Option<(f32, f32)>) {
        let (transducer, branch) = (&found.transducer, found.motional);
        self.tracker.seed(transducer, branch, self.noise_a(&branch));
        self.lm_deviation = transducer.deviations.lm_h / transducer.lm_h;
        let deviation = transducer.deviations.c0_f / transducer.c0_f;
        self.online.seed(branch, deviation, transducer.series_resonance_hz, transducer.q);
        self.online.set_slope(found.slope);
        (self.transducer, self.beside) = (Some(*transducer), beside);
        self.is_unexplained = self.is_uncertain && beside.is_none();
        self.learning.abandon();
    }

    /// Takes the clamped branch as it was measured at the lock point, and the quality factor.
    // Not inlined: once a round.
    #[inline(never)]
    pub(crate) fn take(&mut self, update: &Update) {
        self.tracker.set_branch(update.motional, update.deviation, update.was_off);
        self.tracker.take_q((update.q.value, update.q.deviation));
        if let Some((was_off, transducer)) = update.was_off.zip(self.transducer_by_now()) {
            // A susceptance that is off by the whole conductance moves the lock point by half a bandwidth.
            self.is_uncertain =
                self.is_unexplained || 0.5 * was_off > larger(ALONE.0, ALONE.1 * transducer.q / transducer.series_resonance_hz);
        }
    }

    /// Where to drive, as an offset from the nominal frequency, Hz: within the window, and far enough from its ends for the steps of a measurement that is under way. A
    /// clamped capacitance that is wrong may have pushed it there.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    pub(crate) fn lock_point_hz(&self) -> f32 {
        let within_hz = larger(self.tracker.window_hz() - self.online.reach_hz(), 0.0);
        smaller(larger(self.tracker.offset_hz(), -within_hz), within_hz)
    }

    /// What is not as it should be with the lock.
    // Not inlined, as above.
    #[inline(never)]
    pub(crate) fn limit(&self, state: State) -> Option<Limit> {
        match state {
            State::Unmeasured => Some(Limit::NotTracking),
            _ if self.online.probes() => Some(Limit::Probing),
            _ if self.is_uncertain => Some(Limit::LockUncertain),
            _ => None,
        }
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

    /// Whether the lock is lost, or on another resonance: a lane that has failed looks like that, too.
    #[inline(never)]
    pub(crate) fn is_in_doubt(&self) -> bool {
        self.tracker.tracks() && (self.tracker.state() != State::Locked || self.is_another_mode() || self.leaves_to_a_scan())
    }

    /// Whether the lock is so uncertain that it is left to a scan.
    fn leaves_to_a_scan(&self) -> bool {
        self.is_uncertain && self.tracker.has_a_scan_left()
    }

    /// How the lock is getting on. A fault in a run waits until the lanes have been judged.
    pub(crate) fn progress(&mut self, mode: Mode, amplitude: &AmplitudeLoop, lanes: &mut Lanes) -> Progress {
        let locking = mode == Mode::Lock;
        match self.tracker.state() {
            _ if !self.tracker.tracks() => Progress::Busy,
            // Where something has changed, the clamped branch is in doubt, and with it the phase.
            _ if locking && self.tracker.is_astray() => self.scan_again(),
            State::Disagree if locking || !self.online.doubts() => lanes.judged(locking, Fault::TrackersDisagree),
            State::Locked if self.is_another_mode() => lanes.judged(locking, Fault::WrongMode),
            State::Locked if self.leaves_to_a_scan() && !lanes.postpone(locking) && self.tracker.leave_to_a_scan() => {
                Progress::Back(Mode::Scan)
            }
            State::Locked if amplitude.settled() => Progress::Done,
            State::Lost | State::Disagree if !locking => self.retry_lock(Fault::LossOfLock, lanes),
            State::TimedOut | State::Lost if locking => self.retry_lock(Fault::NoLock, lanes),
            _ => Progress::Busy,
        }
    }

    /// A channel or a lane has failed since the scan has seen the resonance, or that has moved: another one will say.
    #[cold]
    #[inline(never)]
    fn scan_again(&mut self) -> Progress {
        if self.tracker.scan_again() { Progress::Back(Mode::Scan) } else { Progress::Failed(Fault::NoLock) }
    }

    /// Seeks the lock where there is more hope, if there is any left.
    fn retry_lock(&mut self, fault: Fault, lanes: &mut Lanes) -> Progress {
        if lanes.postpone(fault == Fault::NoLock) {
            return Progress::Busy;
        }
        match self.tracker.retry_lock(fault == Fault::LossOfLock) {
            Some(Retry::Nearby | Retry::Window) => Progress::Back(Mode::Lock),
            Some(Retry::Calibrate) => Progress::Back(Mode::SelfTest),
            Some(Retry::Scan) => Progress::Back(Mode::Scan),
            None => Progress::Failed(fault),
        }
    }

    /// Whether it has locked to another resonance than the nominal one, by its inductance, whatever that may have been off by in the beginning.
    // Not inlined: it would be so in several places.
    #[inline(never)]
    fn is_another_mode(&self) -> bool {
        let (Some(nominal), Some(transducer)) = (self.nominal_lm_h, self.transducer_by_now()) else { return false };
        let (ratio, off) = (transducer.lm_h / nominal, SIGMAS * self.lm_deviation);
        ratio * (1.0 + off) < 1.0 / SAME_MODE || ratio > SAME_MODE * (1.0 + off)
    }
}
