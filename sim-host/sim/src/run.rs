//! A run: one controller, one plant, block after block, and the record of it.

use std::sync::atomic::{AtomicBool, Ordering};

use firmware::seam::block::Target;
use firmware::seam::block::{DriveBlock, Gate, LATENCY_BLOCKS, Orders, Request, SenseBlock, SlowSense};
use firmware::seam::mode::Mode;
use firmware::seam::units::{Hertz, Turns};
use hal_mock::analog::Analog;
use hal_mock::block_clock::BlockClock;
use hal_mock::fault_injector::{FaultInjector, FaultKind, Scheduled};
use hal_mock::tracer::DriveHash;

use contact::Clock;

use crate::edge_meter::EdgeMeter;
use crate::processor::{Here, Lost, Processor};
use crate::record::{Command, Record, Row, Window};
use crate::swing::{Swing, SwingMeter};
use crate::trace::{Played, Tracer};
use plant::{Plant, circuit_of};
use scene::settings;
use scene::{self, Driven};

/// Why a run did not happen.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The firmware refuses its configuration.
    #[error("the firmware refuses this scene's settings: {0}")]
    Config(#[from] firmware::seam::error::Error),
    /// The processor was lost on the way.
    #[error(transparent)]
    Lost(#[from] Lost),
    /// There is no processor for the controller.
    #[error(transparent)]
    NoProcessor(Box<dyn std::error::Error + Send + Sync>),
}

/// How far a run looks beyond its own metrics.
#[derive(Default)]
pub struct Watch<'a> {
    /// Stretches of time to record sample by sample.
    pub windows: Vec<Window>,
    /// Flag that the caller sets to stop the run.
    pub stop: Option<&'a AtomicBool>,
    /// Called with the simulated time, s, every now and then.
    pub progress: Option<&'a mut dyn FnMut(f64)>,
    /// Times the run; without it the record has no wall time.
    pub clock: Option<Clock>,
}

/// Most rows of a record: half a minute of blocks. A longer run keeps every second block, or third, …
const MAX_ROWS: u64 = 1_000_000;
/// Blocks between two looks at the stop flag and calls of the progress function.
const LOOK_EVERY: u64 = 256;

/// Runs a scene with the controller in this process.
pub fn run(scene: &Driven, watch: Watch) -> Result<Record, RunError> {
    let mut processor = Here::new(&settings::config(scene))?;
    run_on(&mut processor, scene, watch)
}

/// Runs a scene with the controller on `processor`.
pub fn run_on(processor: &mut dyn Processor, scene: &Driven, mut watch: Watch) -> Result<Record, RunError> {
    let began = watch.clock.map(|clock| clock());
    let sample_hz = scene.sensors.sample_hz;
    let samples = usize::from(scene.controller.block_samples);
    let blocks = (scene.duration_s * sample_hz / samples as f64).ceil() as u64;
    let mut script = Script::new(scene);

    let mut clock = BlockClock::new(Recorder::new(scene, watch.windows), &processor.silence());
    let every = blocks.div_ceil(MAX_ROWS).max(1);
    let mut record = Record { sample_s: 1.0 / sample_hz, block_samples: samples, every, ..Record::default() };
    record.rows.reserve((blocks / every) as usize + 1);
    let mut pending = [Command::default(); LATENCY_BLOCKS];
    for block in 0..blocks {
        if block % LOOK_EVERY == 0 {
            let time_s = block as f64 * samples as f64 / sample_hz;
            if let Some(progress) = &mut watch.progress {
                progress(time_s);
            }
            if watch.stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
                record.interrupted = true;
                break;
            }
        }
        script.order_friction(block as f64 * samples as f64 / sample_hz);
        let slot = &mut pending[(block % LATENCY_BLOCKS as u64) as usize];
        clock.analog.frequency_hz = slot.frequency_hz(sample_hz);
        let telemetry = clock.tick_with(|sense, drive| {
            let telemetry = processor.process(&script.orders, sense, drive);
            (telemetry, processor.silent_from())
        })?;
        script.follow(telemetry.mode);
        clock.analog.running = telemetry.mode == Mode::Run;
        if let Some(instructions) = processor.instructions() {
            record.instructions.get_or_insert_default().add(instructions);
        }
        if let Some(cycles) = processor.cycles() {
            record.cycles.get_or_insert_default().add(cycles);
        }
        let played = std::mem::replace(slot, Command::of(&telemetry));
        pending[((block + 1) % LATENCY_BLOCKS as u64) as usize].dropped_s = clock.dropped() as f64 / sample_hz;
        let time_s = (block + 1) as f64 * samples as f64 / sample_hz;
        if (block + 1).is_multiple_of(every) {
            let happened = (clock.analog.swing, clock.analog.slow, clock.analog.plant.inner.truth());
            record.rows.push(Row::new(time_s, sample_hz, &played, &telemetry, happened));
        }
        record.last = telemetry;
    }
    let recorder = clock.analog;
    let plant = &recorder.plant.inner;
    record.energy = plant.energy();
    record.crash = plant.playback().cloned();
    record.plant_states = plant.states();
    record.drive_hash = recorder.hash.value();
    record.windows = recorder.windows;
    record.edges = recorder.edges.finish();
    record.trace = recorder.tracer;
    record.load = processor.load();
    record.memory = processor.memory()?;
    record.wall_s = watch.clock.zip(began).map(|(clock, began)| (clock() - began).as_secs_f64());
    Ok(record)
}

/// The orders of a run, which may begin with a calibration.
struct Script {
    orders: Orders,
    /// Friction ratios to be ordered, and when, s; the last one first.
    friction: Vec<(f64, f64)>,
    /// The calibration has begun.
    calibrating: bool,
}

impl Script {
    fn new(scene: &Driven) -> Self {
        let controller = scene.controller;
        let request = if controller.phasing.calibrate { Request::Calibrate } else { Request::Run };
        let orders = Orders {
            sequence: 1,
            attempt: 1,
            request,
            gate: Gate::Scheduled,
            detune: Hertz(controller.drive.detune_hz as f32),
            quadrature: controller.phasing.quadrature_turns.map(|turns| Turns(turns as f32)),
            torso_kg: scene.dring().and_then(|dring| dring.seat_reading_kg()).map(|kg| kg as f32),
            ..Orders::default()
        };
        let friction = controller.friction.iter();
        let friction =
            friction.flat_map(|friction| friction.step_s.iter().copied().zip(friction.step_ratio.iter().copied()).rev());
        Script { orders, friction: friction.collect(), calibrating: false }
    }

    /// Orders the friction that is due.
    fn order_friction(&mut self, time_s: f64) {
        while let Some((_, ratio)) = self.friction.pop_if(|(at_s, _)| *at_s <= time_s) {
            let sequence = self.orders.sequence + 1;
            self.orders = Orders { sequence, friction: Some(Target::Ratio(ratio as f32)), ..self.orders };
        }
    }

    /// Orders the run once the calibration is over. After a fault nothing follows.
    fn follow(&mut self, mode: Mode) {
        self.calibrating |= mode == Mode::Calibrate;
        if self.calibrating && mode == Mode::Idle {
            self.calibrating = false;
            self.orders = Orders { sequence: self.orders.sequence + 1, attempt: 2, request: Request::Run, ..self.orders };
        }
    }
}

/// Middleware on the converters: hashes what is played, and keeps windows and traces sample by sample.
struct Recorder {
    /// The plant, with what breaks on the way.
    plant: FaultInjector<Plant>,
    hash: DriveHash,
    meter: SwingMeter,
    /// How far the last block swung.
    swing: Swing,
    /// What the slow sensors have said of it.
    slow: SlowSense,
    windows: Vec<Window>,
    edges: EdgeMeter,
    tracer: Option<Tracer>,
    sample_s: f64,
    /// Samples played so far.
    played: u64,
    /// Frequency of the block that is about to play, Hz.
    frequency_hz: f64,
    /// Whether the controller was running after the block before.
    running: bool,
}

impl Recorder {
    fn new(scene: &Driven, windows: Vec<Window>) -> Self {
        let plant = breakable_plant(scene);
        let sample_s = plant.inner.sample_s();
        let tracer = scene.trace.as_ref().map(|trace| Tracer::new(trace, scene.duration_s, sample_s));
        Recorder {
            plant,
            hash: DriveHash::default(),
            meter: SwingMeter::new(scene),
            swing: Swing::default(),
            slow: SlowSense::default(),
            windows,
            edges: EdgeMeter::new(scene, circuit_of(scene).time_constant_s()),
            tracer,
            sample_s,
            played: 0,
            frequency_hz: 0.0,
            running: false,
        }
    }
}

/// The plant of a scene, with the faults of its converters to come.
pub fn breakable_plant(scene: &Driven) -> FaultInjector<Plant> {
    let plant = Plant::new(scene);
    let block_s = plant.sample_s() * f64::from(scene.controller.block_samples);
    let mut plant = FaultInjector::new(plant, &settings::config(scene).front_end, scene.seed);
    faults(scene, block_s).for_each(|fault| plant.schedule(fault));
    plant
}

/// The faults of a scene that are not of the plant itself, in blocks of this length, s.
pub fn faults(scene: &Driven, block_s: f64) -> impl Iterator<Item = Scheduled> {
    let scheduled =
        move |fault: &scene::Fault| kind(fault.kind).map(|kind| Scheduled { at_block: (fault.at_s / block_s) as u64, kind });
    scene.fault.iter().filter_map(scheduled)
}

/// A scene's fault as the injector's; none if it breaks the plant itself.
fn kind(kind: scene::FaultKind) -> Option<FaultKind> {
    match kind {
        scene::FaultKind::Open => Some(FaultKind::Open),
        scene::FaultKind::Swapped => Some(FaultKind::Swapped),
        scene::FaultKind::SensorStuck => Some(FaultKind::SensorStuck),
        scene::FaultKind::Saturation => Some(FaultKind::Saturation),
        scene::FaultKind::Dropout => Some(FaultKind::Dropout),
        scene::FaultKind::LateBlock => Some(FaultKind::LateBlock),
        scene::FaultKind::BeltStopped => Some(FaultKind::BeltStopped),
        scene::FaultKind::EncoderStuck => Some(FaultKind::EncoderStuck),
        scene::FaultKind::EncoderLost => Some(FaultKind::EncoderLost),
        scene::FaultKind::EncoderLies => Some(FaultKind::EncoderLies),
        scene::FaultKind::ForceStuck => Some(FaultKind::ForceStuck),
        scene::FaultKind::Overtemperature => Some(FaultKind::Overtemperature),
        scene::FaultKind::Short | scene::FaultKind::Depoled | scene::FaultKind::Cracked => None,
        scene::FaultKind::LaneOpen
        | scene::FaultKind::LaneWeak
        | scene::FaultKind::LaneReversed
        | scene::FaultKind::LanesExchanged => None,
    }
}

impl Analog for Recorder {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        let samples = drive.lanes.first().map_or(0, |lane| lane.len()) as u64;
        let (from_s, to_s) = (self.played as f64 * self.sample_s, (self.played + samples) as f64 * self.sample_s);
        for window in &mut self.windows {
            window.record_frequency(from_s, self.frequency_hz);
        }
        let open = |window: &Window| window.trigger.is_none() && window.from_s < to_s && window.to_s > from_s;
        let traced = self.tracer.as_mut().filter(|tracer| tracer.records(self.played, samples));
        let edge = self.edges.records(self.played, samples, self.running);
        self.plant.inner.keep_samples(edge || traced.is_some() || self.windows.iter().any(open));
        self.plant.exchange(drive, sense);
        self.slow = sense.slow;
        self.hash.add(drive);
        if let Some(codes) = drive.lanes.first().filter(|_| edge) {
            let envelope = self.plant.inner.samples().iter().map(|sample| sample.tip_envelope_m_per_s);
            self.edges.take(self.played, codes, envelope, self.frequency_hz);
        }
        self.swing = self.meter.measure(drive);
        for window in self.windows.iter_mut().filter(|window| open(window)) {
            if window.samples.is_empty() {
                window.start_s = from_s + self.sample_s;
            }
            window.samples.extend_from_slice(self.plant.inner.samples());
        }
        if let Some(tracer) = traced {
            let samples = self.plant.inner.samples();
            tracer.record(&Played { first: self.played, frequency_hz: self.frequency_hz, drive, sense, samples });
        }
        self.played += samples;
    }
}
