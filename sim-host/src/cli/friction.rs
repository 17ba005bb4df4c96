//! `sim-host friction`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::{Color, EXPECTATION_MISSED, table};
use crate::friction::cases::{Way, all, few};
use crate::friction::{self, plot, table as tables};
use crate::report::{self, Report};

/// Arguments of the command.
#[derive(Args)]
pub(super) struct FrictionArgs {
    /// Few cases, for continuous integration.
    #[arg(long)]
    quick: bool,
    /// Say how each case is run by itself, and run nothing.
    #[arg(long)]
    list: bool,
    /// Print the tables as docs/friction.md has them.
    #[arg(long)]
    markdown: bool,
    /// Folder for the tables and the plot.
    #[arg(short, long = "output", value_name = "DIR", default_value = "out/friction")]
    output: PathBuf,
    /// Write no files.
    #[arg(long)]
    no_report: bool,
}

/// Runs, prints, writes, and fails where a target is missed.
pub(super) fn run(args: &FrictionArgs, color: Color) -> anyhow::Result<ExitCode> {
    let cases = if args.quick { few() } else { all() };
    if args.list {
        return super::print(&cases.iter().map(|case| format!("{}: {}\n", case.name(), case.command())).collect::<String>());
    }
    let campaign = friction::conduct(cases)?;
    let text = if args.markdown { tables::markdown(&campaign) } else { String::new() };
    let tables = tables::tables(&campaign);
    let rendered = || tables.iter().map(|block| table::render(block, color.stdout)).collect::<String>();
    super::print(&if args.markdown { text } else { rendered() })?;
    if !args.no_report {
        let page = Report {
            title: "The friction switch: what is wanted and what is had".into(),
            subtitle: "Simulated: the controller on the host (SIL)".into(),
            tables,
            figures: vec![plot::figure(&campaign)],
            footer: vec![("sim-host".into(), crate::findings::VERSION.to_owned())],
            ..Report::default()
        };
        report::write(&page, &args.output)?;
        eprintln!("report: {}", args.output.join("report.html").display());
    }
    // The references are shown to miss.
    let judged = campaign.iter().filter(|found| !matches!(found.case.way, Way::Coulomb | Way::Plain(_)));
    Ok(if judged.into_iter().all(|found| found.holds()) { ExitCode::SUCCESS } else { ExitCode::from(EXPECTATION_MISSED) })
}
