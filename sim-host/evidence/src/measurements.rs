//! Published measurements compared with the predictions of the models.
//!
//! ```text
//! measurements/*.toml --> data (number, words, abstract; kind, unit, uncertainty) --+--> verdicts --> tables, figures, measurements.csv
//! scenes and contacts, parameters fixed beforehand --> predictions -----------------+
//! laws.toml --> formulas --> compared with the models that should obey them
//! ```
//!
//! Verdicts are computed, never entered by hand: [`judged`] derives each from a number, its
//! uncertainty and the data that the model was fitted to. Each parameter that was fitted to a datum
//! is named, and agreement with that datum is not counted.

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
use crate::campaign::{self, cells};
use crate::evidence::{Error, Evidence, Options};
use report::Report;

/// A prediction with its datum and its verdict.
#[derive(Clone, Debug)]
struct JudgedPrediction {
    source: Source,
    datum: Datum,
    prediction: Prediction,
    verdict: Verdict,
}

/// All results of the bench.
struct Findings {
    sources: Vec<Source>,
    judged: Vec<JudgedPrediction>,
    laws: Vec<(Law, Vec<laws::Row>)>,
    rail: Rail,
    crashes: Vec<belt_speed::CrashAtRing>,
}

fn compute(progress: &mut dyn FnMut(&str)) -> Result<Findings, Error> {
    let sources = data::sources().map_err(|error| Error::Data(error.to_string()))?;
    progress("experiment 1, as in its scenes");
    let rail = Rail::run()?;
    progress("experiment 2, as in its scene, and other laws");
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

/// Returns the verdicts in the order of the data.
fn judge(sources: &[Source], predictions: &[Prediction]) -> Result<Vec<JudgedPrediction>, Error> {
    let data: Vec<(&Source, &Datum)> =
        sources.iter().flat_map(|source| source.data.iter().map(move |datum| (source, datum))).collect();
    if let Some(lost) = predictions.iter().find(|prediction| data.iter().all(|(_, datum)| datum.id != prediction.datum)) {
        return Err(Error::Data(format!("there is no datum {:?}", lost.datum)));
    }
    let of = |(source, datum): &(&Source, &Datum)| {
        let own = predictions.iter().filter(|prediction| prediction.datum == datum.id);
        let judged = own.map(|prediction| JudgedPrediction {
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
            let JudgedPrediction { source, datum, prediction, .. } = judged;
            format!(
                "{} of {}: {} predicts {}; stated: {} ({})",
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
        let number = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
        let rows = self.judged.iter().map(|JudgedPrediction { source, datum, prediction, verdict }| {
            let (doi, unit) = (source.doi.clone().unwrap_or_default(), datum.unit.clone().unwrap_or_default());
            let [value, uncertainty, off] = [datum.value, datum.uncertainty, prediction.deviation(datum)].map(number);
            let (model, fitted, shown) = (&prediction.model, prediction.fitted(), prediction.shown(datum));
            let (kind, verdict) = (datum.kind.word(), verdict.word());
            cells![source.name, doi, datum.id, kind, value, uncertainty, unit, model, fitted, shown, off, verdict]
        });
        campaign::csv("source,doi,datum,kind,value,uncertainty,unit,model,fitted_to,predicted,deviation,verdict", rows)
    }
}

/// Computes predictions, laws and the failures of the models.
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
    let title = "Published measurements and the predictions of the models";
    let subtitle = "All model results are simulated; all measurements are by others";
    let files = vec![("measurements.csv", found.csv()?)];
    let evidence = campaign::evidence(title, subtitle, tables, files, found.missed());
    let footer = vec![("command".into(), "evidence measurements".into())];
    Ok(Evidence { report: Report { summary, figures: figures::all(&found), footer, ..evidence.report }, ..evidence })
}
