//! `sim-host sweep` and `sim-host merge`.

mod estimate;
mod progress;

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use clap::Args;
use serde_json::json;

use self::progress::Progress;
use super::{Color, DrawingArgs, Exit, Format, ResultArgs, interrupts, mistake};
use scene::load::{Loaded, load};
use sim::output::default_dir;
use sim::output::sweep::{FolderError, Joined, Shard, SweepFolder, join};
use sim::study::sweep::design::Design;
use sim::study::sweep::{Sweep, SweepError, is_of_overlays};

/// Set by Ctrl-C, and by any other request to end.
static STOP: AtomicBool = AtomicBool::new(false);

/// Before a scene: only say what the sweep takes.
const PLAN: &str = "plan";
/// All metrics.
const ALL: &str = "all";

#[derive(Args)]
#[command(override_usage = "sim-host sweep [plan] <SCENE> --over <KEY=START:STOP:N[:log]>… [OPTIONS]\n       \
                            sim-host sweep [plan] <SCENE> --sample sobol:<N> --over <KEY=LEAST:MOST[:log]>… [OPTIONS]\n       \
                            sim-host sweep [plan] <SCENE> --points <FILE> [OPTIONS]",
          mut_arg("output", |arg| arg.help("Folder of the sweep. The same command again goes on where the sweep in it was left. Default: `out/SCENE-sweep`")))]
pub(super) struct SweepArgs {
    /// A built-in scene's name, a TOML file, or `-` for standard input. With `plan` before it nothing is written: only how many points there are, and
    /// what they take.
    #[arg(value_name = "SCENE", num_args = 1..=2, required = true)]
    scene: Vec<String>,
    /// Change one value at all points, as `a.b=v`. Repeatable.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// A key and its values: evenly spaced, or by equal ratios with `:log`; or some values, as `key=a,b,c`. Repeatable: every combination. With --sample the
    /// range of a key, as `key=a:b` or `key=a:b:log`.
    #[arg(long, value_name = "KEY=START:STOP:N[:log]")]
    over: Vec<String>,
    /// A sample of the ranges given by --over, of N pairs of draws of a scrambled Sobol sequence, which makes N (keys + 2) points: with first-order and
    /// total Sobol indices. A power of two is best.
    #[arg(long, value_name = "sobol:N", requires = "over")]
    sample: Option<String>,
    /// A CSV of points: a first line with the keys, then a line a point.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["over", "sample"])]
    points: Option<PathBuf>,
    /// The metrics of each point, or `all` that it has (`sim-host explain` lists them).
    #[arg(long, value_name = "A,B|all", value_delimiter = ',', default_value = ALL)]
    metric: Vec<String>,
    #[command(flatten)]
    result: ResultArgs,
    /// How many points to run at the same time. Default: as many as there are processors.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Run only the I-th of N parts of the sweep, counted from 1, into its own folder or a common one; `sim-host merge` joins them.
    #[arg(long, value_name = "I/N", default_value_t = Shard::WHOLE)]
    shard: Shard,
    #[command(flatten)]
    drawing: DrawingArgs,
}

#[derive(Args)]
#[command(mut_arg("output", |arg| arg.help("Where to put the result. Default: the first folder")))]
pub(super) struct MergeArgs {
    /// The folders of all shards of a sweep.
    #[arg(value_name = "DIR", required = true)]
    dirs: Vec<PathBuf>,
    #[command(flatten)]
    result: ResultArgs,
    #[command(flatten)]
    drawing: DrawingArgs,
}

/// Runs a sweep, or goes on with it.
pub(super) fn run(args: &SweepArgs, color: Color) -> anyhow::Result<Exit> {
    let (plan, scene) = match &args.scene[..] {
        [plan, scene] if plan == PLAN => (true, scene),
        [scene] => (false, scene),
        _ => {
            let named = args.scene.len();
            let why = format!("one scene is swept, with `{PLAN}` before it to see what it takes; {named} are named");
            return Err(mistake(Exit::Usage, why));
        }
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.jobs.unwrap_or(0).into()).build()?;
    let loaded = load(scene, &args.sets)?;
    let sweep = match Sweep::new(&loaded, design(args)?, &metrics(args)) {
        Err(SweepError::Scene(error)) => {
            say!("error: neither the first nor the last point is a valid scene");
            return Err(error.into());
        }
        made => made?,
    };
    if plan {
        return estimate::run(&sweep, args.shard, args.result.format);
    }
    // Not before the scene is read, which may come from a pipe that never ends.
    interrupts::set(&STOP)?;
    pool.install(|| sweep_into(args, &loaded, &sweep, color))
}

/// The points that the arguments ask for.
fn design(args: &SweepArgs) -> Result<Design, SweepError> {
    let sample = |sample: &String| {
        let draws = sample.strip_prefix("sobol:").and_then(|draws| draws.parse().ok());
        draws.ok_or_else(|| SweepError::Sample(sample.clone()))
    };
    match (&args.points, args.sample.as_ref().map(sample).transpose()?) {
        (Some(path), _) => {
            let file = path.display().to_string();
            let open = File::open(path).map_err(|io| SweepError::Open { file: file.clone(), io })?;
            Design::read(&file, open)
        }
        (None, Some(draws)) => Design::sample(args.over.iter().map(|over| over.parse()).collect::<Result<_, _>>()?, draws),
        (None, None) => Design::product(args.over.iter().map(|over| over.parse()).collect::<Result<_, _>>()?),
    }
}

/// The metrics by name; none of them is all.
fn metrics(args: &SweepArgs) -> Vec<String> {
    if args.metric == [ALL] { Vec::new() } else { args.metric.clone() }
}

fn sweep_into(args: &SweepArgs, loaded: &Loaded, sweep: &Sweep, color: Color) -> anyhow::Result<Exit> {
    let dir = args.result.output.clone().unwrap_or_else(|| default_dir(&format!("{}-sweep", loaded.name)));
    let run = || -> Result<Option<Option<Joined>>, FolderError> {
        let folder = SweepFolder::open(&dir, sweep, args.shard, args.points.as_slice())?;
        let (whole, left) = (args.shard.count(sweep.design.count()), folder.left()?);
        if left < whole && !args.result.quiet {
            say!("{}: {} of {whole} points are there already", dir.display(), whole - left);
        }
        let progress = Progress::new(left, args.result.quiet);
        let complete = folder.run(sweep, &STOP, &|| progress.point())?;
        drop(progress);
        if !complete {
            say!(
                "interrupted: {} of {whole} points are in {}; the same command goes on from there",
                whole - folder.left()?,
                dir.display()
            );
            return Ok(None);
        }
        if !folder.is_whole()? {
            return Ok(Some(None));
        }
        join(std::slice::from_ref(&dir), &dir, &args.drawing.presentation()).map(|joined| Some(Some(joined)))
    };
    match run()? {
        None => Ok(Exit::Interrupted),
        Some(None) => {
            if !args.result.quiet {
                say!("shard {} is complete; when all are, `sim-host merge` joins their folders", args.shard);
            }
            Ok(Exit::Done)
        }
        Some(Some(joined)) => show(&joined, &dir, &args.result, color),
    }
}

/// Joins the shards of a sweep.
pub(super) fn merge(args: &MergeArgs, color: Color) -> anyhow::Result<Exit> {
    let target = args.result.output.as_ref().unwrap_or(&args.dirs[0]);
    show(&join(&args.dirs, target, &args.drawing.presentation())?, target, &args.result, color)
}

/// Prints the result of a whole sweep.
fn show(joined: &Joined, dir: &Path, shown: &ResultArgs, color: Color) -> anyhow::Result<Exit> {
    super::print(&match shown.format {
        Format::Human => joined.tables.iter().map(|table| table.terminal(color.stdout)).collect(),
        Format::Json => {
            let json = json!({ "points": joined.points, "failures": joined.failures, "absent": joined.absent, "dir": dir, "complete": true });
            format!("{json:#}\n")
        }
    })?;
    if joined.failures > 0 {
        say!("{} of {} points have no result: {}", joined.failures, joined.points, dir.join("failures.csv").display());
    }
    let (held, other): (Vec<&str>, Vec<&str>) =
        joined.absent.iter().map(String::as_str).partition(|metric| is_of_overlays(metric));
    if !other.is_empty() {
        say!("no point has {}: it has no meaning in such a scene", other.join(", "));
    }
    if !held.is_empty() {
        say!(
            "no point has {}: the measured curves lie over no curve of such a run with this unit, as `sim-host run` of the scene says",
            held.join(", ")
        );
    }
    if !shown.quiet {
        say!("report: {}", joined.page.display());
    }
    Ok(if joined.failures == joined.points { Exit::Failed } else { Exit::Done })
}
