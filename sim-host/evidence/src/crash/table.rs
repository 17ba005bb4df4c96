//! Tables of both studies of the plant.

use super::mass::Estimate;
use super::scheduled::Scheduled;
use plant::dring::motion::Extremes;
use report::TableBlock;

/// Formats a change in per cent; a change of zero has no unit.
fn percent(part: f64) -> String {
    if part == 0.0 { "0".into() } else { unsigned(&format!("{:+.1} %", 100.0 * part)) }
}

/// Formats a number without decimals.
fn whole(value: f64) -> String {
    format!("{value:.0}")
}

fn millimetres(metres: f64) -> String {
    format!("{:.0}", 1e3 * metres)
}

fn added(metres: f64) -> String {
    if metres == 0.0 { "0".into() } else { unsigned(&format!("{:+.1}", 1e3 * metres)) }
}

/// Removes the sign of a number that rounds to zero.
fn unsigned(text: &str) -> String {
    let digits = text.trim_start_matches(['+', '-']);
    if digits.starts_with("0.0") { digits.to_owned() } else { text.to_owned() }
}

/// Returns the table of the switching times and their results.
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
    let caption = "An ideal switch thrown by a clock, on the plant alone. If LOW begins after the peak, or returns to HIGH, the \
                   peak force is that of the passive belt and the excursion is larger.";
    let header = ["occupant", "LOW at [ms]", "HIGH again at [ms]", "peak [N]", "change", "excursion [mm]", "added [mm]"];
    TableBlock::new("timing", "When to switch", caption, &header, crashes.iter().map(row).collect())
}

/// Returns the table of the mass estimates.
pub(super) fn mass(estimates: &[Estimate]) -> TableBlock {
    let row = |known: &Estimate| {
        let what = known.at_ms.map_or_else(|| "the seat, before".into(), |ms| format!("the crash, up to {ms:.0} ms"));
        vec![what, format!("{:.2}", known.r2), format!("{:.1}", known.residual_kg)]
    };
    let caption = "R2 is the fraction of the variance of the mass that is explained. Without any estimate, the standard \
                   deviation of a mass drawn uniformly from 14 to 29 kg is 4.3 kg.";
    let header = ["mass estimated from", "R2", "residual deviation [kg]"];
    TableBlock::new("mass", "Can the mass be estimated from the crash?", caption, &header, estimates.iter().map(row).collect())
}
