//! Every scene with one drive lane, run by the flashed image on a model of its part.
//!
//! ```text
//! scene, changed to what the board has --> stored settings --> image on its part, plant at its pins --> replay on the host, bit for bit --> expectations
//! ```
//!
//! The block interrupt takes an eighth of its time: at its own speed the image misses blocks. What it costs is counted all the same.

use std::sync::atomic::AtomicBool;

use link::modelled_board::record;
use rayon::prelude::*;
use report::{Report, TableBlock, verdict};
use scene::load::{LoadError, Loaded, load};
use scene::{Driven, Scene};
use sim::processor::Processor;
use sim::run::RunError;
use sim::study::monte_carlo::draw::Draws;
use sim::study::{self, Level, Options as StudyOptions, Outcome, Start};

use crate::evidence::{Error, Evidence, Options};

/// The part of its time that the block interrupt takes.
const RATE: f64 = 1.0 / 8.0;
/// Nothing sets it: the caller's flag is looked at between scenes.
static NEVER: AtomicBool = AtomicBool::new(false);

/// A scene, and what of it is changed: limits that the board's converters allow, and the length of its blocks.
struct Case {
    scene: &'static str,
    sets: &'static [&'static str],
    quick: bool,
}

const COOLER: &str = "controller.limits.temperature_c=85";
const FLAGSHIP: &[&str] = &["controller.limits.current_a=2.909091", COOLER];
const WELDER: &[&str] = &["controller.block_samples=32", "controller.limits.current_a=0.14545456", COOLER];
const HEAVY: &[&str] = &["controller.block_samples=32", "controller.limits.current_a=3.6363637", COOLER];
const RANGE_5_V: &str = "controller.limits.voltage_v=4.6866665";
const QUARTER_AMPERE: &[&str] = &[RANGE_5_V, "controller.limits.current_a=0.18181819", COOLER];
const CASES: [Case; 20] = [
    Case { scene: "dummy-load", sets: &[], quick: true },
    Case { scene: "lock", sets: FLAGSHIP, quick: true },
    Case { scene: "lock-step", sets: FLAGSHIP, quick: true },
    Case { scene: "lock-any", sets: FLAGSHIP, quick: false },
    Case { scene: "lock-cold", sets: FLAGSHIP, quick: false },
    Case { scene: "lock-load", sets: FLAGSHIP, quick: false },
    Case { scene: "lock-drift", sets: FLAGSHIP, quick: false },
    Case { scene: "lock-welder", sets: WELDER, quick: false },
    Case { scene: "burst", sets: FLAGSHIP, quick: true },
    Case { scene: "experiment-1", sets: FLAGSHIP, quick: false },
    Case { scene: "experiment-1-fast", sets: FLAGSHIP, quick: false },
    Case { scene: "experiment-1-fitted", sets: FLAGSHIP, quick: false },
    Case { scene: "experiment-2", sets: HEAVY, quick: false },
    Case { scene: "experiment-2-heavy", sets: HEAVY, quick: false },
    Case { scene: "transducer-gb-4540-4sh", sets: QUARTER_AMPERE, quick: false },
    Case { scene: "transducer-ma40s4s", sets: &[RANGE_5_V, "controller.limits.current_a=0.0072727273", COOLER], quick: true },
    Case { scene: "transducer-skymen-60w", sets: &[RANGE_5_V, "controller.limits.current_a=0.36363637", COOLER], quick: false },
    Case { scene: "transducer-smbltd45f28h", sets: QUARTER_AMPERE, quick: false },
    Case { scene: "transducer-smbltd45f40h-1", sets: QUARTER_AMPERE, quick: false },
    Case { scene: "transducer-smbltd45f40h-2", sets: QUARTER_AMPERE, quick: false },
];

/// Runs the scenes.
pub fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let elf = std::fs::read(pil::board_image()?)
        .map_err(|error| pil::PilError::Missing(format!("the image cannot be read: {error}")))?;
    let cases: Vec<&Case> = CASES.iter().filter(|case| case.quick || !options.quick).collect();
    (options.progress)("the flashed image");
    let ran = cases.into_par_iter().map(|case| run(case, &elf).map(|ran| (case.scene, ran))).collect::<Result<Vec<_>, _>>()?;
    let missed = ran.iter().filter_map(|(scene, ran)| ran.failed.as_ref().map(|failed| format!("{scene}: {failed}"))).collect();
    let caption = "By the flashed image on the model of its part, each with its interrupt at an eighth of its time; cycles are those that it costs. Of a scene of many \
                   runs the first one. Replayed on the host bit for bit: orders, codes of the converters, codes that left the DAC.";
    let header = [
        "scene",
        "changed",
        "simulated, s",
        "worst block, instructions",
        "cycles",
        "mean, cycles",
        "drive hash",
        "expectations",
        "",
    ];
    let table = TableBlock::new(
        "board-scenes",
        "Scenes by the flashed image",
        caption,
        &header,
        ran.into_iter().map(|(_, ran)| ran.row).collect(),
    );
    Ok(Evidence {
        missed,
        report: Report { title: "Scenes by the flashed image".into(), tables: vec![table.clone()], ..Report::default() },
        docs: vec![table],
        ..Evidence::default()
    })
}

/// What came of a scene.
struct Ran {
    row: Vec<String>,
    failed: Option<String>,
}

/// A scene of one run and one case, changed.
fn loaded(case: &Case) -> Result<Loaded, LoadError> {
    let sets: Vec<String> = case.sets.iter().map(|&set| set.to_owned()).collect();
    let all = load(case.scene, &sets)?;
    if all.scene.runs == 1 {
        let scene = Scene { grid: None, comparison: None, ..all.scene.clone() };
        return Ok(Loaded { scene, ..all });
    }
    let draws = Draws::of(&all.scene);
    all.cell(&draws.draw(1).sets(&draws.keys))
}

fn run(case: &Case, elf: &[u8]) -> Result<Ran, Error> {
    let loaded = loaded(case)?;
    let start = |scene: &Driven| {
        let replay = record(elf, scene, board::Options { rate: Some(RATE), ..board::Options::default() }, &NEVER)
            .map_err(|error| RunError::NoProcessor(error.into()))?;
        Ok(Box::new(replay) as Box<dyn Processor>)
    };
    let studied = study::run(
        &loaded,
        StudyOptions { start: Some(Start { level: Level::Board, processor: &start }), ..StudyOptions::default() },
    );
    let changed = case.sets.iter().map(|set| format!("`{set}`")).collect::<Vec<_>>().join(" ");
    let duration = loaded.scene.duration_s.to_string();
    let study = match studied {
        Ok(study) => study,
        Err(error) => {
            let failed = format!("{:#}", anyhow::Error::from(error));
            let row = [case.scene.to_owned(), changed, duration, failed.clone()].into_iter();
            let row = row.chain(std::iter::repeat_n(String::new(), 4)).chain([verdict(false).to_owned()]).collect();
            return Ok(Ran { row, failed: Some(failed) });
        }
    };
    let Outcome::Driven(of) = &study.outcome else { return Err(Error::Study(study::StudyError::Incomplete)) };
    let metric = |name| study.metrics.get(name).map_or_else(String::new, |value| format!("{value:.0}"));
    let met = study.judged.iter().filter(|judged| judged.pass).count();
    let row = vec![
        case.scene.to_owned(),
        changed,
        duration,
        metric("worst_block_instructions"),
        metric("worst_block_cycles"),
        metric("mean_block_cycles"),
        format!("{:016x}", of.record.drive_hash),
        format!("{met} of {}", study.judged.len()),
        verdict(study.passes()).to_owned(),
    ];
    let missed: Vec<&str> = study.judged.iter().filter(|judged| !judged.pass).map(|judged| judged.metric.as_str()).collect();
    Ok(Ran { row, failed: (!missed.is_empty()).then(|| missed.join(", ")) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_flashed_image_runs_short_scenes_as_the_host_does() {
        if let Some(missing) = pil::missing_to_build() {
            eprintln!("SKIPPED, scenes by the flashed image: {missing}");
            return;
        }
        let evidence = evidence(&mut Options { quick: true, counted: None, stop: None, progress: &mut |_| () }).unwrap();
        assert!(evidence.missed.is_empty(), "{:#?}", evidence.missed);
        assert!(evidence.docs[0].rows.len() >= 5);
    }
}
