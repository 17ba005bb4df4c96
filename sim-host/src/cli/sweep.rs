//! `sim-host sweep` and `sim-host merge`.

pub(super) mod crossing;
mod estimate;
pub(super) mod progress;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use clap::Args;
use columns::file::MAX_DATA_BYTES;
use serde_json::{Map, Value, json};

use self::crossing::{Crossings, Target};
use self::progress::Progress;
use super::solve::note_keys;
use super::{Color, DrawingArgs, Exit, Format, ResultArgs, interrupts, mistake};
use scene::MAX_CONTOURS;
use scene::load::{Loaded, load};
use sim::output::sweep::{FolderError, Joined, Shard, SweepFolder, join};
use sim::output::{Presentation, default_dir};
use sim::study::sweep::design::Design;
use sim::study::sweep::{Rows, Sweep, SweepError, is_of_overlays};

/// `true` after Ctrl-C or any other request to end.
static STOP: AtomicBool = AtomicBool::new(false);

/// Word before a scene that requests only an estimate of the sweep's cost.
const PLAN: &str = "plan";
/// Value of `--metric` that selects all metrics.
const ALL: &str = "all";

#[derive(Args)]
#[command(override_usage = "sim-host sweep [plan] <SCENE> --over <KEY=START:STOP:N[:log]>… [OPTIONS]\n       \
                            sim-host sweep [plan] <SCENE> --sample sobol:<N> --over <KEY=LEAST:MOST[:log]>… [OPTIONS]\n       \
                            sim-host sweep [plan] <SCENE> --points <FILE> [OPTIONS]",
          mut_arg("output", |arg| arg.help("Folder of the sweep. Continues an unfinished one. Default: `out/SCENE-sweep`")))]
pub(super) struct SweepArgs {
    /// Name of a built-in scene, TOML file, or `-` for standard input. With `plan` before it, only
    /// the number of points and their cost are printed.
    #[arg(value_name = "SCENE", num_args = 1..=2, required = true)]
    scene: Vec<String>,
    /// Change one value at all points, as `a.b=v` (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Key and its values: a range of N values, with equal ratios if `:log` follows, or a list
    /// `key=a,b,c` (repeatable; all combinations are run). With --sample a range `key=a:b[:log]`.
    #[arg(long, value_name = "KEY=START:STOP:N[:log]")]
    over: Vec<String>,
    /// Sample the ranges of --over with N pairs of draws of a scrambled Sobol sequence, for
    /// first-order and total Sobol indices. Takes N (keys + 2) points; N should be a power of two.
    #[arg(long, value_name = "sobol:N", requires = "over")]
    sample: Option<String>,
    /// CSV of points: a first line with the keys, then one line per point.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["over", "sample"])]
    points: Option<PathBuf>,
    /// Metrics of each point, or `all` that it has (`sim-host explain` lists them).
    #[arg(long, value_name = "A,B|all", value_delimiter = ',', default_value = ALL)]
    metric: Vec<String>,
    /// Also print where a metric crosses this value, along the key with the most values.
    #[arg(long, value_name = "METRIC=VALUE", conflicts_with_all = ["sample", "points", "shard"])]
    target: Option<Target>,
    #[command(flatten)]
    result: ResultArgs,
    /// Number of points to run in parallel. Default: the number of processors.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Run only part I of N of the sweep, counted from 1, in its own or a common folder.
    /// `sim-host merge` joins the parts.
    #[arg(long, value_name = "I/N", default_value_t = Shard::WHOLE)]
    shard: Shard,
    #[command(flatten)]
    drawing: DrawingArgs,
    /// Levels of contour lines in the maps over two keys, in the unit of the metric, for example
    /// `0.5,0.9`. At most 16.
    #[arg(long, value_name = "LEVEL,…", value_delimiter = ',', value_parser = level, allow_hyphen_values = true)]
    contour: Vec<f64>,
}

/// Returns the options of a report. `[grid] contours` of a scene has the same limit.
fn presentation(drawing: &DrawingArgs, contours: &[f64]) -> anyhow::Result<Presentation> {
    if contours.len() > MAX_CONTOURS {
        return Err(mistake(Exit::Usage, format!("--contour: {} levels; at most {MAX_CONTOURS} are drawn", contours.len())));
    }
    Ok(Presentation { contours: contours.to_vec(), ..drawing.presentation() })
}

/// Parses the level of a contour line.
fn level(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|level: &f64| level.is_finite()).ok_or_else(|| "must be a finite number".to_owned())
}

#[derive(Args)]
#[command(mut_arg("output", |arg| arg.help("Folder for the result. Default: the first folder")))]
pub(super) struct MergeArgs {
    /// Folders of all shards of a sweep.
    #[arg(value_name = "DIR", required = true)]
    dirs: Vec<PathBuf>,
    #[command(flatten)]
    result: ResultArgs,
    #[command(flatten)]
    drawing: DrawingArgs,
    /// Levels of contour lines in the maps over two keys, in the unit of the metric, for example
    /// `0.5,0.9`. At most 16.
    #[arg(long, value_name = "LEVEL,…", value_delimiter = ',', value_parser = level, allow_hyphen_values = true)]
    contour: Vec<f64>,
}

/// Runs a sweep, or continues one.
pub(super) fn run(args: &SweepArgs, color: Color) -> anyhow::Result<Exit> {
    let (plan, scene) = match &args.scene[..] {
        [plan, scene] if plan == PLAN => (true, scene),
        [scene] => (false, scene),
        _ => {
            let named = args.scene.len();
            let why = format!("give one scene, with `{PLAN}` before it for an estimate of the cost; {named} are given");
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
    if let Some(target) = &args.target {
        target.check(sweep.design.count())?;
    }
    note_keys(&loaded, &sweep.design.keys(), args.result.quiet);
    if plan {
        return estimate::run(&sweep, args.shard, args.result.format);
    }
    // After the scene is read, which may come from an endless pipe.
    interrupts::set(&STOP)?;
    pool.install(|| sweep_into(args, &loaded, &sweep, color))
}

/// Returns the points that the arguments define.
fn design(args: &SweepArgs) -> Result<Design, SweepError> {
    let sample = |sample: &String| {
        let draws = sample.strip_prefix("sobol:").and_then(|draws| draws.parse().ok());
        draws.ok_or_else(|| SweepError::Sample(sample.clone()))
    };
    match (&args.points, args.sample.as_ref().map(sample).transpose()?) {
        (Some(path), _) => {
            let file = path.display().to_string();
            let read = columns::file::read(path, MAX_DATA_BYTES);
            let bytes = read.map_err(|io| SweepError::Open { file: file.clone(), io })?;
            Design::read(&file, &bytes[..])
        }
        (None, Some(draws)) => Design::sample(args.over.iter().map(|over| over.parse()).collect::<Result<_, _>>()?, draws),
        (None, None) => Design::product(args.over.iter().map(|over| over.parse()).collect::<Result<_, _>>()?),
    }
}

/// Returns the metrics by name; an empty list selects all.
fn metrics(args: &SweepArgs) -> Vec<String> {
    if args.metric == [ALL] {
        return Vec::new();
    }
    let target = args.target.iter().map(|target| &target.metric).filter(|name| !args.metric.contains(name));
    args.metric.iter().chain(target).cloned().collect()
}

fn sweep_into(args: &SweepArgs, loaded: &Loaded, sweep: &Sweep, color: Color) -> anyhow::Result<Exit> {
    let dir = args.result.output.clone().unwrap_or_else(|| default_dir(&format!("{}-sweep", loaded.name)));
    let shown = presentation(&args.drawing, &args.contour)?;
    let run = || -> Result<Option<Option<Joined>>, FolderError> {
        let folder = SweepFolder::open(&dir, sweep, args.shard, args.points.as_slice())?;
        for damaged in folder.damaged().iter().filter(|_| !args.result.quiet) {
            say!("note: {damaged}; its points are computed again");
        }
        let (whole, left) = (args.shard.count(sweep.design.count()), folder.left()?);
        if left < whole && !args.result.quiet {
            say!("{}: {} of {whole} points are already done", dir.display(), whole - left);
        }
        let progress = Progress::new(left, args.result.quiet);
        let complete = folder.run(sweep, &STOP, &|| progress.point())?;
        drop(progress);
        if sweep.unsettled() > 0 && !args.result.quiet {
            say!(
                "note: no steady state was found at {} of the computed points; their means are over the last periods of a run, \
                 as `sim-host run` of such a point explains",
                sweep.unsettled()
            );
        }
        if !complete {
            say!(
                "interrupted: {} of {whole} points are in {}; the same command continues from there",
                whole - folder.left()?,
                dir.display()
            );
            return Ok(None);
        }
        if !folder.is_whole()? {
            return Ok(Some(None));
        }
        join(std::slice::from_ref(&dir), &dir, &shown).map(|joined| Some(Some(joined)))
    };
    let done = run()?;
    if args.result.format == Format::Json && !matches!(done, Some(Some(_))) {
        super::print_styled(&format!("{:#}\n", json!({ "dir": dir, "complete": false })))?;
    }
    match done {
        None => Ok(Exit::Interrupted),
        Some(None) => {
            if !args.result.quiet {
                say!("shard {} is complete; `sim-host merge` joins the folders when all shards are", args.shard);
            }
            Ok(Exit::Done)
        }
        Some(Some(joined)) => {
            let target = args.target.as_ref().zip(joined.rows.as_ref());
            let crossings = target.and_then(|(target, rows)| Crossings::new(target, sweep, &joined.names.1, rows));
            if let (Some(target), None) = (&args.target, &crossings) {
                say!("note: no point has {}, so there is no crossing", target.metric);
            }
            show((&joined, crossings.as_ref()), &dir, &args.result, color)
        }
    }
}

/// Joins the shards of a sweep.
pub(super) fn merge(args: &MergeArgs, color: Color) -> anyhow::Result<Exit> {
    let target = args.result.output.as_ref().unwrap_or(&args.dirs[0]);
    let shown = presentation(&args.drawing, &args.contour)?;
    show((&join(&args.dirs, target, &shown)?, None), target, &args.result, color)
}

/// Returns a row for programs: its point, keys and metrics, the fault that ended the run, or the
/// reason that there is no result.
fn json_row(joined: &Joined, rows: &Rows, row: usize) -> Value {
    let (keys, metrics) = &joined.names;
    let mut json = Map::from_iter([("point".to_owned(), json!(rows.points[row]))]);
    json.extend(keys.iter().zip(&rows.keys).map(|(name, values)| (name.clone(), json!(values[row]))));
    json.extend(metrics.iter().zip(&rows.metrics).map(|(name, values)| (name.clone(), json!(values[row]))));
    json.insert("fault_code".to_owned(), json!(rows.fault_codes[row]));
    json.insert("failure".to_owned(), json!(rows.failures[row]));
    Value::Object(json)
}

/// Prints the result of a complete sweep.
fn show(
    (joined, crossings): (&Joined, Option<&Crossings>),
    dir: &Path,
    shown: &ResultArgs,
    color: Color,
) -> anyhow::Result<Exit> {
    super::print_styled(&match shown.format {
        Format::Human => {
            let tables: String = joined.tables.iter().map(|table| table.terminal(color.stdout)).collect();
            tables + &crossings.map_or_else(String::new, |crossings| crossings.text(color.stdout))
        }
        Format::Json => {
            let rows: Option<Vec<Value>> =
                joined.rows.as_ref().map(|rows| (0..rows.points.len()).map(|row| json_row(joined, rows, row)).collect());
            let json = json!({
                "points": joined.points,
                "failures": joined.failures,
                "absent": joined.absent,
                "dir": dir,
                "complete": true,
                "rows": rows,
                "assumed": joined.assumed,
                "target": crossings.map(Crossings::json),
            });
            format!("{json:#}\n")
        }
    })?;
    if joined.failures > 0 {
        say!("{} of {} points have no result: {}", joined.failures, joined.points, dir.join("failures.csv").display());
    }
    let (held, other): (Vec<&str>, Vec<&str>) =
        joined.absent.iter().map(String::as_str).partition(|metric| is_of_overlays(metric));
    if !other.is_empty() {
        say!("no point has {}: not defined for this scene", other.join(", "));
    }
    if !held.is_empty() {
        say!(
            "no point has {}: no curve of the run covers the measured curves in this unit; `sim-host run` states why",
            held.join(", ")
        );
    }
    if !shown.quiet {
        say!("report: {}", joined.page.display());
    }
    Ok(if joined.failures == joined.points { Exit::Failed } else { Exit::Done })
}
