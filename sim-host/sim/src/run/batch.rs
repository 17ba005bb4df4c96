//! Several runs in a batch, with their plants computed together. Each has its own controller,
//! commands and record.

use std::sync::atomic::{AtomicBool, Ordering};

use super::recorder::Watched;
use super::session::Session;
use super::{CHECK_INTERVAL_BLOCKS, RunError};
use crate::instruments::windows_of_metrics;
use crate::processor::{Here, Processor};
use crate::record::Record;
use plant::Plant;
use plant::driven_stack::abreast::{Abreast, Voice};
use scene::{Driven, settings};

pub use plant::quad::LANES;

/// Run in a lane.
struct Lane {
    processor: Here,
    session: Session,
}

/// Runs up to [`LANES`] scenes in a batch, with their controllers in this process. Each record
/// equals that of [`run`](super::run) bit for bit. A plant that is not a stack is computed
/// separately, and a scene may end before the others.
pub fn run_batch(scenes: &[Driven], stop: Option<&AtomicBool>) -> Vec<Result<Record, RunError>> {
    let mut lanes: Vec<Result<Lane, RunError>> = scenes.iter().map(Lane::new).collect();
    let mut batch = Abreast::default();
    let mut block = 0_u64;
    while lanes.iter().flatten().any(|lane| lane.session.next().is_some()) {
        if block.is_multiple_of(CHECK_INTERVAL_BLOCKS) && stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
            lanes.iter_mut().flatten().for_each(|lane| lane.session.interrupt());
            break;
        }
        tick(&mut lanes, &mut batch);
        block += 1;
    }
    lanes.into_iter().map(|lane| lane.and_then(|Lane { mut processor, session }| session.finish(&mut processor))).collect()
}

impl Lane {
    fn new(scene: &Driven) -> Result<Self, RunError> {
        let processor = Here::new(&settings::config(scene))?;
        let session = Session::new(scene, windows_of_metrics(scene), &processor.silence());
        Ok(Lane { processor, session })
    }
}

/// Advances every run that has not ended by a block.
fn tick(lanes: &mut [Result<Lane, RunError>], batch: &mut Abreast) {
    let mut voices: [Option<Voice>; LANES] = [const { None }; LANES];
    let mut watched: [Option<Watched>; LANES] = [const { None }; LANES];
    let going = lanes.iter_mut().map(|lane| lane.as_mut().ok().filter(|lane| lane.session.next().is_some()));
    for ((lane, voice), watched) in going.zip(&mut voices).zip(&mut watched) {
        let Some(lane) = lane else { continue };
        lane.session.begin();
        let (recorder, drive, sense) = lane.session.converters();
        *watched = Some(recorder.begin(drive));
        match &mut recorder.plant.inner {
            Plant::Stack(plant) => *voice = Some(Voice { plant, drive, sense }),
            other => hal_mock::analog::Analog::exchange(other, drive, sense),
        }
    }
    batch.exchange(&mut voices);
    for (lane, watched) in lanes.iter_mut().zip(&watched) {
        let (Ok(running), Some(watched)) = (&mut *lane, watched) else { continue };
        running.session.played(watched);
        if let Err(lost) = running.session.answer(&mut running.processor) {
            *lane = Err(lost.into());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instruments;
    use crate::run::{Watch, run};
    use scene::load::{Loaded, load};

    fn scene(name: &str, sets: &[&str]) -> Loaded {
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        load(name, &sets).unwrap_or_else(|error| panic!("{error}"))
    }

    fn compare(group: &[Loaded]) {
        let scenes: Vec<Driven> = group.iter().map(|loaded| loaded.scene.driven().unwrap()).collect();
        for ((together, scene), loaded) in run_batch(&scenes, None).into_iter().zip(&scenes).zip(group) {
            let (together, alone) = (together.unwrap(), run(scene, Watch::default()).unwrap());
            let what = format!("{} {:?}", loaded.name, loaded.sets);
            assert_eq!(together.drive_hash, alone.drive_hash, "{what}");
            assert!(!alone.rows.is_empty() && together.energy == alone.energy, "{what}");
            assert_eq!(instruments::measure(scene, &together), instruments::measure(scene, &alone), "{what}");
            assert!(format!("{:?}", together.rows) == format!("{:?}", alone.rows), "{what}");
        }
    }

    /// Tests cold starts with different nominal values, with a fault that mutes one of them during
    /// the run, and with one that ends before the others.
    #[test]
    fn batched_cold_starts_equal_separate_runs() {
        compare(&[
            scene("lock-cold", &["seed=5", "controller.drive.frequency_hz=39.4e3"]),
            scene("lock-cold", &["seed=6", "controller.tracking.nominal_q=40", "stack.bvd.q=120"]),
            scene("lock-cold", &["seed=7", "fault.0.kind=open", "fault.0.at_s=0.058"]),
            scene("lock-cold", &["seed=8", "duration_s=0.04"]),
        ]);
    }

    /// Tests bursts with silence between them, a drifting resonance, a contact and a motor. Plants
    /// that cannot be batched are computed separately.
    #[test]
    fn batched_scenes_equal_separate_runs() {
        compare(&[scene("burst", &[]), scene("lock", &[]), scene("lock-step", &[])]);
        let contact = ["duration_s=0.15", "controller.burst.on_s=[0.06]", "controller.burst.off_s=[0.12]"];
        let motor = ["duration_s=0.02", "controller.burst.on_s=[0.01]", "controller.burst.off_s=[0.015]"];
        compare(&[scene("experiment-1", &contact), scene("usm", &motor), scene("belt-stop", &[]), scene("burst", &["seed=2"])]);
    }

    #[test]
    fn stopped_runs_are_marked_interrupted() {
        let loaded = scene("lock-cold", &[]);
        let scenes = [loaded.scene.driven().unwrap(); 2];
        let records = run_batch(&scenes, Some(&AtomicBool::new(true)));
        assert!(records.iter().all(|record| record.as_ref().is_ok_and(|record| record.interrupted && record.rows.is_empty())));
    }
}
