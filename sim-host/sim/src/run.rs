//! A run of one controller and one plant, block by block, and its record.

mod batch;
mod recorder;
mod script;
mod session;

pub use batch::{LANES, run_batch};
pub use script::Script;

use std::sync::atomic::{AtomicBool, Ordering};

use hal_mock::fault_injector::{FaultInjector, FaultKind, Scheduled};

use contact::Clock;

use self::session::Session;
use crate::processor::{Here, Lost, Processor};
use crate::record::{Record, Window};
use plant::Plant;
use scene::settings;
use scene::{self, Driven};

/// Error of a run.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The firmware refuses its configuration.
    #[error("the firmware refuses this scene's settings: {0}")]
    Config(#[from] firmware::seam::error::Error),
    /// The processor was lost during the run.
    #[error(transparent)]
    Lost(#[from] Lost),
    /// There is no processor for the controller.
    #[error(transparent)]
    NoProcessor(Box<dyn std::error::Error + Send + Sync>),
}

/// Options of a run in addition to its metrics.
#[derive(Default)]
pub struct Watch<'a> {
    /// Time windows to record sample by sample.
    pub windows: Vec<Window>,
    /// Flag that the caller sets to stop the run.
    pub stop: Option<&'a AtomicBool>,
    /// Function called repeatedly with the simulated time, s.
    pub progress: Option<&'a mut dyn FnMut(f64)>,
    /// Clock that times the run; without it the record has no wall time.
    pub clock: Option<Clock>,
}

/// Number of blocks between checks of the stop flag and calls of the progress function.
const CHECK_INTERVAL_BLOCKS: u64 = 256;

/// Runs a scene with the controller in this process.
pub fn run(scene: &Driven, watch: Watch) -> Result<Record, RunError> {
    let mut processor = Here::new(&settings::config(scene))?;
    run_on(&mut processor, scene, watch)
}

/// Runs a scene with the controller on `processor`.
pub fn run_on(processor: &mut dyn Processor, scene: &Driven, watch: Watch) -> Result<Record, RunError> {
    let Watch { windows, stop, mut progress, clock } = watch;
    let began = clock.map(|clock| clock());
    let mut session = Session::new(scene, windows, &processor.silence());
    while let Some(block) = session.next() {
        if block.is_multiple_of(CHECK_INTERVAL_BLOCKS) {
            if let Some(progress) = &mut progress {
                progress(session.time_s());
            }
            if stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
                session.interrupt();
                break;
            }
        }
        session.tick(processor)?;
    }
    let mut record = session.finish(processor)?;
    record.wall_s = clock.zip(began).map(|(clock, began)| (clock() - began).as_secs_f64());
    Ok(record)
}

/// Builds the plant of a scene, with the scheduled faults of its converters.
pub fn breakable_plant(scene: &Driven) -> FaultInjector<Plant> {
    let plant = Plant::new(scene);
    let block_s = plant.sample_s() * f64::from(scene.controller.block_samples);
    let mut plant = FaultInjector::new(plant, &settings::config(scene).front_end, scene.seed);
    faults(scene, block_s).for_each(|fault| plant.schedule(fault));
    plant
}

/// Returns the faults of a scene that are not in the plant itself, for blocks of this length, s.
pub fn faults(scene: &Driven, block_s: f64) -> impl Iterator<Item = Scheduled> {
    let scheduled =
        move |fault: &scene::Fault| kind(fault.kind).map(|kind| Scheduled { at_block: (fault.at_s / block_s) as u64, kind });
    scene.fault.iter().filter_map(scheduled)
}

/// Converts a scene's fault to the injector's; `None` if it is in the plant itself.
fn kind(kind: scene::FaultKind) -> Option<FaultKind> {
    match kind {
        scene::FaultKind::Open => Some(FaultKind::Open),
        scene::FaultKind::Swapped => Some(FaultKind::Swapped),
        scene::FaultKind::SensorStuck => Some(FaultKind::SensorStuck),
        scene::FaultKind::CurrentLate => Some(FaultKind::CurrentLate),
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
