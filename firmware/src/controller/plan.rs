//! What each mode wants to play next.

use super::{Controller, Played};
use crate::block::{Gate, Orders, SenseBlock};
use crate::burst::Brake;
use crate::calibrate;
use crate::clamped::{self, Clamped, online};
use crate::demod::Sensed;
use crate::identify::Transducer;
use crate::motional::Motional;
use crate::phasor::{Phasor, magnitude};
use crate::scan;
use crate::self_test;
use crate::shape::Shape;
use crate::supervisor::{Acquisition, Fault, Mode, Progress};
use crate::tracker::identified::Known;
use crate::tracker::observed::Seek;
use crate::tracker::observer::Prior;
use crate::tracker::{Heard, State};
use crate::units::Turns;

/// A resonance whose motional inductance is this many times smaller or larger than was told is another one.
const SAME_MODE: f32 = 2.0;
/// How often what the observer knows of the transducer is taken, blocks.
const LEARN_BLOCKS: u64 = 64;

/// What to play next, before the burst has its say.
#[derive(Clone, Copy)]
pub(super) struct Plan {
    pub(super) volts: f32,
    pub(super) gate: Gate,
    /// The lane to listen to.
    pub(super) listen: u8,
    /// Phase that is driven to zero.
    pub(super) phase: Turns,
    /// The window has limited what the order asks for.
    pub(super) limited: bool,
    pub(super) progress: Progress,
}

impl Plan {
    const SILENT: Plan =
        Plan { volts: 0.0, gate: Gate::Off, listen: 0, phase: Turns(0.0), limited: false, progress: Progress::Busy };

    fn tone(volts: f32) -> Self {
        Plan { volts, gate: Gate::On, ..Plan::SILENT }
    }

    fn and(self, progress: Progress) -> Self {
        Plan { progress, ..self }
    }
}

impl Controller {
    /// Forgets what an earlier attempt has found.
    pub(super) fn begin(&mut self) {
        self.test_again();
        self.calibrate.abandon(&mut self.phasing);
        self.scan.restart();
        self.transducer = None;
        self.sweep.hold.retune(0.0);
        self.sweep.restart();
        self.tracker.restart();
        self.amplitude.restart();
    }

    /// Prepares the self-test and the measurement of the clamped branch that follows it.
    fn test_again(&mut self) {
        self.convert.v.restore_zero();
        self.convert.i.restore_zero();
        self.self_test.restart();
        self.power_on.restart();
        self.probe_hz = 0.0;
    }

    /// What this mode wants to play next.
    pub(super) fn plan(
        &mut self,
        orders: &Orders,
        sense: &SenseBlock,
        sensed: &Sensed,
        heard: &Played,
        motional: Phasor,
    ) -> Plan {
        match self.supervisor.mode() {
            Mode::Idle | Mode::Fault => {
                self.calibrate.abandon(&mut self.phasing);
                Plan::SILENT
            }
            Mode::SelfTest => {
                match self.self_test.step(&mut self.convert, sense, sensed, heard.volts * heard.audible.unwrap_or(1.0)) {
                    self_test::Step::Silence => Plan::SILENT,
                    self_test::Step::Tone { offset_hz, volts } => {
                        self.sweep.hold.retune(offset_hz);
                        Plan::tone(volts)
                    }
                    self_test::Step::Passed => {
                        let (v, i) = self.noise();
                        self.power_on.set_noise(v, i);
                        self.sweep.hold.retune(0.0);
                        Plan::SILENT.and(Progress::Done)
                    }
                    self_test::Step::Failed(fault) => Plan::SILENT.and(Progress::Failed(fault)),
                }
            }
            Mode::Scan => match self.scan.step(&self.convert, sense, sensed) {
                scan::Step::Tune(offset_hz) => {
                    self.sweep.hold.retune(offset_hz);
                    Plan::tone(self.scan_volts)
                }
                scan::Step::Found(transducer, branch) => {
                    self.adopt(transducer, branch, magnitude(motional));
                    Plan::tone(self.scan_volts).and(Progress::Done)
                }
                scan::Step::Failed(fault) => Plan::SILENT.and(Progress::Failed(fault)),
            },
            Mode::Clamped => match self.power_on.step(sensed) {
                clamped::Step::Tone { offset_hz, volts } => {
                    self.sweep.hold.retune(offset_hz);
                    Plan::tone(volts)
                }
                clamped::Step::Silence => Plan::SILENT,
                clamped::Step::Found(clamped) => {
                    self.sweep.hold.retune(0.0);
                    self.observe(&clamped);
                    Plan::tone(self.scan_volts).and(Progress::Done)
                }
                clamped::Step::Failed(fault) => Plan::SILENT.and(Progress::Failed(fault)),
            },
            Mode::Calibrate => match self.calibrate.step(&mut self.phasing, sensed) {
                calibrate::Step::Listen { offset_hz, lane } => {
                    self.sweep.hold.retune(offset_hz);
                    Plan { listen: lane, ..Plan::tone(self.scan_volts) }
                }
                calibrate::Step::Done => {
                    self.sweep.hold.retune(0.0);
                    self.amplitude.set_loudest(self.phasing.loudest());
                    Plan::SILENT.and(Progress::Done)
                }
                calibrate::Step::Failed(fault) => Plan::SILENT.and(Progress::Failed(fault)),
            },
            Mode::Lock => self.follow(&Orders { gate: Gate::On, ..*orders }, sensed, heard, motional),
            Mode::Run => self.follow(orders, sensed, heard, motional),
        }
    }

    /// How a run comes to its frequency.
    pub(super) fn acquisition(&self) -> Acquisition {
        match (self.tracker.tracks(), self.tracker.observes()) {
            (false, _) => Acquisition::Told,
            (true, false) => Acquisition::Scanned,
            (true, true) => Acquisition::Observed,
        }
    }

    /// Takes the clamped branch, and lets the observer begin anywhere in the window.
    fn observe(&mut self, clamped: &Clamped) {
        let window_hz = self.tracker.window_hz();
        let prior = Prior {
            offset_hz: (0.0, window_hz),
            q: core::f32::consts::PI * self.nominal_periods,
            // Measured to a part in five hundred; what was told is what it is held against once it has locked.
            lm_h: (clamped.lm_h.value, clamped.lm_h.deviation),
            axis: clamped.motional.axis,
            noise_a: self.noise_a(&clamped.motional),
        };
        let modes = 1 + u8::from(clamped.company.is_some());
        let known = Known { c0_f: (clamped.c0_f.value, clamped.c0_f.deviation), modes: (modes, 0) };
        self.tracker.observe(clamped.motional, known, &prior);
        let (c0, hz, q) = (clamped.c0_f, clamped.resonance_hz.value, clamped.q.value);
        self.online.seed(clamped.motional, c0.deviation / c0.value, hz, q);
    }

    /// Variances of a block's voltage and current by noise, both components, V² and A².
    fn noise(&self) -> (f32, f32) {
        let (v, i) = self.self_test.noise();
        (self.convert.v.phasor_variance(v, self.samples), self.convert.i.phasor_variance(i, self.samples))
    }

    /// Rms noise of a block's motional current, A.
    fn noise_a(&self, branch: &Motional) -> f32 {
        let (v, i) = self.noise();
        libm::sqrtf(i + branch.y0.norm_sqr() * v)
    }

    /// Takes the transducer that the scan has found, and starts both loops on it.
    fn adopt(&mut self, transducer: Transducer, branch: Motional, motional_current: f32) {
        self.tracker.seed(&transducer, branch, self.noise_a(&branch));
        let deviation = transducer.deviations.c0_f / transducer.c0_f;
        self.online.seed(branch, deviation, transducer.series_resonance_hz, transducer.q);
        self.sweep.hold.retune(self.tracker.offset_hz());
        self.amplitude.seed(&transducer, motional_current);
        self.transducer = Some(transducer);
    }

    /// Takes what the observer knows of the transducer, which is sure of it.
    fn learn(&mut self) -> Option<Transducer> {
        let transducer = self.tracker.identify()?;
        self.tracker.set_resonance(&transducer);
        self.online.set_resonance(transducer.series_resonance_hz, transducer.q);
        (self.transducer, self.learned) = (Some(transducer), self.block);
        Some(transducer)
    }

    /// The same again, now and then.
    pub(super) fn learn_on(&mut self) {
        let following = matches!(self.supervisor.mode(), Mode::Lock | Mode::Run);
        if following && self.transducer.is_some() && self.block - self.learned >= LEARN_BLOCKS && self.tracker.is_sure() {
            self.learn();
        }
    }

    /// Measures the clamped capacitance anew, where it may drift, by small steps of a drive that is otherwise left alone.
    fn probe(&mut self, orders: &Orders, sensed: &Sensed, played: &Played) {
        if !self.online.drifts() || !self.tracker.observes() {
            return;
        }
        let alone = matches!(self.shape, Shape::Sine)
            && self.sweep.holds()
            && orders.detune.0 == 0.0
            && self.supervisor.mode() == Mode::Run;
        let whole = played.flat && played.envelope == 1.0 && !self.amplitude.limited() && !self.tracker.limited();
        let steady = alone && whole && self.tracker.state() == State::Locked;
        let heard = online::Heard { sensed, relative: played.relative, detune_hz: played.detune_hz, steady };
        let wanted = self.online.step(&heard);
        self.probe_hz = wanted.detune_hz;
        if let Some(update) = wanted.update {
            self.tracker.set_branch(update.motional, update.deviation);
        }
    }

    /// Follows frequency and amplitude for one block.
    fn follow(&mut self, orders: &Orders, sensed: &Sensed, played: &Played, motional: Phasor) -> Plan {
        let on = played.flat && played.envelope == 1.0 && played.volts > 0.0;
        let driven = played.envelope != 0.0;
        let heard = Heard {
            offset_hz: played.offset_hz,
            volts: played.volts,
            envelope: played.flat.then_some(played.envelope),
            pure: played.pure,
            on,
            driven,
        };
        let at_lock_point = self.tracker.at_lock_point(motional, played.detune_hz);
        let phase = self.tracker.follow(sensed, motional, at_lock_point, &heard);
        if self.transducer.is_none()
            && self.tracker.is_sure()
            && let Some(transducer) = self.learn()
        {
            self.amplitude.seed(&transducer, magnitude(motional));
        }
        self.probe(orders, sensed, played);
        let (offset_hz, limited) = self.detune(orders);
        self.sweep.hold.retune(offset_hz);
        // An edge is never quite one, whatever its mean rounds to.
        let envelope = if played.flat { played.envelope } else { played.envelope.min(0.999) };
        // Before the order's own amplitude: what rings was driven by the one before.
        self.prepare_brake(orders.gate);
        let known = self.transducer.is_some() || !self.tracker.observes();
        if known {
            self.amplitude.update(orders.amplitude.unwrap_or(self.amplitude_asked), envelope, at_lock_point);
        }
        let volts = match () {
            () if !known => self.scan_volts,
            () if self.burst.is_ending(orders.gate) => self.braked_volts,
            () => self.amplitude.volts(),
        };
        Plan { volts, gate: orders.gate, listen: 0, phase, limited, progress: self.lock_progress() }
    }

    /// Where to drive, as an offset from the nominal frequency, Hz, and whether the order had to be limited. Only what runs is moved
    /// away from the resonance.
    fn detune(&self, orders: &Orders) -> (f32, bool) {
        let window = self.tracker.window_hz();
        let asked = if self.supervisor.mode() == Mode::Run && orders.detune.0.is_finite() { orders.detune.0 } else { 0.0 };
        let offset = if self.tracker.tracks() { self.tracker.offset_hz() } else { 0.0 };
        let wanted = offset + asked + self.probe_hz;
        (wanted.clamp(-window, window), wanted.abs() > window)
    }

    /// The brake for what rings. It is made anew where the drive has changed, because its level counts from the drive.
    fn prepare_brake(&mut self, gate: Gate) {
        const SAME: f32 = 0.01;
        let volts = self.amplitude.volts();
        if self.burst.is_ending(gate) {
            // It brakes what it was made for.
        } else if !self.burst.brakes(gate) || volts == 0.0 {
            self.burst.set_brake(None);
        } else if self.burst.brake().is_none() || (volts - self.braked_volts).abs() > SAME * volts {
            let periods = self.transducer.map_or(self.nominal_periods, |transducer| transducer.q / core::f32::consts::PI);
            self.burst.set_brake(Some(Brake::of(periods, self.amplitude.headroom())));
            self.braked_volts = volts;
        }
    }

    fn lock_progress(&mut self) -> Progress {
        let locking = self.supervisor.mode() == Mode::Lock;
        match self.tracker.state() {
            _ if !self.tracker.tracks() => Progress::Busy,
            State::Disagree => Progress::Failed(Fault::TrackersDisagree),
            State::Locked if self.is_another_mode() => Progress::Failed(Fault::WrongMode),
            State::Locked if self.amplitude.settled() => Progress::Done,
            State::Lost if !locking => self.seek_on(Fault::LossOfLock),
            State::TimedOut | State::Lost if locking => self.seek_on(Fault::NoLock),
            _ => Progress::Busy,
        }
    }

    /// Seeks the lock where there is more hope, if there is any left.
    fn seek_on(&mut self, fault: Fault) -> Progress {
        match self.tracker.seek_on(fault == Fault::LossOfLock) {
            Some(Seek::Nearby | Seek::Window) => Progress::Back(Mode::Lock),
            Some(Seek::Anew) => {
                self.test_again();
                Progress::Back(Mode::SelfTest)
            }
            Some(Seek::Scan) => {
                self.scan.restart();
                Progress::Back(Mode::Scan)
            }
            None => Progress::Failed(fault),
        }
    }

    /// Whether what it has locked to is not the resonance it was told of, by its inductance.
    fn is_another_mode(&self) -> bool {
        let strength = |told: f32| self.transducer.map_or(1.0, |transducer| told / transducer.lm_h);
        self.nominal_lm_h.is_some_and(|told| !(1.0 / SAME_MODE..SAME_MODE).contains(&strength(told)))
    }
}
