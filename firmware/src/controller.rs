//! The controller: `Config -> build -> Controller`, and `process` once a block.
//!
//! Contract: the codes returned for sense block `k` play as block `k + 2` ([`LATENCY_BLOCKS`]). After `build` nothing can
//! fail: trouble is a numbered fault in the telemetry, and a muted drive.

use crate::amplitude::AmplitudeLoop;
use crate::block::{Amplitude, DriveBlock, Gate, LATENCY_BLOCKS, MAX_BLOCK_SAMPLES, MAX_LANES, Orders, SenseBlock};
use crate::burst::Burst;
use crate::config::{Config, TrackingMode};
use crate::convert::Convert;
use crate::demod::{Sensed, demodulate};
use crate::error::{Error, in_range};
use crate::guard::{Driven, Guard};
use crate::identify::Transducer;
use crate::motional::Motional;
use crate::nco::Nco;
use crate::phasing::{self, Lane};
use crate::phasor::{Phasor, magnitude};
use crate::scan::{self, Scan};
use crate::self_test::{self, SelfTest};
use crate::shape::{self, Table};
use crate::shaper;
use crate::supervisor::{Fault, Limit, Mode, Progress, Supervisor};
use crate::sweep::Hold;
use crate::telemetry::Telemetry;
use crate::tracker::{Heard, State, Tracker};
use crate::units::{Hertz, Turns, Volts};

/// A block on its way from `process` to the ear: what was played when the answer arrives.
#[derive(Clone, Copy, Debug, Default)]
struct Played {
    phase: u64,
    word: u64,
    /// Frequency relative to the nominal one.
    relative: f32,
    volts: f32,
    /// Mean envelope; `flat` says whether it is that throughout.
    envelope: f32,
    flat: bool,
}

/// The controller.
#[derive(Clone)]
pub struct Controller {
    samples: usize,
    nominal_hz: f32,
    convert: Convert,
    table: &'static Table,
    lanes: heapless::Vec<Lane, MAX_LANES>,
    amplitude_asked: Amplitude,
    scan_volts: f32,

    block: u64,
    nco: Nco,
    sweep: Hold,
    burst: Burst,
    played: [Played; LATENCY_BLOCKS],
    guard: Guard,
    supervisor: Supervisor,
    self_test: SelfTest,
    scan: Scan,
    tracker: Tracker,
    amplitude: AmplitudeLoop,
    transducer: Option<Transducer>,
}

/// What to play next, before the burst has its say.
struct Plan {
    volts: f32,
    gate: Gate,
    phase: Turns,
    progress: Progress,
}

impl Controller {
    /// Checks a configuration and builds its controller. Names the parameter that is out of range.
    pub fn build(config: &Config) -> Result<Self, Error> {
        in_range("block_samples", config.block_samples.into(), 8.0, MAX_BLOCK_SAMPLES as f64)?;
        if matches!(config.drive.amplitude, Amplitude::MotionalCurrent(_)) && config.tracking.mode == TrackingMode::Off {
            return Err(Error::CurrentWithoutTracking);
        }
        let sweep = Hold::build(config.drive.frequency_hz, config.sample_hz)?;
        let block_s = f32::from(config.block_samples) / config.sample_hz;
        let highest = config.drive.frequency_hz * (1.0 + config.tracking.span) / config.sample_hz;
        Ok(Controller {
            samples: config.block_samples.into(),
            nominal_hz: config.drive.frequency_hz,
            convert: Convert::build(&config.front_end)?,
            table: shape::table(config.drive.shape, highest),
            lanes: phasing::build(&config.phasing, config.lanes)?,
            amplitude_asked: config.drive.amplitude,
            scan_volts: config.drive.scan_volts,
            block: 0,
            nco: Nco::default(),
            burst: Burst::build(&config.burst, config.drive.frequency_hz, config.sample_hz)?,
            played: [Played { word: sweep.word(), relative: 1.0, flat: true, ..Played::default() }; LATENCY_BLOCKS],
            guard: Guard::build(config, block_s)?,
            supervisor: Supervisor::default(),
            self_test: SelfTest::build(config),
            scan: Scan::build(config)?,
            tracker: Tracker::build(config, block_s)?,
            amplitude: AmplitudeLoop::build(config, block_s)?,
            transducer: None,
            sweep,
        })
    }

    /// A block of silence: what plays until the first call has returned.
    pub fn silence(&self) -> DriveBlock {
        DriveBlock::silent(self.lanes.len(), self.samples, self.convert.drive.silence())
    }

    /// One block: what the converters saw, what to play two blocks later, and a report.
    pub fn process(&mut self, orders: &Orders, sense: &SenseBlock, drive: &mut DriveBlock) -> Telemetry {
        let slot = (self.block % LATENCY_BLOCKS as u64) as usize;
        let heard = self.played[slot];
        let sensed = demodulate(&self.convert, sense, heard.phase, heard.word);
        let motional_current = self.tracker.motional_current(&sensed, heard.relative);

        let driven = Driven { volts: heard.flat.then_some(heard.volts * heard.envelope) };
        let found = self.guard.inspect(&self.convert, sense, &sensed, driven);
        if self.supervisor.judge(orders, found) {
            self.begin();
        }
        let plan = self.plan(orders, sense, &sensed, &heard, motional_current);
        self.supervisor.advance(orders, plan.progress, self.tracker.tracks());

        let now = (self.block + LATENCY_BLOCKS as u64) * self.samples as u64;
        let envelope = match self.supervisor.mode() {
            Mode::Idle | Mode::Fault => self.burst.snap(false),
            Mode::SelfTest | Mode::Scan => self.burst.snap(plan.gate == Gate::On),
            Mode::Lock | Mode::Run => self.burst.envelope(plan.gate, now, self.samples),
        };
        let (phase, word) = (self.nco.phase(), self.sweep.word());
        shaper::shape(drive, &self.convert.drive, self.table, &self.lanes, (phase, word, self.samples), plan.volts, &envelope);
        let (level, flat) = (envelope.mean(), envelope.is_flat());
        self.nco.advance(word, self.samples);

        self.played[slot] = Played {
            phase,
            word,
            relative: 1.0 + self.sweep.offset_hz() / self.nominal_hz,
            volts: plan.volts,
            envelope: level,
            flat,
        };
        let telemetry = self.report(orders, &plan, level, sensed, motional_current);
        self.block += 1;
        telemetry
    }

    /// Forgets what an earlier attempt has found.
    fn begin(&mut self) {
        self.convert.v.restore_zero();
        self.convert.i.restore_zero();
        self.self_test.restart();
        self.scan.restart();
        self.transducer = None;
        self.sweep.retune(0.0);
        self.tracker.restart();
        self.amplitude.restart();
    }

    /// What this mode wants to play next.
    fn plan(&mut self, orders: &Orders, sense: &SenseBlock, sensed: &Sensed, heard: &Played, motional: Phasor) -> Plan {
        let silent = Plan { volts: 0.0, gate: Gate::Off, phase: Turns(0.0), progress: Progress::Busy };
        let tone = |volts| Plan { volts, gate: Gate::On, ..silent };
        match self.supervisor.mode() {
            Mode::Idle | Mode::Fault => silent,
            Mode::SelfTest => match self.self_test.step(&mut self.convert, sense, sensed) {
                self_test::Step::Silence => silent,
                self_test::Step::Tone { offset_hz, volts } => {
                    self.sweep.retune(offset_hz);
                    tone(volts)
                }
                self_test::Step::Passed => {
                    self.sweep.retune(0.0);
                    Plan { progress: Progress::Done, ..silent }
                }
                self_test::Step::Failed(fault) => Plan { progress: Progress::Failed(fault), ..silent },
            },
            Mode::Scan => match self.scan.step(sensed) {
                scan::Step::Tune(offset_hz) => {
                    self.sweep.retune(offset_hz);
                    tone(self.scan_volts)
                }
                scan::Step::Found(transducer, branch) => {
                    self.adopt(transducer, branch, magnitude(motional));
                    Plan { progress: Progress::Done, ..tone(self.scan_volts) }
                }
                scan::Step::NotFound => Plan { progress: Progress::Failed(Fault::NoResonance), ..silent },
            },
            Mode::Lock => self.follow(orders, Gate::On, sensed, heard, motional),
            Mode::Run => self.follow(orders, orders.gate, sensed, heard, motional),
        }
    }

    /// Takes the transducer that the scan has found, and starts both loops on it.
    fn adopt(&mut self, transducer: Transducer, branch: Motional, motional_current: f32) {
        self.tracker.seed(&transducer, branch);
        self.sweep.retune(self.tracker.offset_hz());
        self.amplitude.seed(&transducer, motional_current);
        self.transducer = Some(transducer);
    }

    /// Follows frequency and amplitude for one block.
    fn follow(&mut self, orders: &Orders, gate: Gate, sensed: &Sensed, played: &Played, motional: Phasor) -> Plan {
        let on = played.flat && played.envelope == 1.0 && played.volts > 0.0;
        let heard = Heard { volts: played.volts, on, driven: played.envelope > 0.0 };
        let phase = self.tracker.follow(sensed, motional, &heard);
        if self.tracker.tracks() {
            self.sweep.retune(self.tracker.offset_hz());
        }
        // An edge is never quite one, whatever its mean rounds to.
        let envelope = if played.flat { played.envelope } else { played.envelope.min(0.999) };
        self.amplitude.update(orders.amplitude.unwrap_or(self.amplitude_asked), envelope, magnitude(motional));
        Plan { volts: self.amplitude.volts(), gate, phase, progress: self.lock_progress() }
    }

    fn lock_progress(&self) -> Progress {
        let locking = self.supervisor.mode() == Mode::Lock;
        match self.tracker.state() {
            _ if !self.tracker.tracks() => Progress::Busy,
            State::Lost if !locking => Progress::Failed(Fault::LossOfLock),
            State::TimedOut | State::Lost if locking => Progress::Failed(Fault::NoLock),
            State::Locked if self.amplitude.settled() => Progress::Done,
            _ => Progress::Busy,
        }
    }

    fn report(&self, orders: &Orders, plan: &Plan, envelope: f32, sensed: Sensed, motional_current: Phasor) -> Telemetry {
        let mode = self.supervisor.mode();
        let following = matches!(mode, Mode::Lock | Mode::Run);
        let limit = match following {
            true if self.amplitude.limited() => Some(Limit::OverVoltageRequest),
            true if self.tracker.limited() => Some(Limit::FrequencyWindow),
            true if self.tracker.state() == State::Unheard => Some(Limit::NotTracking),
            _ => None,
        };
        Telemetry {
            block: self.block as u32,
            orders_sequence: orders.sequence,
            mode,
            fault: self.supervisor.fault(),
            limit,
            locked: following && self.tracker.state() == State::Locked,
            tuning_word: self.sweep.word(),
            frequency: self.sweep.frequency(),
            resonance: Hertz(self.nominal_hz + self.tracker.estimate_hz()),
            drive: Volts(plan.volts),
            envelope,
            v: sensed.v,
            i: sensed.i,
            motional_current,
            phase: plan.phase,
            transducer: self.transducer,
        }
    }
}
