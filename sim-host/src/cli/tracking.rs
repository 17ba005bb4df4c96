//! `sim-host tracking`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::Color;
use proof::tracking::cases::CASES;
use proof::tracking::{self, Extent, table as tables};
use report::Report;

/// Arguments of the command.
#[derive(Args)]
pub(super) struct TrackingArgs {
    /// Fewer runs of each case, for continuous integration.
    #[arg(long)]
    quick: bool,
    /// Say how each case is run by itself, and run nothing.
    #[arg(long)]
    list: bool,
    /// Folder for the tables.
    #[arg(short, long = "output", value_name = "DIR", default_value = "out/tracking")]
    output: PathBuf,
    /// Write no files.
    #[arg(long)]
    no_report: bool,
}

/// Runs, prints, writes, and fails where a target is missed.
pub(super) fn run(args: &TrackingArgs, color: Color) -> anyhow::Result<ExitCode> {
    if args.list {
        return super::print(&CASES.iter().map(|case| format!("{}: {}\n", case.name, case.command())).collect::<String>());
    }
    let extent = if args.quick { Extent::QUICK } else { Extent::FULL };
    let campaign = tracking::conduct(extent, &mut |next| eprintln!("{next}"))?;
    let page = Report {
        title: "Tracking: every case over many runs".into(),
        subtitle: "Simulated: the controller on the host (SIL)".into(),
        tables: tables::tables(&campaign),
        ..Report::default()
    };
    super::campaign::end(page, None, (!args.no_report).then_some(&*args.output), campaign.holds(), color)
}
