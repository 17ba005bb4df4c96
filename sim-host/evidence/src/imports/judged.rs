//! An imported file compared with its truth, and the result of a damaged file.

use std::panic::catch_unwind;

use import::admittance::measured::Measured;
use import::admittance::{Value, fit};
use import::error::ImportError;
use import::synthetic::{Example, Kind, NAMES, mutated};
use report::statistics::{ascending, quantile};

use crate::campaign::worst;

/// Largest number of points of a file that is damaged, so that many can be tried in little time.
const FEW_POINTS: usize = 201;
/// Number of examples that are damaged in turn.
const DAMAGED_EXAMPLES: u64 = 300;

/// A number of a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Number {
    /// Value less truth, over the stated standard deviation.
    pub(super) deviations: f64,
    /// Stated standard deviation over its bound.
    pub(super) over_bound: f64,
}

/// An imported file.
#[derive(Clone, Debug)]
pub(super) struct Judged {
    /// Number of the example.
    pub(super) number: u64,
    /// Form, noise and fixture of the file.
    pub(super) kind: Kind,
    /// Number of points of the sweep.
    pub(super) points: usize,
    /// Numbers of true resonances, and of those found.
    pub(super) modes: (usize, usize),
    /// Numbers in the order of [`NAMES`]; `None` if the file was refused.
    pub(super) numbers: Option<[Number; 8]>,
    /// Reason of a refusal.
    pub(super) refused: Option<String>,
}

/// Imports an example, and compares it with its truth.
pub(super) fn judge(number: u64) -> Judged {
    let example = Example::draw(number);
    let (kind, points, truths) = (example.kind, example.hz.len(), example.truth.branches.len());
    let of = |modes: usize, numbers, refused| Judged { number, kind, points, modes: (truths, modes), numbers, refused };
    let bounds = example.bounds();
    match (example.import(), bounds) {
        (Ok(found), Some(bounds)) => {
            let c = &found.circuit;
            let values: [Value; 8] =
                [c.series_resonance_hz, c.parallel_resonance_hz, c.q, c.rm_ohm, c.lm_h, c.cm_f, c.c0_f, c.coupling];
            let truth = example.true_values();
            let number = |at: usize| Number {
                deviations: (values[at].value - truth[at]) / values[at].sd,
                over_bound: values[at].sd / bounds[at],
            };
            of(found.modes.len(), Some(std::array::from_fn(number)), None)
        }
        (Ok(_), None) => of(0, None, Some("the example has no bound".into())),
        (Err(error), _) => of(0, None, Some(error.to_string())),
    }
}

/// Coverage and efficiency of a number over many files.
pub(super) struct Statistics {
    /// Name of the number.
    pub(super) name: String,
    /// Fraction of the truths within two standard deviations.
    pub(super) within: f64,
    /// Median ratio of the stated standard deviations to their bounds.
    pub(super) median: f64,
    /// 95th percentile of this ratio.
    pub(super) p95: f64,
    /// Root mean square of the errors over the stated standard deviations.
    pub(super) rms: f64,
    /// Largest error over its stated standard deviation.
    pub(super) worst: f64,
}

impl Statistics {
    /// Computes the statistics of some numbers.
    pub(super) fn new(name: &str, numbers: &[Number]) -> Self {
        let count = numbers.len().max(1) as f64;
        let ratios = ascending(numbers.iter().map(|number| number.over_bound));
        let part = |part: f64| quantile(&ratios, part).unwrap_or(f64::NAN);
        Statistics {
            name: name.to_owned(),
            within: numbers.iter().filter(|number| number.deviations.abs() <= 2.0).count() as f64 / count,
            median: part(0.5),
            p95: part(0.95),
            rms: (numbers.iter().map(|number| number.deviations.powi(2)).sum::<f64>() / count).sqrt(),
            worst: worst(numbers.iter().map(|number| number.deviations.abs())),
        }
    }
}

/// Computes the statistics of each number over the files that were not refused.
pub(super) fn statistics<'a>(set: impl IntoIterator<Item = &'a Judged> + Clone) -> Vec<Statistics> {
    let of = |(at, name): (usize, &&'static str)| {
        let numbers = set.clone().into_iter().filter_map(|judged| judged.numbers.map(|numbers| numbers[at]));
        Statistics::new(name, &numbers.collect::<Vec<_>>())
    };
    NAMES.iter().enumerate().map(of).collect()
}

/// Result of a damaged file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ImportResult {
    /// A circuit, for example if the damage does not matter.
    Taken,
    /// A refusal with this reason.
    Refused(&'static str),
    /// A panic.
    Panic,
}

/// A damaged file.
pub(super) struct Damaged {
    /// Number of the damage.
    pub(super) number: u64,
    /// Result of the import.
    pub(super) end: ImportResult,
}

/// Damages an example, and imports it.
pub(super) fn damaged(number: u64) -> Damaged {
    let first = (number % DAMAGED_EXAMPLES) * 7;
    let small = (first..).map(Example::draw).find(|example| example.hz.len() <= FEW_POINTS);
    let Some(example) = small else { return Damaged { number, end: ImportResult::Taken } };
    let bytes = mutated(&example.bytes, number);
    let tried =
        catch_unwind(|| Measured::parse(&example.name, &bytes, &example.options).and_then(|sweep| fit("damaged", sweep, None)));
    let end = match tried {
        Ok(Ok(_)) => ImportResult::Taken,
        Ok(Err(error)) => ImportResult::Refused(short_reason(&error)),
        Err(_) => ImportResult::Panic,
    };
    Damaged { number, end }
}

/// Returns the short reason of a refusal.
fn short_reason(error: &ImportError) -> &'static str {
    match error {
        ImportError::InFile { source, .. } => short_reason(source),
        ImportError::Unreadable { .. } => "cannot be read",
        ImportError::UnknownForm { .. } => "unknown form",
        ImportError::BadLine { .. } => "a line cannot be used",
        ImportError::SameQuantity { .. } => "two columns of one quantity",
        ImportError::UnitMissing { .. } => "unit missing",
        ImportError::UnitUnknown { .. } => "unit unknown",
        ImportError::AngleDoubtful { .. } => "degrees or radians doubtful",
        ImportError::FrequenciesEqual { .. } => "neighbouring frequencies equal",
        ImportError::FrequenciesUnordered { .. } => "frequencies not in order",
        ImportError::TooFewPoints { .. } => "too few points",
        ImportError::NoResonance { .. } => "no resonance in the range",
        ImportError::TopologyDoubtful { .. } => "connection doubtful",
        ImportError::Fixture(_) => "fixture cannot be corrected",
        ImportError::NoSuchMode(_) => "no such mode",
        ImportError::NotATransducer(_) => "not a transducer",
        ImportError::NoFit(_) => "no fit",
    }
}
