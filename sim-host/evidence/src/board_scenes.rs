//! Every scene that the board can play, run by the flashed image on a model of its part.
//!
//! ```text
//! scene, changed to what the board has --> stored settings --> image on its part, plant at its pins --> replay on the host, bit for bit --> expectations
//! ```
//!
//! At the part's own speed, and no block may pass its budget.

use std::sync::atomic::AtomicBool;

use board::configure::load;
use board::linked::{record, record_on};
use board::recording::Replay;
use nucleo_g474re::blocks::CYCLES_PER_BLOCK;
use rayon::prelude::*;
use report::{Report, TableBlock, verdict};
use scene::load::{LoadError, Loaded};
use scene::{Driven, Equal, Expect, Scene};
use sim::processor::Processor;
use sim::run::RunError;
use sim::study::monte_carlo::draw::Draws;
use sim::study::{self, Level, Options as StudyOptions, Outcome, Start, Study, StudyError};

use crate::evidence::{Error, Evidence, Options};
use crate::field_update::boards::FieldImages;

/// The most of a block's cycles that a scene may take, %: a gate.
const BUDGET: f64 = 96.0;
/// Nothing sets it: the caller's flag is looked at between scenes.
static NEVER: AtomicBool = AtomicBool::new(false);

/// A scene, or a case of its comparison at equal peak, and what of it is changed: limits that the board's converters allow, and the length of its blocks.
#[derive(Clone, Copy)]
pub(crate) struct Case {
    pub(crate) scene: &'static str,
    pub(crate) case: Option<&'static str>,
    sets: &'static [&'static str],
    quick: bool,
}

impl Case {
    const fn of(scene: &'static str, sets: &'static [&'static str]) -> Self {
        Case { scene, case: None, sets, quick: false }
    }

    const fn quick(self) -> Self {
        Case { quick: true, ..self }
    }

    const fn case(self, case: &'static str) -> Self {
        Case { case: Some(case), ..self }
    }

    /// Name of the scene, and of its case.
    pub(crate) fn name(&self) -> String {
        self.case.map_or_else(|| self.scene.to_owned(), |case| format!("{}: {case}", self.scene))
    }
}

const COOLER: &str = "controller.limits.temperature_c=85";
const FLAGSHIP: &[&str] = &["controller.limits.current_a=2.909091", COOLER];
const WELDER: &[&str] = &["controller.block_samples=100", "controller.limits.current_a=0.14545456", COOLER];
const HEAVY: &[&str] = &["controller.block_samples=100", "controller.limits.current_a=3.6363637", COOLER];
const RANGE_5_V: &str = "controller.limits.voltage_v=4.6866665";
const QUARTER_AMPERE: &[&str] = &[RANGE_5_V, "controller.limits.current_a=0.18181819", COOLER];
const BELT: &[&str] = FLAGSHIP;
/// Three readings of the wires, where a scene has an ideal decoder, in blocks of 100 us.
const BROKEN_LINE: &[&str] = &["controller.limits.current_a=2.909091", COOLER, "expect.0.max=0.41"];
/// What blocks of 100 us change where a scene expects what blocks of 32 us do.
const STEP: &[&str] = &["controller.limits.current_a=2.909091", COOLER, "expect.0.max=0.41", "expect.1.max=0.71"];
const DRIFT: &[&str] = &["controller.limits.current_a=2.909091", COOLER, "expect.0.max=4.8"];
const LIES: &[&str] = &["controller.limits.current_a=2.909091", COOLER, "expect.0.max=5.1"];
const MOTOR: &[&str] = &["controller.limits.current_a=0.03636364", COOLER];
const WAVES: &[&str] = &["controller.block_samples=100", "controller.limits.current_a=2.909091", COOLER];
/// The scenes.
pub(crate) const CASES: &[Case] = &[
    Case::of("dummy-load", &[]).quick(),
    Case::of("lock", FLAGSHIP).quick(),
    Case::of("lock-step", STEP).quick(),
    Case::of("lock-any", FLAGSHIP),
    Case::of("lock-cold", FLAGSHIP),
    Case::of("lock-load", FLAGSHIP),
    Case::of("lock-drift", DRIFT),
    Case::of("lock-welder", WELDER),
    Case::of("burst", FLAGSHIP).quick(),
    Case::of("experiment-1", FLAGSHIP),
    Case::of("experiment-1-fast", FLAGSHIP),
    Case::of("experiment-1-fitted", FLAGSHIP),
    Case::of("experiment-2", HEAVY),
    Case::of("experiment-2-heavy", HEAVY),
    Case::of("transducer-gb-4540-4sh", QUARTER_AMPERE),
    Case::of("transducer-ma40s4s", &[RANGE_5_V, "controller.limits.current_a=0.0072727273", COOLER]).quick(),
    Case::of("transducer-skymen-60w", &[RANGE_5_V, "controller.limits.current_a=0.36363637", COOLER]),
    Case::of("transducer-smbltd45f28h", QUARTER_AMPERE),
    Case::of("transducer-smbltd45f40h-1", QUARTER_AMPERE),
    Case::of("transducer-smbltd45f40h-2", QUARTER_AMPERE),
    Case::of("belt-stop", BELT).quick(),
    Case::of("belt-stop-slow", BELT),
    Case::of("belt-stop-stuck", BELT),
    Case::of("belt-stop-lost", BROKEN_LINE),
    Case::of("belt-stop-lies", LIES),
    Case::of("friction-ratio", FLAGSHIP),
    Case::of("friction-burst", FLAGSHIP),
    Case::of("dring-crash", FLAGSHIP).quick(),
    Case::of("usm", MOTOR).quick(),
    Case::of("usm-miscalibrated", MOTOR),
    Case::of("waveforms", WAVES),
    Case::of("waveforms", WAVES).case("square"),
    Case::of("waveforms", WAVES).case("sawtooth"),
    Case::of("waveforms", WAVES).case("noise 30 to 50 kHz"),
    Case::of("waveforms", WAVES).case("chirp 20 to 200 kHz in 10 ms"),
    Case::of("waveforms", WAVES).case("chirp about the tracked resonance"),
    Case::of("waveforms-fast", WAVES),
];

/// How the image is flashed.
enum Flashed {
    /// By itself.
    Alone(Vec<u8>),
    /// Into the slot behind the first stage, where it can be updated.
    InSlot(Box<FieldImages>),
}

impl Flashed {
    fn alone() -> Result<Self, Error> {
        let elf = std::fs::read(pil::board_image()?);
        Ok(Flashed::Alone(elf.map_err(|error| pil::PilError::Missing(format!("the image cannot be read: {error}")))?))
    }

    fn in_slot() -> Result<Self, Error> {
        Ok(Flashed::InSlot(FieldImages::built()?.into()))
    }

    /// Runs a scene, and gives its replay.
    fn record(&self, scene: &Driven) -> Result<Replay, RunError> {
        let failed = |error: anyhow::Error| RunError::NoProcessor(error.into());
        match self {
            Flashed::Alone(elf) => record(elf, scene, board::Options::default(), &NEVER).map_err(|error| failed(error.into())),
            Flashed::InSlot(images) => {
                let recorded = board::Options { record: true, ..board::Options::default() };
                let board = images.started(scene, recorded).map_err(|error| failed(error.into()))?;
                record_on(board, scene, &NEVER).map_err(|error| failed(error.into()))
            }
        }
    }
}

/// Runs the scenes on the image that is flashed by itself.
pub fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    scenes(&Flashed::alone()?, "board-scenes", "Scenes by the flashed image", options)
}

/// Runs the scenes on the image in the slot behind the first stage.
pub fn in_slot(options: &mut Options) -> Result<Evidence, Error> {
    scenes(&Flashed::in_slot()?, "slot-scenes", "Scenes by the image behind a first stage", options)
}

fn scenes(flashed: &Flashed, id: &str, title: &str, options: &mut Options) -> Result<Evidence, Error> {
    let cases: Vec<&Case> = CASES.iter().filter(|case| case.quick || !options.quick).collect();
    (options.progress)("the flashed image");
    let ran =
        cases.into_par_iter().map(|case| run(case, flashed).map(|ran| (case.name(), ran))).collect::<Result<Vec<_>, _>>()?;
    let missed = ran.iter().filter_map(|(scene, ran)| ran.failed.as_ref().map(|failed| format!("{scene}: {failed}"))).collect();
    let caption = "By the flashed image on the model of its part, at its own speed. Cycles are those that a block costs, %: of those that it has. Of a scene of many runs the first one. Replayed on the host bit for bit: orders, codes of the converters, codes that left the DAC.";
    let header = [
        "scene",
        "changed",
        "simulated, s",
        "worst block, instructions",
        "cycles",
        "%",
        "mean, cycles",
        "%",
        "drive hash",
        "expectations",
        "",
    ];
    let table = TableBlock::new(id, title, caption, &header, ran.into_iter().map(|(_, ran)| ran.row).collect());
    Ok(Evidence {
        missed,
        report: Report { title: title.into(), tables: vec![table.clone()], ..Report::default() },
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
pub(crate) fn loaded(case: &Case) -> Result<Loaded, LoadError> {
    let sets: Vec<String> = case.sets.iter().map(|&set| set.to_owned()).collect();
    let all = load(case.scene, &sets)?;
    if let Some(name) = case.case {
        let cases = all.scene.comparison.iter().flat_map(|comparison| &comparison.case);
        let of_case: Vec<String> = cases.filter(|of| of.name == name).flat_map(|of| of.set.clone()).collect();
        let cell = all.cell(&of_case)?;
        // What is expected of it at equal peak, and that nothing is wrong.
        let at_peak = |expect: &Expect| expect.case.as_deref() == Some(name) && expect.matched == Some(Equal::Peak);
        let of_all = |expect: &Expect| expect.case.is_none() && expect.metric == "fault_code";
        let expect = all.scene.expect.iter().filter(|expect| at_peak(expect) || of_all(expect));
        let expect = expect.map(|expect| Expect { case: None, matched: None, ..expect.clone() }).collect();
        let scene = Scene { grid: None, comparison: None, expect, ..cell.scene.clone() };
        return Ok(Loaded { scene, ..cell });
    }
    if all.scene.runs == 1 {
        let expect = all.scene.expect.iter().filter(|expect| expect.case.is_none()).cloned().collect();
        let scene = Scene { grid: None, comparison: None, expect, ..all.scene.clone() };
        return Ok(Loaded { scene, ..all });
    }
    let draws = Draws::of(&all.scene);
    all.cell(&draws.draw(1).sets(&draws.keys))
}

/// Runs a scene, changed, on an image.
fn studied<'a>(loaded: &'a Loaded, flashed: &Flashed) -> Result<Study<'a>, StudyError> {
    let start = |scene: &Driven| Ok(Box::new(flashed.record(scene)?) as Box<dyn Processor>);
    study::run(loaded, StudyOptions { start: Some(Start { level: Level::Board, processor: &start }), ..StudyOptions::default() })
}

/// What the longest block of a study takes of its cycles, %.
fn worst_load(study: &Study) -> f64 {
    100.0 * study.metrics.get("worst_block_cycles").unwrap_or(f64::INFINITY) / f64::from(CYCLES_PER_BLOCK)
}

fn run(case: &Case, flashed: &Flashed) -> Result<Ran, Error> {
    let loaded = loaded(case)?;
    let studied = studied(&loaded, flashed);
    let changed = case.sets.iter().map(|set| format!("`{set}`")).collect::<Vec<_>>().join(" ");
    let duration = loaded.scene.duration_s.to_string();
    let study = match studied {
        Ok(study) => study,
        Err(error) => {
            let failed = format!("{:#}", anyhow::Error::from(error));
            let row = [case.name(), changed, duration, failed.clone()].into_iter();
            let row = row.chain(std::iter::repeat_n(String::new(), 6)).chain([verdict(false).to_owned()]).collect();
            return Ok(Ran { row, failed: Some(failed) });
        }
    };
    let Outcome::Driven(of) = &study.outcome else { return Err(Error::Study(StudyError::Incomplete)) };
    let metric = |name| study.metrics.get(name).map_or_else(String::new, |value| format!("{value:.0}"));
    let mean_load = 100.0 * study.metrics.get("mean_block_cycles").unwrap_or(f64::INFINITY) / f64::from(CYCLES_PER_BLOCK);
    let met = study.judged.iter().filter(|judged| judged.pass).count();
    let row = vec![
        case.name(),
        changed,
        duration,
        metric("worst_block_instructions"),
        metric("worst_block_cycles"),
        format!("{:.1}", worst_load(&study)),
        metric("mean_block_cycles"),
        format!("{mean_load:.1}"),
        format!("{:016x}", of.record.drive_hash),
        format!("{met} of {}", study.judged.len()),
        verdict(study.holds()).to_owned(),
    ];
    let missed: Vec<&str> = study.judged.iter().filter(|judged| !judged.pass).map(|judged| judged.metric.as_str()).collect();
    let over = worst_load(&study) > BUDGET;
    let missed: Vec<&str> = missed.into_iter().chain(over.then_some("the cycles of a block")).collect();
    Ok(Ran { row, failed: (!missed.is_empty()).then(|| missed.join(", ")) })
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;

    #[test]
    fn the_flashed_image_runs_short_scenes_as_the_host_does() {
        if let Some(missing) = pil::missing_to_build() {
            let _ = writeln!(std::io::stderr(), "SKIPPED, scenes by the flashed image: {missing}");
            return;
        }
        let evidence =
            evidence(&mut Options { quick: true, count: None, seed: None, counted: None, stop: None, progress: &mut |_| () })
                .unwrap();
        assert!(evidence.missed.is_empty(), "{:#?}", evidence.missed);
        assert!(evidence.docs[0].rows.len() >= 8);
    }

    /// The start of every scene, with its first bursts: no block of either image may pass its budget.
    #[test]
    fn no_scene_has_a_block_beyond_its_time() {
        if let Some(missing) = pil::missing_to_build() {
            let _ = writeln!(std::io::stderr(), "SKIPPED, the beginning of all scenes by both images: {missing}");
            return;
        }
        let images = [Flashed::alone().unwrap(), Flashed::in_slot().unwrap()];
        let cases: Vec<(&Case, &Flashed)> = CASES.iter().flat_map(|case| images.iter().map(move |image| (case, image))).collect();
        let load = |(case, flashed): (&Case, &Flashed)| {
            let all = loaded(case).unwrap();
            let scene = Scene { duration_s: all.scene.duration_s.min(0.12), expect: Vec::new(), ..all.scene.clone() };
            let begun = Loaded { scene, ..all };
            let load = studied(&begun, flashed).map_or(f64::INFINITY, |study| worst_load(&study));
            (case.name(), load)
        };
        let over: Vec<_> = cases.into_par_iter().map(load).filter(|(_, load)| *load > BUDGET).collect();
        assert!(over.is_empty(), "{over:?}");
    }
}
