//! `sim-host friction`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::Color;
use proof::friction::cases::{Way, all, few};
use proof::friction::{self, plot, table as tables};
use report::Report;

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
    let page = Report {
        title: "The friction switch: what is wanted and what is had".into(),
        subtitle: "Simulated: the controller on the host (SIL)".into(),
        tables: tables::tables(&campaign),
        figures: vec![plot::figure(&campaign)],
        ..Report::default()
    };
    // The references are shown to miss.
    let mut judged = campaign.iter().filter(|found| !matches!(found.case.way, Way::Coulomb | Way::Plain(_)));
    let markdown = args.markdown.then(|| tables::markdown(&campaign));
    super::campaign::end(page, markdown, (!args.no_report).then_some(&*args.output), judged.all(|found| found.holds()), color)
}
