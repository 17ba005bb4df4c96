//! `sim-host validate thesis`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;

use crate::cli::{Color, Format};
use proof::thesis::{self, Findings, Verdict};

/// Arguments of `sim-host validate thesis`.
#[derive(Args)]
pub(super) struct ThesisArgs {
    /// Folder for the report and the figures.
    #[arg(short, long = "output", value_name = "DIR", default_value = "out/thesis")]
    output: PathBuf,
    /// What to print on standard output.
    #[arg(long, value_enum, default_value_t = Format::Human)]
    format: Format,
    /// Say nothing but the result.
    #[arg(short, long)]
    quiet: bool,
}

/// Computes everything, writes the report, prints the tables.
pub(super) fn run(args: &ThesisArgs, color: Color) -> anyhow::Result<ExitCode> {
    let began = Instant::now();
    let say = |what: &str, done: usize, of: usize| {
        if !args.quiet {
            say!("[{:>2}/{of}] {what}, {:.1} s", done + 1, began.elapsed().as_secs_f64());
        }
    };
    let findings = thesis::conduct(&mut |what, done, of| say(what, done, of))?;
    if !args.quiet {
        say!("{} figures", findings.figures.len());
    }
    report::write(&findings.report(), &args.output)?;
    let done = crate::cli::print(&match args.format {
        Format::Human => human(&findings, color),
        Format::Json => format!("{:#}\n", thesis::summary(&findings)),
    })?;
    if !args.quiet {
        say!("report: {} ({:.1} s)", args.output.join("report.html").display(), began.elapsed().as_secs_f64());
    }
    Ok(done)
}

fn human(findings: &Findings, color: Color) -> String {
    let text: String = findings.tables().iter().map(|block| block.terminal(color.stdout)).collect();
    let [reproduced, conditional, refuted] =
        [Verdict::Reproduced, Verdict::Conditional, Verdict::Refuted].map(|verdict| findings.count(verdict));
    format!("{text}{} claims: {reproduced} reproduced, {conditional} conditional, {refuted} refuted\n", findings.claims.len())
}
