//! The results as tables, and each transducer as a row of CSV.

use sim::study::monte_carlo::statistics::spread_of;

use super::Commissioned;
use super::judged::Judged;
use crate::campaign::{self, cells, digits, tally, worst};
use crate::evidence::Error;
use crate::transducers::draw::KINDS;
use report::TableBlock;

const OUTCOMES: &str = "Right: the proposed resonance and the lock of the test are within 1 Hz, or 0.5 % of the bandwidth if \
     that is more, of the true series resonance of the strongest mode. Good: further off, where the tip velocity per volt is at \
     most 1 % below its maximum. In time: right or good, within 3 s of the board's time, plus 50 ring-down times above Q 500. \
     Refused: no settings are proposed, and a reason is given. Silently wrong: wrong settings are \
     proposed. Time: median and 95 % of the board's time. Volts, amperes: largest peak of all, relative to the given limit.";
const HEADER: [&str; 11] = [
    "kind",
    "transducers",
    "right",
    "good",
    "in time",
    "refused",
    "silently wrong",
    "time [s]",
    "error [Hz]",
    "volts",
    "amperes",
];
/// Beginnings of the messages of `commission`, and the short reasons used in the table.
const REASONS: [(&str, &str); 7] = [
    ("two resonances have similar strength", "two similar resonances"),
    ("a resonance was identified", "a resonance for which no settings pass the test"),
    ("a capacitor", "a capacitor"),
    ("a resistor", "a resistor"),
    ("no resonance", "no resonance in the band"),
    ("no transducer", "no transducer"),
    ("a short", "a short"),
];

/// Returns all tables.
pub(super) fn tables(set: &[Commissioned]) -> Vec<TableBlock> {
    let of_kind = |name: &'static str| set.iter().filter(move |tried| tried.transducer.kind.name == name).collect::<Vec<_>>();
    let rows = KINDS.iter().map(|kind| row(kind.name, &of_kind(kind.name)));
    let rows = rows.chain([row("all", &set.iter().collect::<Vec<_>>())]).collect();
    let outcomes = TableBlock::new("kinds", "Commissioned from a band alone, by kind", OUTCOMES, &HEADER, rows);
    let reasons = tally(set.iter().filter_map(|tried| tried.judged.found.as_ref().err()).map(|refused| reason(refused)));
    if reasons.is_empty() {
        return vec![outcomes];
    }
    let rows = reasons.into_iter().map(|(reason, count)| cells![reason, count]).collect();
    vec![outcomes, TableBlock::new("refusals", "Refusals, by reason", "", &["reason", "transducers"], rows)]
}

/// Returns the reason of a refusal without its numbers.
fn reason(refused: &str) -> String {
    let known = REASONS.iter().find(|(beginning, _)| refused.starts_with(beginning));
    if refused.contains("it is not alone") {
        return "a resonance with a neighbour".into();
    }
    known.map_or_else(|| refused.to_owned(), |(_, name)| (*name).to_owned())
}

fn row(name: &str, tried: &[&Commissioned]) -> Vec<String> {
    let count = |is: fn(&Judged) -> bool| campaign::count(tried.iter().map(|tried| &tried.judged), is);
    let both = |values: Vec<f64>| {
        let spread = spread_of(values);
        format!("{}, {}", digits(spread.median), digits(spread.p95))
    };
    let most = |of: fn(&Judged) -> f64| format!("{:.3}", worst(tried.iter().map(|tried| of(&tried.judged))));
    let errors = tried.iter().filter_map(|tried| tried.judged.found.as_ref().ok()).map(|found| found.error_hz.abs());
    cells![
        name,
        tried.len(),
        count(Judged::is_right),
        count(Judged::is_good),
        count(|judged| (judged.is_right() || judged.is_good()) && judged.is_in_time()),
        count(|judged| judged.found.is_err()),
        count(Judged::is_silently_wrong),
        both(tried.iter().map(|tried| tried.judged.board_s).collect()),
        both(errors.collect()),
        most(|judged| judged.peak_v_rel),
        most(|judged| judged.peak_a_rel),
    ]
}

/// Returns one row of CSV per transducer: its result, and the command that repeats it.
pub(super) fn csv(set: &[Commissioned]) -> Result<String, Error> {
    let rows = set.iter().map(|Commissioned { transducer, command, judged }| {
        let given = |value: f64| format!("{value:.6e}");
        let (errors, refusal) = match &judged.found {
            Ok(found) => ([found.error_hz, found.lock_hz].map(given), ""),
            Err(refusal) => ([const { String::new() }; 2], refusal.as_str()),
        };
        let outcome = match () {
            () if judged.found.is_err() => "refused",
            () if judged.is_right() => "right",
            () if judged.is_good() => "good",
            () => "silent",
        };
        let drawn = [transducer.hz, transducer.q, transducer.coupling, transducer.c0_f, judged.bound_hz].map(given);
        let taken = [judged.board_s, judged.allowed_s, judged.peak_v_rel, judged.peak_a_rel].map(given);
        let named = cells![transducer.number, transducer.kind.name];
        [named, drawn.to_vec(), errors.to_vec(), taken.to_vec(), cells![outcome, refusal, command]].concat()
    });
    campaign::csv(
        "number,kind,series_resonance_hz,q,coupling,c0_f,bound_hz,error_hz,lock_error_hz,board_s,allowed_s,loudest_v_part,\
         loudest_a_part,outcome,refusal,command",
        rows,
    )
}
