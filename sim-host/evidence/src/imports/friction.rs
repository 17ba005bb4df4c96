//! Synthetic friction logs: the numbers of the true model against the truth and the Cramér-Rao bound.

use std::collections::BTreeMap;

use import::friction::Model;
use import::synthetic::FrictionExample;

use super::judged::Number;
use super::{COVERAGE, EFFICIENCY};
use crate::evidence::Error;
use report::statistics::{ascending, quantile};
use report::{TableBlock, verdict};

/// Stated standard deviations that a number may be off without a warning.
const FARTHEST: f64 = 6.0;

/// A log that was imported.
#[derive(Clone, Debug)]
pub(super) struct JudgedLog {
    /// Number of the example.
    number: u64,
    /// Model of the truth.
    model: Model,
    /// Whether that model was chosen.
    chosen: bool,
    /// Correlation of the noise of neighbouring samples.
    correlation: f64,
    /// Samples.
    samples: usize,
    /// Numbers of that model.
    numbers: Vec<Named>,
    /// Why it was refused.
    pub(super) refused: Option<String>,
}

/// A number of a log.
#[derive(Clone, Debug)]
struct Named {
    name: String,
    /// Against truth and bound; nothing where the import says that the log does not determine it.
    number: Option<Number>,
    /// Whether the import says that another value explains the log nearly as well.
    ambiguous: bool,
}

/// Imports an example.
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

/// What the logs say of a number.
struct Row {
    name: String,
    count: usize,
    /// Logs that do not determine it, as the import says.
    open: usize,
    within: f64,
    worst: f64,
    median: f64,
    p95: f64,
}

fn rows(set: &[JudgedLog]) -> Vec<Row> {
    let mut by_name: BTreeMap<&str, Vec<&Named>> = BTreeMap::new();
    for named in set.iter().flat_map(|log| &log.numbers) {
        by_name.entry(&named.name).or_default().push(named);
        by_name.entry("all").or_default().push(named);
    }
    let row = |(name, all): (&str, Vec<&Named>)| {
        let numbers: Vec<Number> = all.iter().filter_map(|named| named.number).collect();
        let ratios = ascending(numbers.iter().map(|number| number.over_bound));
        let part = |part: f64| quantile(&ratios, part).unwrap_or(f64::NAN);
        let within = numbers.iter().filter(|number| number.deviations.abs() <= 2.0).count() as f64 / numbers.len() as f64;
        let worst = numbers.iter().fold(0.0f64, |worst, number| worst.max(number.deviations.abs()));
        let (count, open) = (numbers.len(), all.len() - numbers.len());
        Row { name: name.to_owned(), count, open, within, worst, median: part(0.5), p95: part(0.95) }
    };
    by_name.into_iter().map(row).collect()
}

/// The coverage that holds in so many numbers: the band, or as far from that of a normal distribution as twice the deviation of chance.
fn band(count: usize) -> (f64, f64) {
    const NORMAL: f64 = 0.9545;
    let chance = 2.0 * (NORMAL * (1.0 - NORMAL) / count.max(1) as f64).sqrt();
    (COVERAGE.0.min(NORMAL - chance), COVERAGE.1.max(NORMAL + chance))
}

fn holds(row: &Row) -> bool {
    let (least, most) = band(row.count);
    (least..=most).contains(&row.within) && row.median <= EFFICIENCY
}

/// The targets that are missed.
pub(super) fn missed(set: &[JudgedLog]) -> Vec<String> {
    let refused = set.iter().filter_map(|log| log.refused.clone());
    let rows = rows(set);
    let beyond = rows.iter().filter(|row| !holds(row)).map(|row| {
        format!(
            "friction, {}: {:.1} % within two standard deviations, {:.2} times the bound in the median",
            row.name,
            100.0 * row.within,
            row.median
        )
    });
    let far = set.iter().flat_map(|log| log.numbers.iter().map(move |named| (log, named))).filter_map(|(log, named)| {
        let deviations = named.number.filter(|number| !named.ambiguous && number.deviations.abs() > FARTHEST)?.deviations;
        Some(format!(
            "friction, log {}: {} is {deviations:.1} standard deviations off, without a warning",
            log.number, named.name
        ))
    });
    refused.chain(beyond).chain(far).collect()
}

/// The numbers of all logs.
pub(super) fn table(set: &[JudgedLog]) -> TableBlock {
    let row = |row: &Row| {
        vec![
            row.name.clone(),
            row.count.to_string(),
            row.open.to_string(),
            format!("{:.1}", 100.0 * row.within),
            format!("{:.1}", row.worst),
            format!("{:.2}", row.median),
            format!("{:.2}", row.p95),
            verdict(holds(row)).to_owned(),
        ]
    };
    let models = [Model::Coulomb, Model::Stribeck, Model::Dahl, Model::Lugre].map(|model| {
        let of = set.iter().filter(|log| log.model == model);
        format!("{} {} of {}", model.name(), of.clone().filter(|log| log.chosen).count(), of.count())
    });
    let ambiguous = set.iter().filter(|log| log.numbers.iter().any(|named| named.ambiguous)).count();
    let caption = format!(
        "{} friction logs of four models, 300 to 1500 samples, a quarter with a memory in the noise. The numbers are those of the true model; it was chosen so often: {}. Open: logs of which the          import says that they do not determine the number. Within 2 sd is to be {:.0} to {:.0} %, or twice the deviation of chance from 95.4 %; over the bound as above. In {ambiguous}          logs the import says that another value explains the log nearly as well; elsewhere no number may be {FARTHEST} sd off.",
        set.len(),
        models.join(", "),
        100.0 * COVERAGE.0,
        100.0 * COVERAGE.1
    );
    let header = ["number", "logs", "open", "within 2 sd [%]", "worst", "over the bound, median", "95 %", ""];
    TableBlock::new("friction", "Numbers of friction logs", caption, &header, rows(set).iter().map(row).collect())
}

/// Each number of a log as a line.
pub(super) fn csv(set: &[JudgedLog]) -> Result<String, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "log",
        "model",
        "chosen",
        "samples",
        "noise_correlation",
        "number",
        "error_in_sd",
        "sd_over_bound",
        "ambiguous",
        "refused",
    ])?;
    for log in set {
        let own = [
            log.number.to_string(),
            log.model.name().to_owned(),
            log.chosen.to_string(),
            log.samples.to_string(),
            format!("{:.3}", log.correlation),
        ];
        let cell = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.4}"));
        for named in &log.numbers {
            let number = [
                named.name.clone(),
                cell(named.number.map(|number| number.deviations)),
                cell(named.number.map(|number| number.over_bound)),
                named.ambiguous.to_string(),
                String::new(),
            ];
            writer.write_record(own.iter().chain(&number))?;
        }
        if let Some(refused) = &log.refused {
            let empty = || String::new();
            writer.write_record(own.iter().chain(&[empty(), empty(), empty(), empty(), refused.clone()]))?;
        }
    }
    let bytes = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
