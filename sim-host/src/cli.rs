//! The command line. Data goes to standard output, everything else to standard error.
//!
//! | exit code | means |
//! |---|---|
//! | 0 | done |
//! | 1 | the run failed |
//! | 2 | usage |
//! | 3 | invalid scene, or a measured file that is refused |
//! | 4 | the run finished, but an expectation was missed |
//! | 5 | board or link not found or lost |
//! | 130 | interrupted; the results so far are written, and marked |

/// Writes a line to standard error. A reader of it that has gone away is no failure, where `eprintln!` would panic.
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($text)*);
    }};
}

mod advise;
mod compare;
mod examples;
mod explain;
mod import;
mod interrupts;
mod junit;
mod link;
mod progress;
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

use clap::{Args, ColorChoice, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;

use report::{Drawing, PictureFormat, PrintSize};
use scene::load::{LoadError, Loaded, load};
use scene::resolved::resolved_toml;
use scene::{builtin, schema, suite};
use sim::output::{Folder, OutputError, Presentation};
use sim::provenance::{Provenance, command_line};

const EXIT_CODES: &str = "Exit codes: 0 done; 1 the run failed; 2 usage; 3 invalid scene, or a measured file that is refused; 4 the run finished but an expectation was \
missed; 5 QEMU or board not found or lost; 130 interrupted, with the results so far written and marked.";
/// Version and, where the program was built in a checkout, its commit.
const VERSION: &str = env!("SIM_HOST_VERSION");
/// The commit that the program was built from, with `+` where files had been changed since.
const COMMIT: Option<&str> = option_env!("SIM_HOST_COMMIT");
const RUN_FAILED: u8 = 1;
const USAGE: u8 = 2;
const INVALID_INPUT: u8 = 3;
const EXPECTATION_MISSED: u8 = 4;
const LOST: u8 = 5;
const INTERRUPTED: u8 = 130;

/// The scene that runs if none is named.
const FLAGSHIP: &str = "experiment-1";
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
    /// Run our own benches or a suite of your own, and compare each with its targets: the evidence behind docs/claims.md.
    #[command(after_help = validate::help())]
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

#[derive(Args)]
struct SceneArgs {
    /// A built-in scene's name, a TOML file, or `-` for standard input.
    scene: String,
    /// Change one value, as `a.b=v`. Repeatable.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
}

/// How the figures of a report are drawn.
#[derive(Args, Default)]
struct DrawingArgs {
    /// Size of the figures in print: a width, `88mm` of a column or `180mm` of two, or width x height, `120x80mm`; with letters as large as a paper's, and no
    /// title. Default: 1600 x 900 pixels.
    #[arg(long, value_name = "SIZE")]
    figure_size: Option<PrintSize>,
    /// Formats of the figures: `svg`, `png`, `pdf`, or several with commas between. Default: svg,png.
    #[arg(long, value_name = "FORMAT,…", value_delimiter = ',')]
    figure_format: Vec<PictureFormat>,
}

impl DrawingArgs {
    fn presentation(&self) -> Presentation {
        Presentation { drawing: self.drawing(), provenance: provenance() }
    }

    fn drawing(&self) -> Drawing {
        let mut formats = Vec::new();
        for &format in &self.figure_format {
            if !formats.contains(&format) {
                formats.push(format);
            }
        }
        let formats = if formats.is_empty() { Drawing::default().formats } else { formats };
        Drawing { size: self.figure_size, formats }
    }
}

#[derive(Args)]
struct RunArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Seed of all noise; the same as `--set seed=N`.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Of a scene with several `runs`: only this one of them, from 1, with its full report.
    #[arg(long, value_name = "R")]
    run: Option<u32>,
    /// Folder for manifest, summary, trace, report and figures, in place of the run that it holds; other files in it stay. Default: `out/SCENE`, with `-run-R`, `-pil` or `-board` behind.
    #[arg(short, long = "output", value_name = "DIR")]
    output: Option<PathBuf>,
    /// What to print on standard output.
    #[arg(long, value_enum, default_value_t = Format::Human)]
    format: Format,
    /// Write no files.
    #[arg(long)]
    no_report: bool,
    /// Write the expectations as JUnit test cases, for CI.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    #[command(flatten)]
    drawing: DrawingArgs,
    /// Run the controller as thumb code in QEMU, in lockstep with the same plant.
    #[arg(long)]
    pil: bool,
    /// Run the image that is flashed, on a model of its part, and replay what its controller saw. Without a file the image is built from the present
    /// source.
    #[arg(long, value_name = "ELF", num_args = 0..=1, require_equals = true, conflicts_with = "pil")]
    board: Option<Option<PathBuf>>,
    /// With --board: let the block interrupt take a part of its time only, as if the processor were so many times as fast there.
    #[arg(long, value_name = "X", requires = "board", value_parser = times)]
    board_speed: Option<f64>,
    /// With --board: what each function takes of the block interrupt.
    #[arg(long, requires = "board")]
    profile: bool,
    /// Say nothing but the result.
    #[arg(short, long)]
    quiet: bool,
    /// Say more: all metrics, and the modes that the controller goes through.
    #[arg(short, long)]
    verbose: bool,
}

/// How many times as fast a processor is.
fn times(text: &str) -> Result<f64, String> {
    let times = text.parse::<f64>().ok().filter(|times| (0.01..=100.0).contains(times));
    times.ok_or_else(|| "must be from 0.01 to 100".to_owned())
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Tables for a reader.
    Human,
    /// The summary, as JSON.
    Json,
}

/// Parses the arguments of this process, does what they say, and gives the exit code.
pub fn main() -> ExitCode {
    let matches = command().get_matches_from(validate::with_verb(std::env::args_os().collect()));
    let line = CommandLine::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let color = Color::new(line.color);
    let done = match line.command {
        None => run::run(&RunArgs::of_flagship(), color),
        Some(Command::Run(args)) => run::run(&args, color),
        Some(Command::Sweep(args)) => sweep::run(&args, color),
        Some(Command::Merge(args)) => sweep::merge(&args, color),
        Some(Command::List) => print(&list()),
        Some(Command::Show { scene }) => with_scene(&scene, color, |loaded| print(&resolved_toml(&loaded.scene))),
        Some(Command::Check { scene }) => with_scene(&scene, color, |loaded| print(&format!("{}: valid\n", loaded.origin))),
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
    done.unwrap_or_else(|error| {
        // A reader that has gone away (`sim-host list | head -1`) is no error.
        if error.downcast_ref::<io::Error>().is_some_and(|io| io.kind() == io::ErrorKind::BrokenPipe) {
            return ExitCode::SUCCESS;
        }
        say!("error: {error:#}");
        ExitCode::from(RUN_FAILED)
    })
}

/// The command line, with examples in its help.
fn command() -> clap::Command {
    examples::add(CommandLine::command())
}

impl RunArgs {
    fn of_flagship() -> Self {
        RunArgs {
            scene: SceneArgs { scene: FLAGSHIP.into(), sets: Vec::new() },
            seed: None,
            run: None,
            output: None,
            format: Format::Human,
            no_report: false,
            junit: None,
            drawing: DrawingArgs::default(),
            pil: false,
            board: None,
            board_speed: None,
            profile: false,
            quiet: false,
            verbose: false,
        }
    }
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

/// Opens the folder of a result, if there is to be one; the exit code where its files are not those of an earlier result.
fn open(dir: Option<&Path>) -> Result<Result<Option<Folder>, ExitCode>, OutputError> {
    match dir.map(Folder::open).transpose() {
        Err(error @ (OutputError::Strange { .. } | OutputError::Held { .. })) => {
            say!("error: {error}");
            Ok(Err(ExitCode::from(USAGE)))
        }
        folder => folder.map(Ok),
    }
}

/// Where what this process writes comes from.
fn provenance() -> Provenance {
    let arguments: Vec<String> = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
    let words = std::iter::once("sim-host").chain(anywhere(&arguments));
    // https://reproducible-builds.org/specs/source-date-epoch/
    let set =
        std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|seconds| jiff::Timestamp::from_second(seconds.parse().ok()?).ok());
    let date = set.unwrap_or_else(jiff::Timestamp::now);
    Provenance { command: Some(command_line(words)), commit: COMMIT.map(str::to_owned), date: Some(format!("{date:.0}")) }
}

/// Arguments without the folder of the result: they make the same one in any folder.
fn anywhere(arguments: &[String]) -> Vec<&str> {
    let mut kept = Vec::new();
    let mut words = arguments.iter().map(String::as_str);
    while let Some(word) = words.next() {
        match word {
            "-o" | "--output" => drop(words.next()),
            word if word.starts_with("--output=") || (word.starts_with("-o") && word.len() > 2) => {}
            word => kept.push(word),
        }
    }
    kept
}

/// Time since the first call: the clock of what is timed.
fn clock() -> Duration {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}

fn print(text: &str) -> anyhow::Result<ExitCode> {
    io::stdout().lock().write_all(text.as_bytes())?;
    Ok(ExitCode::SUCCESS)
}

/// The scene, or its problems on standard error and the exit code of an invalid scene.
fn with_scene(
    args: &SceneArgs,
    color: Color,
    then: impl FnOnce(&Loaded) -> anyhow::Result<ExitCode>,
) -> anyhow::Result<ExitCode> {
    with_scene_on(args, &[], color, then)
}

/// The same, with values for keys that the scene and its changes do not give.
fn with_scene_on(
    args: &SceneArgs,
    defaults: &[String],
    color: Color,
    then: impl FnOnce(&Loaded) -> anyhow::Result<ExitCode>,
) -> anyhow::Result<ExitCode> {
    match load(&args.scene, &args.sets).and_then(|loaded| loaded.with_defaults(defaults)) {
        Ok(loaded) => then(&loaded),
        Err(error) => Ok(invalid(&error, color)),
    }
}

/// Says what is wrong with a scene.
fn invalid(error: &LoadError, color: Color) -> ExitCode {
    match error {
        LoadError::Invalid(report) => say!("{}", report.render(color.stderr)),
        error => say!("error: {error}"),
    }
    ExitCode::from(INVALID_INPUT)
}

/// The built-in scenes: name and title.
fn list() -> String {
    let width = builtin::all().iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let title = |name: &str| load(name, &[]).map(|loaded| loaded.scene.title).unwrap_or_default();
    builtin::all().iter().map(|(name, _)| format!("{name:width$}  {}\n", title(name))).collect()
}

#[cfg(test)]
mod tests {
    use super::anywhere;

    #[test]
    fn a_command_is_repeated_without_its_folder() {
        let words = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
        for text in ["run lock -o out -q", "run lock --output out -q", "run lock --output=out -q", "run lock -oout -q"] {
            assert_eq!(anywhere(&words(text)), ["run", "lock", "-q"], "{text}");
        }
        assert_eq!(anywhere(&words("run lock --set a.o=1")), ["run", "lock", "--set", "a.o=1"]);
    }
}
