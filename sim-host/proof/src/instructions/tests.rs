//! The counts of this source, and the documentation.

use std::io::Write as _;
use std::path::Path;
use std::sync::LazyLock;

use super::{Measurement, conduct, plot, table};

const MARK: &str = "<!-- tables: printed by `sim-host instructions` -->\n";

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

/// `UPDATE_DOCS=1 cargo test -p sonoglide-proof --lib instructions` writes the tables and the plot anew.
#[test]
fn the_documentation_has_these_counts() {
    let Some(measurement) = measurement() else { return };
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    let path = docs.join("instructions.md");
    let text = std::fs::read_to_string(&path).expect("the page is there");
    let (head, tables) = text.split_once(MARK).expect("the page has its mark");
    let expected = format!("\n{}", table::markdown(measurement));
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, format!("{head}{MARK}{expected}")).expect("the page can be written");
        draw(measurement, &docs);
    } else {
        assert!(tables == expected, "docs/instructions.md has other counts; run with UPDATE_DOCS=1");
    }
}

/// Draws the plot into a folder of its own, and takes the picture from there.
fn draw(measurement: &Measurement, docs: &Path) {
    let folder = std::env::temp_dir().join(format!("instructions-{}", std::process::id()));
    let page = report::Report { figures: vec![plot::figure(measurement)], ..report::Report::default() };
    report::write(&page, &folder).expect("a folder for the plot");
    std::fs::copy(folder.join("instructions.png"), docs.join("instructions.png")).expect("the plot can be written");
    std::fs::remove_dir_all(&folder).expect("the folder goes");
}
