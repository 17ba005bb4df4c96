//! `sim-host run`.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use anyhow::Context;
use clap::Args;

use super::board_model::Flashed;
use super::progress::Progress;
use super::{Color, DrawingArgs, Exit, Format, ReportArgs, SceneArgs, interrupts, junit, mistake, visible};
use link::as_on_board;
use pil::Qemu;
use scene::Driven;
use scene::load::{LoadError, Loaded, load};
use scene::settings::config;
use sim::output::{self, Owner};
use sim::processor::Processor;
use sim::run::RunError;
use sim::study::monte_carlo::draw::Draws;
use sim::study::monte_carlo::most_runs;
use sim::study::{self, Level, Options, Start, Study};
use sim::tables;

/// `true` after Ctrl-C or any other request to end.
static STOP: AtomicBool = AtomicBool::new(false);

/// Scene that runs if none is named.
const FLAGSHIP: &str = "experiment-1";
/// Help of `--output`.
const FOLDER: &str = "Folder for manifest, summary, trace, report and figures. Files of an earlier run are replaced, other \
                      files stay; a folder with files of another command, edited files, or an input of this run is refused. \
                      Default: `out/SCENE` with `-run-R`, `-pil` or `-board` appended, and `-run` if that folder may not be \
                      replaced";

/// Arguments of the command.
#[derive(Args, Default)]
#[command(mut_arg("output", |arg| arg.help(FOLDER)))]
pub(super) struct RunArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Seed of all noise; the same as `--set seed=N`.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Number of runs, each with newly drawn values of the scene's distributions; the same as
    /// `--set runs=N`.
    #[arg(long, value_name = "N")]
    samples: Option<u32>,
    /// Run only run R of a scene with several `runs`, counted from 1, with its full report.
    #[arg(long, value_name = "R")]
    run: Option<u32>,
    #[command(flatten)]
    report: ReportArgs,
    /// Write the expectations as JUnit test cases, for CI.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    #[command(flatten)]
    drawing: DrawingArgs,
    /// Run the controller as Thumb code in QEMU, in lockstep with the same plant.
    #[arg(long)]
    pil: bool,
    /// Run the flashed image on a model of its microcontroller, and replay the inputs of its
    /// controller. Without a file the image is built from the current source.
    #[arg(long, value_name = "ELF", num_args = 0..=1, require_equals = true, conflicts_with = "pil")]
    board: Option<Option<PathBuf>>,
    /// With --board: run the block interrupt as if the processor were X times faster.
    #[arg(long, value_name = "X", requires = "board", value_parser = times)]
    board_speed: Option<f64>,
    /// With --board: print the time of each function in the block interrupt.
    #[arg(long, requires = "board")]
    profile: bool,
    /// Print all metrics and the modes of the controller.
    #[arg(short, long)]
    verbose: bool,
}

/// Parses the factor by which a processor is faster.
pub(super) fn times(text: &str) -> Result<f64, String> {
    let times = text.parse::<f64>().ok().filter(|times| (0.01..=100.0).contains(times));
    times.ok_or_else(|| "must be from 0.01 to 100".to_owned())
}

impl RunArgs {
    /// Returns the arguments of a program that is started without any.
    pub(super) fn flagship() -> Self {
        RunArgs { scene: SceneArgs { scene: FLAGSHIP.into(), sets: Vec::new() }, ..Self::default() }
    }
}

/// Arguments of `design`.
#[derive(Args)]
#[command(mut_arg("output", |arg| arg.help(FOLDER)))]
pub(super) struct DesignArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    drawing: DrawingArgs,
}

/// Computes a design, as `run` does.
pub(super) fn design(args: DesignArgs, color: Color) -> anyhow::Result<Exit> {
    let loaded = load(&args.scene.scene, &args.scene.sets)?;
    if loaded.scene.design.is_none() {
        let message = format!("`{}` is not a design: it has no [design]; `sim-host run` runs any scene", loaded.name);
        return Err(mistake(Exit::Input, message));
    }
    let DesignArgs { scene, report, drawing } = args;
    run_loaded(&RunArgs { scene, report, drawing, ..RunArgs::default() }, &loaded, color)
}

/// Runs a scene, writes its folder and prints its result.
pub(super) fn run(args: &RunArgs, color: Color) -> anyhow::Result<Exit> {
    let mut sets = args.scene.sets.clone();
    sets.extend(args.seed.map(|seed| format!("seed={seed}")));
    sets.extend(args.samples.map(|runs| format!("runs={runs}")));
    let mut loaded = load(&args.scene.scene, &sets)?;
    if args.board.is_some() {
        let (adapted, lowered) = as_on_board::adapted(loaded)?;
        loaded = adapted;
        as_on_board::in_words(&lowered).into_iter().for_each(|said| say!("{said}"));
    }
    match args.run {
        None => run_loaded(args, &loaded, color),
        Some(number) if loaded.scene.runs == 1 || !(1..=most_runs(&loaded)).contains(&number) => {
            let have = if loaded.scene.runs == 1 { "is run once" } else { "has runs 1 to " };
            let last = if loaded.scene.runs == 1 { String::new() } else { most_runs(&loaded).to_string() };
            Err(mistake(Exit::Input, format!("there is no run {number}: `{}` {have}{last}", loaded.name)))
        }
        Some(number) => run_loaded(args, &single_run(&loaded, number)?, color),
    }
}

/// Makes a scene of one of the runs of a scene.
fn single_run(loaded: &Loaded, number: u32) -> Result<Loaded, LoadError> {
    let draws = Draws::of(&loaded.scene);
    let one = loaded.cell(&draws.draw(number).sets(&draws.keys))?;
    Ok(Loaded { run: Some(number), ..one })
}

fn run_loaded(args: &RunArgs, loaded: &Loaded, color: Color) -> anyhow::Result<Exit> {
    // After the scene is read, which may come from an endless pipe.
    interrupts::set(&STOP)?;
    let image = image(args, loaded)?;
    let run = args.run.map_or_else(String::new, |number| format!("-run-{number}"));
    let default = format!("{}{run}{}", loaded.name, image.as_ref().map_or("", Image::suffix));
    // A refused folder is reported before a run that may take long.
    let folder = args.report.open(&default, Owner::new("run", loaded.files()))?;
    let start = image.as_ref().map(|image| move |scene: &Driven| image.start(scene));
    let start = start.as_ref().zip(image.as_ref()).map(|(start, image)| Start { level: image.level(), processor: start });
    let mut progress = Progress::new(loaded.scene.duration_s, loaded.scene.runs, args.report.result.quiet);
    let report = &mut |reached| progress.at(reached);
    let options = Options { start, stop: Some(&STOP), progress: Some(report), clock: Some(super::clock), law: None };
    let study = study::run(loaded, options);
    drop(progress);
    let study = study?;
    if let Some(folder) = &folder {
        output::write_into(loaded, &study, folder, &args.drawing.presentation())?;
    }
    if let Some(path) = &args.junit {
        junit::write(&study, path).with_context(|| format!("cannot write `{}`", path.display()))?;
    }
    if matches!(args.report.result.format, Format::Json) {
        tables::not_drawn(&study).iter().for_each(|said| say!("warning: {said}"));
    }
    super::print_styled(&match args.report.result.format {
        Format::Human if args.report.result.quiet => visible(&tables::in_short(&study)),
        Format::Human => human(&study, args, color),
        Format::Json => format!("{:#}\n", output::printed(&study)),
    })?;
    if let Some(folder) = folder.filter(|_| !args.report.result.quiet) {
        say!("report: {}", folder.dir().join("report.html").display());
    }
    Ok(if study.interrupted {
        Exit::Interrupted
    } else if !study.passes() {
        Exit::Missed
    } else {
        Exit::Done
    })
}

/// Image that runs the controller outside this process.
enum Image {
    /// Controller in QEMU.
    Emulated(PathBuf),
    /// Flashed image on the model of its microcontroller.
    Flashed(Flashed),
}

impl Image {
    /// Suffix of the default folder of a run.
    fn suffix(&self) -> &'static str {
        match self {
            Image::Emulated(_) => "-pil",
            Image::Flashed(_) => "-board",
        }
    }

    fn level(&self) -> Level {
        match self {
            Image::Emulated(_) => Level::Pil,
            Image::Flashed(_) => Level::Board,
        }
    }

    fn start(&self, scene: &Driven) -> Result<Box<dyn Processor>, RunError> {
        match self {
            Image::Emulated(image) => Ok(Box::new(Qemu::start(image, &config(scene))?)),
            Image::Flashed(image) => image.start(scene, &STOP),
        }
    }
}

/// Returns the image that the arguments select, if any.
fn image(args: &RunArgs, loaded: &Loaded) -> anyhow::Result<Option<Image>> {
    let option = if args.pil { "--pil" } else { "--board" };
    if !args.pil && args.board.is_none() {
        return Ok(None);
    }
    let Some(scene) = loaded.scene.driven() else {
        let why = format!("{option} runs the controller as Thumb code, but `{}` has no [controller]", loaded.name);
        return Err(mistake(Exit::Input, why));
    };
    match &args.board {
        None => Ok(Some(Image::Emulated(pil::image()?))),
        Some(file) => {
            let image = Flashed::new(file.as_deref(), &scene, args.board_speed, args.profile)?;
            Ok(Some(Image::Flashed(image)))
        }
    }
}

fn human(study: &Study, args: &RunArgs, color: Color) -> String {
    let mut text = format!("{}\n\n", tables::title(study));
    if study.interrupted {
        text += &format!("INTERRUPTED after {}: the results cover that part only.\n\n", tables::reached(study));
    }
    for remark in tables::remarks(study) {
        text += &format!("{remark}\n\n");
    }
    text += &format!("{}\n\n", tables::headline_line(study));
    if let Some(modes) = tables::modes(study).filter(|_| args.verbose) {
        text += &format!("{modes}\n");
    }
    text = visible(&text);
    let mut tables = tables::tables(study);
    if args.verbose || study.judged.is_empty() {
        tables.push(tables::all_metrics(study));
    }
    for block in &tables {
        text += &block.terminal(color.stdout);
    }
    text + &visible(&tables::manner(study)) + "\n"
}
