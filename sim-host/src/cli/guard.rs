//! `sim-host guard`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::Color;
use proof::guard::{self, Extent, table as tables};
use report::Report;

/// Arguments of the command.
#[derive(Args)]
pub(super) struct GuardArgs {
    /// Fewer and shorter runs, for continuous integration.
    #[arg(long)]
    quick: bool,
    /// Folder for the tables.
    #[arg(short, long = "output", value_name = "DIR", default_value = "out/guard")]
    output: PathBuf,
    /// Write no files.
    #[arg(long)]
    no_report: bool,
}

/// Runs, prints, writes, and fails where a target is missed.
pub(super) fn run(args: &GuardArgs, color: Color) -> anyhow::Result<ExitCode> {
    let extent = if args.quick { Extent::QUICK } else { Extent::FULL };
    let campaign = guard::conduct(extent, &mut |next| eprintln!("{next}"))?;
    let page = Report {
        title: "Weld guard: a belt that stops, slows, breaks its sensor or belies it".into(),
        subtitle: "Simulated: the firmware's guard at block rate, without the carrier".into(),
        tables: tables::tables(&campaign),
        ..Report::default()
    };
    super::campaign::end(page, None, (!args.no_report).then_some(&*args.output), campaign.holds(), color)
}
