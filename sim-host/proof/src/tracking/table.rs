//! The campaign as tables.

use super::bad_input::Defect;
use super::cases::{CASES, Family, Load};
use super::{Campaign, Found, Judged};
use report::TableBlock;
use sim::instruments::runs::statistics::{Spread, spread};
use sim::tables::number;

const COLD: [(&str, &str); 3] =
    [("100 Hz [ms]", "lock_time_100hz_ms"), ("20 Hz [ms]", "lock_time_20hz_ms"), ("4 Hz [ms]", "lock_time_4hz_ms")];
const STEP: [(&str, &str); 3] =
    [("100 Hz [ms]", "relock_time_100hz_ms"), ("20 Hz [ms]", "relock_time_20hz_ms"), ("4 Hz [ms]", "relock_time_4hz_ms")];
const DRIFT: [(&str, &str); 3] = [
    ("to 4 Hz [ms]", "lock_time_4hz_ms"),
    ("again to 4 Hz [ms]", "relock_time_4hz_ms"),
    ("largest error [Hz]", "frequency_error_max_hz"),
];

/// All tables.
pub fn tables(campaign: &Campaign) -> Vec<TableBlock> {
    vec![targets(campaign), cold(campaign), step(campaign), drift(campaign), anything(campaign), defects(campaign)]
}

/// The same as Markdown, for the documentation, with the commands behind.
pub fn markdown(campaign: &Campaign) -> String {
    report::markdown(&[tables(campaign), vec![commands(campaign)]].concat())
}

fn of(campaign: &Campaign, family: Family) -> impl Iterator<Item = &Found> {
    campaign.found.iter().filter(move |found| found.case.family == family)
}

/// Three digits.
fn shown(value: f64) -> String {
    if !value.is_finite() {
        return "never".into();
    }
    let places = if value.abs() < 1.0 {
        3
    } else if value.abs() < 100.0 {
        2
    } else {
        0
    };
    format!("{value:.places$}")
}

fn optional(value: Option<f64>) -> String {
    value.map_or_else(|| "–".into(), shown)
}

/// Median, 95th percentile and maximum.
fn three(found: &Found, metric: &str) -> String {
    let Some(Spread { median, p95, max, .. }) = spread(metric, found.runs.runs.iter().map(|run| &run.metrics)) else {
        return "–".into();
    };
    format!("{}, {}, {}", shown(median), shown(p95), shown(max))
}

fn two(found: &Found, metric: &str) -> String {
    let of = spread(metric, found.runs.runs.iter().map(|run| &run.metrics));
    of.map_or_else(|| "–".into(), |spread| format!("{}, {}", shown(spread.p95), shown(spread.max)))
}

fn flaws(found: &Found) -> String {
    found.flaws().map(|count| count.to_string()).join(", ")
}

fn targets(campaign: &Campaign) -> TableBlock {
    let row = |(found, judged): (&Found, Judged)| {
        let (metric, unit) = in_words(judged.target.metric);
        let verdict = if judged.holds() { "PASS" } else { "MISS" };
        vec![
            found.case.name.to_owned(),
            format!("{metric} [{unit}]"),
            number(judged.target.at_most),
            shown(judged.found),
            verdict.to_owned(),
        ]
    };
    let rows = campaign.found.iter().flat_map(|found| found.judged().map(move |judged| (found, judged))).map(row);
    TableBlock::new("targets", "Targets", "", &["case", "what", "at most", "found", ""], rows.collect())
}

fn in_words(metric: &str) -> (String, &'static str) {
    let (name, of) = metric.strip_suffix("_p95").map_or((metric, "median"), |name| (name, "95 %"));
    let (what, unit) = match name {
        "lock_time_20hz_ms" => ("to within 20 Hz", "ms"),
        "lock_time_4hz_ms" => ("to within 4 Hz", "ms"),
        "relock_time_20hz_ms" => ("again within 20 Hz", "ms"),
        "frequency_bias_hz" => ("bias", "Hz"),
        "frequency_jitter_hz" => ("jitter", "Hz"),
        _ => ("largest error", "Hz"),
    };
    (format!("{what}, {of}"), unit)
}

fn cold(campaign: &Campaign) -> TableBlock {
    let row = |found: &Found| {
        let mut row = vec![found.case.name.to_owned()];
        row.extend(COLD.map(|(_, metric)| three(found, metric)));
        row.push(found.bounds.times_ms.map(optional).join(", "));
        row.extend(["frequency_bias_hz", "frequency_jitter_hz"].map(|metric| two(found, metric)));
        row.push(flaws(found));
        row
    };
    let header = ["case", COLD[0].0, COLD[1].0, COLD[2].0, "bound: 20 Hz, 4 Hz [ms]", "bias [Hz]", "jitter [Hz]", "flaws"];
    let caption = "Times from the first sample of the lock stage: median, 95 % of the runs, largest. Bias, of its size, and jitter in steady state: 95 %, \
                   largest. Bound: no unbiased estimate from the same samples is played within 20 Hz, within 4 Hz, sooner at 95 %. Flaws: \
                   runs with a false lock, with a loss that was not noticed, and that ended in a fault.";
    TableBlock::new("cold", "Cold start", caption, &header, of(campaign, Family::Cold).map(row).collect())
}

fn step(campaign: &Campaign) -> TableBlock {
    let row = |found: &Found| {
        let mut row = vec![found.case.name.to_owned()];
        row.extend(STEP.map(|(_, metric)| three(found, metric)));
        row.push(found.bounds.times_ms.map(optional).join(", "));
        row.push(two(found, "frequency_bias_hz"));
        row.push(flaws(found));
        row
    };
    let header = ["case", STEP[0].0, STEP[1].0, STEP[2].0, "bound: 20 Hz, 4 Hz [ms]", "bias [Hz]", "flaws"];
    let caption = "Times from the step. The bound knows Lm, C0 and the moment of the step.";
    TableBlock::new("step", "Load step", caption, &header, of(campaign, Family::Step).map(row).collect())
}

fn drift(campaign: &Campaign) -> TableBlock {
    let row = |found: &Found| {
        let mut row = vec![found.case.name.to_owned()];
        row.extend(DRIFT.map(|(_, metric)| three(found, metric)));
        row.extend(["frequency_bias_hz", "frequency_jitter_hz"].map(|metric| two(found, metric)));
        row.push(optional(found.bounds.ramp_hz));
        row.push(flaws(found));
        row
    };
    let header = ["case", DRIFT[0].0, DRIFT[1].0, DRIFT[2].0, "bias [Hz]", "rms about it [Hz]", "bound [Hz rms]", "flaws"];
    let caption = "Times for good: of bursts, after that the drive is within 4 Hz in every block of every ON window, up to the disturbance, and again from it on; \
                   0 is a drive that never leaves. Errors in steady state while the resonance moves. The bound is of an estimate that takes the \
                   resonance for constant; one that follows the slope, as the observer does, can do better.";
    TableBlock::new("drift", "Drift and bursts", caption, &header, of(campaign, Family::Drift).map(row).collect())
}

fn anything(campaign: &Campaign) -> TableBlock {
    let row = |found: &Found| {
        let [false_locks, losses, faults] = found.flaws();
        let times = ["lock_time_20hz_ms", "relock_time_20hz_ms"].map(|metric| three(found, metric));
        let counts = [found.runs.runs.len() as f64, false_locks, losses, faults].map(|count| count.to_string());
        [vec![found.case.name.to_owned()], counts.to_vec(), times.to_vec()].concat()
    };
    let all: Vec<&Found> = of(campaign, Family::Anything).collect();
    let sum = |count: fn(&Found) -> f64| all.iter().map(|found| count(found)).sum::<f64>().to_string();
    let total = vec![
        "all".to_owned(),
        sum(|found| found.runs.runs.len() as f64),
        sum(|found| found.flaws()[0]),
        sum(|found| found.flaws()[1]),
        sum(|found| found.flaws()[2]),
        String::new(),
        String::new(),
    ];
    let header = ["case", "runs", "false locks", "undetected losses", "faults", "to 20 Hz [ms]", "again to 20 Hz [ms]"];
    let rows = all.iter().map(|found| row(found)).chain([total]).collect();
    TableBlock::new(
        "anything",
        "Anything at once",
        "Again: from the later of two steps; blocks without drive are not counted.",
        &header,
        rows,
    )
}

fn defects(campaign: &Campaign) -> TableBlock {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for defects in campaign.defects.chunk_by(|a, b| (a.name, a.running) == (b.name, b.running)) {
        let Some(first) = defects.first() else { continue };
        let when = if first.running { "while running" } else { "from the beginning" };
        let mut row = vec![
            first.name.to_owned(),
            when.to_owned(),
            first.expected.iter().map(|fault| fault.code().to_string()).collect::<Vec<_>>().join(" or "),
        ];
        row.extend(defects.iter().map(ends));
        rows.push(row);
    }
    let columns = Load::ALL.iter().map(|load| format!("Q {}", load.q));
    let header: Vec<String> = ["defect", "", "fault"].map(String::from).into_iter().chain(columns).collect();
    let caption = "The faults that came of it, and the longest time to silence, ms: from the defect, or from the first sample of the run. Unnoticed: runs in \
                   which a lock was claimed that was none any more.";
    TableBlock { id: "defects".into(), title: "Bad input".into(), caption: caption.into(), header, rows }
}

fn ends(defect: &Defect) -> String {
    let codes: Vec<String> = defect.found.iter().map(|code| if *code == 0 { "none".into() } else { code.to_string() }).collect();
    let time = defect.latest_ms.map_or_else(|| "–".into(), |ms| format!("{} ms", shown(ms)));
    let verdict = if defect.holds() { "" } else { "MISS " };
    let unnoticed = if defect.unnoticed == 0 { String::new() } else { format!("; {} runs unnoticed", defect.unnoticed) };
    format!("{verdict}{}: {time}{unnoticed}", codes.join(" or "))
}

fn commands(campaign: &Campaign) -> TableBlock {
    let ran = |name: &str| campaign.found.iter().any(|found| found.case.name == name);
    let rows = CASES.iter().filter(|case| ran(case.name)).map(|case| vec![case.name.to_owned(), format!("`{}`", case.command())]);
    TableBlock::new("commands", "Each case by itself", "", &["case", "command"], rows.collect())
}
