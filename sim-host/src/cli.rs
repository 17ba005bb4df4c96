//! The command line. Data goes to standard output, everything else to standard error.

/// Formats a line and writes it with [`note`].
macro_rules! say {
    ($($text:tt)*) => {
        $crate::cli::note(&format!($($text)*))
    };
}

mod advise;
#[cfg(feature = "board-model")]
mod board_model;
#[cfg(not(feature = "board-model"))]
#[path = "cli/board_model/absent.rs"]
mod board_model;
mod compare;
mod drawing;
mod examples;
mod exit;
mod explain;
mod export;
mod groups;
mod hint;
mod import;
mod interrupts;
mod junit;
mod link;
mod optimise;
mod progress;
mod provenance;
mod result_args;
mod run;
mod shell;
mod solve;
mod spectrum;
mod sweep;
mod validate;

use std::ffi::OsString;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use clap::{Args, ColorChoice, CommandFactory, FromArgMatches, Parser, Subcommand};
use clap_complete::Shell;
use columns::visible;

use self::drawing::DrawingArgs;
use self::exit::{EXIT_CODES, Exit, mistake};
use self::provenance::provenance;
use self::result_args::{Format, ReportArgs, ResultArgs};
use self::run::RunArgs;
use ::link::number_with_unit::joined;
use scene::load::{Loaded, load};
use scene::resolved::resolved_toml;
use scene::{builtin, schema, suite};
use sim::output::{Folder, OutputError, Owner};

/// Version, followed by the commit if the program was built in a checkout.
const VERSION: &str = env!("SIM_HOST_VERSION");

/// Scene that provides sensors, amplifier and limits if a transducer is given by its numbers.
const DEFAULT_SCENE: &str = "lock-cold";

/// Sonoglide simulator: the firmware's controller with a simulated piezo stack and friction
/// contact.
///
/// Without a command it runs the scene experiment-1, prints its tables and writes its report.
#[derive(Parser)]
#[command(name = "sim-host", version = VERSION, arg_required_else_help = false)]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
    /// When to use colour.
    #[arg(long, global = true, value_enum, default_value_t = ColorChoice::Auto)]
    color: ColorChoice,
}

#[derive(Subcommand)]
enum Command {
    /// Run a scene, check its expectations and write a report.
    #[command(after_help = EXIT_CODES)]
    Run(Box<RunArgs>),
    /// Run a scene at many points in parallel.
    ///
    /// Writes the metrics as Parquet and CSV, with Sobol indices, figures and a report.
    #[command(after_help = EXIT_CODES)]
    Sweep(Box<sweep::SweepArgs>),
    /// Join the shards of a sweep.
    Merge(sweep::MergeArgs),
    /// Find the values of a key at which a metric has a value.
    ///
    /// Samples the range of the key, and searches between all neighbours with the value between
    /// them: no monotonicity is assumed.
    #[command(after_help = EXIT_CODES)]
    Solve(solve::SolveArgs),
    /// Find the values of several keys at which a metric is best, within limits of others.
    ///
    /// Samples the ranges of the keys, and searches from each local optimum of the sample.
    #[command(after_help = EXIT_CODES)]
    Optimise(optimise::OptimiseArgs),
    /// Compute the resonances, the circuit and the stresses of a transducer or horn.
    ///
    /// Reads a scene with `[design]`, and writes its circuit as tables of a driven scene,
    /// `stack.toml`. Prints the same as `run` (docs/design.md).
    #[command(after_help = EXIT_CODES)]
    Design(run::DesignArgs),
    /// Export a scene for other simulators.
    #[command(subcommand, after_help = EXIT_CODES)]
    Export(export::Export),
    /// List the built-in scenes.
    List,
    /// Print a scene with all values, units and descriptions, as TOML.
    Show {
        #[command(flatten)]
        scene: SceneArgs,
    },
    /// Check that a scene is valid.
    Check {
        #[command(flatten)]
        scene: SceneArgs,
    },
    /// Recommend controller settings for a transducer.
    ///
    /// Takes a scene or the numbers of a transducer. Prints settings to paste into a scene, and the
    /// expected lock time, jitter and bandwidth.
    #[command(after_help = EXIT_CODES)]
    Advise(advise::AdviseArgs),
    /// Compare two runs, or a run with a measurement.
    #[command(after_help = EXIT_CODES)]
    Compare(compare::CompareArgs),
    /// Explain a metric, fault, limit, key, file or term.
    ///
    /// Without a name it lists everything that can be explained.
    Explain {
        /// A metric, the number or name of a fault or limit, a scene key, a file of a run, or a
        /// term of the glossary.
        #[arg(value_name = "METRIC|FAULT|LIMIT|KEY|FILE|TERM")]
        word: Vec<String>,
    },
    /// Import measured admittance or friction data.
    ///
    /// Writes fitted parameters with standard deviations, a report and a scene
    /// (docs/measured-data.md).
    #[command(after_help = EXIT_CODES)]
    Import(Box<import::ImportArgs>),
    /// Compute the time-frequency spectrum of a signal.
    ///
    /// Reads a trace, a capture or any table, and applies the short-time Fourier transform,
    /// wavelets or the Wigner-Ville distribution (docs/figures.md).
    Spectrum(Box<spectrum::SpectrumArgs>),
    /// Print the JSON Schema of scenes.
    Schema {
        /// Print the schema of suites instead (docs/ci.md).
        #[arg(long)]
        suite: bool,
    },
    /// Talk to a real or simulated driver board.
    #[command(after_help = EXIT_CODES)]
    Link(Box<link::LinkArgs>),
    /// Run your own suite of cases and compare each case with its targets.
    ///
    /// docs/ci.md describes the format.
    #[command(after_help = EXIT_CODES)]
    Validate(Box<validate::ValidateArgs>),
    /// Print shell completions.
    Completions {
        /// Shell.
        shell: Shell,
    },
    /// Print or write the manual pages.
    Man {
        /// Write the manual page of the program and one page per command into this folder.
        #[arg(short, long = "output", value_name = "DIR")]
        output: Option<PathBuf>,
    },
}

#[derive(Args, Default)]
struct SceneArgs {
    /// Name of a built-in scene, TOML file, or `-` for standard input.
    scene: String,
    /// Change one value, as `a.b=v` (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
}

impl SceneArgs {
    fn load(&self) -> anyhow::Result<Loaded> {
        Ok(load(&self.scene, &self.sets)?)
    }
}

/// Returns the words of the command line; those of `link` may have a unit apart from its number, as
/// `drive 2 V`.
fn words(arguments: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let arguments: Vec<OsString> = arguments.collect();
    let text: Option<Vec<String>> = arguments.iter().map(|word| word.to_str().map(str::to_owned)).collect();
    match text.filter(|words| words.get(1).is_some_and(|word| word == "link")) {
        Some(words) => joined(words).into_iter().map(OsString::from).collect(),
        None => arguments,
    }
}

/// Parses the arguments of this process, runs the command and returns the exit code.
pub fn main() -> ExitCode {
    let matches = command().try_get_matches_from(words(std::env::args_os())).unwrap_or_else(|error| {
        let arguments: Vec<String> = std::env::args().skip(1).collect();
        // Help and version are errors of clap, too.
        if let Some(meant) = hint::meant(error.kind(), &arguments).filter(|_| error.use_stderr()) {
            say!("error: {meant}");
            std::process::exit(Exit::Usage as i32);
        }
        error.exit()
    });
    let line = CommandLine::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let color = Color::new(line.color);
    let done = match line.command {
        None => run::run(&RunArgs::flagship(), color),
        Some(Command::Run(args)) => run::run(&args, color),
        Some(Command::Sweep(args)) => sweep::run(&args, color),
        Some(Command::Solve(args)) => solve::run(&args, color),
        Some(Command::Optimise(args)) => optimise::run(&args, color),
        Some(Command::Merge(args)) => sweep::merge(&args, color),
        Some(Command::Design(args)) => run::design(args, color),
        Some(Command::Export(export)) => export::run(&export),
        Some(Command::List) => print(&list()),
        Some(Command::Show { scene }) => scene.load().and_then(|loaded| print(&resolved_toml(&loaded.scene))),
        Some(Command::Check { scene }) => scene.load().and_then(|loaded| print(&format!("{}: valid\n", loaded.origin))),
        Some(Command::Explain { word }) => explain::run(&word.join(" ")),
        Some(Command::Compare(args)) => compare::run(&args, color),
        Some(Command::Advise(args)) => advise::run(&args, color),
        Some(Command::Spectrum(args)) => spectrum::run(&args, color),
        Some(Command::Import(args)) => import::run(&args, color),
        Some(Command::Validate(args)) => validate::run(&args, color),
        Some(Command::Link(args)) => link::run(&args, color),
        Some(Command::Completions { shell }) => shell::completions(shell),
        Some(Command::Man { output }) => shell::manual(output.as_deref()),
        Some(Command::Schema { suite }) => print(&format!("{:#}\n", if suite { suite::schema() } else { schema::schema() })),
    };
    done.unwrap_or_else(|error| exit::report(&error, color)).into()
}

/// Returns the command line with its groups of commands and its examples.
fn command() -> clap::Command {
    groups::add(examples::add(CommandLine::command()))
}

/// Use of colour for each stream: as `--color` states, or on a terminal without `NO_COLOR`.
#[derive(Clone, Copy)]
struct Color {
    stdout: bool,
    stderr: bool,
}

impl Color {
    fn new(choice: ColorChoice) -> Self {
        let colored = |terminal: bool| match choice {
            ColorChoice::Always => true,
            ColorChoice::Never => false,
            ColorChoice::Auto => terminal && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()),
        };
        Color { stdout: colored(io::stdout().is_terminal()), stderr: colored(io::stderr().is_terminal()) }
    }
}

/// Opens the given folder of a result, or its default folder.
fn open(dir: Option<&Path>, default: &str, owner: Owner) -> Result<Folder, OutputError> {
    let folder = match dir {
        Some(dir) => Folder::open(dir, owner),
        None => Folder::open_default(default, &owner),
    }?;
    if let Some(why) = folder.avoided() {
        say!("note: {why}: the result goes to `{}`", folder.dir().display());
    }
    Ok(folder)
}

/// Returns the message that this build lacks a part, with the commands that build it.
fn missing_part(part: &str) -> String {
    format!(
        "this build has no {part}; build with `--features full`: `cargo run --release --features full -- …` in a checkout, or \
         `cargo install --path sim-host --features full`"
    )
}

/// Time since the first call, used as the clock of all timing.
fn clock() -> Duration {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}

/// Writes a line to standard error, with control characters escaped.
fn note(line: &str) {
    note_styled(&visible(line));
}

/// Writes a line with escape codes of this program to standard error and ignores errors:
/// `eprintln!` panics if the reader is gone.
fn note_styled(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Writes a text to standard output, with control characters escaped.
fn print(text: &str) -> anyhow::Result<Exit> {
    print_styled(&visible(text))
}

/// Writes JSON, or a text with escape codes of this program, to standard output. Texts from outside
/// are already escaped in it.
fn print_styled(text: &str) -> anyhow::Result<Exit> {
    io::stdout().lock().write_all(text.as_bytes())?;
    Ok(Exit::Done)
}

/// Returns one line for each built-in scene: name and title.
fn list() -> String {
    let width = builtin::all().iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let title = |name: &str| load(name, &[]).map(|loaded| loaded.scene.title).unwrap_or_default();
    builtin::all().iter().map(|(name, _)| format!("{name:width$}  {}\n", title(name))).collect()
}
