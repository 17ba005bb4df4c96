//! The counts of this source, and the documentation.

use std::io::Write as _;
use std::path::Path;
use std::sync::LazyLock;

use super::{Measurement, conduct, table};

const MARK: &str = "<!-- tables: printed by `sim-host validate instructions` -->\n";

/// The measurement; `None` where QEMU is not installed.
static MEASUREMENT: LazyLock<Option<Measurement>> =
    LazyLock::new(|| pil::missing().is_none().then(|| conduct().expect("the image builds and counts")));

/// The measurement; where there can be none, says so.
fn measurement() -> Option<&'static Measurement> {
    if let Some(reason) = pil::missing() {
        // Straight to the stream: what a passing test prints by macro is never shown.
        let text = format!("\nSKIPPED, instruction counts: {reason}\n");
        std::io::stderr().write_all(text.as_bytes()).expect("standard error");
    }
    MEASUREMENT.as_ref()
}

#[test]
fn the_budget_holds() {
    let Some(measurement) = measurement() else { return };
    let missed: Vec<&str> = measurement.judged.iter().filter(|judged| !judged.holds()).map(|judged| judged.bound.name).collect();
    assert!(missed.is_empty(), "over budget: {missed:?}");
}

/// `UPDATE_DOCS=1 cargo test -p sonoglide-proof --lib instructions` writes the tables anew.
#[test]
fn the_documentation_has_these_counts() {
    let Some(measurement) = measurement() else { return };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/instructions.md");
    let text = std::fs::read_to_string(&path).expect("the page is there");
    let (head, tables) = text.split_once(MARK).expect("the page has its mark");
    let expected = format!("\n{}", table::markdown(measurement));
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, format!("{head}{MARK}{expected}")).expect("the page can be written");
    } else {
        assert!(tables == expected, "docs/instructions.md has other counts; run with UPDATE_DOCS=1");
    }
}
