//! `sim-host compare`.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::{Color, DrawingArgs, Exit, Format, ResultArgs};
use report::Report;
use sim::compare::{CompareError, Comparison, Side, Tolerances};
use sim::output::{OutputError, Owner};

/// Arguments of the command.
#[derive(Args)]
#[command(mut_arg("output", |arg| arg.help("Folder for a report with the figures of both results overlaid")))]
pub(super) struct CompareArgs {
    /// Folder of a run, or CSV of measured metrics with the columns metric, value and sd.
    a: PathBuf,
    /// Second folder or CSV.
    b: PathBuf,
    /// Tolerance: `1%` or `0.01` for all metrics, `METRIC=0.5` or `METRIC=2%` for one (repeatable).
    /// Default: 0, or two standard deviations of a measured value.
    #[arg(long = "tolerance", value_name = "[METRIC=]X[%]")]
    tolerances: Vec<String>,
    /// Compare only these metrics, and fail if one is missing.
    #[arg(long = "metric", value_name = "METRIC,…", value_delimiter = ',')]
    metrics: Vec<String>,
    #[command(flatten)]
    result: ResultArgs,
    #[command(flatten)]
    drawing: DrawingArgs,
}

/// Compares, prints, and returns `Exit::Missed` if a value is outside its tolerance.
pub(super) fn run(args: &CompareArgs, color: Color) -> anyhow::Result<Exit> {
    let compared = compared(args)?;
    if let Some(dir) = &args.result.output {
        let folder = super::open(Some(dir), "", Owner::new("compare", [&args.a, &args.b]))?;
        let report = compared.report();
        let footer = [report.footer, super::provenance().footer()].concat();
        report::write_drawn(&Report { footer, ..report }, folder.unfinished(), &args.drawing.drawing())
            .map_err(OutputError::from)?;
        let mut manifest = compared.json();
        manifest["complete"] = json!(true);
        folder.finish(manifest)?;
    }
    super::print_styled(&match args.result.format {
        Format::Human => compared.table().terminal(color.stdout),
        Format::Json => format!("{:#}\n", compared.json()),
    })?;
    if let Some(dir) = args.result.output.as_ref().filter(|_| !args.result.quiet) {
        say!("report: {}", dir.join("report.html").display());
    }
    Ok(if compared.holds() { Exit::Done } else { Exit::Missed })
}

fn compared(args: &CompareArgs) -> Result<Comparison, CompareError> {
    let tolerances = Tolerances::parse(&args.tolerances)?;
    Comparison::new(Side::read(&args.a)?, Side::read(&args.b)?, &tolerances, &args.metrics)
}
