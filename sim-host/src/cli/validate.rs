//! `sim-host validate`: our own benches and a user's own suites, each held against its targets.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use clap::Args;

use super::{Color, EXIT_CODES, Exit, Format, ReportArgs, interrupts, mistake, print};
use proof::bench::{BENCHES, Bench, named};
use proof::evidence::{Error, Evidence, Options, run_suite};
use proof::precision::instructions::run_alone;
use report::Report;
use scene::nearest::{listed, nearest};
use scene::suite::{self, LoadedSuite};
use serde_json::json;
use sim::output::Folder;
use sim::study::StudyError;

/// Set by Ctrl-C, and by any other request to end.
static STOP: AtomicBool = AtomicBool::new(false);

/// Arguments of the command.
#[derive(Args)]
#[command(mut_arg("output", |arg| arg.help("Folder for tables and figures; of all benches, for a folder of each. Default: `out/BENCH`")))]
pub(super) struct ValidateArgs {
    /// A bench, or a suite of your own as TOML file; `show BENCH` prints a built-in suite, to be copied. Without any, all benches run.
    #[arg(value_name = "BENCH|FILE")]
    what: Vec<String>,
    /// The quick variant, where there is one: fewer runs and cases.
    #[arg(long)]
    quick: bool,
    /// How many runs of each kind and place (`faults`), transducers to commission (`commission`), files to import (`import`), millions of bytes to send (`fuzz`), or millions of samples to drive (`soak`), in place of the bench's
    /// own number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    count: Option<u32>,
    /// One input alone, by the seed that a failure names (`fuzz`, `soak`); or another set of as many contacts (`contacts`).
    #[arg(long, value_name = "SEED")]
    seed: Option<u64>,
    /// Say what there is, or how each case of a suite is run by itself, and run nothing.
    #[arg(long)]
    list: bool,
    /// Print the tables as Markdown, as the documentation has them.
    #[arg(long)]
    markdown: bool,
    #[command(flatten)]
    report: ReportArgs,
    /// Do not count the instructions of the methods (`precision`), even if valgrind is there.
    #[arg(long)]
    no_count: bool,
    /// Run one method and nothing else: what is counted.
    #[arg(long, value_name = "METHOD,STEPS,PERIODS", hide = true)]
    alone: Option<String>,
}

/// How this program is started to be counted.
const ALONE: [&str; 2] = ["validate", "--alone"];

/// The benches, for the help of the command.
pub(super) fn help() -> String {
    format!("Benches:\n{}\n{EXIT_CODES}", benches())
}

fn benches() -> String {
    BENCHES.iter().map(|bench| format!("  {:12}  {}\n", bench.name, bench.about)).collect()
}

/// Does what the arguments say; of all benches, the exit code is that of the first that fails.
pub(super) fn run(args: &ValidateArgs, color: Color) -> anyhow::Result<Exit> {
    if let Some(setting) = &args.alone {
        return alone(setting);
    }
    if args.seed.is_some() && args.count.is_some() && args.what != ["contacts"] {
        let why =
            "--seed is one input alone, of which there is no --count; only `contacts` takes both, for another set of contacts";
        return Err(mistake(Exit::Usage, why));
    }
    interrupts::set(&STOP)?;
    match args.what.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] if args.list => print(&benches()),
        [] => all(args, color),
        ["show", name] => match named(name).and_then(|bench| bench.suite) {
            Some(text) => print(text),
            None => Err(unknown(name, "no built-in suite", BENCHES.iter().filter(|bench| bench.suite.is_some()))),
        },
        [file] if Path::new(file).extension().is_some() => suite(&suite::load(file, args.quick)?, args, color),
        [name] => match named(name) {
            Some(bench) => one(bench, args.report.result.output.clone(), args, color),
            None => Err(unknown(name, "neither a bench nor a TOML file", BENCHES.iter())),
        },
        _ => Err(mistake(Exit::Usage, "one bench or file at a time, or `show` and a bench")),
    }
}

fn unknown<'a>(name: &str, what: &str, known: impl Iterator<Item = &'a Bench>) -> anyhow::Error {
    let known: Vec<&str> = known.map(|bench| bench.name).collect();
    let similar = nearest(name, known.iter().copied());
    let meant = if similar.is_empty() { known } else { similar };
    mistake(Exit::Input, format!("`{name}` is {what}; try {}", listed(meant, "or")))
}

fn all(args: &ValidateArgs, color: Color) -> anyhow::Result<Exit> {
    let mut failed = None;
    for bench in &BENCHES {
        say!("validate {}", bench.name);
        let dir = args.report.result.output.as_ref().map(|dir| dir.join(bench.name));
        let code = one(bench, dir, args, color)?;
        failed = failed.or((code != Exit::Done).then_some(code));
        if STOP.load(Ordering::Relaxed) {
            break;
        }
    }
    Ok(failed.unwrap_or(Exit::Done))
}

fn one(bench: &Bench, dir: Option<PathBuf>, args: &ValidateArgs, color: Color) -> anyhow::Result<Exit> {
    if args.list {
        return match bench.load(args.quick).transpose()? {
            Some(loaded) => print(&cases(&loaded)),
            None => print(&format!("{}: {}\n", bench.name, bench.about)),
        };
    }
    let executable = std::env::current_exe()?;
    let counted = (!args.no_count).then_some((executable.as_path(), ALONE.as_slice()));
    let what = What { name: bench.name, dir, is_suite: bench.suite.is_some(), counted };
    evidence(&what, args, color, bench.run)
}

fn suite(loaded: &LoadedSuite, args: &ValidateArgs, color: Color) -> anyhow::Result<Exit> {
    if args.list {
        return print(&cases(loaded));
    }
    let what = What { name: &loaded.name, dir: args.report.result.output.clone(), is_suite: true, counted: None };
    evidence(&what, args, color, |options| run_suite(loaded, options, |_, _| Ok(())))
}

fn cases(loaded: &LoadedSuite) -> String {
    loaded.cases.iter().map(|case| format!("{}: {}\n", case.name, case.command)).collect()
}

/// A bench or suite that is run.
struct What<'a> {
    name: &'a str,
    /// The folder for its files, if it is not the usual one.
    dir: Option<PathBuf>,
    is_suite: bool,
    counted: Option<(&'a Path, &'a [&'a str])>,
}

/// Runs a bench, writes its folder, unless `--no-report` is given, and prints. Fails where a target is missed.
fn evidence(
    what: &What,
    args: &ValidateArgs,
    color: Color,
    run: impl FnOnce(&mut Options) -> Result<Evidence, Error>,
) -> anyhow::Result<Exit> {
    let dir = (!args.report.no_report).then(|| what.dir.clone().unwrap_or_else(|| Path::new("out").join(what.name)));
    let folder = super::open(dir.as_deref())?;
    let progress = &mut |next: &str| {
        // A bench that is no suite has no other place where it could end.
        if !what.is_suite && STOP.load(Ordering::Relaxed) {
            std::process::exit(Exit::Interrupted as i32);
        }
        if !args.report.result.quiet {
            say!("{next}");
        }
    };
    let evidence = match run(&mut Options {
        quick: args.quick,
        count: args.count,
        seed: args.seed,
        counted: what.counted,
        stop: Some(&STOP),
        progress,
    }) {
        Ok(evidence) => evidence,
        Err(Error::Scene(error)) => return Err(error.into()),
        Err(Error::Study(StudyError::Interrupted)) => {
            say!("interrupted: the cases are not complete, and nothing is written");
            return Ok(Exit::Interrupted);
        }
        Err(error) => return Err(error.into()),
    };
    if let (Some(dir), Some(folder)) = (dir, folder) {
        write(&evidence, what.name, args.quick, &folder)?;
        if !args.report.result.quiet {
            say!("report: {}", dir.join("report.html").display());
        }
    }
    let tables = evidence.printed.as_ref().unwrap_or(&evidence.report.tables);
    print(&match args.report.result.format {
        Format::Json => format!("{:#}\n", evidence.json()),
        Format::Human if args.markdown => report::markdown(&evidence.docs),
        Format::Human => tables.iter().map(|table| table.terminal(color.stdout)).collect(),
    })?;
    for missed in &evidence.missed {
        say!("missed: {missed}");
    }
    Ok(if evidence.missed.is_empty() { Exit::Done } else { Exit::Missed })
}

/// Writes tables, figures and further files, in place of the result that the folder holds.
fn write(evidence: &Evidence, name: &str, quick: bool, folder: &Folder) -> anyhow::Result<()> {
    let dir = folder.unfinished();
    let footer = super::provenance().footer();
    let footer = footer.into_iter().chain(evidence.report.footer.clone()).collect();
    report::write(&Report { footer, ..evidence.report.clone() }, dir)?;
    for (file, text) in &evidence.files {
        fs::write(dir.join(file), text).with_context(|| format!("cannot write {}", dir.join(file).display()))?;
    }
    let manifest = json!({ "program": "sim-host", "version": sim::VERSION, "bench": name, "quick": quick, "complete": true });
    Ok(folder.finish(manifest)?)
}

fn alone(setting: &str) -> anyhow::Result<Exit> {
    let parts: Vec<&str> = setting.split(',').collect();
    let [method, steps, periods] = parts[..] else { anyhow::bail!("{setting:?} is not METHOD,STEPS,PERIODS") };
    let known = run_alone(method, steps.parse()?, periods.parse()?)?;
    if !known {
        say!("error: there is no method {method:?}");
    }
    Ok(if known { Exit::Done } else { Exit::Failed })
}

/// The arguments of a process, with `validate` before the name of a bench that stands by itself, as it did until version 0.1.
pub(super) fn with_verb(mut arguments: Vec<OsString>) -> Vec<OsString> {
    // `import` is a command of its own, and its bench is younger than the change.
    let is_old = |bench: &Bench, argument: &OsString| argument == bench.name && bench.name != "import";
    let verb = arguments.iter().skip(1).position(|argument| BENCHES.iter().any(|bench| is_old(bench, argument)));
    // Only what stands first is a command: `--color` may be before it.
    let Some(place) = verb.map(|place| place + 1).filter(|&place| match place {
        1 => true,
        2 => arguments[1].to_str().is_some_and(|text| text.starts_with("--color=")),
        3 => arguments[1] == "--color",
        _ => false,
    }) else {
        return arguments;
    };
    let name = arguments[place].to_string_lossy().into_owned();
    say!("note: `sim-host {name}` is `sim-host validate {name}` now; the old name goes with the next version");
    arguments.insert(place, "validate".into());
    arguments
}
