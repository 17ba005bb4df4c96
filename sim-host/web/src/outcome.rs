//! Result of a run, as shown by the page.

use report::TableBlock;
use serde_json::{Value, json};
use sim::provenance::Provenance;
use sim::study::{Outcome, Study};
use sim::{summary, tables};

use crate::figures;
use crate::motor::Motor;
use crate::scope::Scope;

/// Returns everything that the page shows of a study.
pub(crate) fn to_json(study: &Study) -> Value {
    let report = tables::report(study, &Provenance::default());
    let (scope, motor) = match &study.outcome {
        Outcome::Driven(run) => (Some(Scope::driven(run)), Motor::from_run(run)),
        Outcome::Contact(solved) => (Some(Scope::contact(solved)), None),
        Outcome::Design(_) | Outcome::MonteCarlo(_) => (None, None),
    };
    let machine = summary::machine(study);
    json!({
        "title": report.title,
        "subtitle": report.subtitle,
        "level": tables::level(study),
        "drive_hash": summary::summary(study)["drive_hash"],
        "passes": study.passes(),
        "expectations": study.judged.len(),
        "headline": report.summary,
        "main": tables::main_metric(study),
        "fault": crate::curve::fault(study),
        "paragraphs": report.paragraphs,
        "tables": report.tables.iter().map(table).collect::<Vec<_>>(),
        "appendix": report.appendix.iter().map(table).collect::<Vec<_>>(),
        "figures": report.figures.iter().map(figures::figure).collect::<Vec<_>>(),
        "metrics": study.metrics.iter().collect::<std::collections::BTreeMap<_, _>>(),
        "scope": scope,
        "motor": motor,
        "crash": report.crash,
        "wall_s": machine["wall_s"],
        "simulated_s_per_wall_s": machine["simulated_s_per_wall_s"],
    })
}

pub(crate) fn table(block: &TableBlock) -> Value {
    json!({ "id": block.id, "title": block.title, "caption": block.caption, "header": block.header, "rows": block.rows })
}
