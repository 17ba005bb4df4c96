//! Remarks and tables of a study: the same for the terminal and for the report.

mod comparison;
mod driven;
mod grid;
mod inputs;
pub(crate) mod misfit;

use crate::figures;
use crate::instruments::{self, Line, View, crash};
use crate::numbers::{number, precise};
use crate::overlay;
use crate::provenance::Provenance;
use crate::study::{Outcome, Study, contact, design, monte_carlo};
use report::{Report, TableBlock, rounded_to};
use scene::load::Assumed;
use scene::metrics;
use scene::resolved::resolved_json;

/// Returns the report of a study.
pub fn report(study: &Study, provenance: &Provenance) -> Report {
    let preface = match &study.outcome {
        Outcome::Driven(run) => driven::preface(run),
        Outcome::Contact(_) => contact::table::PREFACE.to_owned(),
        Outcome::Design(_) => design::table::PREFACE.to_owned(),
        Outcome::MonteCarlo(runs) => monte_carlo::table::preface(runs),
    };
    Report {
        title: title(study),
        subtitle: inputs::source(study),
        summary: headline(study),
        paragraphs: [remarks(study), inputs::notes(study), vec![preface]].concat(),
        tables: inputs::changed(study).into_iter().chain(tables(study)).collect(),
        figures: figures::of(study),
        crash: study.run().and_then(|run| crash::view(&View::new(&run.scene, &run.record))),
        appendix: vec![dictionary(study), inputs::all(study)],
        footer: footer(study, provenance),
        interrupted: study.interrupted,
    }
}

/// Returns the title of a study, marked if it is from a base with other inputs.
pub fn title(study: &Study) -> String {
    let of_base = study.inherited.as_ref().is_some_and(|inherited| inherited.title);
    if of_base { format!("{} (with changed inputs)", study.scene.title) } else { study.scene.title.clone() }
}

/// Returns the main tables of a scene: expectations, comparison, results and grid.
pub fn tables(study: &Study) -> Vec<TableBlock> {
    let mut tables = vec![expectations(study)];
    tables.extend(comparison::tables(study));
    match &study.outcome {
        Outcome::Driven(run) => tables.extend(driven::tables(run, &study.metrics)),
        Outcome::Contact(solved) => tables.extend(contact::table::tables(study, solved)),
        Outcome::Design(drawn) => tables.extend(design::table::tables(drawn)),
        Outcome::MonteCarlo(runs) => tables.extend(monte_carlo::table::tables(study, runs)),
    }
    tables.extend(study.overlaid.iter().map(|overlaid| overlay::table(&overlaid.residuals)));
    tables.extend(grid::tables(study));
    tables.retain(|table| !table.rows.is_empty());
    tables
}

/// Returns remarks that a reader must know before the numbers.
pub fn remarks(study: &Study) -> Vec<String> {
    let mut remarks = Vec::new();
    let changes = study.changes.join(", ");
    if let Some(number) = study.run_number {
        remarks.push(format!(
            "Single run {number} of the scene's runs, with its drawn values: {changes}. The notes are those of \
                              all runs."
        ));
    } else if !changes.is_empty() {
        remarks.push(format!("Changed inputs: {changes}."));
    }
    if study.scene.runs == 1 && !study.scene.vary.is_empty() && study.run_number.is_none() {
        remarks.push("Distributions and `[[vary]]` have no effect in a single run; set `runs` to draw their values.".to_owned());
    }
    let method = study.scene.integrator.method;
    remarks.extend(method.and_then(|method| {
        let (old, new) = (method.name(), method.replacement()?.name());
        Some(format!("`integrator.method = \"{old}\"` is deprecated; the next version removes it. Use \"{new}\"."))
    }));
    remarks.extend(inputs::remark(study));
    remarks.extend(Assumed::remark(&study.assumed));
    remarks.extend(renamed(study));
    remarks.extend(match &study.outcome {
        Outcome::Driven(run) => driven::remarks(run),
        Outcome::Contact(solved) => contact::table::remarks(solved),
        Outcome::Design(drawn) => design::table::remarks(drawn),
        Outcome::MonteCarlo(runs) => monte_carlo::table::remarks(study, runs),
    });
    remarks.extend(not_drawn(study));
    let grid = study.scene.grid.iter().flat_map(|grid| grid.over.iter().map(|over| over.key.as_str()));
    let changed = study.changes.iter().filter_map(|change| change.split('=').next());
    let keys = grid.chain(study.scene.vary.iter().map(|vary| vary.key.as_str())).chain(changed);
    remarks.extend(misfit::misfits(&resolved_json(study.scene), keys));
    remarks
}

/// Returns `" (assumed)"` if a metric, or the label of one, follows from a value that the user did
/// not set. `driven`: the scene has a controller.
pub fn mark(all: &[Assumed], driven: bool, metric: &str) -> &'static str {
    let has = |words: &[&str]| words.iter().any(|word| metric.contains(word));
    let words =
        ["friction", "reduction", "breakaway", "kappa", "load_cell", "release", "hold", "creep", "detent", "slip", "ripple"];
    let of_contact = has(&words) || !driven && has(&["ratio"]) && !has(&["velocity"]);
    // A contact on a stack is vibrated through its force factor, while the drive is ON.
    let of_stack = (of_contact || has(&["velocity", "displacement", "tip"])) && !has(&["off", "OFF", "wanted", "estimate"]);
    let follows = |assumed: &Assumed| if assumed.is_contact() { of_contact } else { of_stack };
    if all.iter().any(follows) { " (assumed)" } else { "" }
}

/// Returns the mark of a metric of a study.
fn mark_of(study: &Study, metric: &str) -> &'static str {
    mark(&study.assumed, study.scene.controller.is_some(), metric)
}

/// Returns the measured curves of the scene that its run does not show, with reasons: one sentence
/// each.
pub fn not_drawn(study: &Study) -> Vec<String> {
    let several = "Figures of several runs show all of them together; the metrics `overlay_…` are computed for each run.";
    let more = study.monte_carlo().map_or_else(String::new, |_| format!(" {several}"));
    study.overlaid.iter().flat_map(|overlaid| &overlaid.not_drawn).map(|said| format!("{said}{more}")).collect()
}

/// Returns a remark for each expectation that uses a former name of a metric.
fn renamed(study: &Study) -> Vec<String> {
    let former = |name: &str| {
        let present =
            metrics::renamed(name).filter(|present| study.metrics.get(name).is_none() && study.metrics.get(present).is_some())?;
        Some(format!("The expectation of `{name}` is checked against `{present}`, its present name."))
    };
    study.judged.iter().filter_map(|judged| former(&judged.metric)).collect()
}

/// Returns the headline numbers.
pub fn headline(study: &Study) -> Vec<(String, String)> {
    let (first, lines): (Vec<_>, Vec<Line>) = match &study.outcome {
        Outcome::Driven(run) => (driven::fault(run).into_iter().collect(), instruments::headline().collect()),
        Outcome::Contact(solved) => (contact::table::ratio(solved).into_iter().collect(), contact::table::HEADLINE.to_vec()),
        Outcome::Design(_) => (Vec::new(), design::table::HEADLINE.to_vec()),
        Outcome::MonteCarlo(runs) => (monte_carlo::table::first(study.scene, runs), monte_carlo::table::HEADLINE.to_vec()),
    };
    let intervals = study.monte_carlo().map_or_else(Vec::new, |runs| monte_carlo::uncertainty::intervals(study.scene, runs));
    let tile = |&(label, metric, unit): &Line| {
        // The median is in the interval.
        if intervals.iter().any(|interval| interval.line.1 == metric) {
            return None;
        }
        study.metrics.get(metric).map(|value| (label.to_owned(), format!("{} {unit}", number(value)).trim_end().to_owned()))
    };
    // Averages of a run that ended in a fault are those before it.
    let is_fault = study.run().and_then(driven::fault).is_some();
    let is_mean = |label: &str| ["friction", "velocity", "bias", "power"].iter().any(|word| label.contains(word));
    let before = |label: &str| if is_fault && is_mean(label) { " (until the fault)" } else { "" };
    let until = |(label, value): (String, String)| {
        let value = value + before(&label);
        (label, value)
    };
    let tiles = first.into_iter().chain(lines.iter().filter_map(tile).map(until));
    tiles
        .map(|(label, value)| {
            let value = value + mark_of(study, &label);
            (label, value)
        })
        .collect()
}

/// Returns the most important of the metrics that a study has.
pub fn main_metric(study: &Study) -> Option<Line> {
    let of_runs = study.monte_carlo().map_or(&[][..], |_| monte_carlo::table::HEADLINE);
    let lines = monte_carlo::uncertainty::lines(study.scene);
    let is_shown = |line: &&Line| study.monte_carlo().is_some() || !monte_carlo::uncertainty::LOCK.contains(line);
    lines.iter().chain(of_runs).filter(is_shown).find(|(_, metric, _)| study.metrics.find(metric).is_some()).copied()
}

/// Describes in one line how the study was run.
pub fn manner(study: &Study) -> String {
    match &study.outcome {
        Outcome::Driven(run) => driven::manner(run),
        Outcome::Contact(solved) => contact::table::manner(solved),
        Outcome::Design(drawn) => design::table::manner(drawn),
        Outcome::MonteCarlo(runs) => monte_carlo::table::manner(runs),
    }
}

/// Returns the reached and the full duration, or number of runs, in words.
pub fn reached(study: &Study) -> String {
    let reached_s = match &study.outcome {
        Outcome::Driven(run) => driven::reached_s(run),
        Outcome::Contact(solved) => contact::table::reached_s(solved),
        Outcome::Design(_) => return String::new(),
        Outcome::MonteCarlo(runs) => return monte_carlo::table::reached(runs),
    };
    format!("{} s of {} s", number(reached_s), study.scene.duration_s)
}

/// Returns the modes of the controller with their times.
pub fn modes(study: &Study) -> Option<String> {
    study.run().map(driven::modes)
}

/// Returns the level at which the controller ran, which determines the meaning of the result.
pub fn level(study: &Study) -> String {
    match &study.outcome {
        Outcome::Driven(run) => run.level.to_string(),
        Outcome::MonteCarlo(runs) if study.scene.controller.is_some() => runs.level.to_string(),
        Outcome::Contact(_) => contact::table::LEVEL.to_owned(),
        Outcome::Design(_) => design::table::LEVEL.to_owned(),
        Outcome::MonteCarlo(_) if study.scene.design.is_some() => design::table::LEVEL.to_owned(),
        Outcome::MonteCarlo(_) => contact::table::LEVEL.to_owned(),
    }
}

fn footer(study: &Study, provenance: &Provenance) -> Vec<(String, String)> {
    let own = match &study.outcome {
        Outcome::Driven(run) => driven::footer(run),
        Outcome::Contact(solved) => contact::table::footer(solved),
        Outcome::Design(_) => design::table::footer(),
        Outcome::MonteCarlo(runs) => monte_carlo::table::footer(runs),
    };
    let all = [("scene", study.name.clone()), ("seed", study.scene.seed.to_string())];
    let named = all.into_iter().chain(own).map(|(label, value)| (label.to_owned(), value));
    named.chain(provenance.footer()).collect()
}

fn expectations(study: &Study) -> TableBlock {
    let rows = study
        .judged
        .iter()
        .map(|judged| {
            let fine = judged.tolerance.zip(judged.value).is_some_and(|(tolerance, value)| tolerance < 1e-4 * value.abs());
            let shown = if fine { precise } else { number };
            let value = judged.value.map_or_else(|| "no such value in this run".to_owned(), shown);
            let verdict = match (judged.counts, judged.pass) {
                (true, true) => "PASS",
                (true, false) => "MISS",
                (false, true) => "holds",
                (false, false) => "does not hold",
            };
            let metric = match &judged.case {
                Some((case, equal)) => format!("{} ({case}, equal {})", judged.metric, equal.name()),
                None => judged.metric.clone(),
            };
            vec![verdict.into(), metric, value, judged.limit.clone(), judged.source.clone()]
        })
        .collect();
    let base = study.inherited.as_ref().filter(|_| study.judged.iter().any(|judged| !judged.counts));
    let caption = base.map_or_else(String::new, |inherited| {
        format!(
            "Expectations of the base scene `{}` do not count, because its inputs were changed. Expectations of this scene do \
             (`[[expect]]`, or `expect = []` for none).",
            inherited.base
        )
    });
    TableBlock::new("expectations", "Expected", &caption, &["", "metric", "value", "expected", "source"], rows)
}

/// Returns the headline of a study as one line.
pub fn headline_line(study: &Study) -> String {
    headline(study).iter().map(|(label, value)| format!("{label} {value}")).collect::<Vec<_>>().join(" | ")
}

/// Returns only the result of a study: the headline, the number of expectations that hold, and
/// those that do not.
pub fn in_short(study: &Study) -> String {
    let mut text = if study.interrupted { format!("INTERRUPTED after {}\n", reached(study)) } else { String::new() };
    text += &format!("{}\n", headline_line(study));
    let counted: Vec<_> = study.judged.iter().filter(|judged| judged.counts).collect();
    if !counted.is_empty() {
        let holding = counted.iter().filter(|judged| judged.pass).count();
        text += &format!("{holding} of {} expectations hold\n", counted.len());
    }
    for judged in counted.iter().filter(|judged| !judged.pass) {
        let value = judged.value.map_or_else(|| "no such value".to_owned(), number);
        text += &format!("MISS {}: {value}, expected {}\n", judged.metric, judged.limit);
    }
    text
}

/// Returns a table of every metric of a study.
pub fn all_metrics(study: &Study) -> TableBlock {
    let row =
        |(name, value): (&str, f64)| vec![name.to_owned(), shown(study, name, value) + mark_of(study, name), described(name).0];
    TableBlock::new("metrics", "All metrics", "", &["metric", "value", "unit"], study.metrics.iter().map(row).collect())
}

/// Returns a table of every metric of a study, with its meaning.
fn dictionary(study: &Study) -> TableBlock {
    let row = |(name, value): (&str, f64)| {
        let (unit, meaning) = described(name);
        vec![name.to_owned(), shown(study, name, value) + mark_of(study, name), unit, meaning]
    };
    let header = ["metric", "value", "unit", "meaning"];
    TableBlock::new("metrics", "All metrics", "", &header, study.metrics.iter().map(row).collect())
}

/// Formats a metric: to the digits of its standard deviation if the study has that metric too
/// (`q_sd`, `c0_sd_f`), else with four.
fn shown(study: &Study, name: &str, value: f64) -> String {
    let deviation = match name.rsplit_once('_') {
        Some((quantity, unit)) if metrics::metric(&format!("{quantity}_sd_{unit}")).is_some() => format!("{quantity}_sd_{unit}"),
        _ => format!("{name}_sd"),
    };
    study.metrics.get(&deviation).map_or_else(|| number(value), |sd| rounded_to(value, sd))
}

/// Returns unit and meaning of a metric.
fn described(name: &str) -> (String, String) {
    let known = metrics::metric(name).or_else(|| metrics::of_one_run(name));
    known.map_or_else(Default::default, |metric| (metric.unit.to_owned(), metric.meaning.to_owned()))
}
