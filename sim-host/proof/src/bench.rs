//! The benches: what each measures, held against its targets. Built-in suites and code give the same [`Evidence`].

use std::path::Path;

use serde_json::{Map, Value, json};

use crate::{crash, friction, guard, instructions, precision, thesis};
use report::{Report, TableBlock};
use scene::load::LoadError;
use scene::suite::{self, LoadedSuite};
use sim::study::StudyError;
use sim::study::suite::{Judged, SuiteResult};

/// A bench.
pub struct Bench {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it does, in one line.
    pub about: &'static str,
    /// Whether it has a quick variant.
    pub has_quick: bool,
    /// The text of its suite, if it is one.
    pub suite: Option<&'static str>,
    /// Runs it.
    pub run: fn(&mut Options) -> Result<Evidence, Error>,
}

/// All benches, in the order in which they run.
pub const BENCHES: [Bench; 7] = [
    Bench {
        name: "tracking",
        about: "every tracking case over many seeds, against targets, Cramer-Rao bounds and the numbers of its faults",
        has_quick: true,
        suite: Some(include_str!("../suites/tracking.toml")),
        run: |options| built_in("tracking", options, |_, _| Ok(())),
    },
    Bench {
        name: "friction",
        about: "friction ratios over contacts, by amplitude and by bursts, set point against result",
        has_quick: true,
        suite: Some(include_str!("../suites/friction.toml")),
        run: friction::run,
    },
    Bench {
        name: "guard",
        about: "a belt that stops or slows, or whose encoder fails, a thousand times each, against the weld guard",
        has_quick: true,
        suite: None,
        run: guard::evidence,
    },
    Bench {
        name: "crash",
        about: "light, medium and heavy occupants with the D-ring's friction switched, against the passive belt",
        has_quick: true,
        suite: Some(include_str!("../suites/crash.toml")),
        run: crash::run,
    },
    Bench {
        name: "precision",
        about: "speed against error of every contact method, the claims, and the hard cases",
        has_quick: true,
        suite: None,
        run: precision::evidence,
    },
    Bench {
        name: "instructions",
        about: "instructions of the controller on an emulated Cortex-M4F, against the budget",
        has_quick: false,
        suite: None,
        run: instructions::evidence,
    },
    Bench {
        name: "thesis",
        about: "every figure, claim and contradiction of the thesis's chapters 3, 4 and appendix B",
        has_quick: false,
        suite: None,
        run: thesis::evidence,
    },
];

/// What a bench is given from outside.
pub struct Options<'a> {
    /// Fewer runs and cases.
    pub quick: bool,
    /// The program to count instructions of, and the options that make it run one method alone (`precision`).
    pub counted: Option<(&'a Path, &'a [&'a str])>,
    /// Called with what comes next.
    pub progress: &'a mut (dyn FnMut(&str) + Send),
}

/// What a bench has found.
#[derive(Default)]
pub struct Evidence {
    /// The page: tables and figures.
    pub report: Report,
    /// The tables of the terminal, if they are others than those of the page.
    pub printed: Option<Vec<TableBlock>>,
    /// The tables of the documentation.
    pub docs: Vec<TableBlock>,
    /// The result for programs, if it is more than the tables.
    pub summary: Value,
    /// Further files of its folder: name and text.
    pub files: Vec<(&'static str, String)>,
    /// The targets that are missed.
    pub missed: Vec<String>,
}

/// Why a bench has no result.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene or a suite is not valid.
    #[error(transparent)]
    Scene(#[from] LoadError),
    /// A case has no result.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A contact study has no answer.
    #[error(transparent)]
    Contact(#[from] contact::SolveError),
    /// The reference of the methods is not to be trusted.
    #[error(transparent)]
    Reference(#[from] precision::reference::NoReference),
    /// The firmware refuses a case.
    #[error("the firmware refuses a case: {0}")]
    Config(#[from] firmware::seam::error::Error),
    /// The image of the emulator could not be built or run.
    #[error(transparent)]
    Pil(#[from] pil::PilError),
    /// The image did not come to its end, or printed something else than counts.
    #[error("the image gives no counts: {0}")]
    Counts(String),
    /// A table of numbers cannot be written.
    #[error(transparent)]
    Csv(#[from] csv::Error),
}

impl Evidence {
    /// The result for programs.
    pub fn json(&self) -> Value {
        let table = |table: &TableBlock| json!({ "title": table.title, "header": table.header, "rows": table.rows });
        let tables: Vec<Value> = self.report.tables.iter().map(table).collect();
        match &self.summary {
            Value::Null => {
                json!({ "title": self.report.title, "pass": self.missed.is_empty(), "missed": self.missed, "tables": tables })
            }
            summary => summary.clone(),
        }
    }
}

impl Bench {
    /// The suite of this bench, loaded.
    pub fn load(&self, quick: bool) -> Option<Result<LoadedSuite, LoadError>> {
        self.suite.map(|text| suite::load_text(self.name, text, quick))
    }
}

/// The bench of this name.
pub fn named(name: &str) -> Option<&'static Bench> {
    BENCHES.iter().find(|bench| bench.name == name)
}

/// Runs a suite, and adds what `more` makes of it: figures, tables of its own.
pub fn run_suite(
    loaded: &LoadedSuite,
    options: &mut Options,
    more: impl FnOnce(&SuiteResult, &mut Report) -> Result<(), Error>,
) -> Result<Evidence, Error> {
    let result = sim::study::suite::run(loaded, options.progress)?;
    let suite = &loaded.suite;
    let footer = vec![("suite".to_owned(), loaded.name.clone())];
    let mut report = Report { title: suite.title.clone(), tables: result.tables(), footer, ..Report::default() };
    report.paragraphs.clone_from(&suite.notes);
    more(&result, &mut report)?;
    let docs = [report.tables.clone(), vec![result.commands()]].concat();
    let missed = result.judged.iter().flat_map(|judged| judged.missed.iter().map(|case| format!("{} of {case}", judged.metric)));
    let missed = missed.collect();
    Ok(Evidence { printed: None, docs, summary: summary(&result), files: Vec::new(), missed, report })
}

/// Runs the built-in suite of this name.
pub(crate) fn built_in(
    name: &str,
    options: &mut Options,
    more: impl FnOnce(&SuiteResult, &mut Report) -> Result<(), Error>,
) -> Result<Evidence, Error> {
    match named(name).and_then(|bench| bench.load(options.quick)) {
        Some(loaded) => run_suite(&loaded?, options, more),
        None => Ok(Evidence::default()),
    }
}

/// Targets and metrics for programs.
fn summary(result: &SuiteResult) -> Value {
    let target = |judged: &Judged| {
        let worst = judged.worst.as_ref().map(|(case, value)| json!({ "case": case, "value": value }));
        json!({
            "metric": judged.metric, "limit": judged.limit, "cases": judged.cases, "worst": worst, "pass": judged.holds(),
            "missed": judged.missed, "source": judged.source,
        })
    };
    let metrics = |case: &sim::study::suite::CaseResult| {
        let metrics: Map<String, Value> = case.metrics.iter().map(|(name, value)| (name.to_owned(), json!(value))).collect();
        json!({ "case": case.case.name, "group": case.case.group, "command": case.case.command, "metrics": metrics })
    };
    json!({
        "suite": result.suite.name, "title": result.suite.suite.title, "pass": result.holds(),
        "targets": result.judged.iter().map(target).collect::<Vec<_>>(),
        "cases": result.cases.iter().map(metrics).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_suite_is_valid_and_its_quick_variant_is_less() {
        let load = |bench: &Bench, quick| bench.load(quick).map(|loaded| loaded.unwrap_or_else(|error| panic!("{error}")));
        for bench in &BENCHES {
            let (Some(full), Some(quick)) = (load(bench, false), load(bench, true)) else { continue };
            let runs = |suite: &LoadedSuite| suite.cases.iter().map(|case| case.loaded.scene.runs).sum::<u32>();
            assert!(runs(&quick) * 4 < runs(&full), "{}: {} of {}", bench.name, runs(&quick), runs(&full));
        }
    }
}
