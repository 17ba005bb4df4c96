//! A run in progress, block by block, with its commands, converters and record. The caller owns the
//! controller.

use firmware::seam::block::{DriveBlock, LATENCY_BLOCKS, SenseBlock};
use firmware::seam::mode::Mode;
use hal_mock::block_clock::BlockClock;

use super::RunError;
use super::recorder::{Recorder, Watched};
use super::script::Script;
use crate::processor::{Lost, Processor};
use crate::record::{Command, Record, Row, Window};
use scene::Driven;

/// Maximum number of rows of a record: half a minute of blocks. A longer run keeps every second or
/// third block, and so on.
const MAX_ROWS: u64 = 1_000_000;

/// Run in progress.
pub(super) struct Session {
    sample_hz: f64,
    samples: usize,
    blocks: u64,
    block: u64,
    script: Script,
    clock: BlockClock<Recorder>,
    pending: [Command; LATENCY_BLOCKS],
    record: Record,
}

impl Session {
    /// Begins a run with `silence` playing.
    pub(super) fn new(scene: &Driven, windows: Vec<Window>, silence: &DriveBlock) -> Self {
        let sample_hz = scene.sensors.sample_hz;
        let samples = usize::from(scene.controller.block_samples);
        let blocks = (scene.duration_s * sample_hz / samples as f64).ceil() as u64;
        let every = blocks.div_ceil(MAX_ROWS).max(1);
        let mut record = Record { sample_s: 1.0 / sample_hz, block_samples: samples, every, ..Record::default() };
        record.rows.reserve((blocks / every) as usize + 1);
        Session {
            sample_hz,
            samples,
            blocks,
            block: 0,
            script: Script::new(scene),
            clock: BlockClock::new(Recorder::new(scene, windows), silence),
            pending: [Command::default(); LATENCY_BLOCKS],
            record,
        }
    }

    /// Returns the number of the next block, if there is one.
    pub(super) fn next(&self) -> Option<u64> {
        (self.block < self.blocks).then_some(self.block)
    }

    /// Returns the beginning of the next block, s.
    pub(super) fn time_s(&self) -> f64 {
        self.block as f64 * self.samples as f64 / self.sample_hz
    }

    /// Marks the run as stopped before its end.
    pub(super) fn interrupt(&mut self) {
        self.record.interrupted = true;
    }

    /// Plays the next block, and processes it in the controller.
    pub(super) fn tick(&mut self, processor: &mut (impl Processor + ?Sized)) -> Result<(), Lost> {
        self.begin();
        let (recorder, drive, sense) = self.clock.converters();
        hal_mock::analog::Analog::exchange(recorder, drive, sense);
        self.answer(processor)
    }

    /// Begins the next block: the part of a tick before the plant plays.
    pub(super) fn begin(&mut self) {
        self.script.order_friction(self.time_s());
        let slot = &self.pending[(self.block % LATENCY_BLOCKS as u64) as usize];
        self.clock.analog.frequency_hz = slot.frequency_hz(self.sample_hz);
    }

    /// Returns the recorder, the drive block to play, and the sense block to fill.
    pub(super) fn converters(&mut self) -> (&mut Recorder, &DriveBlock, &mut SenseBlock) {
        self.clock.converters()
    }

    /// Ends a block that the plant has played without an exchange.
    pub(super) fn played(&mut self, watched: &Watched) {
        let (recorder, drive, sense) = self.clock.converters();
        recorder.end(watched, drive, sense);
    }

    /// Processes a played and sampled block in the controller, and adds it to the record.
    pub(super) fn answer(&mut self, processor: &mut (impl Processor + ?Sized)) -> Result<(), Lost> {
        let Session { sample_hz, script, clock, record, block, .. } = self;
        let (block, sample_hz) = (*block, *sample_hz);
        clock.answer(|sense, drive| {
            let processed = processor.process_into(&script.orders, sense, drive, &mut record.last);
            (processed, processor.silent_from())
        })?;
        script.follow(record.last.mode);
        clock.analog.running = record.last.mode == Mode::Run;
        if let Some(instructions) = processor.instructions() {
            record.instructions.get_or_insert_default().add(instructions);
        }
        if let Some(cycles) = processor.cycles() {
            record.cycles.get_or_insert_default().add(cycles);
        }
        let slot = &mut self.pending[(block % LATENCY_BLOCKS as u64) as usize];
        let played = std::mem::replace(slot, Command::from_telemetry(&record.last));
        self.pending[((block + 1) % LATENCY_BLOCKS as u64) as usize].dropped_s = clock.dropped() as f64 / sample_hz;
        let time_s = (block + 1) as f64 * self.samples as f64 / sample_hz;
        if (block + 1).is_multiple_of(record.every) {
            let happened = (clock.analog.swing, clock.analog.slow, clock.analog.plant.inner.truth());
            record.rows.push(Row::new(record.rows.len() as u32, (time_s, sample_hz), &played, &record.last, happened));
            record.motors.extend(clock.analog.plant.inner.motor_truth());
        }
        self.block += 1;
        Ok(())
    }

    /// Returns the record of a run that has ended or was stopped.
    pub(super) fn finish(self, processor: &mut (impl Processor + ?Sized)) -> Result<Record, RunError> {
        let Session { mut record, clock, .. } = self;
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
        Ok(record)
    }
}
