//! Arguments of a result: where it goes, and how it is printed. What the folder holds is said by each command, in the help of `--output`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use sim::output::{Folder, OutputError, Owner};

/// Where a result goes, and how it is printed.
#[derive(Args, Default)]
pub(super) struct ResultArgs {
    #[arg(short, long = "output", value_name = "DIR")]
    pub(super) output: Option<PathBuf>,
    /// What to print on standard output.
    #[arg(long, value_enum, default_value_t = Format::Human)]
    pub(super) format: Format,
    /// Say nothing but the result.
    #[arg(short, long)]
    pub(super) quiet: bool,
}

/// The same of a command that writes a folder unless it is told not to.
#[derive(Args, Default)]
pub(super) struct ReportArgs {
    #[command(flatten)]
    pub(super) result: ResultArgs,
    /// Write no files.
    #[arg(long)]
    pub(super) no_report: bool,
}

impl ReportArgs {
    /// Opens the folder of the result, by default that of a name within `out`; `None` if no files are to be written.
    pub(super) fn open(&self, default: &str, owner: Owner) -> Result<Option<Folder>, OutputError> {
        (!self.no_report).then(|| super::open(self.result.output.as_deref(), default, owner)).transpose()
    }
}

/// What is printed on standard output.
#[derive(Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    /// Tables for a reader.
    #[default]
    Human,
    /// The summary, as JSON.
    Json,
}
