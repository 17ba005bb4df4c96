//! Arguments of a result: where it goes, and how it is printed. What the folder holds is said by each command, in the help of `--output`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

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
    /// The folder of the result, if there is to be one.
    pub(super) fn dir(&self, default: impl FnOnce() -> PathBuf) -> Option<PathBuf> {
        (!self.no_report).then(|| self.result.output.clone().unwrap_or_else(default))
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
