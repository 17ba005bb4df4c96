//! Every built-in scene with a controller, host compared with thumb code: the hash of all played
//! codes, and the last report.
//!
//! `UPDATE_DOCS=1 cargo test -p image-scenarios docs -- --include-ignored` writes the table of
//! docs/evidence/processor-in-the-loop.md.

use std::fmt::Write as _;
use std::path::Path;

use pil::Qemu;
use scene::load::load;
use scene::{Driven, builtin, settings};
use sim::processor::Processor;
use sim::study::monte_carlo::MonteCarlo;
use sim::study::{self, Level, Options, Outcome, Start};

use super::{bits, image};

/// Number of runs of a scene with many runs.
const RUNS: u32 = 8;

/// Values of a scene that are compared and reported.
struct Played {
    hash: u64,
    /// Last report of a single run, bit for bit; or the metrics of several runs.
    end: Vec<u8>,
    blocks: u64,
    metrics: Vec<Option<f64>>,
}

const METRICS: [&str; 3] = ["mean_block_instructions", "worst_block_instructions", "stack_blocks_bytes"];

/// Runs a scene, in this process or on an image. Returns `None` if it has no controller.
fn played(name: &str, image: Option<&Path>) -> Option<Played> {
    let mut loaded = load(name, &[]).unwrap_or_else(|error| panic!("{error}"));
    loaded.scene.driven()?;
    if loaded.scene.runs > 1 {
        loaded = load(name, &[format!("runs={RUNS}")]).unwrap_or_else(|error| panic!("{error}"));
    }
    // Grids and comparisons run on the host in either case.
    (loaded.scene.grid, loaded.scene.comparison) = (None, None);
    let start = image
        .map(|image| move |scene: &Driven| Ok(Box::new(Qemu::start(image, &settings::config(scene))?) as Box<dyn Processor>));
    let start = start.as_ref().map(|start| Start { level: Level::Pil, processor: start });
    let study = study::run(&loaded, Options { start, ..Options::default() }).unwrap_or_else(|error| panic!("{name}: {error}"));
    let metrics = METRICS.iter().map(|metric| study.metrics.get(metric)).collect();
    Some(match &study.outcome {
        Outcome::Driven(run) => {
            Played { hash: run.record.drive_hash, end: bits(&run.record.last), blocks: run.record.rows.len() as u64, metrics }
        }
        Outcome::MonteCarlo(runs) => Played { hash: runs.drive_hash()?, end: ends(runs), blocks: 0, metrics },
        Outcome::Contact(_) | Outcome::Design(_) => return None,
    })
}

/// Returns the metrics of the runs of a campaign, without those that only a separate processor has.
fn ends(runs: &MonteCarlo) -> Vec<u8> {
    let common = |name: &&str| !["instructions", "stack_", "image_"].iter().any(|part| name.contains(part));
    let metrics = runs.runs.iter().flat_map(|run| run.metrics.iter().filter(|(name, _)| common(name)));
    metrics.flat_map(|(_, value)| value.to_le_bytes()).collect()
}

const HEADER: &str =
    "| scene | blocks | hash, host and QEMU | instructions, mean | worst block | stack [bytes] |\n|---|---|---|---|---|---|\n";

/// The target without the DSP instructions of a Cortex-M4, and with another memory map.
#[test]
fn a_cortex_m33_plays_every_scene_alike() {
    if !super::is_possible("the controller on a Cortex-M33", pil::missing_to_build_cortex_m33()) {
        return;
    }
    let image = pil::cortex_m33_image().expect("the image builds");
    assert_eq!(compare(&image).0, with_a_controller());
}

/// Compares the scenes. Returns their number and a table.
fn compare(image: &Path) -> (usize, String) {
    let (mut compared, mut table) = (0, HEADER.to_owned());
    for (name, _) in builtin::all() {
        let Some(here) = played(name, None) else { continue };
        let there = played(name, Some(image)).expect("the same scene");
        assert_eq!(here.hash, there.hash, "{name}: hashes of all drive codes played");
        assert!(here.end == there.end, "{name}: identical codes, but different reports");
        compared += 1;
        let blocks = if there.blocks > 0 { there.blocks.to_string() } else { format!("{RUNS} runs") };
        let cell = |value: &Option<f64>| value.map_or_else(|| "–".into(), |value| format!("{value:.0}"));
        let cells: Vec<String> = there.metrics.iter().map(cell).collect();
        let _ = writeln!(table, "| `{name}` | {blocks} | `{:016x}` | {} |", there.hash, cells.join(" | "));
    }
    (compared, table)
}

/// Returns the number of scenes with a controller: all except the contact studies.
fn with_a_controller() -> usize {
    builtin::all().iter().filter(|(name, _)| load(name, &[]).is_ok_and(|loaded| loaded.scene.driven().is_some())).count()
}

/// Runs every scene to its end on host and processor, and compares the instructions with the
/// documentation.
#[test]
fn every_scene_is_played_alike_and_the_docs_have_its_counts() {
    let Some(image) = image() else { return };
    let (compared, table) = compare(&image);
    assert_eq!(compared, with_a_controller());
    report::docs::block(
        "evidence/processor-in-the-loop.md",
        "cargo test -p image-scenarios processor_in_the_loop::scenes",
        &table,
    );
}
