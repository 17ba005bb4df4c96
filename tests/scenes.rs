//! Every built-in scene: its expectations hold, and its golden table is what it was.
//!
//! The tables hold rounded physical numbers, never a raw trace, so that they read as results and survive a compiler. To accept new
//! ones: `INSTA_UPDATE=always cargo test`, and read the difference.

use std::sync::atomic::AtomicBool;

use sim_host::processor::Here;
use sim_host::scene::builtin;
use sim_host::scene::load::load;
use sim_host::settings;
use sim_host::study::{Study, conduct};

/// What depends on the machine, and what is round-off only.
const NOT_GOLDEN: [&str; 2] = ["simulated_s_per_wall_s", "energy_residual"];

fn study(name: &str) -> Study {
    let loaded = load(name, &[]).unwrap_or_else(|error| panic!("{error}"));
    let mut here = Here::new(&settings::config(&loaded.scene)).unwrap();
    conduct(&loaded, &mut here, &AtomicBool::new(false), None).unwrap()
}

/// Three significant digits: what a change of physics moves, and a change of rounding does not.
fn rounded(value: f64) -> String {
    format!("{value:.2e}")
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
    for (name, _) in builtin::all() {
        let study = study(name);
        let missed: Vec<_> = study.judged.iter().filter(|judged| !judged.pass).collect();
        assert!(missed.is_empty(), "{name}: {missed:#?}");
        assert!(!study.judged.is_empty(), "{name} expects nothing");
        insta::assert_snapshot!(*name, golden(&study));
    }
}

#[test]
fn the_same_seed_gives_the_same_run_and_another_seed_another() {
    let hash = |seed: &str| {
        let loaded = load("lock", &[format!("seed={seed}")]).unwrap();
        let mut here = Here::new(&settings::config(&loaded.scene)).unwrap();
        conduct(&loaded, &mut here, &AtomicBool::new(false), None).unwrap().record.drive_hash
    };
    assert_eq!(hash("3"), hash("3"));
    assert_ne!(hash("3"), hash("4"));
}
