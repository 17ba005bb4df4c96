//! The results as tables, and each answer as a row of CSV.

use super::cost::Cost;
use super::draw::Friction;
use super::judged::{Judged, Verdict, groups};
use super::{ContactRuns, RECORD_TOLERANCES, TOLERANCES};
use crate::campaign::{self, cells, columns, or_dash};
use crate::evidence::Error;
use report::TableBlock;
use report::statistics::{ascending, percentile};

const MEAN_CAPTION: &str = "Contact spring, friction, velocity ratio and damping over ten decades, the natural frequency over \
     three. Reference unknown: two settings of the Taylor series differ by more than a tenth of the tolerance, or it needs more \
     than thousands of parts a step. Silently wrong: the error exceeds the tolerance, which is reported as met. Flagged: the \
     tolerance is reported as not met, or the question is refused. Low by 3, or 10: the stated error times 3, or 10, is less \
     than the true one. Last column: stated over true error, median, of answers in steps whose error is above 1e-13.";
const RECORD_CAPTION: &str = "The same for the whole record (`tolerance_of = \"record\"`): the largest error of friction over \
     the Coulomb force, of displacement and of velocity over their largest values, at any moment from the start on. The \
     reference is the Taylor series at the same moments.";
const COST_CAPTION: &str = "Time from the question to the answer, without energies, over that of one run by the cheapest of 72 \
     settings (linexp of order 2, 4, 6, 10, from 4 to 2048 steps a period) that meets the tolerance together with all finer \
     ones of its order. Every seventh of the first thousand Dahl contacts.";
/// Largest fraction of answers that may be flagged, and that may be low by 3.
const MAX_FLAGGED_REL: f64 = 0.01;
/// Largest median ratio of stated to true error.
const MAX_STATED_RATIO: f64 = 10.0;
/// Largest cost over that of the cheapest setting: median and 90 %.
const MAX_COST: [f64; 2] = [2.0, 4.0];
/// Error below which a stated error is about round-off.
const ROUND_OFF: f64 = 1e-13;
/// Largest number of answers that are listed.
const MAX_LISTED: usize = 20;

/// Returns all tables.
pub fn tables(set: &[ContactRuns], costs: &[Cost]) -> Vec<TableBlock> {
    let word = accuracy("word", "`auto` on random contacts: mean friction ratio", MEAN_CAPTION, set, Quantity::Mean);
    let record = accuracy("record", "`auto` on random contacts: whole record", RECORD_CAPTION, set, Quantity::Record);
    let header = columns("tolerance | periods | contacts | cost, median | cost, 90 %");
    let rows = TOLERANCES.iter().flat_map(|&tolerance| {
        [(0.0, 100.0), (100.0, 300.0), (300.0, 1e9)].map(|(from, to)| {
            let ratios = ratios(costs, |cost| cost.tolerance == tolerance && cost.periods >= from && cost.periods < to);
            let part = |part| or_dash(at(&ratios, part), |ratio| format!("{ratio:.2}"));
            let periods = if to < 1e9 { format!("{from:.0} to {to:.0}") } else { format!("from {from:.0}") };
            cells![format!("{tolerance:.0e}"), periods, ratios.len(), part(0.5), part(0.9)]
        })
    });
    let cost = TableBlock::new("cost", "Cost of `auto` over the cheapest setting", COST_CAPTION, &header, rows.collect());
    vec![word, record, cost]
}

/// The quantity that has the tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quantity {
    /// The mean friction ratio.
    Mean,
    /// The whole record.
    Record,
}

impl Quantity {
    fn answers(self, tried: &ContactRuns) -> &[Judged] {
        if self == Quantity::Record { &tried.records } else { &tried.answers }
    }
}

/// Returns the table of the accuracy of `auto`.
fn accuracy(name: &str, title: &str, caption: &str, set: &[ContactRuns], of: Quantity) -> TableBlock {
    let header = columns(
        "law | tolerance | contacts | reference unknown | silently wrong | flagged | refused | low by 3 | low by 10 | \
         stated / true error",
    );
    let rows = questions(of).map(|(friction, tolerance)| {
        let answers = answers(set, friction, tolerance, of);
        let count = |is: fn(&Judged) -> bool| campaign::count(answers.iter().map(|(_, judged)| *judged), is);
        cells![
            friction.name(),
            format!("{tolerance:.0e}"),
            answers.len(),
            count(|judged| judged.verdict == Verdict::Unknown),
            count(Judged::is_silently_wrong),
            count(Judged::is_flagged),
            count(|judged| matches!(judged.verdict, Verdict::Refused | Verdict::Failed)),
            count(|judged| judged.is_low_by(3.0)),
            count(|judged| judged.is_low_by(10.0)),
            or_dash(high(&answers), |high| format!("{high:.1}")),
        ]
    });
    TableBlock::new(name, title, caption, &header, rows.collect())
}

/// Returns the targets that are missed.
pub fn missed(set: &[ContactRuns], costs: &[Cost]) -> Vec<String> {
    let mut missed = Vec::new();
    let mut named = Vec::new();
    let questions =
        [Quantity::Mean, Quantity::Record].into_iter().flat_map(|of| questions(of).map(move |question| (of, question)));
    for (of, (friction, tolerance)) in questions {
        let answers = answers(set, friction, tolerance, of);
        let record = if of == Quantity::Record { "record, " } else { "" };
        let asked = format!("{}, {record}{tolerance:.0e}", friction.name());
        let mut many = |what: &str, is: fn(&Judged) -> bool, part: f64| {
            let count = campaign::count(answers.iter().map(|(_, judged)| *judged), is);
            if count as f64 > (part * answers.len() as f64).ceil() {
                missed.push(format!("{asked}: {count} of {} {what}", answers.len()));
            }
        };
        many("silently wrong", Judged::is_silently_wrong, 0.0);
        many("failed without advice", |judged| judged.verdict == Verdict::Failed, 0.0);
        many("flagged", Judged::is_flagged, MAX_FLAGGED_REL);
        many("low by 3", |judged| judged.is_low_by(3.0), MAX_FLAGGED_REL);
        many("low by 10", |judged| judged.is_low_by(10.0), 0.0);
        if let Some(high) = high(&answers).filter(|high| *high > MAX_STATED_RATIO) {
            missed.push(format!("{asked}: estimates high by {high:.0}, median"));
        }
        let bad = |judged: &Judged| judged.is_silently_wrong() || judged.is_low_by(10.0) || judged.verdict == Verdict::Failed;
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
        for (part, most) in [0.5, 0.9].into_iter().zip(MAX_COST) {
            if let Some(ratio) = at(&ratios, part).filter(|ratio| *ratio > most) {
                missed.push(format!(
                    "cost at {tolerance:.0e}: {ratio:.1} times the cheapest at {:.0} %; the target is {most}",
                    100.0 * part
                ));
            }
        }
    }
    named.truncate(MAX_LISTED);
    missed.extend(named);
    missed
}

fn questions(of: Quantity) -> impl Iterator<Item = (Friction, f64)> {
    let tolerances: &[f64] = if of == Quantity::Record { &RECORD_TOLERANCES } else { &TOLERANCES };
    let laws: &[Friction] = if of == Quantity::Record { &Friction::RECORDED } else { &Friction::ALL };
    laws.iter().flat_map(move |&friction| tolerances.iter().map(move |&tolerance| (friction, tolerance)))
}

fn answers(set: &[ContactRuns], friction: Friction, tolerance: f64, of: Quantity) -> Vec<(&ContactRuns, &Judged)> {
    let tried = set.iter().filter(|tried| tried.friction == friction);
    tried
        .flat_map(move |tried| {
            of.answers(tried).iter().filter(move |judged| judged.tolerance == tolerance).map(move |judged| (tried, judged))
        })
        .collect()
}

/// Returns the median ratio of stated to true error.
fn high(answers: &[(&ContactRuns, &Judged)]) -> Option<f64> {
    let over = |(_, judged): &(&ContactRuns, &Judged)| match judged.verdict {
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

/// Returns one row of CSV per answer.
pub fn csv(set: &[ContactRuns]) -> Result<String, Error> {
    let rows = set.iter().flat_map(|tried| {
        let records = tried.records.iter().map(|judged| (Quantity::Record, judged));
        let row = |(of, judged): (Quantity, &Judged)| {
            let (verdict, error, estimate, met) = match judged.verdict {
                Verdict::Answered { error, estimate, met } => ("answered", error, estimate, met),
                Verdict::Refused => ("refused", f64::NAN, f64::NAN, false),
                Verdict::Failed => ("failed", f64::NAN, f64::NAN, false),
                Verdict::Unknown => ("unknown", f64::NAN, f64::NAN, false),
            };
            let unknown = tried.truth.filter(|_| of == Quantity::Mean).map_or(f64::NAN, |truth| truth.unknown);
            let (of, tolerance) = (format!("{of:?}").to_lowercase(), format!("{:.0e}", judged.tolerance));
            let [error, estimate] = [error, estimate].map(|error| format!("{error:.3e}"));
            let (unknown, groups) = (format!("{unknown:.1e}"), groups(&tried.contact.problem, tried.contact.direction));
            let (law, number) = (tried.friction.name(), tried.contact.number);
            cells![law, number, of, tolerance, verdict, error, estimate, met, unknown, judged.how, groups]
        };
        tried.answers.iter().map(|judged| (Quantity::Mean, judged)).chain(records).map(row).collect::<Vec<_>>()
    });
    campaign::csv("law,number,of,tolerance,verdict,error,estimate,met,truth_unknown,how,contact", rows)
}

/// Returns one row of CSV per timed question.
pub fn costs_csv(costs: &[Cost]) -> Result<String, Error> {
    let rows = costs.iter().map(|Cost { number, periods, kappa, tolerance, best: (order, steps), ratio, how }| {
        let [kappa, tolerance] = [format!("{kappa:.2e}"), format!("{tolerance:.0e}")];
        cells![number, format!("{periods:.0}"), kappa, tolerance, order, steps, format!("{ratio:.3}"), how]
    });
    campaign::csv("number,periods,kappa,tolerance,best_order,best_steps,ratio,auto", rows)
}
