//! `sim-host crash`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::{Color, EXPECTATION_MISSED, table};
use crate::crash::{self, Extent, table as tables};
use crate::report::{self, Report};

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
    let tables = tables::tables(&campaign);
    super::print(&tables.iter().map(|block| table::render(block, color.stdout)).collect::<String>())?;
    if !args.no_report {
        let page = Report {
            title: "Crash: a seat belt's friction, switched".into(),
            subtitle: "Simulated: the controller on the host (SIL), assumed people in an assumed belt".into(),
            tables,
            footer: vec![("sim-host".into(), crate::findings::VERSION.to_owned())],
            ..Report::default()
        };
        report::write(&page, &args.output)?;
        eprintln!("report: {}", args.output.join("report.html").display());
    }
    Ok(if campaign.holds() { ExitCode::SUCCESS } else { ExitCode::from(EXPECTATION_MISSED) })
}
