//! The comparison of a case: each peer's time for each error, its ratio to our cheapest, and its
//! setting.

use report::TableBlock;

use crate::bench::{Entry, Quantity, Results};
use crate::choice::{self, TARGETS};

/// One peer's cell of the comparison.
pub struct Cell {
    /// Time for the error, ns a period.
    pub ns: Option<f64>,
    /// Ratio to our cheapest.
    pub ratio: Option<f64>,
    /// The setting that takes this time.
    pub setting: Option<String>,
    /// Error of this setting.
    pub error: Option<f64>,
    /// Least error of the peer.
    pub least_error: Option<f64>,
}

/// Computes a peer's cell for an error.
pub fn cell(results: &Results, entry: &Entry, quantity: Quantity, level: f64) -> Cell {
    let point = choice::cheapest(&entry.points, quantity, level);
    let ns = point.and_then(|point| point.ns());
    let ours = choice::ours(&results.entries, quantity, level);
    Cell {
        ns,
        ratio: ns.zip(ours).map(|(ns, ours)| ns / ours),
        setting: point.map(|point| format!("{}, {}", point.way.name, point.setting)),
        error: point.and_then(|point| Some(point.result.as_ref().ok()?.error(quantity))),
        least_error: choice::least_error(&entry.points, quantity),
    }
}

impl Cell {
    fn text(&self) -> String {
        match (self.ns, self.ratio) {
            (Some(ns), Some(ratio)) => format!("{} ({})", grouped(ns), two_digits(ratio)),
            (Some(ns), None) => format!("{} (ours: not met)", grouped(ns)),
            (None, _) => self.least_error.map_or("none".into(), |error| format!("no: {error:.0e}")),
        }
    }
}

fn heading((quantity, level): (Quantity, f64)) -> String {
    format!("{} {level:.0e}", quantity.name())
}

/// Returns the table of times, with the ratio to ours in brackets.
pub fn costs(results: &Results) -> TableBlock {
    let row = |entry: &Entry| {
        let cells = TARGETS.map(|(quantity, level)| cell(results, entry, quantity, level).text());
        std::iter::once(entry.name.clone()).chain(cells).collect()
    };
    let name = results.kind.name();
    TableBlock {
        id: format!("costs-{}", results.kind.stem()),
        title: format!("{name}: ns a period for an error, and ratio to ours"),
        caption:
            "The cheapest setting of each peer that meets the error of the mean friction ratio, or of the state at the end. \
                  no: not met, with its least error."
                .into(),
        header: std::iter::once("peer".into()).chain(TARGETS.map(heading)).collect(),
        rows: results.entries.iter().map(row).collect(),
    }
}

/// Returns the table of the settings that the times belong to.
pub fn settings(results: &Results) -> TableBlock {
    let rows = |entry: &Entry| {
        let row = |(quantity, level)| {
            let cell = cell(results, entry, quantity, level);
            Some(vec![entry.name.clone(), heading((quantity, level)), cell.setting?, format!("{:.1e}", cell.error?)])
        };
        TARGETS.into_iter().filter_map(row).collect::<Vec<_>>()
    };
    TableBlock {
        id: format!("settings-{}", results.kind.stem()),
        title: format!("{}: the settings", results.kind.name()),
        caption: "Tolerances are absolute and relative; ours: steps a period.".into(),
        header: ["peer", "error", "cheapest setting", "its error"].map(String::from).to_vec(),
        rows: results.entries.iter().flat_map(rows).collect(),
    }
}

/// Returns the failed runs, one line per peer.
pub fn failure_notes(results: &Results) -> Vec<String> {
    let of = |entry: &Entry| {
        let mut failures = entry.points.iter().filter_map(|point| Some((point, point.result.as_ref().err()?)));
        let count = failures.clone().count();
        let (point, why) = failures.next()?;
        let (name, all) = (&entry.name, entry.points.len());
        let case = results.kind.name();
        Some(format!("FAILED    {case}, {name}: {count} of {all} settings, first {}, {}: {why}", point.way.name, point.setting))
    };
    results.entries.iter().filter_map(of).collect()
}

fn two_digits(value: f64) -> String {
    let decimals = (1.0 - value.log10().floor()).clamp(0.0, 3.0) as usize;
    format!("{value:.decimals$}")
}

/// Formats a number with its digits in groups of three.
fn grouped(value: f64) -> String {
    let digits = format!("{value:.0}");
    let count = digits.len();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (count - index).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_show_time_ratio_and_least_error() {
        let cell = |ns, ratio| Cell { ns, ratio, setting: None, error: None, least_error: Some(3e-7) }.text();
        assert_eq!(cell(Some(12_345.0), Some(7.06)), "12 345 (7.1)");
        assert_eq!(cell(Some(500.0), Some(0.944)), "500 (0.94)");
        assert_eq!(cell(Some(500.0), Some(1234.0)), "500 (1234)");
        assert_eq!(cell(Some(500.0), None), "500 (ours: not met)");
        assert_eq!(cell(None, None), "no: 3e-7");
    }
}
