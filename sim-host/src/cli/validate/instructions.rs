//! `sim-host validate instructions`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use crate::cli::{Color, RUN_FAILED};
use proof::instructions::{self, Measurement, table as tables};
use report::{self, Report};

/// Arguments of the command.
#[derive(Args)]
pub(super) struct InstructionsArgs {
    /// Folder for the tables.
    #[arg(short, long = "output", value_name = "DIR", default_value = "out/instructions")]
    output: PathBuf,
    /// Write no files.
    #[arg(long)]
    no_report: bool,
}

/// Counts, prints, writes, and fails where a budget is exceeded.
pub(super) fn run(args: &InstructionsArgs, color: Color) -> anyhow::Result<ExitCode> {
    let measurement = instructions::conduct()?;
    crate::cli::print(&tables::tables(&measurement).iter().map(|block| block.terminal(color.stdout)).collect::<String>())?;
    if !args.no_report {
        report::write(&page(&measurement), &args.output)?;
        say!("report: {}", args.output.join("report.html").display());
    }
    for judged in measurement.judged.iter().filter(|judged| !judged.holds()) {
        say!("error: over budget: {}", judged.bound.name);
    }
    Ok(if measurement.holds() { ExitCode::SUCCESS } else { ExitCode::from(RUN_FAILED) })
}

fn page(measurement: &Measurement) -> Report {
    Report {
        title: "Instructions: speed against error on the target".into(),
        subtitle: "Counted by an emulated Cortex-M4F; instructions, not cycles".into(),
        tables: tables::tables(measurement),
        footer: vec![("sim-host".into(), sim::VERSION.to_owned())],
        ..Report::default()
    }
}
