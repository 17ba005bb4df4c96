//! The blocks of the documentation that `sim-host validate` writes are what it prints. `UPDATE_DOCS=1 cargo test docs` writes them anew.

use crate::{crash, friction, guard, instructions, thesis, tracking};
use report::docs::{block, is_update, path};
use report::{Report, markdown};

#[test]
fn tracking_has_these_numbers() {
    let campaign = tracking::conduct(tracking::Extent::FULL, &mut |_| ()).unwrap();
    block("tracking.md", "sim-host validate tracking", &tracking::table::markdown(&campaign));
}

#[test]
fn friction_has_these_numbers() {
    let campaign = friction::conduct(friction::cases::all()).unwrap();
    block("friction.md", "sim-host validate friction", &friction::table::markdown(&campaign));
    if is_update() {
        let folder = std::env::temp_dir().join(format!("friction-{}", std::process::id()));
        report::write(&Report { figures: vec![friction::plot::figure(&campaign)], ..Report::default() }, &folder).unwrap();
        std::fs::copy(folder.join("friction-switch.png"), path("friction-switch.png")).unwrap();
    }
}

#[test]
fn crash_has_these_numbers() {
    let campaign = crash::conduct(crash::Extent::FULL, &mut |_| ()).unwrap();
    block("crash.md", "sim-host validate crash", &crash::table::markdown(&campaign));
}

#[test]
fn guard_has_these_numbers() {
    let campaign = guard::conduct(guard::Extent::FULL, &mut |_| ()).unwrap();
    assert!(campaign.holds());
    block("guard.md", "sim-host validate guard", &guard::table::markdown(&campaign));
}

#[test]
fn instructions_has_these_counts() {
    let Some(measurement) = instructions::tests::measurement() else { return };
    block("instructions.md", "sim-host validate instructions", &instructions::table::markdown(measurement));
}

#[test]
fn thesis_has_these_numbers() {
    block("thesis-errata.md", "sim-host validate thesis", &markdown(&thesis::table::in_short(&thesis::tests::FINDINGS)));
    block("experiment-2.md", "sim-host validate thesis", &markdown(&thesis::experiment_2_tables()));
}
