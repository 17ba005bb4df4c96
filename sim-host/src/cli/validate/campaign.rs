//! What the commands have in common that hold a campaign against its targets: tables in the terminal, a page of them, and an exit code.

use std::path::Path;
use std::process::ExitCode;

use crate::cli::{Color, EXPECTATION_MISSED};
use report::{self, Report};
use sim::VERSION;

/// Prints the tables of a page, if they are not printed otherwise, and writes the page, if there is a folder for it. Fails where a target is missed.
pub(super) fn end(
    page: Report,
    printed: Option<String>,
    folder: Option<&Path>,
    holds: bool,
    color: Color,
) -> anyhow::Result<ExitCode> {
    let rendered = || page.tables.iter().map(|block| block.terminal(color.stdout)).collect();
    crate::cli::print(&printed.unwrap_or_else(rendered))?;
    if let Some(folder) = folder {
        let page = Report { footer: vec![("sim-host".into(), VERSION.to_owned())], ..page };
        report::write(&page, folder)?;
        say!("report: {}", folder.join("report.html").display());
    }
    Ok(if holds { ExitCode::SUCCESS } else { ExitCode::from(EXPECTATION_MISSED) })
}
