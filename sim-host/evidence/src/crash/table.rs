//! Both studies of the plant as tables.

use super::mass::Estimate;
use super::scheduled::Scheduled;
use plant::dring::motion::Extremes;
use report::TableBlock;

/// A change in per cent, or none.
fn percent(part: f64) -> String {
    if part == 0.0 { "0".into() } else { unsigned(&format!("{:+.1} %", 100.0 * part)) }
}

/// A number of newton; whole.
fn whole(value: f64) -> String {
    format!("{value:.0}")
}

fn millimetres(metres: f64) -> String {
    format!("{:.0}", 1e3 * metres)
}

fn added(metres: f64) -> String {
    if metres == 0.0 { "0".into() } else { unsigned(&format!("{:+.1}", 1e3 * metres)) }
}

/// What rounds to nothing has no sign.
fn unsigned(text: &str) -> String {
    let digits = text.trim_start_matches(['+', '-']);
    if digits.starts_with("0.0") { digits.to_owned() } else { text.to_owned() }
}

/// Table of the moments at which the switch is thrown, and the results.
pub(super) fn scheduled(crashes: &[Scheduled]) -> TableBlock {
    let row = |timed: &Scheduled| {
        let at = |ms: Option<f64>| ms.map_or_else(|| "never".into(), |ms| format!("{ms:.0}"));
        let Extremes { shoulder_n, excursion_m, .. } = timed.extremes;
        vec![
            timed.occupant.to_owned(),
            at(timed.low_ms),
            at(timed.high_ms),
            whole(shoulder_n),
            percent(shoulder_n / timed.passive.shoulder_n - 1.0),
            millimetres(excursion_m),
            added(excursion_m - timed.passive.excursion_m),
        ]
    };
    let caption = "An ideal switch thrown by a clock, on the plant alone. LOW that comes when the peak is over, or that goes back to HIGH, has the \
                   force of the passive belt and more way besides.";
    let header = ["occupant", "LOW at [ms]", "HIGH again at [ms]", "peak [N]", "change", "excursion [mm]", "added [mm]"];
    TableBlock::new("timing", "When to switch", caption, &header, crashes.iter().map(row).collect())
}

/// What the crash says of the mass.
pub(super) fn mass(estimates: &[Estimate]) -> TableBlock {
    let row = |known: &Estimate| {
        let what = known.at_ms.map_or_else(|| "the seat, before".into(), |ms| format!("the crash, up to {ms:.0} ms"));
        vec![what, format!("{:.2}", known.r2), format!("{:.1}", known.left_kg)]
    };
    let caption = "R2 is the part of the variance of the mass that is explained. Of a mass drawn evenly from 14 to 29 kg the deviation is 4.3 kg if nothing \
                   is known.";
    let header = ["the mass by", "R2", "deviation left [kg]"];
    TableBlock::new("mass", "Can the mass be estimated from the crash?", caption, &header, estimates.iter().map(row).collect())
}
