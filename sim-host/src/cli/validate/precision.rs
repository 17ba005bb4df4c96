//! `sim-host validate precision`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use crate::cli::{Color, EXPECTATION_MISSED, Format, RUN_FAILED};
use proof::precision::study::{Extent, conduct};
use proof::precision::{folder, instructions, table as tables};

/// Arguments of the command.
#[derive(Args)]
pub(super) struct PrecisionArgs {
    /// Fewer steps, rounds and periods, for continuous integration; every method and every case all the same.
    #[arg(long)]
    quick: bool,
    /// Folder for the tables, the curves and the report.
    #[arg(short, long = "output", value_name = "DIR", default_value = "out/precision")]
    output: PathBuf,
    /// What to print on standard output.
    #[arg(long, value_enum, default_value_t = Format::Human)]
    format: Format,
    /// Write no files.
    #[arg(long)]
    no_report: bool,
    /// Do not count instructions, even if valgrind is there.
    #[arg(long)]
    no_count: bool,
    /// Run one method and nothing else: what is counted.
    #[arg(long, value_name = "METHOD,STEPS,PERIODS", hide = true)]
    alone: Option<String>,
}

/// How this program is started to be counted.
const ALONE: [&str; 3] = ["validate", "precision", "--alone"];

/// Measures, prints and writes.
pub(super) fn run(args: &PrecisionArgs, color: Color) -> anyhow::Result<ExitCode> {
    if let Some(setting) = &args.alone {
        return alone(setting);
    }
    let executable = std::env::current_exe()?;
    let counted = (!args.no_count).then_some((executable.as_path(), ALONE.as_slice()));
    let study = conduct(Extent { quick: args.quick, counted }, &mut |next| say!("{next}"))?;
    if !args.no_report {
        folder::write(&study, &args.output)?;
    }
    crate::cli::print(&match args.format {
        Format::Human => {
            let blocks = [
                tables::reference(&study.reference),
                tables::work(&study),
                tables::hard_in_short(&study.hard),
                tables::claims(&study.claims),
            ];
            blocks.iter().map(|block| block.terminal(color.stdout)).collect()
        }
        Format::Json => format!("{:#}\n", folder::summary(&study)),
    })?;
    if !args.no_report {
        say!("report: {}", args.output.join("report.html").display());
    }
    Ok(if study.passes() { ExitCode::SUCCESS } else { ExitCode::from(EXPECTATION_MISSED) })
}

fn alone(setting: &str) -> anyhow::Result<ExitCode> {
    let parts: Vec<&str> = setting.split(',').collect();
    let [method, steps, periods] = parts[..] else { anyhow::bail!("{setting:?} is not METHOD,STEPS,PERIODS") };
    let known = instructions::run_alone(method, steps.parse()?, periods.parse()?)?;
    if !known {
        say!("error: there is no method {method:?}");
    }
    Ok(if known { ExitCode::SUCCESS } else { ExitCode::from(RUN_FAILED) })
}
