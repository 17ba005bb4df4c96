//! Every built-in scene: its expectations hold, and its golden table is unchanged.
//!
//! The tables contain rounded physical numbers, never raw traces, so that they are readable and
//! independent of the compiler. To accept new ones, run `INSTA_UPDATE=always cargo test` and review
//! the difference. The hash of all drive codes is exact, for one target.

use std::collections::BTreeSet;

use report::significant;
use scene::builtin;
use scene::load::{Loaded, load};
use scene::metrics;
use sim::data::FigureData;
use sim::figures;
use sim::study::comparison::Standing;
use sim::study::{self, Options, Study};
use sim::tables;

/// Metrics that consist only of round-off.
const NOT_GOLDEN: [&str; 2] = ["energy_residual", "error_estimate"];

/// Metrics that no built-in scene has by default: those of an emulator, of the flashed image, of a
/// damper, of an actuator with a law, of a step under another scan, and of a tolerance of the whole
/// record.
const NOT_IN_SCENES: [&str; 17] = [
    "instructions_total",
    "mean_block_instructions",
    "worst_block_instructions",
    "mean_block_cycles",
    "mean_block_load_percent",
    "worst_block_load_percent",
    "background_share_percent",
    "flash_fetches_percent",
    "longest_masked_cycles",
    "worst_block_cycles",
    "stack_power_up_bytes",
    "stack_blocks_bytes",
    "image_flash_bytes",
    "image_ram_bytes",
    "damper_ratio",
    "actuator_power_w",
    "record_error_estimate",
];
/// Prefix of the metrics of the user's own curves over a figure.
const OVERLAY: &str = "overlay_";

/// Number of golden runs of a scene with many runs.
const GOLDEN_RUNS: u32 = 8;

fn loaded(name: &str, sets: &[String]) -> Loaded {
    load(name, sets).unwrap_or_else(|error| panic!("{error}"))
}

fn study(loaded: &Loaded) -> Study<'_> {
    study::run(loaded, Options::default()).unwrap()
}

/// Formats three significant digits, or half a hertz of a frequency: a change of physics is
/// visible, a change of rounding is not.
fn rounded(value: f64) -> String {
    if value.abs() > 1e4 { format!("{:.0}", value) } else { format!("{value:.2e}") }
}

/// Formats a small value with three digits after the point, others with one.
fn in_a_grid(value: f64) -> String {
    if value.abs() < 2.0 { format!("{value:.3}") } else { format!("{value:.1}") }
}

/// Returns the metric of one run on which a statistic is based.
fn of_one(name: &'static str) -> &'static str {
    metrics::of_one_run(name).map_or(name, |metric| metric.name)
}

/// Checks that docs/metrics-and-files.md lists each figure of a study with its columns.
fn every_figure_is_described(study: &Study) {
    for figure in figures::of(study) {
        let data = FigureData::of(&figure.id).unwrap_or_else(|| panic!("{}: no data of `{}`", study.name, figure.id));
        // A contact study has its time in periods, a grid its keys, a distribution its metric.
        assert!(
            data.x == figure.x.label || ["friction", "grid-*", "distribution"].contains(&data.id),
            "{}: {} is over {}",
            study.name,
            figure.id,
            figure.x.label
        );
        for series in &figure.series {
            assert!(data.has(&series.csv_column), "{}: {} has {}", study.name, figure.id, series.csv_column);
        }
    }
}

fn golden(study: &Study) -> String {
    let golden = study.metrics.iter().filter(|(name, _)| !NOT_GOLDEN.contains(&of_one(name)));
    let mut table: String = golden.map(|(name, value)| format!("{name:28} {}\n", rounded(value))).collect();
    if let Some(result) = &study.grid {
        let across = result.grid.over.last().map_or(1, |over| over.values.len());
        for (name, metric) in result.metrics.iter().zip(&result.rows.metrics) {
            table += &format!("\n{name}\n");
            for (row, cells) in result.rows.keys[0].chunks(across).zip(metric.chunks(across)) {
                let cells: String = cells.iter().map(|cell| format!("{:>10}", cell.map_or("-".into(), in_a_grid))).collect();
                table += &format!("{:>6}{cells}\n", row[0]);
            }
        }
    }
    if let Some(result) = &study.comparison {
        let metrics = &result.comparison.metrics;
        for matched in &result.matches {
            table += &format!("\nequal {}: amplitude, {}\n", matched.equal.name(), metrics.join(", "));
            for case in &matched.cases {
                let amplitude = match case.standing {
                    Standing::Equal { .. } => format!("{:.2e}", case.amplitude),
                    Standing::Beyond { needs } => format!("{needs:.2e} needed"),
                    Standing::Unmeasured { .. } => "unmeasured".into(),
                };
                let cells: String =
                    metrics.iter().map(|name| format!("{:>10}", case.metric(name).map_or("-".into(), rounded))).collect();
                table += &format!("{:36}{amplitude:>15}{cells}\n", case.name);
            }
        }
    }
    table
}

/// Rows of the flagship's table in README.
const README_ROWS: [&str; 4] = ["series resonance [Hz]", "Q", "Rm [ohm]", "tip velocity, steady [m/s]"];

/// Rounds the estimate and its standard deviation of a row to two digits of the deviation.
fn rounded_to_deviation(row: &[String]) -> Vec<String> {
    let number = |cell: &String| cell.parse::<f64>().ok();
    let digits = number(&row[3]).map(|deviation| (1 - deviation.log10().floor() as i32).max(0) as usize);
    let rounded = |cell: &String| match (number(cell), digits) {
        (Some(value), Some(digits)) => format!("{value:.digits$}"),
        (Some(value), None) => significant(value),
        (None, _) => cell.clone(),
    };
    row.iter().enumerate().map(|(column, cell)| if (2..4).contains(&column) { rounded(cell) } else { cell.clone() }).collect()
}

/// Compares README's table with the output of the flagship.
fn check_readme(study: &Study) {
    let table = tables::tables(study).into_iter().find(|table| table.id == "three-ways").expect("the table");
    let row = |name: &&str| rounded_to_deviation(table.rows.iter().find(|row| row[0] == *name).expect("a row"));
    let rows = std::iter::once(&table.header).cloned().chain(README_ROWS.iter().map(row));
    let mut lines: Vec<String> = rows.map(|cells| format!("| {} |", cells.join(" | "))).collect();
    lines.insert(1, "|---|---|---|---|---|".into());
    report::docs::block("../README.md", "sim-host run experiment-1", &lines.join("\n"));
}

#[test]
fn every_built_in_scene_meets_its_expectations_golden_table_and_docs() {
    let mut hashes = String::new();
    let mut measured = BTreeSet::new();
    for (name, _) in builtin::all() {
        let runs = loaded(name, &[]).scene.runs.min(GOLDEN_RUNS);
        let sets = if runs > 1 { vec![format!("runs={runs}")] } else { Vec::new() };
        let loaded = loaded(name, &sets);
        let study = study(&loaded);
        let missed: Vec<_> = study.judged.iter().filter(|judged| !judged.pass).collect();
        assert!(missed.is_empty(), "{name}: {missed:#?}");
        assert!(!study.judged.is_empty(), "{name} has no expectations");
        insta::assert_snapshot!(*name, golden(&study));
        measured.extend(study.metrics.iter().map(|(name, _)| of_one(name)));
        every_figure_is_described(&study);
        if *name == "experiment-1" {
            check_readme(&study);
        }
        let hash = study.run().map(|run| run.record.drive_hash);
        if let Some(hash) = hash.or_else(|| study.monte_carlo()?.drive_hash()) {
            hashes += &format!("{name:28} {hash:016x}\n");
        }
    }
    let elsewhere = |name: &str| NOT_IN_SCENES.contains(&name) || name.starts_with(OVERLAY);
    let nowhere: Vec<_> = metrics::names().filter(|name| !measured.contains(name) && !elsewhere(name)).collect();
    assert!(nowhere.is_empty(), "no scene has {nowhere:?}");
    if cfg!(all(target_arch = "x86_64", target_os = "linux")) {
        insta::assert_snapshot!("drive-hashes-x86_64-linux", hashes);
    }
}

#[test]
fn the_same_seed_gives_the_same_run_and_another_seed_another() {
    let hash = |seed: &str| {
        let loaded = loaded("lock", &[format!("seed={seed}")]);
        study(&loaded).run().unwrap().record.drive_hash
    };
    assert_eq!(hash("3"), hash("3"));
    assert_ne!(hash("3"), hash("4"));
}

/// A defect while the drive is ON causes its fault, and the drive is silent within the stated time.
/// This is the block that shows the defect (32 us), two queued blocks (64 us), and the blocks that
/// the guard needs for its decision.
#[test]
fn defects_cause_their_fault_and_mute_the_drive() {
    for (scene, kind, code, microseconds) in [
        ("lock", "late_block", 11, 96.0),
        ("lock", "saturation", 28, 96.0),
        ("lock", "sensor_stuck", 20, 96.0 + 7.0 * 32.0),
        ("lock", "open", 23, 96.0 + 7.0 * 32.0),
        ("belt-stop", "belt_stopped", 40, 96.0 + 2400.0),
        ("lock", "overtemperature", 44, 96.0),
    ] {
        let sets = [format!("fault.0.kind={kind}"), "fault.0.at_s=0.2".into()];
        let loaded = loaded(scene, &sets);
        let study = study(&loaded);
        assert_eq!(study.metrics.get("fault_code"), Some(f64::from(code)), "{kind}");
        let latency = study.metrics.get("fault_latency_us").unwrap();
        assert!(latency <= microseconds + 0.5, "{kind}: {latency} us");
    }
}
