//! Synthetic friction logs: the numbers of the true model against the truth and the Cramér-Rao bound.

use std::collections::BTreeMap;

use import::friction::Model;
use import::synthetic::FrictionExample;

use super::judged::Number;
use super::{COVERAGE, EFFICIENCY};
use report::{TableBlock, verdict};

/// A log that was imported.
#[derive(Clone, Debug)]
pub(super) struct JudgedLog {
    /// Model of the truth.
    model: Model,
    /// Whether that model was chosen.
    chosen: bool,
    /// Numbers of that model, by name; none that the log does not determine.
    numbers: Vec<(String, Number)>,
    /// Why it was refused.
    pub(super) refused: Option<String>,
}

/// Imports an example.
pub(super) fn judge(number: u64) -> JudgedLog {
    let example = FrictionExample::draw(number);
    let model = example.model;
    let refused =
        |why: &str| JudgedLog { model, chosen: false, numbers: Vec::new(), refused: Some(format!("log {number}: {why}")) };
    let found = match example.import() {
        Ok(found) => found,
        Err(error) => return refused(&error.to_string()),
    };
    let Some(fitted) = found.models.iter().find(|fitted| fitted.model == model) else {
        return refused("the model was not fitted");
    };
    let Some(bounds) = example.bounds() else { return refused("the example has no bound") };
    let judged = |bounded: import::synthetic::Bounded| {
        let (_, value, sd) = fitted.parameters.iter().find(|(name, ..)| *name == bounded.name)?;
        let sd = (*sd)?;
        Some((bounded.name, Number { deviations: (value - bounded.value) / sd, over_bound: sd / bounded.bound }))
    };
    JudgedLog {
        model,
        chosen: found.chosen().model == model,
        numbers: bounds.into_iter().filter_map(judged).collect(),
        refused: None,
    }
}

/// What the logs say of a number.
struct Row {
    name: String,
    count: usize,
    within: f64,
    worst: f64,
    median: f64,
    p95: f64,
}

fn rows(set: &[JudgedLog]) -> Vec<Row> {
    let mut by_name: BTreeMap<&str, Vec<Number>> = BTreeMap::new();
    for (name, number) in set.iter().flat_map(|log| &log.numbers) {
        by_name.entry(name).or_default().push(*number);
        by_name.entry("all").or_default().push(*number);
    }
    let row = |(name, numbers): (&str, Vec<Number>)| {
        let mut ratios: Vec<f64> = numbers.iter().map(|number| number.over_bound).collect();
        ratios.sort_by(f64::total_cmp);
        let part = |part: f64| ratios.get((part * ratios.len() as f64) as usize).copied().unwrap_or(f64::NAN);
        let within = numbers.iter().filter(|number| number.deviations.abs() <= 2.0).count() as f64 / numbers.len() as f64;
        let worst = numbers.iter().fold(0.0f64, |worst, number| worst.max(number.deviations.abs()));
        Row { name: name.to_owned(), count: numbers.len(), within, worst, median: part(0.5), p95: part(0.95) }
    };
    by_name.into_iter().map(row).collect()
}

/// The coverage that so few numbers leave to chance, beyond what is asked for of many.
fn slack(count: usize) -> f64 {
    2.0 * (0.05 * 0.95 / count.max(1) as f64).sqrt()
}

fn holds(row: &Row) -> bool {
    let slack = slack(row.count);
    (COVERAGE.0 - slack..=COVERAGE.1 + slack).contains(&row.within) && row.median <= EFFICIENCY
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
    refused.chain(beyond).collect()
}

/// The numbers of all logs.
pub(super) fn table(set: &[JudgedLog]) -> TableBlock {
    let row = |row: &Row| {
        vec![
            row.name.clone(),
            row.count.to_string(),
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
    let caption = format!(
        "{} friction logs of four models, 300 to 1500 samples, a quarter with a memory in the noise. The numbers are those of the true model; it was chosen so often: {}. Within 2 sd is to be \
         {:.0} to {:.0} %, and twice what chance adds in so few numbers; over the bound as above.",
        set.len(),
        models.join(", "),
        100.0 * COVERAGE.0,
        100.0 * COVERAGE.1
    );
    let header = ["number", "logs", "within 2 sd [%]", "worst", "over the bound, median", "95 %", ""];
    TableBlock::new("friction", "Numbers of friction logs", caption, &header, rows(set).iter().map(row).collect())
}
