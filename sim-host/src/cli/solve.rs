//! `sim-host solve`.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use clap::Args;
use serde_json::json;

use super::{Color, Exit, Format, interrupts, mistake};
use report::TableBlock;
use scene::load::load;
use scene::shown;
use sim::numbers::precise;
use sim::study::solve::{Answer, Question, Root, SolveError};
use sim::study::sweep::unit;

/// `true` after Ctrl-C or any other request to end.
static STOP: AtomicBool = AtomicBool::new(false);

/// Metrics that are printed with the answer of a driven scene, if none are requested.
const OF_A_DRIVE: [&str; 3] = ["drive_peak_v", "drive_power_w", "tip_velocity_m_per_s"];

#[derive(Args)]
pub(super) struct SolveArgs {
    /// Name of a built-in scene, TOML file, or `-` for standard input.
    scene: String,
    /// Metric and its wanted value, for example `reduction_percent=70`.
    #[arg(long = "for", value_name = "METRIC=VALUE")]
    target: String,
    /// Key that is changed and its range; logarithmic if `:log` follows.
    #[arg(long, value_name = "KEY=LEAST:MOST[:log]")]
    by: String,
    /// Change one value of the scene, as `a.b=v` (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Further metrics to print with the answer.
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    metric: Vec<String>,
    /// Number of runs in parallel. Default: the number of processors.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Format of standard output.
    #[arg(long, value_enum, default_value_t = Format::Human)]
    format: Format,
}

/// Finds the values of a key at which a metric has a value.
pub(super) fn run(args: &SolveArgs, color: Color) -> anyhow::Result<Exit> {
    let parsed = args.target.split_once('=').and_then(|(metric, value)| Some((metric.trim(), value.trim().parse::<f64>().ok()?)));
    let Some((metric, target)) = parsed.filter(|(_, value)| value.is_finite()) else {
        let why =
            format!("`--for {}` is not a metric with a number: write, for example, `--for reduction_percent=70`", args.target);
        return Err(mistake(Exit::Usage, why));
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.jobs.unwrap_or(0).into()).build()?;
    let loaded = load(&args.scene, &args.sets)?;
    let mut metrics = vec![metric.to_owned()];
    let of_a_drive = OF_A_DRIVE.iter().filter(|_| args.metric.is_empty() && loaded.scene.controller.is_some());
    metrics.extend(of_a_drive.map(|&name| name.to_owned()).chain(args.metric.iter().cloned()).filter(|name| name != metric));
    let question = Question { loaded: &loaded, range: args.by.parse()?, metrics, target };
    interrupts::set(&STOP)?;
    let runs = AtomicU64::new(0);
    let count = || {
        runs.fetch_add(1, Ordering::Relaxed);
    };
    let answer = pool.install(|| question.answer(&STOP, &count)).map_err(|error| match error {
        SolveError::Question(error) => anyhow::Error::from(error),
        SolveError::Run(error) => error.into(),
    })?;
    let Some(answer) = answer else {
        say!("interrupted: no answer");
        return Ok(Exit::Interrupted);
    };
    super::print_styled(&match args.format {
        Format::Human => human(&question, &answer, color),
        Format::Json => format!("{:#}\n", json(&question, &answer)),
    })?;
    for why in &answer.failures {
        say!("note: without a value in a part of the range: {why}");
    }
    if answer.roots.is_empty() && answer.samples.iter().all(|(_, value)| value.is_none()) {
        return Ok(Exit::Failed);
    }
    if args.format == Format::Human {
        say!("{} runs", runs.into_inner());
    }
    Ok(if answer.roots.is_empty() { Exit::Missed } else { Exit::Done })
}

/// Returns a name with its unit.
fn with_unit(name: &str) -> String {
    match unit(name).as_str() {
        "1" | "" => name.to_owned(),
        unit => format!("{name} [{unit}]"),
    }
}

fn human(question: &Question, answer: &Answer, color: Color) -> String {
    let (metric, target, key) = (&question.metrics[0], shown(question.target), &question.range.key);
    let (from, to) = question.range.ends;
    let range = format!("{key} from {} to {}", shown(from), shown(to));
    if answer.roots.is_empty() {
        let found: Vec<(f64, f64)> = answer.samples.iter().filter_map(|(at, value)| Some((*at, (*value)?))).collect();
        let by = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        return match (found.iter().min_by(by), found.iter().max_by(by)) {
            (Some(least), Some(most)) => format!(
                "{metric} is never {target} at {range}: it is from {} (at {}) to {} (at {})\n",
                precise(least.1),
                precise(least.0),
                precise(most.1),
                precise(most.0)
            ),
            _ => format!("{metric} has no value at {range}\n"),
        };
    }
    let header = std::iter::once(with_unit(key)).chain(question.metrics.iter().map(|name| with_unit(name)));
    let cells = |root: &Root| {
        let metrics = root.metrics.iter().map(|value| value.map_or_else(|| "–".to_owned(), precise));
        std::iter::once(precise(root.value)).chain(metrics).collect::<Vec<_>>()
    };
    let jumps = answer.roots.iter().filter_map(|root| Some((root, root.jump?)));
    let jumps: String = jumps
        .map(|(root, (below, above))| {
            let at = precise(root.value);
            format!(" At {at} it jumps from {} to {}: there is no value in between.", precise(below), precise(above))
        })
        .collect();
    let caption = format!(
        "Each value is searched between neighbours of {} samples; two values within an interval are not seen.{jumps}",
        answer.samples.len()
    );
    let table = TableBlock {
        title: format!("Where {metric} is {target}, by {range}"),
        header: header.collect(),
        rows: answer.roots.iter().map(cells).collect(),
        caption,
        ..TableBlock::default()
    };
    table.terminal(color.stdout)
}

fn json(question: &Question, answer: &Answer) -> serde_json::Value {
    let of = |root: &Root| {
        let metrics = question.metrics.iter().zip(&root.metrics).map(|(name, value)| (name.clone(), json!(value)));
        json!({
            "value": root.value,
            "within": [root.within.0, root.within.1],
            "metrics": metrics.collect::<serde_json::Map<_, _>>(),
            "jump": root.jump.map(|(below, above)| [below, above]),
            "runs": root.runs,
        })
    };
    json!({
        "scene": question.loaded.name,
        "key": question.range.key,
        "metric": question.metrics[0],
        "target": question.target,
        "roots": answer.roots.iter().map(of).collect::<Vec<_>>(),
        "samples": answer.samples,
        "failures": answer.failures,
    })
}
