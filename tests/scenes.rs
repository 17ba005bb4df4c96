//! Every built-in scene: its expectations hold, and its golden table is what it was.
//!
//! The tables hold rounded physical numbers, never a raw trace, so that they read as results and survive a compiler. To accept new
//! ones: `INSTA_UPDATE=always cargo test`, and read the difference. The hash of all drive codes is exact, and of one target.

use std::sync::atomic::AtomicBool;

use sim_host::processor::Here;
use sim_host::scene::builtin;
use sim_host::scene::load::load;
use sim_host::settings;
use sim_host::study::{Level, Study, conduct};

/// What depends on the machine, and what is round-off only.
const NOT_GOLDEN: [&str; 2] = ["simulated_s_per_wall_s", "energy_residual"];

fn study(name: &str) -> Study {
    let loaded = load(name, &[]).unwrap_or_else(|error| panic!("{error}"));
    let mut here = Here::new(&settings::config(&loaded.scene)).unwrap();
    conduct(&loaded, (Level::Sil, &mut here), &AtomicBool::new(false), None).unwrap()
}

/// Three significant digits, or half a hertz of a frequency: what a change of physics moves, and a change of rounding does not.
fn rounded(value: f64) -> String {
    if value.abs() > 1e4 { format!("{:.0}", value) } else { format!("{value:.2e}") }
}

fn golden(study: &Study) -> String {
    let metrics = study.metrics.iter().filter(|(name, _)| !NOT_GOLDEN.contains(name));
    let mut table: String = metrics.map(|(name, value)| format!("{name:28} {}\n", rounded(value))).collect();
    if let Some(result) = &study.grid {
        table += &format!("\n{}\n", result.grid.metric);
        for (row, cells) in result.grid.rows.iter().zip(&result.cells) {
            let cells: String =
                cells.iter().map(|cell| format!("{:>10}", cell.map_or("-".into(), |x| format!("{x:.1}")))).collect();
            table += &format!("{row:>6}{cells}\n");
        }
    }
    table
}

#[test]
fn every_built_in_scene_meets_its_expectations_and_its_golden_table() {
    let mut hashes = String::new();
    for (name, _) in builtin::all() {
        let study = study(name);
        let missed: Vec<_> = study.judged.iter().filter(|judged| !judged.pass).collect();
        assert!(missed.is_empty(), "{name}: {missed:#?}");
        assert!(!study.judged.is_empty(), "{name} expects nothing");
        insta::assert_snapshot!(*name, golden(&study));
        hashes += &format!("{name:28} {:016x}\n", study.record.drive_hash);
    }
    if cfg!(all(target_arch = "x86_64", target_os = "linux")) {
        insta::assert_snapshot!("drive-hashes-x86_64-linux", hashes);
    }
}

#[test]
fn the_same_seed_gives_the_same_run_and_another_seed_another() {
    let hash = |seed: &str| {
        let loaded = load("lock", &[format!("seed={seed}")]).unwrap();
        let mut here = Here::new(&settings::config(&loaded.scene)).unwrap();
        conduct(&loaded, (Level::Sil, &mut here), &AtomicBool::new(false), None).unwrap().record.drive_hash
    };
    assert_eq!(hash("3"), hash("3"));
    assert_ne!(hash("3"), hash("4"));
}

/// What breaks while the drive is ON is named by its number, and the drive is silent within the time stated: the block that shows it
/// (32 us), two blocks on their way (64 us), and as many more as the guard takes to be sure.
#[test]
fn what_breaks_is_named_and_mutes_the_drive() {
    for (kind, code, microseconds) in [
        ("late_block", 11, 96.0),
        ("saturation", 20, 96.0),
        ("sensor_stuck", 20, 96.0 + 7.0 * 32.0),
        ("open", 23, 96.0 + 7.0 * 32.0),
        ("belt_stopped", 40, 96.0 + 4000.0),
    ] {
        let sets = [format!("fault.0.kind={kind}"), "fault.0.at_s=0.2".into()];
        let loaded = load("lock", &sets).unwrap_or_else(|error| panic!("{error}"));
        let mut here = Here::new(&settings::config(&loaded.scene)).unwrap();
        let study = conduct(&loaded, (Level::Sil, &mut here), &AtomicBool::new(false), None).unwrap();
        assert_eq!(study.metrics.get("fault_code"), Some(f64::from(code)), "{kind}");
        let latency = study.metrics.get("fault_latency_us").unwrap();
        assert!(latency <= microseconds + 0.5, "{kind}: {latency} us");
    }
}
