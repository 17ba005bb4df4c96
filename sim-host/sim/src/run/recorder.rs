//! Recorder of a run between controller and plant.

use firmware::seam::block::{DriveBlock, SenseBlock, SlowSense};
use hal_mock::analog::Analog;
use hal_mock::fault_injector::FaultInjector;
use hal_mock::tracer::DriveHash;

use super::breakable_plant;
use crate::edge_meter::EdgeMeter;
use crate::record::Window;
use crate::swing::{Swing, SwingMeter};
use crate::trace::{Played, Tracer};
use plant::{Plant, circuit_of};
use scene::Driven;

/// Middleware on the converters: hashes the played codes, and records windows and traces sample by
/// sample.
pub(super) struct Recorder {
    /// Plant with the scheduled faults.
    pub(super) plant: FaultInjector<Plant>,
    pub(super) hash: DriveHash,
    meter: SwingMeter,
    /// Swing of the last block.
    pub(super) swing: Swing,
    /// Readings of the slow sensors in the last block.
    pub(super) slow: SlowSense,
    pub(super) windows: Vec<Window>,
    pub(super) edges: EdgeMeter,
    pub(super) tracer: Option<Tracer>,
    sample_s: f64,
    /// Number of samples played.
    played: u64,
    /// Frequency of the next block, Hz.
    pub(super) frequency_hz: f64,
    /// `true` if the controller was in `Run` after the previous block.
    pub(super) running: bool,
}

impl Recorder {
    pub(super) fn new(scene: &Driven, windows: Vec<Window>) -> Self {
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

impl Analog for Recorder {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        let watched = self.begin(drive);
        self.plant.inner.exchange(drive, sense);
        self.end(&watched, drive, sense);
    }
}

/// Recording of a block, sample by sample.
pub(super) struct Watched {
    from_s: f64,
    to_s: f64,
    samples: u64,
    edge: bool,
    traced: bool,
}

impl Watched {
    fn opens(&self, window: &Window) -> bool {
        window.trigger.is_none() && window.from_s < self.to_s && window.to_s > self.from_s
    }
}

impl Recorder {
    /// Prepares the recording before a block is played.
    pub(super) fn begin(&mut self, drive: &DriveBlock) -> Watched {
        let samples = drive.lanes.first().map_or(0, |lane| lane.len()) as u64;
        let (from_s, to_s) = (self.played as f64 * self.sample_s, (self.played + samples) as f64 * self.sample_s);
        for window in &mut self.windows {
            window.record_frequency(from_s, self.frequency_hz);
        }
        let traced = self.tracer.as_mut().is_some_and(|tracer| tracer.records(self.played, samples));
        let edge = self.edges.begin_block(self.played, samples, self.running);
        let watched = Watched { from_s, to_s, samples, edge, traced };
        self.plant.inner.keep_samples(edge || traced || self.windows.iter().any(|window| watched.opens(window)));
        watched
    }

    /// Records a block after the plant has played and sampled it.
    pub(super) fn end(&mut self, watched: &Watched, drive: &DriveBlock, sense: &mut SenseBlock) {
        self.plant.damage(sense);
        self.slow = sense.slow;
        self.hash.add(drive);
        if let Some(codes) = drive.lanes.first().filter(|_| watched.edge) {
            let envelope = self.plant.inner.samples().iter().map(|sample| sample.tip_envelope_m_per_s);
            self.edges.record_block(self.played, codes, envelope, self.frequency_hz);
        }
        self.swing = self.meter.measure(drive);
        for window in self.windows.iter_mut().filter(|window| watched.opens(window)) {
            if window.samples.is_empty() {
                window.start_s = watched.from_s + self.sample_s;
            }
            window.samples.extend_from_slice(self.plant.inner.samples());
        }
        if let Some(tracer) = self.tracer.as_mut().filter(|_| watched.traced) {
            let samples = self.plant.inner.samples();
            tracer.record(&Played { first: self.played, frequency_hz: self.frequency_hz, drive, sense, samples });
        }
        self.played += watched.samples;
    }
}
