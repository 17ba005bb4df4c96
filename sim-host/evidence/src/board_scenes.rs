//! Runs every scene that the board can play by the flashed image on a model of its part.
//!
//! ```text
//! scene, changed to the board's converters --> stored settings --> image on its part, plant at its pins --> replay on the host, bit for bit --> expectations
//! ```
//!
//! The part runs at its own speed, and no block may exceed its budget.

use std::sync::atomic::AtomicBool;

use board::configure::load;
use board::linked::{record, record_on};
use board::recording::Replay;
use nucleo_g474re::blocks::CYCLES_PER_BLOCK;
use rayon::prelude::*;
use report::{TableBlock, verdict};
use scene::load::{LoadError, Loaded};
use scene::{Driven, Equal, Expect, Scene};
use sim::processor::Processor;
use sim::run::RunError;
use sim::study::monte_carlo::draw::Draws;
use sim::study::{self, Level, Options as StudyOptions, Outcome, Start, Study, StudyError};

use crate::campaign::{self, cells, columns};
use crate::evidence::{Error, Evidence, Options};
use crate::field_update::boards::FieldImages;

/// Largest fraction of a block's cycles that a scene may take, %; a larger one fails the scene.
const BUDGET_PERCENT: f64 = 96.0;
/// A stop flag that is never set; the caller's flag is checked between scenes.
static NEVER: AtomicBool = AtomicBool::new(false);

/// A scene, or a case of its comparison at equal peak, with its changed settings: limits within the
/// range of the board's converters, and the length of its blocks.
#[derive(Clone, Copy)]
pub(crate) struct Case {
    pub(crate) scene: &'static str,
    pub(crate) case: Option<&'static str>,
    sets: &'static [&'static str],
    quick: bool,
}

impl Case {
    const fn new(scene: &'static str, sets: &'static [&'static str]) -> Self {
        Case { scene, case: None, sets, quick: false }
    }

    const fn quick(self) -> Self {
        Case { quick: true, ..self }
    }

    const fn case(self, case: &'static str) -> Self {
        Case { case: Some(case), ..self }
    }

    /// Returns the name of the scene, with that of its case.
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
/// Settings with time for three readings of the wires in blocks of 100 us; the scene itself assumes
/// an ideal decoder.
const BROKEN_LINE: &[&str] = &["controller.limits.current_a=2.909091", COOLER, "expect.0.max=0.41"];
/// Settings with expectations for blocks of 100 us; those of the scene are for blocks of 32 us.
const STEP: &[&str] = &["controller.limits.current_a=2.909091", COOLER, "expect.0.max=0.41", "expect.1.max=0.71"];
const DRIFT: &[&str] = &["controller.limits.current_a=2.909091", COOLER, "expect.0.max=4.8"];
const LIES: &[&str] = &["controller.limits.current_a=2.909091", COOLER, "expect.0.max=5.1"];
const MOTOR: &[&str] = &["controller.limits.current_a=0.03636364", COOLER];
const WAVES: &[&str] = &["controller.block_samples=100", "controller.limits.current_a=2.909091", COOLER];
/// All scenes of the bench.
pub(crate) const CASES: &[Case] = &[
    Case::new("dummy-load", &[]).quick(),
    Case::new("lock", FLAGSHIP).quick(),
    Case::new("lock-step", STEP).quick(),
    Case::new("lock-any", FLAGSHIP),
    Case::new("lock-cold", FLAGSHIP),
    Case::new("lock-load", FLAGSHIP),
    Case::new("lock-drift", DRIFT),
    Case::new("lock-welder", WELDER),
    Case::new("burst", FLAGSHIP).quick(),
    Case::new("experiment-1", FLAGSHIP),
    Case::new("experiment-1-fast", FLAGSHIP),
    Case::new("experiment-1-fitted", FLAGSHIP),
    Case::new("experiment-2", HEAVY),
    Case::new("experiment-2-heavy", HEAVY),
    Case::new("transducer-gb-4540-4sh", QUARTER_AMPERE),
    Case::new("transducer-ma40s4s", &[RANGE_5_V, "controller.limits.current_a=0.0072727273", COOLER]).quick(),
    Case::new("transducer-skymen-60w", &[RANGE_5_V, "controller.limits.current_a=0.36363637", COOLER]),
    Case::new("transducer-smbltd45f28h", QUARTER_AMPERE),
    Case::new("transducer-smbltd45f40h-1", QUARTER_AMPERE),
    Case::new("transducer-smbltd45f40h-2", QUARTER_AMPERE),
    Case::new("belt-stop", BELT).quick(),
    Case::new("belt-stop-slow", BELT),
    Case::new("belt-stop-stuck", BELT),
    Case::new("belt-stop-lost", BROKEN_LINE),
    Case::new("belt-stop-lies", LIES),
    Case::new("friction-ratio", FLAGSHIP),
    Case::new("friction-burst", FLAGSHIP),
    Case::new("dring-crash", FLAGSHIP).quick(),
    Case::new("usm", MOTOR).quick(),
    Case::new("usm-miscalibrated", MOTOR),
    Case::new("waveforms", WAVES),
    Case::new("waveforms", WAVES).case("square"),
    Case::new("waveforms", WAVES).case("sawtooth"),
    Case::new("waveforms", WAVES).case("noise 30 to 50 kHz"),
    Case::new("waveforms", WAVES).case("chirp 20 to 200 kHz in 10 ms"),
    Case::new("waveforms", WAVES).case("chirp about the tracked resonance"),
    Case::new("waveforms-fast", WAVES),
];

/// The flashed image.
enum Flashed {
    /// The image alone.
    Alone(Vec<u8>),
    /// The updatable image in a slot after the first stage.
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

    /// Runs a scene, and returns its replay.
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

/// Runs the scenes on the image flashed alone.
pub fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    scenes(&Flashed::alone()?, "board-scenes", "Scenes by the flashed image", options)
}

/// Runs the scenes on the image in the slot after the first stage.
pub fn in_slot(options: &mut Options) -> Result<Evidence, Error> {
    scenes(&Flashed::in_slot()?, "slot-scenes", "Scenes by the image after a first stage", options)
}

fn scenes(flashed: &Flashed, id: &str, title: &str, options: &mut Options) -> Result<Evidence, Error> {
    let cases: Vec<&Case> = CASES.iter().filter(|case| case.quick || !options.quick).collect();
    (options.progress)("the flashed image");
    let ran =
        cases.into_par_iter().map(|case| run(case, flashed).map(|ran| (case.name(), ran))).collect::<Result<Vec<_>, _>>()?;
    let missed = ran.iter().filter_map(|(scene, ran)| ran.failed.as_ref().map(|failed| format!("{scene}: {failed}"))).collect();
    let caption = "By the flashed image on the model of its part, at its own speed. Cycles: those that a block takes; %: of \
                   those available. For a scene of many runs, the first one. Replayed on the host bit for bit: orders, codes of \
                   the converters, codes played by the DAC.";
    let header = columns(
        "scene | changed | simulated, s | worst block, instructions | cycles | % | mean, cycles | % | drive hash | \
         expectations | ",
    );
    let table = TableBlock::new(id, title, caption, &header, ran.into_iter().map(|(_, ran)| ran.row).collect());
    Ok(campaign::evidence(title, "", vec![table], Vec::new(), missed))
}

/// Result of a scene.
struct SceneResult {
    row: Vec<String>,
    failed: Option<String>,
}

/// Loads a scene with its changed settings, reduced to one run and one case.
pub(crate) fn loaded(case: &Case) -> Result<Loaded, LoadError> {
    let sets: Vec<String> = case.sets.iter().map(|&set| set.to_owned()).collect();
    let all = load(case.scene, &sets)?;
    if let Some(name) = case.case {
        let cases = all.scene.comparison.iter().flat_map(|comparison| &comparison.case);
        let of_case: Vec<String> = cases.filter(|of| of.name == name).flat_map(|of| of.set.clone()).collect();
        let cell = all.cell(&of_case)?;
        // Its expectations at equal peak, and the one that no fault occurs.
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

/// Runs a loaded scene on an image.
fn studied<'a>(loaded: &'a Loaded, flashed: &Flashed) -> Result<Study<'a>, StudyError> {
    let start = |scene: &Driven| Ok(Box::new(flashed.record(scene)?) as Box<dyn Processor>);
    study::run(loaded, StudyOptions { start: Some(Start { level: Level::Board, processor: &start }), ..StudyOptions::default() })
}

/// Returns the cycles of the longest block of a study, % of those available.
fn worst_load(study: &Study) -> f64 {
    100.0 * study.metrics.get("worst_block_cycles").unwrap_or(f64::INFINITY) / f64::from(CYCLES_PER_BLOCK)
}

fn run(case: &Case, flashed: &Flashed) -> Result<SceneResult, Error> {
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
            return Ok(SceneResult { row, failed: Some(failed) });
        }
    };
    let Outcome::Driven(of) = &study.outcome else { return Err(Error::Study(StudyError::Incomplete)) };
    let metric = |name| study.metrics.get(name).map_or_else(String::new, |value| format!("{value:.0}"));
    let mean_load = 100.0 * study.metrics.get("mean_block_cycles").unwrap_or(f64::INFINITY) / f64::from(CYCLES_PER_BLOCK);
    let met = study.judged.iter().filter(|judged| judged.pass).count();
    let [instructions, worst, mean] = ["worst_block_instructions", "worst_block_cycles", "mean_block_cycles"].map(metric);
    let [worst_load, mean_load] = [worst_load(&study), mean_load].map(|load| format!("{load:.1}"));
    let (hash, met) = (format!("{:016x}", of.record.drive_hash), format!("{met} of {}", study.judged.len()));
    let holds = verdict(study.holds());
    let row = cells![case.name(), changed, duration, instructions, worst, worst_load, mean, mean_load, hash, met, holds];
    let missed: Vec<&str> = study.judged.iter().filter(|judged| !judged.pass).map(|judged| judged.metric.as_str()).collect();
    let over = self::worst_load(&study) > BUDGET_PERCENT;
    let missed: Vec<&str> = missed.into_iter().chain(over.then_some("cycles of a block")).collect();
    Ok(SceneResult { row, failed: (!missed.is_empty()).then(|| missed.join(", ")) })
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
        let evidence = campaign::quick(evidence, None);
        assert!(evidence.missed.is_empty(), "{:#?}", evidence.missed);
        assert!(evidence.docs[0].rows.len() >= 8);
    }

    /// Runs the start of every scene, with its first bursts: no block of either image exceeds its
    /// budget.
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
        let over: Vec<_> = cases.into_par_iter().map(load).filter(|(_, load)| *load > BUDGET_PERCENT).collect();
        assert!(over.is_empty(), "{over:?}");
    }
}
