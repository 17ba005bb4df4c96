//! The results as tables, and each transducer as a line of numbers.

use sim::numbers::number;

use super::draw::KINDS;
use super::outcome::{Judged, Outcome, PARAMETERS};
use super::summary::{Summary, fault_of, faults};
use super::{TriedCase, TriedTransducer};
use crate::evidence::Error;
use report::TableBlock;

/// What the columns of the outcomes mean.
const OUTCOMES: &str = "Locked: within 1 Hz, or 0.5 % of the bandwidth if that is more. Named: locked outside that, and said so by limit 97, 98 or 107, or by fault 33 or 34. \
     Silent: locked outside that, with neither. Accused: ended by a fault that does not hold, as every transducer is healthy. Refused: ended by a fault \
     whose documented reason holds. Late: not locked in time, or ended by fault 31 or 32. Lock and power-on: median and 95 % of the time to within 20 Hz, or the bound if that \
     is more, from the first sample of the lock stage and from power-on, of all runs that end locked. Bias: median and 95 % of its size, of the same.";
/// Headings of the outcomes.
const HEADER: [&str; 10] =
    ["runs", "locked", "named", "silent", "accused", "refused", "late", "lock [ms]", "power-on [ms]", "bias [Hz]"];
/// Decades of Q, and steps of the coupling.
const QUALITIES: [(f64, f64); 4] = [(0.0, 10.0), (10.0, 100.0), (100.0, 1000.0), (1000.0, f64::INFINITY)];
const COUPLINGS: [(f64, f64); 5] = [(0.0, 0.05), (0.05, 0.1), (0.1, 0.2), (0.2, 0.4), (0.4, 1.0)];

/// All tables.
pub(super) fn tables(set: &[TriedTransducer], cases: &[TriedCase]) -> Vec<TableBlock> {
    vec![by_kind(set), by_range(set), coverage(set), fault_codes(set), breaking_points(cases)]
}

/// Some transducers of the set, by their heading.
type Part<'a> = (String, Vec<&'a TriedTransducer>);

fn part<'a>(name: impl Into<String>, set: &'a [TriedTransducer], of: impl Fn(&TriedTransducer) -> bool) -> Part<'a> {
    (name.into(), set.iter().filter(|tried| of(tried)).collect())
}

fn summary(part: &Part) -> Summary {
    Summary::of(part.1.iter().map(|tried| &tried.tried.judged))
}

fn kinds(set: &[TriedTransducer]) -> Vec<Part<'_>> {
    let of_kind = |kind: &'static super::draw::Kind| part(kind.name, set, move |tried| tried.transducer.kind == kind);
    KINDS.iter().map(of_kind).chain([part("all", set, |_| true)]).collect()
}

fn header(first: &str, rest: &[&str]) -> Vec<String> {
    std::iter::once(&first).chain(rest).map(|&heading| heading.to_owned()).collect()
}

fn by_kind(set: &[TriedTransducer]) -> TableBlock {
    let rows = kinds(set).iter().map(|part| outcomes(&part.0, &summary(part))).collect();
    TableBlock::new("kinds", "Random set, by kind", OUTCOMES, &header("kind", &HEADER), rows)
}

fn by_range(set: &[TriedTransducer]) -> TableBlock {
    let quality = QUALITIES.map(|(from, to)| {
        let name = if to.is_finite() { format!("Q {from} to {to}") } else { format!("Q from {from}") };
        part(name, set, move |tried| (from..to).contains(&tried.transducer.q))
    });
    let coupling = COUPLINGS.map(|(from, to)| {
        let name = if to < 1.0 { format!("k {from} to {to}") } else { format!("k from {from}") };
        part(name, set, move |tried| (from..to).contains(&tried.transducer.coupling))
    });
    let prior = [("only the band is known", true), ("nominal values are wrong", false)]
        .map(|(name, band_only)| part(name, set, move |tried| tried.transducer.band_only == band_only));
    let parts = quality.into_iter().chain(coupling).chain(prior);
    let mut rows: Vec<_> = parts.map(|part| outcomes(&part.0, &summary(&part))).collect();
    rows.push(outcomes("all, by `phase_lock`", &Summary::of(set.iter().map(|tried| &tried.phase_lock.judged))));
    let caption = "Columns as above. The last row is of the same transducers with `tracking.mode = \"phase_lock\"`, which begins with a scan of the window; all others are of the observer.";
    TableBlock::new(
        "ranges",
        "Random set, by quality factor, coupling, prior and mode of tracking",
        caption,
        &header("part", &HEADER),
        rows,
    )
}

/// A row of outcomes.
fn outcomes(name: &str, of: &Summary) -> Vec<String> {
    let counts = &of.counts;
    let both = |median: f64, p95: f64| format!("{}, {}", cell(median), cell(p95));
    let counted = [counts.runs, counts.locked, counts.named, counts.silent, counts.accused, counts.refused, counts.late];
    let mut row = vec![name.to_owned()];
    row.extend(counted.map(|count| count.to_string()));
    row.push(both(of.lock_ms.median, of.lock_ms.p95));
    row.push(both(of.power_on_ms.median, of.power_on_ms.p95));
    row.push(both(of.bias_hz.median, of.bias_hz.p95));
    row
}

/// A number with three digits, or a dash for what never comes.
fn cell(value: f64) -> String {
    if value.is_finite() { number(format!("{value:.2e}").parse().unwrap_or(value)) } else { "–".into() }
}

fn coverage(set: &[TriedTransducer]) -> TableBlock {
    let row = |part: &Part| {
        let Summary { counts, stated, covered, beyond_stated, beyond_half_bandwidth, .. } = summary(part);
        let share =
            |count: usize| if stated == 0 { "–".to_owned() } else { format!("{:.0} %", 100.0 * count as f64 / stated as f64) };
        let end_locked = counts.locked + counts.silent;
        let mut row = vec![part.0.clone(), end_locked.to_string(), stated.to_string()];
        row.extend(covered.map(share));
        row.extend([beyond_stated, beyond_half_bandwidth].map(|count| count.to_string()));
        row
    };
    let within = PARAMETERS.map(|name| format!("{name} within 2 sd"));
    let mut header = vec!["kind", "end locked", "state deviations"];
    header.extend(within.iter().map(String::as_str));
    header.extend(["bias beyond 3 sd", "bias beyond half a bandwidth"]);
    let caption = "Of the runs that end locked without a limit: those that state standard deviations of the transducer, the share of these of which the truth is \
                   within two stated standard deviations (95 % would be right), and the runs whose bias is beyond three of the resonance, or beyond half a bandwidth.";
    TableBlock::new("coverage", "Random set, stated uncertainties", caption, &header, kinds(set).iter().map(row).collect())
}

fn fault_codes(set: &[TriedTransducer]) -> TableBlock {
    let row = |(code, (fault, all, holds)): (u8, (firmware::seam::fault::Fault, usize, usize))| {
        let of_kind = |part: &Part| {
            let count =
                part.1.iter().filter(|tried| fault_of(&tried.tried.judged).is_some_and(|(found, _)| found == fault)).count();
            (count > 0).then(|| format!("{count} {}", part.0))
        };
        let kinds = kinds(set);
        let kinds: Vec<String> = kinds[..KINDS.len()].iter().filter_map(of_kind).collect();
        vec![code.to_string(), fault.called().to_owned(), all.to_string(), holds.to_string(), kinds.join(", ")]
    };
    let rows = faults(set.iter().map(|tried| &tried.tried.judged)).into_iter().map(row).collect();
    let caption = "Faults that have ended a run, and how many of them hold: a resonance outside the window (30), a C0 more than 40 % off its nominal value (25), an Lm off by more than two \
                   (34), more current than the range (21, 28); faults 31 and 32 say only that there is no lock.";
    TableBlock::new("faults", "Random set, faults", caption, &["fault", "name", "runs", "of which hold", "kinds"], rows)
}

fn breaking_points(cases: &[TriedCase]) -> TableBlock {
    let row = |case: &TriedCase| {
        let runs = || case.runs.iter().map(|run| &run.judged);
        let summary = Summary::of(runs());
        let codes = faults(runs()).into_iter().map(|(code, (_, count, _))| format!("{count} × {code}"));
        let mut row = outcomes(&case.name, &summary);
        row.extend([codes.collect::<Vec<_>>().join(", "), case.group.clone()]);
        row
    };
    let header = header("case", &HEADER).into_iter().chain(["faults", "group"].map(str::to_owned)).collect::<Vec<_>>();
    let caption = "Columns as above; faults: how many runs have ended in which. A step while running is judged by the end of the run; its times are those before the step.";
    TableBlock::new("breaking-points", "Breaking points", caption, &header, cases.iter().map(row).collect())
}

/// Name of an outcome, and the number of its fault.
fn outcome(judged: &Judged) -> (&'static str, Option<u8>) {
    let fault = fault_of(judged).map(|(fault, _)| fault.code());
    let name = match judged.outcome {
        Outcome::Locked => "locked",
        Outcome::Named => "named",
        Outcome::Silent => "silent",
        Outcome::Accused(_) => "accused",
        Outcome::Refused(_) => "refused",
        Outcome::Late(_) => "late",
    };
    (name, fault)
}

/// Each transducer with what became of it and the command that repeats its run.
pub(super) fn csv(set: &[TriedTransducer]) -> Result<String, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "number",
        "kind",
        "band_only",
        "series_resonance_hz",
        "q",
        "coupling",
        "c0_f",
        "rm_ohm",
        "figure_of_merit",
        "nominal_hz",
        "nominal_q",
        "nominal_lm_h",
        "true_lm_h",
        "nominal_c0_f",
        "outcome",
        "fault",
        "bias_hz",
        "lock_ms",
        "power_on_ms",
        "resonance_error_hz",
        "resonance_deviation_hz",
        "q_error",
        "q_deviation",
        "rm_error_ohm",
        "rm_deviation_ohm",
        "lm_error_h",
        "lm_deviation_h",
        "c0_error_f",
        "c0_deviation_f",
        "phase_lock_outcome",
        "phase_lock_fault",
        "command",
    ])?;
    for TriedTransducer { transducer, tried, phase_lock } in set {
        let (judged, nominal) = (&tried.judged, &transducer.nominal);
        let (outcome, fault) = outcome(judged);
        let given = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.6e}"));
        let mut record = vec![transducer.number.to_string(), transducer.kind.name.into(), transducer.band_only.to_string()];
        record.extend(
            [
                transducer.hz,
                transducer.q,
                transducer.coupling,
                transducer.c0_f,
                transducer.rm_ohm(),
                transducer.figure_of_merit(),
                nominal.hz,
                nominal.q,
            ]
            .map(|value| given(Some(value))),
        );
        record.extend([nominal.lm_h, Some(transducer.lm_h()), nominal.c0_f].map(given));
        record.extend([outcome.to_owned(), fault.map_or_else(String::new, |fault| fault.to_string())]);
        record.extend([judged.bias_hz, judged.lock_ms, judged.power_on_ms].map(given));
        for place in 0..PARAMETERS.len() {
            let stated = judged.stated.map(|stated| stated[place]);
            record.extend([stated.map(|stated| stated.error), stated.map(|stated| stated.deviation)].map(given));
        }
        let (outcome, fault) = self::outcome(&phase_lock.judged);
        record.extend([outcome.to_owned(), fault.map_or_else(String::new, |fault| fault.to_string()), tried.command.clone()]);
        writer.write_record(record)?;
    }
    let bytes = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
