//! `sim-host validate`: a user's suite of cases, each compared with its targets.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use clap::Args;

use super::{Color, Exit, Format, ReportArgs, interrupts, mistake, print, print_styled, visible};
use scene::suite::{self, LoadedSuite};
use sim::evidence::{SuiteError, run_suite};
use sim::output::Owner;
use sim::study::StudyError;

/// `true` after Ctrl-C or any other request to end.
static STOP: AtomicBool = AtomicBool::new(false);

/// Arguments of the command.
#[derive(Args)]
#[command(mut_arg("output", |arg| arg.help("Folder for tables and figures. Default: `out/SUITE`")))]
pub(super) struct ValidateArgs {
    /// Suite of cases and targets, as a TOML file (docs/ci.md).
    #[arg(value_name = "SUITE.toml", required = true, num_args = 1..)]
    suite: Vec<String>,
    /// Run the quick variant of the suite, with fewer runs and cases.
    #[arg(long)]
    quick: bool,
    /// Print the command of each case without running it.
    #[arg(long)]
    list: bool,
    /// Print the tables as Markdown.
    #[arg(long)]
    markdown: bool,
    #[command(flatten)]
    report: ReportArgs,
}

/// Benches, which are in `evidence`; all but two were commands of this program until version 0.1.
const MOVED: [&str; 22] = [
    "tracking",
    "transducers",
    "estimates",
    "drift",
    "commission",
    "import",
    "friction",
    "guard",
    "crash",
    "faults",
    "board-faults",
    "board-scenes",
    "slot-scenes",
    "update-cuts",
    "fuzz",
    "soak",
    "features",
    "contacts",
    "precision",
    "instructions",
    "thesis",
    "measurements",
];

/// Runs a suite, writes its folder, and prints its tables.
pub(super) fn run(args: &ValidateArgs, color: Color) -> anyhow::Result<Exit> {
    let name = args.suite.last().map_or("", String::as_str);
    if Path::new(name).extension().is_none() {
        let show = if args.suite.len() > 1 { "show " } else { "" };
        return Err(if MOVED.contains(&name) {
            let command = format!("cargo run --release -p sonoglide-evidence -- {show}{name}");
            mistake(Exit::Usage, format!("`{name}` is a bench; run `{command}` in a checkout"))
        } else {
            mistake(Exit::Input, format!("`{name}` is not a suite: give a TOML file (docs/ci.md)"))
        });
    }
    if args.suite.len() > 1 {
        return Err(mistake(Exit::Usage, "give only one suite"));
    }
    interrupts::set(&STOP)?;
    let loaded = suite::load(name, args.quick)?;
    if args.list {
        return print(&loaded.cases.iter().map(|case| format!("{}: {}\n", case.name, case.command)).collect::<String>());
    }
    judge(&loaded, args, color)
}

fn judge(loaded: &LoadedSuite, args: &ValidateArgs, color: Color) -> anyhow::Result<Exit> {
    let folder = args.report.open(&loaded.name, Owner::new("validate", &args.suite))?;
    let progress = &mut |next: &str| {
        if !args.report.result.quiet {
            say!("{next}");
        }
    };
    let evidence = match run_suite(loaded, Some(&STOP), progress, |_, _| Ok::<(), SuiteError>(())) {
        Ok(evidence) => evidence,
        Err(SuiteError::Study(StudyError::Interrupted)) => {
            say!("interrupted: some cases did not run, so nothing is written");
            return Ok(Exit::Interrupted);
        }
        Err(error) => return Err(error.into()),
    };
    if let Some(folder) = folder {
        evidence.write(super::provenance().footer(), &loaded.name, args.quick, &folder)?;
        if !args.report.result.quiet {
            say!("report: {}", folder.dir().join("report.html").display());
        }
    }
    print_styled(&match args.report.result.format {
        Format::Json => format!("{:#}\n", evidence.json()),
        Format::Human if args.markdown => visible(&report::markdown(&evidence.docs)),
        Format::Human => evidence.report.tables.iter().map(|table| table.terminal(color.stdout)).collect(),
    })?;
    evidence.missed.iter().for_each(|missed| say!("missed: {missed}"));
    Ok(if evidence.missed.is_empty() { Exit::Done } else { Exit::Missed })
}
