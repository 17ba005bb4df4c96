//! `sim-host optimise`.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use clap::{ArgGroup, Args};

use super::solve::{cause, heading, note_keys, note_unsettled, range, with_unit};
use super::sweep::progress::Progress;
use super::{Color, Exit, Format, interrupts, mistake};
use report::TableBlock;
use scene::load::load;
use scene::shown;
use sim::numbers::precise;
use sim::output::default_dir;
use sim::output::optimise::RunsFile;
use sim::study::optimise::{Answer, Goal, Known, Limit, Question, Run};

/// `true` after Ctrl-C or any other request to end.
static STOP: AtomicBool = AtomicBool::new(false);

/// Distance of a key from an end of its range, relative to the range, below which it is at the end.
const AT_END_REL: f64 = 1e-4;
/// Distance of a metric from its limit, relative to the limit, below which the limit is reached.
const AT_LIMIT_REL: f64 = 1e-3;

#[derive(Args)]
#[command(group(ArgGroup::new("goal").required(true).args(["minimise", "maximise"])),
          mut_arg("output", |arg| arg.help("Folder for a file with all runs, from which an interrupted search continues. Default: `out/SCENE-optimise`")))]
pub(super) struct OptimiseArgs {
    /// Name of a built-in scene, TOML file, or `-` for standard input.
    scene: String,
    /// Metric, or one of the keys, to make as small as possible.
    #[arg(long, value_name = "METRIC")]
    minimise: Option<String>,
    /// Metric, or one of the keys, to make as large as possible.
    #[arg(long, value_name = "METRIC")]
    maximise: Option<String>,
    /// Limit of a metric, for example "friction_ratio<=0.4" (repeatable).
    #[arg(long, value_name = "METRIC<=VALUE")]
    subject_to: Vec<String>,
    /// Key that is changed and its range; logarithmic if `:log` follows (repeatable).
    #[arg(long, value_name = "KEY=LEAST:MOST[:log]", required = true)]
    over: Vec<String>,
    /// Largest number of runs. Default: 2000, or 200 for a scene that drives a controller.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=1_000_000))]
    runs: Option<u32>,
    /// Change one value of the scene, as `a.b=v` (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Further metrics to print with the answer.
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    metric: Vec<String>,
    /// Number of runs in parallel. Default: the number of processors.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Folder of the result.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Write no file; an interrupted search then begins again.
    #[arg(long, conflicts_with = "output")]
    no_report: bool,
    /// Format of standard output.
    #[arg(long, value_enum, default_value_t = Format::Human)]
    format: Format,
    /// Print only the result.
    #[arg(short, long)]
    quiet: bool,
}

/// Finds the values of several keys at which a metric is best within limits.
pub(super) fn run(args: &OptimiseArgs, color: Color) -> anyhow::Result<Exit> {
    let (goal, objective) = match (&args.minimise, &args.maximise) {
        (Some(metric), _) => (Goal::Minimise, metric),
        (None, Some(metric)) => (Goal::Maximise, metric),
        (None, None) => return Err(mistake(Exit::Usage, "give --minimise METRIC or --maximise METRIC")),
    };
    let limits = args.subject_to.iter().map(|text| text.parse()).collect::<Result<Vec<Limit>, String>>();
    let limits = limits.map_err(|why| mistake(Exit::Usage, why))?;
    let ranges = args.over.iter().map(|text| range("--over", text)).collect::<anyhow::Result<Vec<_>>>()?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.jobs.unwrap_or(0).into()).build()?;
    let loaded = load(&args.scene, &args.sets)?;
    let runs = args.runs.map(u64::from);
    let question = Question::new(&loaded, ranges, (goal, objective.clone()), limits, (args.metric.clone(), runs));
    note_keys(&loaded, &question.keys(), args.quiet);
    question.check().map_err(anyhow::Error::from)?;
    interrupts::set(&STOP)?;
    let dir = args.output.clone().unwrap_or_else(|| default_dir(&format!("{}-optimise", loaded.name)));
    let file = (!args.no_report).then(|| RunsFile::open(&dir, &question)).transpose()?;
    let nothing = Known::new();
    let known = file.as_ref().map_or(&nothing, RunsFile::known);
    if !known.is_empty() && !args.quiet {
        say!("{}: {} runs are already done", dir.display(), known.len());
    }
    let progress = Progress::new(question.runs.saturating_sub(known.len() as u64), args.quiet);
    let done = |run: &Run| {
        file.iter().for_each(|file| file.add(run));
        progress.point();
    };
    let answer = pool.install(|| question.answer(known, &STOP, &done)).map_err(cause)?;
    drop(progress);
    let Some(answer) = answer else {
        match &file {
            Some(file) => say!("interrupted: the same command continues from {}", file.path().display()),
            None => say!("interrupted: no answer"),
        }
        return Ok(Exit::Interrupted);
    };
    file.iter().try_for_each(|file| file.finish(&answer.runs))?;
    super::print_styled(&match args.format {
        Format::Human => human(&question, &answer, color),
        Format::Json => format!("{:#}\n", answer.json(&question)),
    })?;
    if !args.quiet {
        notes(&answer);
        file.iter().for_each(|file| say!("all runs: {}", file.path().display()));
    }
    Ok(match (&answer.optima[..], answer.is_within_limits) {
        ([], _) => Exit::Failed,
        (_, false) => Exit::Missed,
        (_, true) => Exit::Done,
    })
}

/// Prints the number of runs without a result, and of those without a steady state.
fn notes(answer: &Answer) {
    let failed: Vec<&str> = answer.runs.iter().filter_map(|run| run.failure.as_deref()).collect();
    if let Some(first) = failed.first() {
        say!("note: {} of {} runs do not count; the first: {first}", failed.len(), answer.runs.len());
    }
    note_unsettled(answer.unsettled);
}

fn human(question: &Question, answer: &Answer, color: Color) -> String {
    let Some(best) = answer.optima.first() else {
        return format!("no run has a result: {} runs failed\n", answer.runs.len());
    };
    let keys = question.ranges.iter().zip(&best.values).map(|(range, &value)| {
        let part = range.part(value);
        let note = match () {
            () if part < AT_END_REL => "at the lower end of its range",
            () if part > 1.0 - AT_END_REL => "at the upper end of its range",
            () => "",
        };
        vec![with_unit(&range.key), precise(value), note.to_owned()]
    });
    let heading = heading(question.loaded, &question.keys());
    let is_key = |name: &String| question.ranges.iter().any(|range| range.key == *name);
    let own = |(name, _): &(&String, &Option<f64>)| !is_key(name);
    let metrics = question.metrics.iter().zip(&best.metrics).filter(own).map(|(name, value)| {
        let value_text = value.map_or_else(|| "–".to_owned(), precise);
        let limits = question.limits.iter().filter(|limit| limit.metric == *name).map(|limit| {
            let excess = question.excess(limit, best).unwrap_or(f64::NAN);
            let state = match () {
                () if excess > 0.0 => "exceeded",
                () if -excess < AT_LIMIT_REL * limit.value.abs() => "reached",
                () => "not reached",
            };
            format!("limit {} {} {state}", if limit.is_upper { "<=" } else { ">=" }, shown(limit.value))
        });
        vec![heading(name), value_text, limits.collect::<Vec<_>>().join(", ")]
    });
    let limits = question.limits.iter().map(Limit::text).collect::<Vec<_>>().join(" and ");
    let how = if question.goal == Goal::Minimise { "Smallest" } else { "Largest" };
    let with = if limits.is_empty() { String::new() } else { format!(" with {limits}") };
    let title = if answer.is_within_limits {
        format!("{how} {}{with}", question.metrics[0])
    } else {
        format!("No run has {limits}: the nearest one")
    };
    let caption = format!(
        "{} runs: {} sample the ranges, the others search from the best of them. An optimum that is narrower than the distance \
         of the samples can be missed: narrow the ranges, or use more --runs.",
        answer.runs.len(),
        answer.samples
    );
    let header = ["", "value", ""].map(str::to_owned);
    let best = TableBlock::new("optimum", &title, caption, &header, keys.chain(metrics).collect());
    let others = (answer.optima.len() > 1).then(|| {
        let keys = question.ranges.iter().map(|range| with_unit(&range.key));
        let header: Vec<String> = keys.chain(question.metrics.iter().filter(|name| !is_key(name)).map(&heading)).collect();
        let cells = |run: &Run| {
            let metrics = question
                .metrics
                .iter()
                .zip(&run.metrics)
                .filter(own)
                .map(|(_, value)| value.map_or_else(|| "–".to_owned(), precise));
            run.values.iter().map(|&value| precise(value)).chain(metrics).collect()
        };
        let rows = answer.optima[1..].iter().map(cells).collect();
        TableBlock::new("others", "Where the other searches ended", "", &header, rows)
    });
    std::iter::once(best).chain(others).map(|table| table.terminal(color.stdout)).collect()
}
