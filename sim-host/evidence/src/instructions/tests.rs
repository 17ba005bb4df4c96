//! Tests that the counted instructions stay within the budget.

use std::io::Write as _;
use std::sync::LazyLock;

use super::{Measurement, measure};

/// The measurement; `None` if QEMU is not installed.
static MEASUREMENT: LazyLock<Option<Measurement>> =
    LazyLock::new(|| pil::missing().is_none().then(|| measure().expect("the image builds and counts")));

/// Returns the measurement; reports on standard error why there is none.
fn measurement() -> Option<&'static Measurement> {
    if let Some(reason) = pil::missing() {
        // Straight to the stream: the output of macros is hidden if the test passes.
        let text = format!("\nSKIPPED, instruction counts: {reason}\n");
        std::io::stderr().write_all(text.as_bytes()).expect("standard error");
    }
    MEASUREMENT.as_ref()
}

#[test]
fn the_budget_holds() {
    let Some(measurement) = measurement() else { return };
    let missed: Vec<&str> =
        measurement.judged.iter().filter(|judged| !judged.holds()).map(|judged| judged.bound.name.as_str()).collect();
    assert!(missed.is_empty(), "over budget: {missed:?}");
}
