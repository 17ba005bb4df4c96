//! Arguments of a result: its folder and its format. The help of `--output` of each command states
//! the contents of the folder.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use sim::output::{Folder, OutputError, Owner};

/// Folder and format of a result.
#[derive(Args, Default)]
pub(super) struct ResultArgs {
    #[arg(short, long = "output", value_name = "DIR")]
    pub(super) output: Option<PathBuf>,
    /// Format of standard output.
    #[arg(long, value_enum, default_value_t = Format::Human)]
    pub(super) format: Format,
    /// Print only the result.
    #[arg(short, long)]
    pub(super) quiet: bool,
}

/// Folder and format of a result that is written to a folder unless `--no-report` is given.
#[derive(Args, Default)]
pub(super) struct ReportArgs {
    #[command(flatten)]
    pub(super) result: ResultArgs,
    /// Write no files.
    #[arg(long)]
    pub(super) no_report: bool,
}

impl ReportArgs {
    /// Opens the folder of the result, by default `out/` followed by `default`; `None` if no files
    /// are to be written.
    pub(super) fn open(&self, default: &str, owner: Owner) -> Result<Option<Folder>, OutputError> {
        (!self.no_report).then(|| super::open(self.result.output.as_deref(), default, owner)).transpose()
    }
}

/// Format of standard output.
#[derive(Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    /// Tables.
    #[default]
    Human,
    /// Summary as JSON.
    Json,
}
