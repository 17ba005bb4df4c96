//! The command line. Data goes to standard output, everything else to standard error.

/// Writes a line to standard error. A reader of it that has gone away is no failure, where `eprintln!` would panic.
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($text)*);
    }};
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
mod groups;
mod import;
mod interrupts;
mod junit;
mod link;
mod progress;
mod provenance;
mod result_args;
mod run;
mod shell;
mod spectrum;
mod sweep;
mod validate;

use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use clap::{Args, ColorChoice, CommandFactory, FromArgMatches, Parser, Subcommand};
use clap_complete::Shell;

use self::drawing::DrawingArgs;
use self::exit::{EXIT_CODES, Exit, mistake};
use self::provenance::provenance;
use self::result_args::{Format, ReportArgs, ResultArgs};
use self::run::RunArgs;
use scene::load::{Loaded, load};
use scene::resolved::resolved_toml;
use scene::{builtin, schema, suite};
use sim::output::{Folder, OutputError, Owner};

/// Version and, where the program was built in a checkout, its commit.
const VERSION: &str = env!("SIM_HOST_VERSION");

/// The scene that lends sensors, amplifier and limits to a transducer that is given by its numbers.
const LENDER: &str = "lock-cold";

/// Sonoglide's simulator: the firmware's own controller against a simulated stack and friction contact.
///
/// Without a command it runs the flagship scene, prints its table and writes its report.
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
    /// Run a scene, judge its expectations, and write its report.
    #[command(after_help = EXIT_CODES)]
    Run(Box<RunArgs>),
    /// Run a scene at many points, with some keys at many values, in parallel: metrics as Parquet and CSV, Sobol indices, figures and a report.
    #[command(after_help = EXIT_CODES)]
    Sweep(Box<sweep::SweepArgs>),
    /// Join the shards of a sweep that ran in several processes or on several machines.
    Merge(sweep::MergeArgs),
    /// List the built-in scenes, one line each.
    List,
    /// Show a scene fully resolved, as TOML with units and meanings.
    Show {
        #[command(flatten)]
        scene: SceneArgs,
    },
    /// Validate a scene only.
    Check {
        #[command(flatten)]
        scene: SceneArgs,
    },
    /// Advise on a transducer, by a scene or by its numbers: settings to paste, and the lock time, jitter and bandwidth to expect.
    #[command(after_help = EXIT_CODES)]
    Advise(advise::AdviseArgs),
    /// Compare two runs, or a run and a measurement: metrics with tolerances, figures laid over each other.
    #[command(after_help = EXIT_CODES)]
    Compare(compare::CompareArgs),
    /// Say what a metric, fault, limit, key or file means: unit, window, sign, columns, remedy. Without a word: all that can be explained.
    Explain {
        /// A metric, the number or name of a fault or limit, a key of a scene, or a file of a run.
        #[arg(value_name = "METRIC|FAULT|LIMIT|KEY|FILE")]
        word: Vec<String>,
    },
    /// Import measured data: parameters with standard deviations, a report, and a ready scene (docs/import.md).
    #[command(after_help = EXIT_CODES)]
    Import(Box<import::ImportArgs>),
    /// Show which frequencies a signal has when: short-time spectrum, wavelets or Wigner-Ville distribution of a trace, a capture, or any table (docs/figures.md).
    Spectrum(Box<spectrum::SpectrumArgs>),
    /// Print the JSON Schema of a scene, for editors.
    Schema {
        /// Of a suite of cases and targets instead (docs/suites.md).
        #[arg(long)]
        suite: bool,
    },
    /// Talk to a driver board, or to a simulated one.
    #[command(after_help = EXIT_CODES)]
    Link(Box<link::LinkArgs>),
    /// Run a suite of your own, and compare each case with its targets (docs/suites.md).
    #[command(after_help = EXIT_CODES)]
    Validate(Box<validate::ValidateArgs>),
    /// Print completions of commands and options for a shell.
    Completions {
        /// The shell.
        shell: Shell,
    },
    /// Print the manual page.
    Man {
        /// Write it into this folder, with a page for each command.
        #[arg(short, long = "output", value_name = "DIR")]
        output: Option<PathBuf>,
    },
}

#[derive(Args, Default)]
struct SceneArgs {
    /// A built-in scene's name, a TOML file, or `-` for standard input.
    scene: String,
    /// Change one value, as `a.b=v`. Repeatable.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
}

impl SceneArgs {
    fn load(&self) -> anyhow::Result<Loaded> {
        Ok(load(&self.scene, &self.sets)?)
    }
}

/// Parses the arguments of this process, does what they say, and gives the exit code.
pub fn main() -> ExitCode {
    let matches = command().get_matches();
    let line = CommandLine::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let color = Color::new(line.color);
    let done = match line.command {
        None => run::run(&RunArgs::of_flagship(), color),
        Some(Command::Run(args)) => run::run(&args, color),
        Some(Command::Sweep(args)) => sweep::run(&args, color),
        Some(Command::Merge(args)) => sweep::merge(&args, color),
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

/// The command line, with groups of commands and examples in its help.
fn command() -> clap::Command {
    groups::add(examples::add(CommandLine::command()))
}

/// Whether each stream gets colour: asked for, or a terminal with no `NO_COLOR`.
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

/// Opens the given folder of a result, or else its default one.
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

/// Says that this build lacks a part, and how to get a build that has it.
fn without(part: &str) -> String {
    format!(
        "this build has no {part}; a build with `--features full` has: `cargo run --release --features full -- …` in a checkout, or \
         `cargo install --path sim-host --features full`"
    )
}

/// Time since the first call: the clock of what is timed.
fn clock() -> Duration {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}

fn print(text: &str) -> anyhow::Result<Exit> {
    io::stdout().lock().write_all(text.as_bytes())?;
    Ok(Exit::Done)
}

/// The built-in scenes: name and title.
fn list() -> String {
    let width = builtin::all().iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let title = |name: &str| load(name, &[]).map(|loaded| loaded.scene.title).unwrap_or_default();
    builtin::all().iter().map(|(name, _)| format!("{name:width$}  {}\n", title(name))).collect()
}
