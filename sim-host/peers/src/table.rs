//! The comparison: at the same error, every peer's cost over the cheapest of ours.

use report::TableBlock;

use crate::bench::{Entry, Quantity};
use crate::interpolate::{Cost, cost};
use crate::peer::Family;

/// Errors at which peers are compared.
pub const TARGETS: [(Quantity, f64); 5] =
    [(Quantity::Mean, 1e-4), (Quantity::Mean, 1e-6), (Quantity::Mean, 1e-8), (Quantity::Force, 1e-6), (Quantity::Force, 1e-8)];

/// A peer whose mean is never this good is of no use: the coarsest target.
const USELESS: f64 = 1e-4;

/// One peer's cell of the comparison.
pub struct Cell {
    /// What the error costs.
    pub cost: Option<Cost>,
    /// The cheapest of ours.
    pub ours: Option<Cost>,
}

impl Cell {
    /// Cost of the peer over that of our method.
    pub fn ratio(&self) -> Option<f64> {
        Some(self.cost?.value()? / self.ours?.value()?)
    }

    /// How the ratio is to be read: exactly, or as a bound.
    pub fn bound(&self) -> &'static str {
        match (self.cost, self.ours) {
            (Some(Cost::AtMost(_)), Some(Cost::AtMost(_))) => "~",
            (Some(Cost::AtMost(_)), _) => "<=",
            (_, Some(Cost::AtMost(_))) => ">=",
            _ => "",
        }
    }

    fn ratio_text(&self) -> String {
        match (self.ratio(), self.cost) {
            (Some(ratio), _) => format!("{} {}", self.bound(), three_digits(ratio)).trim().to_string(),
            (None, Some(Cost::NotReached(best))) => format!("best: {:.0e}", best.error),
            (None, Some(_)) => "ours: not reached".into(),
            (None, None) => "unusable".into(),
        }
    }

    fn cost_text(&self) -> String {
        match self.cost {
            Some(Cost::At(ns)) => three_digits(1e-3 * ns),
            Some(Cost::AtMost(ns)) => format!("<= {}", three_digits(1e-3 * ns)),
            Some(Cost::NotReached(best)) => format!("best: {:.0e} at {}", best.error, three_digits(1e-3 * best.cost)),
            None => "unusable".into(),
        }
    }
}

/// A peer's cells, in the order of the targets.
pub fn cells(entries: &[Entry], entry: &Entry) -> Vec<Cell> {
    let of = |entry: &Entry, (quantity, target)| if usable(entry) { cost(&entry.curve(quantity), target) } else { None };
    let ours = |target| {
        let all = entries.iter().filter(|entry| entry.family == Family::Ours).filter_map(|entry| of(entry, target));
        let number = |cost: &Cost| cost.value().unwrap_or(f64::INFINITY);
        all.min_by(|a, b| number(a).total_cmp(&number(b)))
    };
    TARGETS.iter().map(|&target| Cell { cost: of(entry, target), ours: ours(target) }).collect()
}

/// Whether a peer has a point that is of any use.
pub fn usable(entry: &Entry) -> bool {
    entry.curve(Quantity::Mean).iter().any(|point| point.error < USELESS)
}

/// Table of costs over those of our method.
pub fn ratios(entries: &[Entry]) -> TableBlock {
    let caption = "Cost at the same error, over the cheapest of ours at that error: interpolated on each peer's own work-precision curve, \
                   never beyond it. >= and <=: one side is better than asked at its coarsest already; ~: both are. best: the error is \
                   not reached, this is the least.";
    table("ratios", "Cost over ours, at the same error", caption, entries, Cell::ratio_text)
}

/// Table of the costs themselves.
pub fn costs(entries: &[Entry]) -> TableBlock {
    let caption = "Wall time, us a period, on this machine in this run: good for ratios only.";
    table("costs", "Cost at the same error, us a period", caption, entries, Cell::cost_text)
}

fn table(id: &str, title: &str, caption: &str, entries: &[Entry], text: fn(&Cell) -> String) -> TableBlock {
    let heading = |(quantity, target): (Quantity, f64)| match quantity {
        Quantity::Mean => format!("mean {target:.0e}"),
        Quantity::Force => format!("F(t) {target:.0e}"),
    };
    let row = |entry: &Entry| {
        let cells = cells(entries, entry);
        std::iter::once(entry.name.clone()).chain(cells.iter().map(text)).collect()
    };
    TableBlock {
        id: id.into(),
        title: title.into(),
        caption: caption.into(),
        header: std::iter::once("peer".into()).chain(TARGETS.into_iter().map(heading)).collect(),
        rows: entries.iter().map(row).collect(),
    }
}

/// Peers that are of no use, and runs that gave nothing, one a line.
pub fn troubles(entries: &[Entry]) -> Vec<String> {
    let of = |entry: &Entry| {
        let mut failures = entry.failures();
        let count = entry.failures().count();
        let first =
            failures.next().map(|(setting, why)| format!("{count} of {} runs failed, at {setting}: {why}", entry.points.len()));
        if usable(entry) {
            return first.map(|failure| format!("FAILED    {}: {failure}", entry.name));
        }
        let best = entry.curve(Quantity::Mean).iter().map(|point| point.error).reduce(f64::min);
        let best = best.map(|error| format!("least error of the mean {error:.0e}"));
        let what: Vec<String> = best.into_iter().chain(first).collect();
        Some(format!("UNUSABLE  {}: {}", entry.name, what.join("; ")))
    };
    entries.iter().filter_map(of).collect()
}

fn three_digits(value: f64) -> String {
    let decimals = (2.0 - value.log10().floor()).clamp(0.0, 3.0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_say_what_they_are() {
        let cell = |cost, ours| Cell { cost: Some(cost), ours: Some(ours) }.ratio_text();
        assert_eq!(cell(Cost::At(20.0), Cost::At(10.0)), "2.00");
        assert_eq!(cell(Cost::AtMost(20.0), Cost::At(10.0)), "<= 2.00");
        assert_eq!(cell(Cost::At(12345.0), Cost::AtMost(10.0)), ">= 1234");
        assert_eq!(cell(Cost::AtMost(5.0), Cost::AtMost(10.0)), "~ 0.500");
        let best = crate::interpolate::Measured { error: 3e-7, cost: 1.0 };
        assert_eq!(cell(Cost::NotReached(best), Cost::At(10.0)), "best: 3e-7");
        assert_eq!(cell(Cost::At(1.0), Cost::NotReached(best)), "ours: not reached");
    }
}
