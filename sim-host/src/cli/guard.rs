//! `sim-host guard`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::{Color, EXPECTATION_MISSED, table};
use crate::guard::{self, Extent, table as tables};
use crate::report::{self, Report};

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
    let tables = tables::tables(&campaign);
    super::print(&tables.iter().map(|block| table::render(block, color.stdout)).collect::<String>())?;
    if !args.no_report {
        let page = Report {
            title: "Weld guard: a belt that stops, slows, breaks its sensor or belies it".into(),
            subtitle: "Simulated: the firmware's guard at block rate, without the carrier".into(),
            tables,
            footer: vec![("sim-host".into(), crate::findings::VERSION.to_owned())],
            ..Report::default()
        };
        report::write(&page, &args.output)?;
        eprintln!("report: {}", args.output.join("report.html").display());
    }
    Ok(if campaign.holds() { ExitCode::SUCCESS } else { ExitCode::from(EXPECTATION_MISSED) })
}
