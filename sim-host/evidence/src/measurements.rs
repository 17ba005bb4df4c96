//! Published measurements, and what the models here predict of them.
//!
//! ```text
//! measurements/*.toml --> data (number, words, abstract; kind, unit, uncertainty) --+--> verdicts --> tables, figures, measurements.csv
//! scenes and contacts, parameters fixed beforehand --> predictions -----------------+
//! laws.toml --> formulas --> beside the models that should have them
//! ```
//!
//! No verdict is written down: [`judged`] tells how it follows from a number, its uncertainty and what was fitted to what. A parameter that
//! was fitted to a datum is named, and agreement with that datum is not counted.

mod across;
mod along;
mod belt;
mod belt_speed;
mod data;
mod figures;
mod judged;
mod laws;
mod tables;

#[cfg(test)]
mod tests;

use self::along::Rail;
use self::data::{Datum, Law, Source};
use self::judged::{Prediction, Verdict};
use crate::evidence::{Error, Evidence, Options};
use report::Report;

/// A prediction with its datum and its verdict.
#[derive(Clone, Debug)]
struct Judged {
    source: Source,
    datum: Datum,
    prediction: Prediction,
    verdict: Verdict,
}

/// Everything that was found.
struct Findings {
    sources: Vec<Source>,
    judged: Vec<Judged>,
    laws: Vec<(Law, Vec<laws::Row>)>,
    rail: Rail,
    crashes: Vec<belt_speed::AtRing>,
}

fn compute(progress: &mut dyn FnMut(&str)) -> Result<Findings, Error> {
    let sources = data::sources().map_err(|error| Error::Data(error.to_string()))?;
    progress("experiment 1 as its scenes run it");
    let rail = Rail::run()?;
    progress("experiment 2 as its scene runs it, and other laws");
    let belt = belt::predictions()?;
    progress("pin, Hertz's contact, tip");
    let data: Vec<Datum> = sources.iter().flat_map(|source| source.data.clone()).collect();
    let predictions = [along::predictions(&rail), belt, across::pin(&data), across::hertz(), across::tip()].concat();
    progress("laws");
    let laws = data::laws().map_err(|error| Error::Data(error.to_string()))?;
    let laws = laws.into_iter().map(|law| Ok((law.clone(), laws::rows(&law)?))).collect::<Result<_, Error>>()?;
    progress("crashes: heat and air at the D-ring");
    let crashes = belt_speed::all()?;
    Ok(Findings { judged: judge(&sources, &predictions)?, sources, laws, rail, crashes })
}

/// Verdicts in the order of the data.
fn judge(sources: &[Source], predictions: &[Prediction]) -> Result<Vec<Judged>, Error> {
    let data: Vec<(&Source, &Datum)> =
        sources.iter().flat_map(|source| source.data.iter().map(move |datum| (source, datum))).collect();
    if let Some(lost) = predictions.iter().find(|prediction| data.iter().all(|(_, datum)| datum.id != prediction.datum)) {
        return Err(Error::Data(format!("there is no datum {:?}", lost.datum)));
    }
    let of = |(source, datum): &(&Source, &Datum)| {
        let own = predictions.iter().filter(|prediction| prediction.datum == datum.id);
        let judged = own.map(|prediction| Judged {
            source: (*source).clone(),
            datum: (*datum).clone(),
            verdict: prediction.verdict(datum),
            prediction: prediction.clone(),
        });
        judged.collect::<Vec<_>>()
    };
    Ok(data.iter().flat_map(of).collect())
}

impl Findings {
    fn missed(&self) -> Vec<String> {
        let predictions = self.judged.iter().filter(|judged| judged.verdict == Verdict::Misses).map(|judged| {
            let Judged { source, datum, prediction, .. } = judged;
            format!(
                "{} of {}: {} says {}; stated: {} ({})",
                datum.id,
                source.name,
                prediction.model,
                prediction.shown(datum),
                datum.says,
                datum.number()
            )
        });
        let laws = self.laws.iter().filter(|(law, rows)| law.outside.is_none() && !laws::holds(law, rows));
        predictions.chain(laws.map(|(law, _)| format!("law {}: {}", law.id, law.says))).collect()
    }

    fn count(&self, verdict: Verdict) -> usize {
        self.judged.iter().filter(|judged| judged.verdict == verdict).count()
    }

    fn csv(&self) -> Result<String, Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record([
            "source",
            "doi",
            "datum",
            "kind",
            "value",
            "uncertainty",
            "unit",
            "model",
            "fitted_to",
            "predicted",
            "deviation",
            "verdict",
        ])?;
        let number = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
        for Judged { source, datum, prediction, verdict } in &self.judged {
            writer.write_record([
                source.name.to_owned(),
                source.doi.clone().unwrap_or_default(),
                datum.id.clone(),
                datum.kind.word().into(),
                number(datum.value),
                number(datum.uncertainty),
                datum.unit.clone().unwrap_or_default(),
                prediction.model.clone(),
                prediction.fitted(),
                prediction.shown(datum),
                number(prediction.deviation(datum)),
                verdict.word().into(),
            ])?;
        }
        let bytes = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }
}

/// Predictions, laws, and where the models fail.
pub(crate) fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let found = compute(options.progress)?;
    let tables = vec![
        tables::predictions(&found.judged),
        tables::fails(&found.judged),
        tables::open(&found.judged),
        tables::laws(&found.laws),
        belt_speed::table(&found.crashes),
        tables::not_comparable(&found.sources),
        tables::sources(&found.sources),
    ];
    let all = found.judged.len();
    let summary = [Verdict::Agrees, Verdict::Fitted, Verdict::Misses, Verdict::Open, Verdict::Undetermined];
    let summary = summary.map(|verdict| (verdict.word().to_owned(), format!("{} of {all}", found.count(verdict)))).to_vec();
    Ok(Evidence {
        report: Report {
            title: "Published measurements, and what the models predict of them".into(),
            subtitle: "Everything on the model's side is simulated; what is measured was measured by others".into(),
            summary,
            tables: tables.clone(),
            figures: figures::all(&found),
            footer: vec![("command".into(), "evidence measurements".into())],
            ..Report::default()
        },
        docs: tables,
        files: vec![("measurements.csv", found.csv()?)],
        missed: found.missed(),
        ..Evidence::default()
    })
}
