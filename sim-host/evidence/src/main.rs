//! `evidence`: runs the project's own benches and compares the results with their targets.
//!
//!     cargo run --release -p sonoglide-evidence -- tracking --quick
#![forbid(unsafe_code)]

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use clap::{Parser, ValueEnum};
use scene::nearest::{listed, nearest};
use sim::output::{Folder, Owner};
use sim::provenance::{Provenance, command_line};
use sonoglide_evidence::bench::{BENCHES, Bench, named};
use sonoglide_evidence::evidence::{Evidence, Options};
use sonoglide_evidence::precision::instructions::run_alone;

/// Exit codes, the same as those of `sim-host`.
const USAGE: u8 = 2;
const EXPECTATION_MISSED: u8 = 4;
const INTERRUPTED: u8 = 130;
/// `true` after Ctrl-C; a second Ctrl-C exits immediately.
static STOP: AtomicBool = AtomicBool::new(false);
/// Arguments with which this program starts itself to count the instructions of one method.
const ALONE: [&str; 1] = ["--alone"];

/// Runs benches and compares each with its targets: the evidence behind docs/claims.md.
#[derive(Parser)]
#[command(name = "evidence", version, after_help = benches())]
struct Arguments {
    /// Bench to run; `show NAME` prints its suite; all benches if none is named.
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    /// Run the quick variant: fewer runs and cases.
    #[arg(long)]
    quick: bool,
    /// Number of runs of each kind and place (`faults`), transducers (`commission`, `drift`, the
    /// wider set of `transducers`), files (`import`), contacts (`contacts`), or millions of bytes
    /// (`fuzz`) or samples (`soak`).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    count: Option<u32>,
    /// Run one input alone, with the seed from a failure message (`fuzz`, `soak`), or another set
    /// of contacts (`contacts`), or the wider set from this number on (`transducers`,
    /// `commission`), or the set from this number on (`drift`).
    #[arg(long, value_name = "SEED")]
    seed: Option<u64>,
    /// List the benches, or the command of each case of a suite, and run nothing.
    #[arg(long)]
    list: bool,
    /// Print the tables as Markdown, as in the documentation.
    #[arg(long)]
    markdown: bool,
    /// Folder for tables and figures; with all benches, one subfolder each. Default: `out/NAME`.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Write no files.
    #[arg(long)]
    no_report: bool,
    /// Output format on standard output.
    #[arg(long, value_enum, default_value_t = Format::Human)]
    format: Format,
    /// Print no progress.
    #[arg(short, long)]
    quiet: bool,
    /// Do not count the instructions of the methods (`precision`), even if valgrind is installed.
    #[arg(long)]
    no_count: bool,
    /// Run only one method, to count its instructions.
    #[arg(long, value_name = "METHOD,STEPS,PERIODS", hide = true)]
    alone: Option<String>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Tables.
    Human,
    /// The summary as JSON.
    Json,
}

fn benches() -> String {
    let lines: String = BENCHES.iter().map(|bench| format!("  {:12}  {}\n", bench.name, bench.about)).collect();
    format!("Benches:\n{lines}\nExit codes: 0 done; 1 failed; 2 usage; 4 a target was missed; 130 interrupted.")
}

fn main() -> anyhow::Result<ExitCode> {
    let arguments = Arguments::parse();
    ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(INTERRUPTED.into());
        }
    })?;
    if let Some(setting) = &arguments.alone {
        return alone(setting);
    }
    let of_a_set = ["contacts", "transducers", "commission", "drift"];
    let is_alone = !matches!(&arguments.names[..], [name] if of_a_set.contains(&name.as_str()));
    if arguments.seed.is_some() && arguments.count.is_some() && is_alone {
        eprintln!("error: --seed runs one input alone, without --count; only `{}` take both", of_a_set.join("`, `"));
        return Ok(ExitCode::from(USAGE));
    }
    match arguments.names.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] if arguments.list => print(&format!("{}\n", benches())),
        [] => all(&arguments),
        ["show", name] => match named(name).and_then(|bench| bench.suite) {
            Some(text) => print(text),
            None => Ok(unknown(name, "not a suite", BENCHES.iter().filter(|bench| bench.suite.is_some()))),
        },
        [name] => match named(name) {
            Some(bench) => one(bench, arguments.output.clone(), &arguments),
            None => Ok(unknown(name, "not a bench", BENCHES.iter())),
        },
        _ => {
            eprintln!("error: give one bench at a time, or `show` and a bench");
            Ok(ExitCode::from(USAGE))
        }
    }
}

fn unknown<'a>(name: &str, what: &str, known: impl Iterator<Item = &'a Bench>) -> ExitCode {
    let known: Vec<&str> = known.map(|bench| bench.name).collect();
    let similar = nearest(name, known.iter().copied());
    eprintln!("error: `{name}` is {what}; try {}", listed(if similar.is_empty() { known } else { similar }, "or"));
    ExitCode::from(USAGE)
}

/// Runs all benches; returns the exit code of the first that fails.
fn all(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let mut failed = None;
    for bench in &BENCHES {
        eprintln!("evidence {}", bench.name);
        let code = one(bench, arguments.output.as_ref().map(|dir| dir.join(bench.name)), arguments)?;
        failed = failed.or((code != ExitCode::SUCCESS).then_some(code));
    }
    Ok(failed.unwrap_or(ExitCode::SUCCESS))
}

/// Runs a bench, writes its folder, and prints its tables.
fn one(bench: &Bench, dir: Option<PathBuf>, arguments: &Arguments) -> anyhow::Result<ExitCode> {
    if arguments.list {
        return match bench.load(arguments.quick).transpose()? {
            Some(loaded) => {
                print(&loaded.cases.iter().map(|case| format!("{}: {}\n", case.name, case.command)).collect::<String>())
            }
            None => print(&format!("{}: {}\n", bench.name, bench.about)),
        };
    }
    let dir = (!arguments.no_report).then(|| dir.unwrap_or_else(|| Path::new("out").join(bench.name)));
    // Opened before a bench that may take long.
    let owner = || Owner::new("evidence", std::iter::empty::<&Path>());
    let folder = dir.as_deref().map(|dir| Folder::open(dir, owner())).transpose()?;
    let executable = std::env::current_exe()?;
    let run = (bench.run)(&mut Options {
        quick: arguments.quick,
        count: arguments.count,
        seed: arguments.seed,
        counted: (!arguments.no_count).then_some((executable.as_path(), ALONE.as_slice())),
        stop: Some(&STOP),
        progress: &mut |next: &str| {
            if !arguments.quiet {
                eprintln!("{next}");
            }
        },
    });
    let evidence = match run {
        Err(_) if STOP.load(Ordering::Relaxed) => return Ok(ExitCode::from(INTERRUPTED)),
        run => run?,
    };
    if let (Some(dir), Some(folder)) = (dir, folder) {
        let words = std::env::args().skip(1).collect::<Vec<_>>();
        let command = command_line(std::iter::once("evidence").chain(words.iter().map(String::as_str)));
        let footer = Provenance { command: Some(command), commit: None, date: None }.footer();
        evidence.write(footer, bench.name, arguments.quick, &folder)?;
        if !arguments.quiet {
            eprintln!("report: {}", dir.join("report.html").display());
        }
    }
    print(&printed(&evidence, arguments))?;
    evidence.missed.iter().for_each(|missed| eprintln!("missed: {missed}"));
    Ok(if evidence.missed.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(EXPECTATION_MISSED) })
}

fn printed(evidence: &Evidence, arguments: &Arguments) -> String {
    let color = std::io::stdout().is_terminal();
    let tables = evidence.printed.as_ref().unwrap_or(&evidence.report.tables);
    match arguments.format {
        Format::Json => format!("{:#}\n", evidence.json()),
        Format::Human if arguments.markdown => report::markdown(&evidence.docs),
        Format::Human => tables.iter().map(|table| table.terminal(color)).collect(),
    }
}

fn alone(setting: &str) -> anyhow::Result<ExitCode> {
    let [method, steps, periods] = setting.split(',').collect::<Vec<_>>()[..] else {
        anyhow::bail!("{setting:?} is not METHOD,STEPS,PERIODS")
    };
    anyhow::ensure!(run_alone(method, steps.parse()?, periods.parse()?)?, "there is no method {method:?}");
    Ok(ExitCode::SUCCESS)
}

fn print(text: &str) -> anyhow::Result<ExitCode> {
    std::io::stdout().lock().write_all(text.as_bytes()).context("standard output")?;
    Ok(ExitCode::SUCCESS)
}
