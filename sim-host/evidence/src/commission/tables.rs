//! The results as tables, and each transducer as a line of numbers.

use std::collections::BTreeMap;

use sim::numbers::number;
use sim::study::monte_carlo::statistics::spread_of;

use super::Tried;
use crate::evidence::Error;
use crate::transducers::draw::KINDS;
use report::TableBlock;

const OUTCOMES: &str = "Right: the proposed resonance and the lock of the test are within 1 Hz, or 0.5 % of the bandwidth if that is more, of the true series \
     resonance of the strongest mode. In time: right, within 3 s of the board's time, and 50 ring-down times more above Q 500. Refused: no settings are proposed, \
     and the reason is named. Silent: settings are proposed that are wrong. Time: median and 95 % of the board's time of all. Volts, amperes: largest peak of all, as a \
     part of the bound given.";
const HEADER: [&str; 10] =
    ["kind", "transducers", "right", "in time", "refused", "silent", "time [s]", "error [Hz]", "volts", "amperes"];
/// Beginnings of refusals, in short.
const REASONS: [(&str, &str); 7] = [
    ("two resonances are alike", "two resonances are alike"),
    ("a resonance was identified", "a resonance for which no settings pass the test"),
    ("a capacitor", "a capacitor"),
    ("a resistor", "a resistor"),
    ("no resonance", "no resonance in the band"),
    ("no transducer", "no transducer"),
    ("a short", "a short"),
];

/// All tables.
pub(super) fn tables(set: &[Tried]) -> Vec<TableBlock> {
    let of_kind = |name: &'static str| set.iter().filter(move |tried| tried.transducer.kind.name == name).collect::<Vec<_>>();
    let rows = KINDS.iter().map(|kind| row(kind.name, &of_kind(kind.name)));
    let rows = rows.chain([row("all", &set.iter().collect::<Vec<_>>())]).collect();
    let outcomes = TableBlock::new("kinds", "Commissioned from a band alone, by kind", OUTCOMES, &HEADER, rows);
    let mut reasons: BTreeMap<String, usize> = BTreeMap::new();
    for refused in set.iter().filter_map(|tried| tried.judged.found.as_ref().err()) {
        *reasons.entry(reason(refused)).or_default() += 1;
    }
    if reasons.is_empty() {
        return vec![outcomes];
    }
    let rows = reasons.into_iter().map(|(reason, count)| vec![reason, count.to_string()]).collect();
    vec![outcomes, TableBlock::new("refusals", "Refusals, by reason", "", &["reason", "transducers"], rows)]
}

/// The reason of a refusal, without its numbers.
fn reason(refused: &str) -> String {
    let known = REASONS.iter().find(|(beginning, _)| refused.starts_with(beginning));
    if refused.contains("it is not alone") {
        return "a resonance that is not alone".into();
    }
    known.map_or_else(|| refused.to_owned(), |(_, name)| (*name).to_owned())
}

fn row(name: &str, tried: &[&Tried]) -> Vec<String> {
    let count = |is: &dyn Fn(&Tried) -> bool| tried.iter().filter(|tried| is(tried)).count().to_string();
    let both = |values: Vec<f64>| {
        let spread = spread_of(values);
        format!("{}, {}", digits(spread.median), digits(spread.p95))
    };
    let most = |of: fn(&Tried) -> f64| format!("{:.3}", tried.iter().map(|tried| of(tried)).fold(0.0, f64::max));
    let errors = tried.iter().filter_map(|tried| tried.judged.found.as_ref().ok()).map(|found| found.error_hz.abs());
    vec![
        name.to_owned(),
        tried.len().to_string(),
        count(&|tried| tried.judged.is_right()),
        count(&|tried| tried.judged.is_right() && tried.judged.is_in_time()),
        count(&|tried| tried.judged.found.is_err()),
        count(&|tried| tried.judged.is_silent()),
        both(tried.iter().map(|tried| tried.judged.board_s).collect()),
        both(errors.collect()),
        most(|tried| tried.judged.loudest_v),
        most(|tried| tried.judged.loudest_a),
    ]
}

/// A number with three digits, or a dash where there is none.
fn digits(value: f64) -> String {
    if value.is_finite() { number(format!("{value:.2e}").parse().unwrap_or(value)) } else { "–".into() }
}

/// Each transducer with what became of it, and the command that repeats it.
pub(super) fn csv(set: &[Tried]) -> Result<String, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "number",
        "kind",
        "series_resonance_hz",
        "q",
        "coupling",
        "c0_f",
        "bound_hz",
        "error_hz",
        "lock_error_hz",
        "board_s",
        "allowed_s",
        "loudest_v_part",
        "loudest_a_part",
        "outcome",
        "refusal",
        "command",
    ])?;
    for Tried { transducer, command, judged } in set {
        let given = |value: f64| format!("{value:.6e}");
        let (errors, refusal) = match &judged.found {
            Ok(found) => ([found.error_hz, found.lock_hz].map(given), String::new()),
            Err(refusal) => ([const { String::new() }; 2], refusal.clone()),
        };
        let outcome = match () {
            () if judged.found.is_err() => "refused",
            () if judged.is_right() => "right",
            () => "silent",
        };
        let mut record = vec![transducer.number.to_string(), transducer.kind.name.to_owned()];
        record.extend(
            [transducer.hz, transducer.q, transducer.coupling, transducer.c0_f, judged.bound_hz]
                .map(given)
                .into_iter()
                .chain(errors),
        );
        record.extend([judged.board_s, judged.allowed_s, judged.loudest_v, judged.loudest_a].map(given));
        record.extend([outcome.to_owned(), refusal, command.clone()]);
        writer.write_record(record)?;
    }
    let bytes = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
