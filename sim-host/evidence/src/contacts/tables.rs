//! The results as tables, and each answer as a line of numbers.

use super::cost::Cost;
use super::draw::Friction;
use super::judged::{Judged, Verdict, groups};
use super::{RECORD_TOLERANCES, TOLERANCES, Tried};
use crate::evidence::Error;
use report::TableBlock;
use report::statistics::{ascending, percentile};

const WORD: &str = "Contact spring, friction, velocity ratio and damping over ten decades, the natural frequency over three. Not known: two settings of the Taylor series differ by more than a tenth of \
     the tolerance, or it needs more than thousands of parts a step. Silent: off by more than the tolerance, and not said. Flagged: the tolerance is \
     said not to be met, or the question is refused. Low: the stated error times 3, or 10, is less than the true one. High: stated over true error, median, of \
     answers in steps whose error is above 1e-13.";
const RECORD: &str = "The same of the whole record (`tolerance_of = \"record\"`): the largest error of friction over the Coulomb force, of displacement and of velocity over their largest, at any moment from the start on. The truth is the Taylor series at the same moments.";
const COST: &str = "Time from the question to the answer, without energies, over that of one run by the cheapest of 54 settings (linexp of order 2, 4, 6, from 4 \
     to 2048 steps a period) that meets the tolerance together with all finer ones of its order. Every seventh of the first thousand Dahl contacts.";
/// Part that may be flagged, and low by 3.
const MOST: f64 = 0.01;
/// The stated error over the true one, median.
const MOST_HIGH: f64 = 10.0;
/// Cost over the cheapest setting's: median, and 90 %.
const MOST_COST: [f64; 2] = [2.0, 4.0];
/// Below this a stated error is about round-off.
const ROUND_OFF: f64 = 1e-13;
/// Answers that are named.
const NAMED: usize = 20;

/// All tables.
pub fn tables(set: &[Tried], costs: &[Cost]) -> Vec<TableBlock> {
    let word = kept("word", "What `auto` says of random contacts", WORD, set, Of::Mean);
    let record = kept("record", "What `auto` says of whole records", RECORD, set, Of::Record);
    let header = ["tolerance", "periods", "contacts", "cost, median", "cost, 90 %"];
    let rows = TOLERANCES.iter().flat_map(|&tolerance| {
        [(0.0, 100.0), (100.0, 300.0), (300.0, 1e9)].map(|(from, to)| {
            let ratios = ratios(costs, |cost| cost.tolerance == tolerance && cost.periods >= from && cost.periods < to);
            let part = |part| at(&ratios, part).map_or("–".into(), |ratio| format!("{ratio:.2}"));
            let periods = if to < 1e9 { format!("{from:.0} to {to:.0}") } else { format!("from {from:.0}") };
            vec![format!("{tolerance:.0e}"), periods, ratios.len().to_string(), part(0.5), part(0.9)]
        })
    });
    let cost = TableBlock::new("cost", "What `auto` costs over the cheapest setting", COST, &header, rows.collect());
    vec![word, record, cost]
}

/// What is asked of `auto`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Of {
    /// The mean friction ratio.
    Mean,
    /// The whole record.
    Record,
}

impl Of {
    fn answers(self, tried: &Tried) -> &[Judged] {
        if self == Of::Record { &tried.records } else { &tried.answers }
    }
}

/// How `auto` keeps its word.
fn kept(name: &str, title: &str, caption: &str, set: &[Tried], of: Of) -> TableBlock {
    let header =
        ["law", "tolerance", "contacts", "not known", "silent", "flagged", "refused", "low by 3", "low by 10", "high, median"];
    let rows = questions(of).map(|(friction, tolerance)| {
        let answers = answers(set, friction, tolerance, of);
        let count = |is: &dyn Fn(&Judged) -> bool| answers.iter().filter(|(_, judged)| is(judged)).count().to_string();
        vec![
            friction.name().to_owned(),
            format!("{tolerance:.0e}"),
            answers.len().to_string(),
            count(&|judged| judged.verdict == Verdict::Unknown),
            count(&Judged::is_silent),
            count(&Judged::is_flagged),
            count(&|judged| matches!(judged.verdict, Verdict::Refused | Verdict::Failed)),
            count(&|judged| judged.is_low_by(3.0)),
            count(&|judged| judged.is_low_by(10.0)),
            high(&answers).map_or("–".into(), |high| format!("{high:.1}")),
        ]
    });
    TableBlock::new(name, title, caption, &header, rows.collect())
}

/// The targets that are missed.
pub fn missed(set: &[Tried], costs: &[Cost]) -> Vec<String> {
    let mut missed = Vec::new();
    let mut named = Vec::new();
    let questions = [Of::Mean, Of::Record].into_iter().flat_map(|of| questions(of).map(move |question| (of, question)));
    for (of, (friction, tolerance)) in questions {
        let answers = answers(set, friction, tolerance, of);
        let asked = if of == Of::Record {
            format!("{}, record, {tolerance:.0e}", friction.name())
        } else {
            format!("{}, {tolerance:.0e}", friction.name())
        };
        let mut many = |what: &str, is: &dyn Fn(&Judged) -> bool, part: f64| {
            let count = answers.iter().filter(|(_, judged)| is(judged)).count();
            if count as f64 > (part * answers.len() as f64).ceil() {
                missed.push(format!("{asked}: {count} of {} {what}", answers.len()));
            }
        };
        many("silently off", &Judged::is_silent, 0.0);
        many("failed without advice", &|judged| judged.verdict == Verdict::Failed, 0.0);
        many("flagged", &Judged::is_flagged, MOST);
        many("low by 3", &|judged| judged.is_low_by(3.0), MOST);
        many("low by 10", &|judged| judged.is_low_by(10.0), 0.0);
        if let Some(high) = high(&answers).filter(|high| *high > MOST_HIGH) {
            missed.push(format!("{asked}: estimates high by {high:.0}, median"));
        }
        let bad = |judged: &Judged| judged.is_silent() || judged.is_low_by(10.0) || judged.verdict == Verdict::Failed;
        for (tried, judged) in answers.iter().filter(|(_, judged)| bad(judged)) {
            named.push(format!(
                "{asked}: contact {}: {:?}, {}: {}",
                tried.contact.number,
                judged.verdict,
                judged.how,
                groups(&tried.contact.problem, tried.contact.direction)
            ));
        }
    }
    for tolerance in TOLERANCES {
        let ratios = ratios(costs, |cost| cost.tolerance == tolerance);
        for (part, most) in [0.5, 0.9].into_iter().zip(MOST_COST) {
            if let Some(ratio) = at(&ratios, part).filter(|ratio| *ratio > most) {
                missed.push(format!(
                    "cost at {tolerance:.0e}: {ratio:.1} times the cheapest at {:.0} %, and {most} is asked",
                    100.0 * part
                ));
            }
        }
    }
    named.truncate(NAMED);
    missed.extend(named);
    missed
}

fn questions(of: Of) -> impl Iterator<Item = (Friction, f64)> {
    let tolerances: &[f64] = if of == Of::Record { &RECORD_TOLERANCES } else { &TOLERANCES };
    let laws: &[Friction] = if of == Of::Record { &Friction::RECORDED } else { &Friction::ALL };
    laws.iter().flat_map(move |&friction| tolerances.iter().map(move |&tolerance| (friction, tolerance)))
}

fn answers(set: &[Tried], friction: Friction, tolerance: f64, of: Of) -> Vec<(&Tried, &Judged)> {
    let tried = set.iter().filter(|tried| tried.friction == friction);
    tried
        .flat_map(move |tried| {
            of.answers(tried).iter().filter(move |judged| judged.tolerance == tolerance).map(move |judged| (tried, judged))
        })
        .collect()
}

/// Stated over true error, median.
fn high(answers: &[(&Tried, &Judged)]) -> Option<f64> {
    let over = |(_, judged): &(&Tried, &Judged)| match judged.verdict {
        Verdict::Answered { error, estimate, .. } if error > ROUND_OFF => Some(estimate / error),
        _ => None,
    };
    at(&ascending(answers.iter().filter_map(over)), 0.5)
}

fn ratios(costs: &[Cost], of: impl Fn(&Cost) -> bool) -> Vec<f64> {
    ascending(costs.iter().filter(|cost| of(cost)).map(|cost| cost.ratio))
}

fn at(sorted: &[f64], part: f64) -> Option<f64> {
    (!sorted.is_empty()).then(|| percentile(sorted, part))
}

/// Each answer.
pub fn csv(set: &[Tried]) -> Result<String, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "law",
        "number",
        "of",
        "tolerance",
        "verdict",
        "error",
        "estimate",
        "met",
        "truth_unknown",
        "how",
        "contact",
    ])?;
    for tried in set {
        let records = tried.records.iter().map(|judged| (Of::Record, judged));
        for (of, judged) in tried.answers.iter().map(|judged| (Of::Mean, judged)).chain(records) {
            let (verdict, error, estimate, met) = match judged.verdict {
                Verdict::Answered { error, estimate, met } => ("answered", error, estimate, met),
                Verdict::Refused => ("refused", f64::NAN, f64::NAN, false),
                Verdict::Failed => ("failed", f64::NAN, f64::NAN, false),
                Verdict::Unknown => ("unknown", f64::NAN, f64::NAN, false),
            };
            let unknown = tried.truth.filter(|_| of == Of::Mean).map_or(f64::NAN, |truth| truth.unknown);
            writer.write_record([
                tried.friction.name().to_owned(),
                tried.contact.number.to_string(),
                format!("{of:?}").to_lowercase(),
                format!("{:.0e}", judged.tolerance),
                verdict.into(),
                format!("{error:.3e}"),
                format!("{estimate:.3e}"),
                met.to_string(),
                format!("{unknown:.1e}"),
                judged.how.clone(),
                groups(&tried.contact.problem, tried.contact.direction),
            ])?;
        }
    }
    text(writer)
}

/// Each question that was timed.
pub fn costs_csv(costs: &[Cost]) -> Result<String, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["number", "periods", "kappa", "tolerance", "best_order", "best_steps", "ratio", "auto"])?;
    for Cost { number, periods, kappa, tolerance, best, ratio, how } in costs {
        writer.write_record([
            number.to_string(),
            format!("{periods:.0}"),
            format!("{kappa:.2e}"),
            format!("{tolerance:.0e}"),
            best.0.to_string(),
            best.1.to_string(),
            format!("{ratio:.3}"),
            how.clone(),
        ])?;
    }
    text(writer)
}

fn text(writer: csv::Writer<Vec<u8>>) -> Result<String, Error> {
    let bytes = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
