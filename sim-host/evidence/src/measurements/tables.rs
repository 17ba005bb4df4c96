//! The tables of the bench.

use super::Judged;
use super::data::{Datum, Law, Source};
use super::judged::Verdict;
use super::laws::{Row, holds};
use report::{TableBlock, verdict};

/// Predictions beside the numbers and sentences that they are held against, in the order of the sources.
pub fn predictions(judged: &[Judged]) -> TableBlock {
    let row = |judged: &Judged| {
        let Judged { source, datum, prediction, verdict } = judged;
        vec![
            source.name.into(),
            datum.says.clone(),
            datum.conditions.clone(),
            datum.kind.word().into(),
            datum.number(),
            prediction.model.clone(),
            prediction.fitted(),
            prediction.shown(datum),
            prediction.deviation(datum).map_or("–".into(), |off| format!("{off:+.2}")),
            verdict.word().into(),
        ]
    };
    let caption = "No source states an uncertainty. Rounding: half of the last digit printed. ASSUMED: what an experiment of this kind can show, \
                   as `evidence thesis` takes it. FITTED: a parameter was fitted to this datum itself, so that agreement confirms nothing; a datum \
                   named as fitted in another row leaves this one a prediction. MISS: not within the uncertainty, or the sentence does not hold.";
    TableBlock::new(
        "predictions",
        "Predictions against measurements",
        caption,
        &[
            "source",
            "stated",
            "conditions",
            "kind",
            "number",
            "model and parameters",
            "fitted to",
            "model says",
            "deviation",
            "verdict",
        ],
        judged.iter().map(row).collect(),
    )
}

/// Where a model fails, and which experiment would decide.
pub fn fails(judged: &[Judged]) -> TableBlock {
    let row = |judged: &Judged| {
        let Judged { source, datum, prediction, .. } = judged;
        let decides = datum.decides.clone().unwrap_or_else(|| "–".into());
        vec![prediction.model.clone(), format!("{}: {}", source.name, datum.says), prediction.shown(datum), decides]
    };
    let missed = judged.iter().filter(|judged| judged.verdict == Verdict::Misses);
    TableBlock::new(
        "fails",
        "Where a model fails",
        "Every MISS of the table above.",
        &["model", "against", "it says", "what would decide"],
        missed.map(row).collect(),
    )
}

/// Predictions of numbers that were not at hand, and what depends on a parameter that is unknown.
pub fn open(judged: &[Judged]) -> TableBlock {
    let row = |judged: &Judged| {
        let Judged { datum, prediction, verdict, .. } = judged;
        let decides = datum.decides.clone().unwrap_or_else(|| "–".into());
        let stated = format!("{} ({})", datum.says, datum.conditions);
        vec![stated, prediction.model.clone(), prediction.shown(datum), verdict.word().into(), decides]
    };
    let open = judged.iter().filter(|judged| matches!(judged.verdict, Verdict::Open | Verdict::Undetermined));
    TableBlock::new(
        "open",
        "Open predictions",
        "Published before the number is read: whoever has it can decide between the models.",
        &["datum", "model", "it says", "", "what would decide"],
        open.map(row).collect(),
    )
}

/// Data that no model can be held against.
pub fn not_comparable(sources: &[Source]) -> TableBlock {
    let row = |(source, datum): (&Source, &Datum)| {
        let why = datum.not_comparable.clone()?;
        let stated = if datum.value.is_some() { format!("{}: {}", datum.says, datum.number()) } else { datum.says.clone() };
        Some(vec![source.name.into(), datum.kind.word().into(), stated, datum.conditions.clone(), why])
    };
    let all = sources.iter().flat_map(|source| source.data.iter().map(move |datum| (source, datum)));
    TableBlock::new(
        "not-comparable",
        "Not comparable",
        "Published data that no model here can be held against, and why.",
        &["source", "kind", "stated", "conditions", "why not"],
        all.filter_map(row).collect(),
    )
}

/// Laws apart from measurements.
pub fn laws(laws: &[(Law, Vec<Row>)]) -> TableBlock {
    let of = |(law, rows): &(Law, Vec<Row>)| {
        let word = if law.outside.is_some() { "not claimed there" } else { verdict(holds(law, rows)) };
        let row = |row: &Row| {
            let models = row.models.iter().map(|(name, value)| format!("{name}: {value:.10}")).collect::<Vec<_>>().join("; ");
            vec![
                law.says.clone(),
                row.at.to_string(),
                row.checked.map_or("–".into(), |checked| format!("{checked:.4}")),
                format!("{:.10}", row.formula),
                models,
                format!("{:.1e}", row.off()),
                format!("{:.1e}", law.tolerance),
                word.to_owned(),
            ]
        };
        rows.iter().map(row).collect::<Vec<_>>()
    };
    let conditions = laws.iter().map(|(law, _)| {
        let outside = law.outside.as_ref().map(|outside| format!("; {outside}")).unwrap_or_default();
        format!("{}: {}; {} ({}){outside}.", law.id, law.conditions, law.cite, law.kind)
    });
    let caption = format!("Checked: computed elsewhere, to four digits. {}", conditions.collect::<Vec<_>>().join(" "));
    TableBlock::new(
        "laws",
        "Laws",
        caption,
        &["law", "at", "checked", "formula", "models", "off", "allowed", ""],
        laws.iter().flat_map(of).collect(),
    )
}

/// The sources, with what of each was read.
pub fn sources(sources: &[Source]) -> TableBlock {
    let row = |source: &Source| {
        vec![source.name.into(), source.cite.clone(), source.doi.clone().unwrap_or_else(|| "–".into()), source.read.clone()]
    };
    TableBlock::new(
        "sources",
        "Sources",
        "The data are in `sim-host/evidence/measurements`, one file for each source.",
        &["file", "publication", "DOI", "what was read"],
        sources.iter().map(row).collect(),
    )
}
