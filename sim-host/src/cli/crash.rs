//! `sim-host crash`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::Color;
use proof::crash::{self, Extent, table as tables};
use report::Report;

/// Arguments of the command.
#[derive(Args)]
pub(super) struct CrashArgs {
    /// Fewer crashes, for continuous integration.
    #[arg(long)]
    quick: bool,
    /// Folder for the tables.
    #[arg(short, long = "output", value_name = "DIR", default_value = "out/crash")]
    output: PathBuf,
    /// Write no files.
    #[arg(long)]
    no_report: bool,
}

/// Runs, prints, writes, and fails where a target is missed.
pub(super) fn run(args: &CrashArgs, color: Color) -> anyhow::Result<ExitCode> {
    let extent = if args.quick { Extent::QUICK } else { Extent::FULL };
    let campaign = crash::conduct(extent, &mut |next| eprintln!("{next}"))?;
    let page = Report {
        title: "Crash: a seat belt's friction, switched".into(),
        subtitle: "Simulated: the controller on the host (SIL), assumed people in an assumed belt".into(),
        tables: tables::tables(&campaign),
        ..Report::default()
    };
    super::campaign::end(page, None, (!args.no_report).then_some(&*args.output), campaign.holds(), color)
}
