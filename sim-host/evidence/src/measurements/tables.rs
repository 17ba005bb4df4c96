//! Tables of the bench.

use super::JudgedPrediction;
use super::data::{Datum, Law, Source};
use super::judged::Verdict;
use super::laws::{Row, holds};
use crate::campaign::{cells, columns, or_dash};
use report::{TableBlock, verdict};

/// Tabulates predictions with their numbers and sentences, in the order of the sources.
pub fn predictions(judged: &[JudgedPrediction]) -> TableBlock {
    let row = |judged: &JudgedPrediction| {
        let JudgedPrediction { source, datum, prediction, verdict } = judged;
        vec![
            source.name.into(),
            datum.says.clone(),
            datum.conditions.clone(),
            datum.kind.word().into(),
            datum.number(),
            prediction.model.clone(),
            prediction.fitted(),
            prediction.shown(datum),
            or_dash(prediction.deviation(datum), |off| format!("{off:+.2}")),
            verdict.word().into(),
        ]
    };
    let caption = "No source states an uncertainty. Rounding: half of the last printed digit. ASSUMED: the resolution of \
                   such an experiment, as in `evidence thesis`. FITTED: a parameter was fitted to this datum, so agreement \
                   confirms nothing. If only another datum is named as fitted, the row remains a prediction. MISS: outside \
                   the uncertainty, or the sentence does not hold.";
    let header = columns(
        "source | stated | conditions | kind | number | model and parameters | fitted to | model result | deviation | verdict",
    );
    let rows = judged.iter().map(row).collect();
    TableBlock::new("predictions", "Predictions against measurements", caption, &header, rows)
}

/// Tabulates the failures of the models and the experiments that would decide.
pub fn fails(judged: &[JudgedPrediction]) -> TableBlock {
    let row = |judged: &JudgedPrediction| {
        let JudgedPrediction { source, datum, prediction, .. } = judged;
        let decides = datum.decides.clone().unwrap_or_else(|| "–".into());
        vec![prediction.model.clone(), format!("{}: {}", source.name, datum.says), prediction.shown(datum), decides]
    };
    let missed = judged.iter().filter(|judged| judged.verdict == Verdict::Misses);
    TableBlock::new(
        "fails",
        "Failures of the models",
        "Every MISS of the table above.",
        &["model", "against", "model result", "deciding experiment"],
        missed.map(row).collect(),
    )
}

/// Tabulates predictions of numbers that were not available, and results that depend on an unknown
/// parameter.
pub fn open(judged: &[JudgedPrediction]) -> TableBlock {
    let row = |judged: &JudgedPrediction| {
        let JudgedPrediction { datum, prediction, verdict, .. } = judged;
        let decides = datum.decides.clone().unwrap_or_else(|| "–".into());
        let stated = format!("{} ({})", datum.says, datum.conditions);
        vec![stated, prediction.model.clone(), prediction.shown(datum), verdict.word().into(), decides]
    };
    let open = judged.iter().filter(|judged| matches!(judged.verdict, Verdict::Open | Verdict::Undetermined));
    TableBlock::new(
        "open",
        "Open predictions",
        "Published before the number was read: anyone who has the number can decide between the models.",
        &["datum", "model", "model result", "", "deciding experiment"],
        open.map(row).collect(),
    )
}

/// Tabulates the data that no model can be compared with.
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
        "Published data with which no model here can be compared, and the reasons.",
        &["source", "kind", "stated", "conditions", "reason"],
        all.filter_map(row).collect(),
    )
}

/// Tabulates the laws, separately from measurements.
pub fn laws(laws: &[(Law, Vec<Row>)]) -> TableBlock {
    let of = |(law, rows): &(Law, Vec<Row>)| {
        let word = if law.outside.is_some() { "not claimed there" } else { verdict(holds(law, rows)) };
        let row = |row: &Row| {
            let models = row.models.iter().map(|(name, value)| format!("{name}: {value:.10}")).collect::<Vec<_>>().join("; ");
            let checked = or_dash(row.checked, |checked| format!("{checked:.4}"));
            let [off, tolerance] = [row.off(), law.tolerance].map(|off| format!("{off:.1e}"));
            cells![law.says, row.at, checked, format!("{:.10}", row.formula), models, off, tolerance, word]
        };
        rows.iter().map(row).collect::<Vec<_>>()
    };
    let conditions = laws.iter().map(|(law, _)| {
        let outside = law.outside.as_ref().map(|outside| format!("; {outside}")).unwrap_or_default();
        format!("{}: {}; {} ({}){outside}.", law.id, law.conditions, law.cite, law.kind)
    });
    let caption = format!("Checked: computed elsewhere, to four digits. {}", conditions.collect::<Vec<_>>().join(" "));
    let header = columns("law | at | checked | formula | models | deviation | allowed | ");
    TableBlock::new("laws", "Laws", caption, &header, laws.iter().flat_map(of).collect())
}

/// Tabulates the sources with the parts of each that were read.
pub fn sources(sources: &[Source]) -> TableBlock {
    let row = |source: &Source| {
        vec![source.name.into(), source.cite.clone(), source.doi.clone().unwrap_or_else(|| "–".into()), source.read.clone()]
    };
    TableBlock::new(
        "sources",
        "Sources",
        "The data are in `sim-host/evidence/measurements`, one file for each source.",
        &["file", "publication", "DOI", "parts read"],
        sources.iter().map(row).collect(),
    )
}
