//! Evidence: tables, figures and missed targets of a suite or a bench, and the folder with them.

use std::sync::atomic::AtomicBool;

use report::{Report, TableBlock};
use scene::load::LoadError;
use scene::suite::LoadedSuite;
use serde_json::{Map, Value, json};

#[cfg(feature = "files")]
use crate::output::{Folder, OutputError};
use crate::study::StudyError;
use crate::study::suite::{self, Progress, SuiteResult, TargetResult};

/// Result of a suite or a bench.
#[derive(Default)]
pub struct Evidence {
    /// Tables and figures of the page.
    pub report: Report,
    /// Tables for the terminal, if they differ from those of the page.
    pub printed: Option<Vec<TableBlock>>,
    /// Tables for the documentation.
    pub docs: Vec<TableBlock>,
    /// Machine-readable result; null if the tables contain all of it.
    pub summary: Value,
    /// Further files for the folder: name and text.
    pub files: Vec<(&'static str, String)>,
    /// Targets that were missed.
    pub missed: Vec<String>,
}

/// Error of a suite.
#[derive(Debug, thiserror::Error)]
pub enum SuiteError {
    /// A scene or the suite is not valid.
    #[error(transparent)]
    Scene(#[from] LoadError),
    /// A case has no result.
    #[error(transparent)]
    Study(#[from] StudyError),
}

impl Evidence {
    /// Returns the machine-readable result.
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

    /// Writes tables, figures and further files into a folder; `footer` comes first in the
    /// provenance of the page.
    #[cfg(feature = "files")]
    pub fn write(&self, footer: Vec<(String, String)>, name: &str, quick: bool, folder: &Folder) -> Result<(), OutputError> {
        let dir = folder.unfinished();
        let footer = footer.into_iter().chain(self.report.footer.clone()).collect();
        report::write(&Report { footer, ..self.report.clone() }, dir)?;
        for (file, text) in &self.files {
            std::fs::write(dir.join(file), text).map_err(|io| OutputError::Write { path: dir.join(file), io })?;
        }
        folder.finish(json!({ "bench": name, "quick": quick, "complete": true }))
    }
}

/// Runs a suite. `more` adds its own figures and tables, `stop` ends the suite, and `progress` is
/// called with the name of each case.
pub fn run_suite<E: From<StudyError>>(
    loaded: &LoadedSuite,
    stop: Option<&AtomicBool>,
    progress: Progress,
    more: impl FnOnce(&SuiteResult, &mut Report) -> Result<(), E>,
) -> Result<Evidence, E> {
    let result = suite::run(loaded, stop, progress)?;
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

/// Returns targets and metrics as JSON.
fn summary(result: &SuiteResult) -> Value {
    let target = |judged: &TargetResult| {
        let worst = judged.worst.as_ref().map(|(case, value)| json!({ "case": case, "value": value }));
        json!({
            "metric": judged.metric, "limit": judged.limit, "cases": judged.cases, "worst": worst, "pass": judged.holds(),
            "missed": judged.missed, "source": judged.source,
        })
    };
    let metrics = |case: &suite::CaseResult| {
        let metrics: Map<String, Value> = case.metrics.iter().map(|(name, value)| (name.to_owned(), json!(value))).collect();
        json!({ "case": case.case.name, "group": case.case.group, "command": case.case.command, "metrics": metrics })
    };
    json!({
        "suite": result.suite.name, "title": result.suite.suite.title, "pass": result.holds(),
        "targets": result.judged.iter().map(target).collect::<Vec<_>>(),
        "cases": result.cases.iter().map(metrics).collect::<Vec<_>>(),
    })
}
