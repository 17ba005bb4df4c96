//! Every built-in scene that has a controller, host against thumb code: the hash of every code played, and the last report.
//!
//! The ordinary test runs each for a while; the other one to its end, and prints the table of docs/processor-in-the-loop.md:
//!
//!     cargo test -p scenarios processor_in_the_loop::scenes -- --ignored --nocapture

use std::fmt::Write as _;
use std::path::Path;

use firmware::seam::config::Config;
use pil::Qemu;
use scene::builtin;
use scene::load::load;
use sim::processor::Processor;
use sim::study::monte_carlo::MonteCarlo;
use sim::study::{self, Options, Outcome, Start};

use super::{bits, image};

/// Of a scene with many runs, so many are run.
const RUNS: u32 = 2;
/// The same to their end.
const MORE_RUNS: u32 = 8;

/// What makes a scene short: a power-up, and most of a run. What a scene does not have keeps its length.
fn shortened(name: &str) -> &'static [&'static str] {
    const BURST: &[&str] = &["duration_s=0.16", "controller.burst.on_s=[0.12]", "controller.burst.off_s=[0.15]"];
    match name {
        "lock-step" => &["duration_s=0.12", "disturbance.0.at_s=0.08", "disturbance.1.at_s=0.08"],
        "lock-drift" => &["duration_s=0.12", "disturbance.0.at_s=0.07", "disturbance.1.at_s=0.09"],
        "belt-stop-slow" => &["duration_s=0.12", "disturbance.0.at_s=0.09"],
        _ if name.starts_with("belt-stop") => &["duration_s=0.12", "fault.0.at_s=0.09"],
        _ if name.starts_with("friction-") => &["duration_s=0.12"],
        _ if name.starts_with("transducer-") => &["duration_s=0.1"],
        _ if ["experiment-", "waveforms", "usm"].iter().any(|start| name.starts_with(start)) => BURST,
        _ => &[],
    }
}

/// What is compared of a scene, and told of it.
struct Played {
    hash: u64,
    /// The last report of a single run, bit for bit; the metrics of several.
    end: Vec<u8>,
    blocks: u64,
    metrics: Vec<Option<f64>>,
}

const TOLD: [&str; 3] = ["mean_block_instructions", "worst_block_instructions", "stack_blocks_bytes"];

/// Runs a scene, here or on an image; nothing if it has no controller.
fn played(name: &str, sets: &[&str], runs: u32, image: Option<&Path>) -> Option<Played> {
    let mut sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    let mut loaded = load(name, &sets).unwrap_or_else(|error| panic!("{error}"));
    loaded.scene.driven()?;
    if loaded.scene.runs > 1 {
        sets.push(format!("runs={runs}"));
        loaded = load(name, &sets).unwrap_or_else(|error| panic!("{error}"));
    }
    // What stands beside the scene's own runs is run on the host in either case.
    (loaded.scene.grid, loaded.scene.comparison) = (None, None);
    let start = image.map(|image| move |config: &Config| Ok(Box::new(Qemu::start(image, config)?) as Box<dyn Processor>));
    let start = start.as_ref().map(|start| start as Start);
    let study = study::run(&loaded, Options { start, ..Options::default() }).unwrap_or_else(|error| panic!("{name}: {error}"));
    let metrics = TOLD.iter().map(|metric| study.metrics.get(metric)).collect();
    Some(match &study.outcome {
        Outcome::Driven(run) => {
            Played { hash: run.record.drive_hash, end: bits(&run.record.last), blocks: run.record.rows.len() as u64, metrics }
        }
        Outcome::MonteCarlo(runs) => Played { hash: runs.drive_hash()?, end: ends(runs), blocks: 0, metrics },
        Outcome::Contact(_) => return None,
    })
}

/// What the runs of a campaign came to, but for what a processor of its own adds.
fn ends(runs: &MonteCarlo) -> Vec<u8> {
    let common = |name: &&str| !["instructions", "stack_", "image_"].iter().any(|part| name.contains(part));
    let metrics = runs.runs.iter().flat_map(|run| run.metrics.iter().filter(|(name, _)| common(name)));
    metrics.flat_map(|(_, value)| value.to_le_bytes()).collect()
}

const HEADER: &str =
    "| scene | blocks | hash, host and QEMU | instructions, mean | worst block | stack [bytes] |\n|---|---|---|---|---|---|\n";

/// Compares the scenes, and makes a table of them.
fn compare(image: &Path, sets: impl Fn(&str) -> &'static [&'static str], runs: u32) -> (usize, String) {
    let (mut compared, mut table) = (0, HEADER.to_owned());
    for (name, _) in builtin::all() {
        let Some(here) = played(name, sets(name), runs, None) else { continue };
        let there = played(name, sets(name), runs, Some(image)).expect("the same scene");
        assert_eq!(here.hash, there.hash, "{name}: hashes of all drive codes played");
        assert!(here.end == there.end, "{name}: played alike, reported otherwise");
        compared += 1;
        let blocks = if there.blocks > 0 { there.blocks.to_string() } else { format!("{runs} runs") };
        let cell = |value: &Option<f64>| value.map_or_else(|| "–".into(), |value| format!("{value:.0}"));
        let cells: Vec<String> = there.metrics.iter().map(cell).collect();
        let _ = writeln!(table, "| `{name}` | {blocks} | `{:016x}` | {} |", there.hash, cells.join(" | "));
    }
    (compared, table)
}

/// The scenes with a controller: all but the contact studies.
fn with_a_controller() -> usize {
    builtin::all().iter().filter(|(name, _)| load(name, &[]).is_ok_and(|loaded| loaded.scene.driven().is_some())).count()
}

#[test]
fn every_scene_is_played_alike_for_a_while() {
    let Some(image) = image() else { return };
    let (compared, table) = compare(&image, shortened, RUNS);
    println!("{table}");
    assert_eq!(compared, with_a_controller());
}

#[test]
#[ignore = "minutes: every scene to its end"]
fn every_scene_is_played_alike_to_its_end() {
    let Some(image) = image() else { return };
    let (compared, table) = compare(&image, |_| &[], MORE_RUNS);
    println!("{table}");
    assert_eq!(compared, with_a_controller());
}
