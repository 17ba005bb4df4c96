//! The tracked transducer: tracker, clamped capacitance, and the equivalent circuit that is
//! identified during tracking.

use crate::find::clamped::online::{Online, Update};
use crate::find::clamped::{Clamped, Measured};
use crate::find::identify::choice::LM_FACTOR;
use crate::find::lanes::Lanes;
use crate::find::scan::modes::Modes;
use crate::find::scan::ring_down::RingDown;
use crate::generate::amplitude::AmplitudeLoop;
use crate::generate::step::Progress;
use crate::seam::compare::{larger, smaller};
use crate::seam::config::Config;
use crate::seam::fault::{Fault, Limit};
use crate::seam::mode::Mode;
use crate::seam::transducer::Transducer;
use crate::sense::motional::Motional;
use crate::track::tracker::identified::{Known, Learning, OFF_RESONANCE_UNCERTAINTY_REL};
use crate::track::tracker::observed::{NEARBY_REL, Retry};
use crate::track::tracker::observer::Prior;
use crate::track::tracker::{State, Tracker};

/// Interval at which the identified transducer is taken from the observer, blocks.
pub(crate) const LEARN_BLOCKS: u64 = 64;
/// Largest relative deviation at which the calibration's Q is used, if only the band is known.
const CLEAR_Q_REL: f32 = 0.3;
/// Shift of a lock by the clamped branch measured at the lock point, above which the lock is
/// uncertain, bandwidths: another resonance is near, or the first branch was measured badly.
const UNCERTAIN_SHIFT_BANDWIDTHS: f32 = 0.006;
/// Smallest shift that makes a lock uncertain, Hz.
const UNCERTAIN_SHIFT_HZ: f32 = 1.0;
/// Tolerance of comparisons, standard deviations.
const TOLERANCE_SIGMAS: f32 = 3.0;

/// Tracker and identified transducer.
#[derive(Clone, Debug)]
#[repr(C)]
pub(crate) struct TrackedTransducer {
    /// Number of the block in which the transducer was last identified.
    learned: u64,
    /// Time constant of the resonance from the nominal Q, periods.
    nominal_periods: f32,
    /// `true` if more than the frequency band is known.
    is_known: bool,
    /// Nominal motional inductance, H.
    nominal_lm_h: Option<f32>,
    /// Relative standard deviation of the inductance at the start.
    lm_deviation: f32,
    /// Noise variances of a block's voltage, V², and current, A², each of both components together,
    /// as measured in the silence of the self-test.
    pub(crate) noise: (f32, f32),
    pub(crate) tracker: Tracker,
    pub(crate) online: Online,
    /// Transducer as identified first, from a scan, or last from a settled block under drive. The
    /// loops use the latest one, whose resonance is less certain after a silence.
    transducer: Option<Transducer>,
    /// Last transducer tracked with a certain lock: resonance, Hz; Q; and Lm, H.
    remembered: Option<[f32; 3]>,
    /// Latest identification, in parts.
    learning: Learning,
    /// Mode that disturbs the driven one most: its series resonance, Hz, and its motional
    /// capacitance relative to that of the driven mode.
    pub(crate) other_mode: Option<(f32, f32)>,
    /// `true` if the lock was not at the frequency that its first clamped branch gave: another
    /// resonance is near.
    is_uncertain: bool,
}

impl TrackedTransducer {
    /// Builds a transducer of which only the nominal values are known.
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
            other_mode: None,
            is_uncertain: false,
        }
    }

    /// Resets the transducer for a new attempt; a certain lock is remembered.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    pub(crate) fn restart(&mut self) {
        let is_certain = !self.learning.transducer().quality.is_lossy();
        let certain = self.transducer.take_if(|_| is_certain);
        let remembered = certain.map(|known| [known.series_resonance_hz, known.q, known.lm_h]);
        self.remembered = remembered.or(self.remembered);
        (self.transducer, self.other_mode) = (None, None);
        self.is_uncertain = false;
        self.learning = Learning::default();
        self.tracker.restart();
    }

    /// Returns the best identification of the transducer, if there is one.
    pub(crate) fn transducer(&self) -> Option<&Transducer> {
        self.transducer.as_ref()
    }

    /// Returns the latest transducer; during an identification, without its deviations.
    pub(crate) fn latest_transducer(&self) -> Option<&Transducer> {
        self.learning.has_begun().then(|| self.learning.transducer())
    }

    /// Returns the latest time constant of the resonance, periods.
    pub(crate) fn periods(&self) -> f32 {
        self.latest_transducer().map_or(self.nominal_periods, |transducer| transducer.q / core::f32::consts::PI)
    }

    /// Returns the number of blocks since the last identification.
    pub(crate) fn since_learned(&self, block: u64) -> u64 {
        block - self.learned
    }

    /// Returns the rms noise of a block's motional current, A.
    fn noise_a(&self, branch: &Motional) -> f32 {
        let (v, i) = self.noise;
        fpu::sqrtf(i + branch.y0.norm_sqr() * v)
    }

    /// Returns the series resonance, Hz, and Q of the last tracked transducer. Returns `None` if
    /// the measurement off resonance gives a different resonance or Lm, so that another transducer
    /// may be connected.
    fn remembered_lock(&self, clamped: &Clamped) -> Option<(f32, f32)> {
        let off = |found: &Measured, known: f32, rest: f32| {
            (found.value - known).abs() > TOLERANCE_SIGMAS * found.deviation + rest * known
        };
        let [hz, q, lm_h] = self.remembered?;
        let same = !off(&clamped.resonance_hz, hz, NEARBY_REL)
            && !off(&clamped.lm_h, lm_h, TOLERANCE_SIGMAS * OFF_RESONANCE_UNCERTAINTY_REL);
        same.then_some((hz, q))
    }

    /// Takes the clamped branch, and starts the observer: near the last lock if the transducer is
    /// the same, otherwise in the whole window.
    pub(crate) fn observe(&mut self, clamped: &Clamped) {
        let window_hz = self.tracker.window_hz();
        let known_q = core::f32::consts::PI * self.nominal_periods;
        let q = if self.is_known || clamped.q.deviation > CLEAR_Q_REL * clamped.q.value { known_q } else { clamped.q.value };
        let remembered = self.remembered_lock(clamped);
        let prior = Prior {
            offset_hz: remembered.map_or((0.0, window_hz), |(hz, _)| self.tracker.prior_near(hz)),
            q: remembered.map_or(q, |(_, q)| q),
            // Measured to 0.2 %; it is compared with the nominal value after the lock.
            lm_h: (clamped.lm_h.value, clamped.lm_h.deviation),
            axis: clamped.motional.axis,
            noise_a: self.noise_a(&clamped.motional),
        };
        self.lm_deviation = larger(clamped.lm_h.deviation / clamped.lm_h.value, OFF_RESONANCE_UNCERTAINTY_REL);
        let modes = 1 + u8::from(clamped.second_mode.is_some());
        let known = Known { c0_f: (clamped.c0_f.value, clamped.c0_f.deviation), modes: (modes, 0), ..Known::default() };
        self.tracker.observe(clamped.motional, known, &prior);
        let (c0, hz, q) = (clamped.c0_f, clamped.resonance_hz.value, clamped.q.value);
        self.online.seed(clamped.motional, c0.deviation / c0.value, hz, q);
        self.other_mode = clamped.second_mode;
        self.is_uncertain = false;
        *self.learning.quality() = clamped.quality;
    }

    /// Takes the transducer found by the scan, and all its modes.
    pub(crate) fn adopt(&mut self, found: &RingDown, modes: &Modes) {
        let RingDown { transducer: scanned, stated, motional: branch, slope, .. } = found;
        let is_crowded = modes.is_crowded();
        self.tracker.seed(scanned, *branch, self.noise_a(branch), is_crowded);
        self.lm_deviation = stated.deviations.lm_h / stated.lm_h;
        self.online.seed(*branch, scanned.deviations.c0_f / scanned.c0_f, scanned.series_resonance_hz, scanned.q);
        self.online.set_slope(*slope);
        if is_crowded {
            self.online.omit_rounds();
        }
        self.other_mode = modes.other_mode();
        self.is_uncertain = false;
        self.transducer = Some(*stated);
        self.learning.adopt(stated);
    }

    /// Takes the clamped branch and the quality factor measured at the lock point.
    // Not inlined: once a round.
    #[inline(never)]
    pub(crate) fn apply_update(&mut self, update: &Update) {
        self.tracker.set_branch(self.online.motional(), self.online.deviation(), update.was_off);
        self.tracker.take_q((update.q.value, update.q.deviation));
        if let Some((was_off, transducer)) = update.was_off.zip(self.latest_transducer()) {
            // An error of the susceptance equal to the conductance moves the lock point by half a
            // bandwidth.
            self.is_uncertain = 0.5 * was_off
                > larger(UNCERTAIN_SHIFT_BANDWIDTHS, UNCERTAIN_SHIFT_HZ * transducer.q / transducer.series_resonance_hz);
            self.learning.quality().turn(was_off);
        }
    }

    /// Returns the frequency to drive, as an offset from the nominal frequency, Hz.
    ///
    /// It lies within the window, with room for the steps of a measurement in progress: a wrong
    /// clamped capacitance may have pushed it to the edge.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    pub(crate) fn lock_point_hz(&self) -> f32 {
        let within_hz = larger(self.tracker.window_hz() - self.online.reach_hz(), 0.0);
        smaller(larger(self.tracker.offset_hz(), -within_hz), within_hz)
    }

    /// Returns the limit that applies to the lock.
    // Not inlined, as above.
    #[inline(never)]
    pub(crate) fn limit(&self, state: State) -> Option<Limit> {
        match state {
            State::Unmeasured => Some(Limit::NotTracking),
            _ if self.learning.transducer().quality.is_lossy() => Some(Limit::LockUncertain),
            _ => None,
        }
    }

    /// Begins an identification from a converged observer. Returns the values that the loops need,
    /// which are complete at once.
    pub(crate) fn begin_to_learn(&mut self, block: u64) -> &Transducer {
        self.tracker.learn(&mut self.learning);
        let transducer = self.learning.transducer();
        self.tracker.set_resonance(transducer);
        self.online.set_resonance(transducer.series_resonance_hz, transducer.q);
        self.learned = block;
        transducer
    }

    /// Advances the identification by one part.
    fn continue_learning(&mut self) {
        self.learning.advance();
        if self.learning.is_over() && (self.transducer.is_none() || self.learning.is_settled()) {
            self.transducer.get_or_insert_default().copy(self.learning.transducer());
        }
    }

    /// Runs a complete identification.
    fn learn(&mut self, block: u64) {
        self.begin_to_learn(block);
        while !self.learning.is_over() {
            self.continue_learning();
        }
    }

    /// Repeats the identification every [`LEARN_BLOCKS`]. `following`: the resonance is tracked.
    /// `whole`: all parts in one block. `idle`: this block has time for a part.
    pub(crate) fn learn_periodically(&mut self, block: u64, following: bool, whole: bool, idle: bool) {
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

    /// Returns `true` if the lock is lost, uncertain, or on another resonance. A failed lane has
    /// the same effect.
    #[inline(never)]
    pub(crate) fn is_in_doubt(&self) -> bool {
        let leaves_to_a_scan = || self.is_uncertain && self.tracker.can_scan();
        self.tracker.tracks() && (self.tracker.state() != State::Locked || self.is_another_mode() || leaves_to_a_scan())
    }

    /// Returns the progress of the lock. A fault in a run waits until the lanes have been checked.
    pub(crate) fn progress(&mut self, mode: Mode, amplitude: &AmplitudeLoop, lanes: &mut Lanes) -> Progress {
        let locking = mode == Mode::Lock;
        match self.tracker.state() {
            _ if !self.tracker.tracks() => Progress::Busy,
            // After a change the clamped branch is in doubt, and with it the phase.
            _ if locking && self.tracker.is_astray() => self.order_second_scan(),
            State::Disagree if locking || !self.online.doubts() => lanes.judged(locking, Fault::TrackersDisagree),
            // Off resonance, where Lm was measured, other resonances make it seem smaller: a scan
            // decides.
            State::Locked if self.is_uncertain || self.is_another_mode() => match () {
                () if self.tracker.can_scan() && !lanes.postpone(locking) && self.tracker.hand_over_to_scan() => {
                    Progress::Back(Mode::Scan)
                }
                () if self.is_another_mode() => lanes.judged(locking, Fault::WrongMode),
                () if amplitude.settled() => Progress::Done,
                () => Progress::Busy,
            },
            State::Locked if amplitude.settled() => Progress::Done,
            State::Lost | State::Disagree if !locking => self.retry_lock(Fault::LossOfLock, lanes),
            State::TimedOut | State::Lost if locking => self.retry_lock(Fault::NoLock, lanes),
            _ => Progress::Busy,
        }
    }

    /// Orders another scan once: since the last one a channel or a lane has failed, or the
    /// resonance has moved.
    #[cold]
    #[inline(never)]
    fn order_second_scan(&mut self) -> Progress {
        if self.tracker.take_second_scan() { Progress::Back(Mode::Scan) } else { Progress::Failed(Fault::NoLock) }
    }

    /// Starts the next attempt to lock, or fails after the last one.
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

    /// Returns `true` if the inductance shows that the lock is on another resonance than the
    /// nominal one, with the uncertainty at the start as a tolerance.
    // Not inlined: it has several callers.
    #[inline(never)]
    fn is_another_mode(&self) -> bool {
        let (Some(nominal), Some(transducer)) = (self.nominal_lm_h, self.latest_transducer()) else { return false };
        let (ratio, off) = (transducer.lm_h / nominal, TOLERANCE_SIGMAS * self.lm_deviation);
        ratio * (1.0 + off) < 1.0 / LM_FACTOR || ratio > LM_FACTOR * (1.0 + off)
    }
}
