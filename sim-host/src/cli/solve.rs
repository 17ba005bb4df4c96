//! `sim-host solve`.

use std::sync::atomic::AtomicBool;

use clap::Args;

use super::sweep::crossing::Target;
use super::sweep::progress::Progress;
use super::{Color, Exit, Format, interrupts, mistake};
use report::TableBlock;
use scene::load::{Assumed, Loaded, load};
use scene::shown;
use sim::numbers::precise;
use sim::study::solve::{Answer, Crossing, Question, Root, SAMPLES, SolveError};
use sim::study::sweep::axis::Range;
use sim::study::sweep::{SweepError, unit};
use sim::tables::mark;

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
    target: Target,
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
    /// Print only the result.
    #[arg(short, long)]
    quiet: bool,
}

/// Finds the values of a key at which a metric has a value.
pub(super) fn run(args: &SolveArgs, color: Color) -> anyhow::Result<Exit> {
    let Target { metric, value: target } = args.target.clone();
    let range = range("--by", &args.by)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.jobs.unwrap_or(0).into()).build()?;
    let loaded = load(&args.scene, &args.sets)?;
    let mut metrics = vec![metric.clone()];
    let of_a_drive = OF_A_DRIVE.iter().filter(|_| args.metric.is_empty() && loaded.scene.controller.is_some());
    metrics.extend(of_a_drive.map(|&name| name.to_owned()).chain(args.metric.iter().cloned()).filter(|name| *name != metric));
    let question = Question { loaded: &loaded, range, metrics, target };
    note_keys(&loaded, &[&question.range.key], args.quiet);
    interrupts::set(&STOP)?;
    let progress = Progress::new(SAMPLES, args.quiet);
    let answer = pool.install(|| question.answer(&STOP, &|| progress.point())).map_err(cause)?;
    drop(progress);
    let Some(answer) = answer else {
        say!("interrupted: no answer");
        return Ok(Exit::Interrupted);
    };
    super::print_styled(&match args.format {
        Format::Human => human(&question, &answer, color),
        Format::Json => format!("{:#}\n", answer.json(&question)),
    })?;
    if !args.quiet {
        notes(&answer);
    }
    Ok(match (answer.roots.is_empty(), answer.samples.iter().all(|(_, value)| value.is_none())) {
        (_, true) => Exit::Failed,
        (true, _) => Exit::Missed,
        _ => Exit::Done,
    })
}

/// Prints the parts of the range without a value, and the runs without a steady state.
fn notes(answer: &Answer) {
    if let (Some((first, why)), Some((last, _))) = (answer.failures.first(), answer.failures.last()) {
        let (count, why) = (answer.failures.len(), why.lines().next().unwrap_or_default());
        say!("note: {count} runs from {} to {} have no value; the first: {why}", shown(*first), shown(*last));
    }
    note_unsettled(answer.unsettled);
}

/// Parses the range of an option.
pub(super) fn range(option: &str, text: &str) -> anyhow::Result<Range> {
    text.parse().map_err(|error| match error {
        SweepError::Axis { text, why } => {
            mistake(Exit::Usage, format!("`{option} {text}` is not a range KEY=LEAST:MOST or KEY=LEAST:MOST:log: {why}"))
        }
        error => error.into(),
    })
}

/// Returns the error itself, by which the exit code is chosen.
pub(super) fn cause(error: SolveError) -> anyhow::Error {
    match error {
        SolveError::Question(error) => error.into(),
        SolveError::Run(error) => error.into(),
    }
}

/// Prints a note on the values that move with these keys, and one on the values that nobody set.
pub(super) fn note_keys(loaded: &Loaded, keys: &[&str], quiet: bool) {
    let notes = loaded.scene.coupled(keys).into_iter().chain(Assumed::remark(&loaded.assumed_with(keys)));
    notes.filter(|_| !quiet).for_each(|note| say!("note: {note}"));
}

/// Prints the number of runs without a steady state, if there are any.
pub(super) fn note_unsettled(count: u64) {
    if count > 0 {
        say!("note: in {count} runs no steady state was found; their means are over the last periods of a run");
    }
}

/// Returns a name with its unit.
pub(super) fn with_unit(name: &str) -> String {
    match unit(name).as_str() {
        "1" | "" => name.to_owned(),
        unit => format!("{name} [{unit}]"),
    }
}

/// Returns the heading of a metric, for a result in which these keys change: its name, its unit,
/// and a mark if it follows from a value that nobody set.
pub(super) fn heading<'a>(loaded: &'a Loaded, keys: &[&str]) -> impl Fn(&String) -> String + 'a {
    let assumed = loaded.assumed_with(keys);
    move |name| with_unit(name) + mark(&assumed, loaded.scene.controller.is_some(), name)
}

fn human(question: &Question, answer: &Answer, color: Color) -> String {
    let (metric, target, key) = (&question.metrics[0], shown(question.target), &question.range.key);
    let (from, to) = question.range.ends;
    let range = format!("{key} from {} to {}", shown(from), shown(to));
    let roots = (!answer.roots.is_empty()).then(|| {
        let heading = heading(question.loaded, &[key]);
        let header = std::iter::once(with_unit(key)).chain(question.metrics.iter().map(heading));
        let cells = |root: &Root| {
            let at = match root.within {
                (first, last) if root.runs == 0 && first < last => format!("{} to {}", shown(first), shown(last)),
                _ => precise(root.value),
            };
            let metrics = root.metrics.iter().map(|value| value.map_or_else(|| "–".to_owned(), precise));
            std::iter::once(at).chain(metrics).collect::<Vec<_>>()
        };
        let caption = format!(
            "Searched between {} samples of the range. Two crossings between the same two samples are missed: narrow the range \
             to find them.",
            answer.samples.len()
        );
        let rows = answer.roots.iter().map(cells).collect();
        TableBlock::new("roots", &format!("Where {metric} is {target}, by {range}"), caption, &header.collect::<Vec<_>>(), rows)
    });
    let crossings = (!answer.crossings.is_empty()).then(|| {
        let cells = |crossing: &Crossing| {
            let (below, above) = crossing.metric;
            vec![shown(crossing.within.0), precise(below), precise(above)]
        };
        TableBlock::new(
            "crossings",
            &format!("Where {metric} crosses {target} without reaching it"),
            "It has a step there, or scatters from run to run.",
            &[with_unit(key), "just below".to_owned(), "just above".to_owned()],
            answer.crossings.iter().map(cells).collect(),
        )
    });
    let found: Vec<(f64, f64)> = answer.samples.iter().filter_map(|(at, value)| Some((*at, (*value)?))).collect();
    let by = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
    let none = match (found.iter().min_by(by), found.iter().max_by(by)) {
        _ if !answer.roots.is_empty() || !answer.crossings.is_empty() => String::new(),
        (Some(least), Some(most)) if least.1 == most.1 => {
            format!("{metric} is {} at all of {} samples, by {range}\n", least.1, found.len())
        }
        (Some(least), Some(most)) => format!(
            "{metric} does not cross {target} between {} samples, by {range}: it is from {} (at {}) to {} (at {})\n",
            found.len(),
            least.1,
            shown(least.0),
            most.1,
            shown(most.0)
        ),
        _ => format!("{metric} has no value, by {range}\n"),
    };
    [roots, crossings].into_iter().flatten().map(|table| table.terminal(color.stdout)).collect::<String>() + &none
}
