//! Synthetic friction logs: the numbers of the true model, compared with the truth and the
//! Cramér-Rao bound.

use std::collections::BTreeMap;

use import::friction::Model;
use import::synthetic::FrictionExample;

use super::MAX_BOUND_RATIO;
use super::judged::{Number, Statistics};
use crate::campaign::{self, cells, columns};
use crate::evidence::Error;
use report::{TableBlock, verdict};

/// Half width of a stated 95 % interval, standard deviations.
const INTERVAL_SIGMAS: f64 = 1.96;
/// Required fraction of the truths within their 95 % intervals, for each number.
const COVERAGE: std::ops::RangeInclusive<f64> = 0.92..=0.98;
/// Largest error without a warning, stated standard deviations.
const MAX_DEVIATIONS: f64 = 6.0;

/// A log that was imported.
#[derive(Clone, Debug)]
pub(super) struct JudgedLog {
    /// Number of the example.
    number: u64,
    /// Model of the truth.
    model: Model,
    /// `true` if that model was chosen.
    chosen: bool,
    /// Correlation of the noise of neighbouring samples.
    correlation: f64,
    /// Number of samples.
    samples: usize,
    /// Numbers of that model.
    numbers: Vec<Named>,
    /// Reason of a refusal.
    pub(super) refused: Option<String>,
}

/// A number of a log.
#[derive(Clone, Debug)]
struct Named {
    name: String,
    /// Errors and deviations; `None` if the import reports that the log does not determine the
    /// number.
    number: Option<Number>,
    /// `true` if the import reports that another value explains the log nearly as well.
    ambiguous: bool,
}

/// Imports an example, and compares it with its truth.
pub(super) fn judge(number: u64) -> JudgedLog {
    let example = FrictionExample::draw(number);
    let judged = |chosen, numbers, refused: Option<String>| JudgedLog {
        number,
        model: example.model,
        chosen,
        correlation: example.correlation,
        samples: example.log.force_n.len(),
        numbers,
        refused: refused.map(|why| format!("log {number}: {why}")),
    };
    let found = match example.import() {
        Ok(found) => found,
        Err(error) => return judged(false, Vec::new(), Some(error.to_string())),
    };
    let Some(fitted) = found.models.iter().find(|fitted| fitted.model == example.model) else {
        return judged(false, Vec::new(), Some("the model was not fitted".into()));
    };
    let Some(bounds) = example.bounds() else {
        return judged(false, Vec::new(), Some("the example has no bound".into()));
    };
    let number = |bounded: import::synthetic::Bounded| {
        let (_, value, sd) = fitted.parameters.iter().find(|(name, ..)| *name == bounded.name)?;
        let of = |sd: f64| Number { deviations: (value - bounded.value) / sd, over_bound: sd / bounded.bound };
        Some(Named { ambiguous: fitted.ambiguous.contains(&bounded.name), name: bounded.name, number: sd.map(of) })
    };
    judged(found.chosen().model == example.model, bounds.into_iter().filter_map(number).collect(), None)
}

/// Statistics of a number over all logs.
struct Row {
    count: usize,
    /// Number of logs that do not determine it, according to the import.
    open: usize,
    /// Fraction of the truths within their 95 % intervals.
    covered: f64,
    of: Statistics,
}

fn rows(set: &[JudgedLog]) -> Vec<Row> {
    let mut by_name: BTreeMap<&str, Vec<&Named>> = BTreeMap::new();
    for named in set.iter().flat_map(|log| &log.numbers) {
        by_name.entry(&named.name).or_default().push(named);
        by_name.entry("all").or_default().push(named);
    }
    let row = |(name, all): (&str, Vec<&Named>)| {
        let numbers: Vec<Number> = all.iter().filter_map(|named| named.number).collect();
        let covered = numbers.iter().filter(|number| number.deviations.abs() <= INTERVAL_SIGMAS).count();
        let covered = covered as f64 / numbers.len().max(1) as f64;
        Row { count: numbers.len(), open: all.len() - numbers.len(), covered, of: Statistics::new(name, &numbers) }
    };
    by_name.into_iter().map(row).collect()
}

/// Returns the required coverage of `count` numbers: [`COVERAGE`], or within two standard
/// deviations of 95 % by chance if that range is wider.
fn band(count: usize) -> (f64, f64) {
    const NORMAL: f64 = 0.95;
    let chance = 2.0 * (NORMAL * (1.0 - NORMAL) / count.max(1) as f64).sqrt();
    (COVERAGE.start().min(NORMAL - chance), COVERAGE.end().max(NORMAL + chance))
}

fn holds(row: &Row) -> bool {
    let (least, most) = band(row.count);
    (least..=most).contains(&row.covered) && row.of.median <= MAX_BOUND_RATIO
}

/// Returns the targets that are missed.
pub(super) fn missed(set: &[JudgedLog]) -> Vec<String> {
    let refused = set.iter().filter_map(|log| log.refused.clone());
    let rows = rows(set);
    let beyond = rows.iter().filter(|row| !holds(row)).map(|row| {
        let Statistics { name, median, .. } = &row.of;
        let covered = 100.0 * row.covered;
        format!("friction, {name}: {covered:.1} % within their 95 % intervals, {median:.2} times the bound in the median")
    });
    let far = set.iter().flat_map(|log| log.numbers.iter().map(move |named| (log, named))).filter_map(|(log, named)| {
        let deviations = named.number.filter(|number| !named.ambiguous && number.deviations.abs() > MAX_DEVIATIONS)?.deviations;
        Some(format!(
            "friction, log {}: {} is {deviations:.1} standard deviations off, without a warning",
            log.number, named.name
        ))
    });
    refused.chain(beyond).chain(far).collect()
}

/// Returns the table of the numbers of all logs.
pub(super) fn table(set: &[JudgedLog]) -> TableBlock {
    let row = |row: &Row| {
        let Statistics { name, worst, median, p95, .. } = &row.of;
        let [covered, worst] = [100.0 * row.covered, *worst].map(|value| format!("{value:.1}"));
        let [median, p95] = [median, p95].map(|ratio| format!("{ratio:.2}"));
        cells![name, row.count, row.open, covered, worst, median, p95, verdict(holds(row))]
    };
    let models = [Model::Coulomb, Model::Stribeck, Model::Dahl, Model::Lugre].map(|model| {
        let of = set.iter().filter(|log| log.model == model);
        format!("{} {} of {}", model.name(), of.clone().filter(|log| log.chosen).count(), of.count())
    });
    let ambiguous = set.iter().filter(|log| log.numbers.iter().any(|named| named.ambiguous)).count();
    let caption = format!(
        "{} friction logs of four models, 300 to 1500 samples, a quarter with correlated noise. An independent model \
         integrates the contact in time; the instrument has uneven sample times, a resolution, a filter in both channels, an \
         offset that drifts and, in half of the logs, a normal force that varies. The numbers are those of the true model; it \
         was chosen as follows: {}. Open: logs that do not determine the number, according to the import. Covered: truths \
         within the stated 95 % interval, required {:.0} to {:.0} %, or 95 % within twice its deviation by chance; over the \
         bound as above. In {ambiguous} logs the import reports that another value explains the log nearly as well; in all \
         others no number may be {MAX_DEVIATIONS} sd off.",
        set.len(),
        models.join(", "),
        100.0 * COVERAGE.start(),
        100.0 * COVERAGE.end()
    );
    let header = columns("number | logs | open | covered [%] | worst | over the bound, median | 95 % | ");
    TableBlock::new("friction", "Numbers of friction logs", caption, &header, rows(set).iter().map(row).collect())
}

/// Returns one row of CSV per number of a log.
pub(super) fn csv(set: &[JudgedLog]) -> Result<String, Error> {
    let cell = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.4}"));
    let rows = set.iter().flat_map(|log| {
        let own = cells![log.number, log.model.name(), log.chosen, log.samples, format!("{:.3}", log.correlation)];
        let of_number = |Named { name, number, ambiguous }: &Named| {
            let [error, over] = [number.map(|number| number.deviations), number.map(|number| number.over_bound)].map(cell);
            cells![name, error, over, ambiguous, ""]
        };
        let refused = log.refused.iter().map(|refused| cells!["", "", "", "", refused]);
        log.numbers.iter().map(of_number).chain(refused).map(move |cells| [own.clone(), cells].concat()).collect::<Vec<_>>()
    });
    let header = "log,model,chosen,samples,noise_correlation,number,error_in_sd,sd_over_bound,ambiguous,refused";
    campaign::csv(header, rows)
}
