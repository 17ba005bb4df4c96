//! Evidence: the tables, figures and missed targets that every bench gives, made by a suite or by code.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use serde_json::{Map, Value, json};

use crate::precision::reference::NoReference;
use report::{Report, TableBlock};
use scene::load::LoadError;
use scene::suite::{self, LoadedSuite};
use sim::study::StudyError;
use sim::study::suite::{Judged, SuiteResult};

/// Options of a bench, and what it needs from outside.
pub struct Options<'a> {
    /// Fewer runs and cases.
    pub quick: bool,
    /// How many runs of each kind and place (`faults`), transducers that are commissioned (`commission`), files that are imported (`import`), millions of bytes sent (`fuzz`) or of samples driven (`soak`), where it is not the usual number.
    pub count: Option<u32>,
    /// One input alone, by its seed (`fuzz`, `soak`); another set (`contacts`).
    pub seed: Option<u64>,
    /// The program to count instructions of, and the options that make it run one method alone (`precision`).
    pub counted: Option<(&'a Path, &'a [&'a str])>,
    /// Flag that the caller sets to stop the cases of a suite.
    pub stop: Option<&'a AtomicBool>,
    /// Called with what comes next.
    pub progress: &'a mut (dyn FnMut(&str) + Send),
}

/// The result of a bench.
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
    Reference(#[from] NoReference),
    /// The firmware refuses a case.
    #[error("the firmware refuses a case: {0}")]
    Config(#[from] firmware::seam::error::Error),
    /// The image of the emulator could not be built or run.
    #[error(transparent)]
    Pil(#[from] pil::PilError),
    /// The image did not come to its end, or printed something else than counts.
    #[error("the image gives no counts: {0}")]
    Counts(String),
    /// A campaign against the flashed image has no board to begin with.
    #[error(transparent)]
    Campaign(#[from] crate::campaign_error::CampaignError),
    /// A simulated board has not answered.
    #[error("a simulated board has failed: {0}")]
    Board(String),
    /// The published data do not fit what is held against them.
    #[error("the published data: {0}")]
    Data(String),
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

/// Runs a suite, and adds what `more` makes of it: figures, tables of its own.
pub fn run_suite(
    loaded: &LoadedSuite,
    options: &mut Options,
    more: impl FnOnce(&SuiteResult, &mut Report) -> Result<(), Error>,
) -> Result<Evidence, Error> {
    let result = sim::study::suite::run(loaded, options.stop, options.progress)?;
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

/// Runs a built-in suite, by its name and text.
pub(crate) fn built_in(
    (name, text): (&str, &str),
    options: &mut Options,
    more: impl FnOnce(&SuiteResult, &mut Report) -> Result<(), Error>,
) -> Result<Evidence, Error> {
    run_suite(&suite::load_text(name, text, options.quick)?, options, more)
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
