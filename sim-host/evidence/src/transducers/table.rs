//! Tables of the results, and a CSV file with a row for each transducer.

use super::draw::{KINDS, Transducer};
use super::outcome::{JudgedRun, Outcome, PARAMETERS};
use super::summary::{Counts, Summary, fault_of, faults};
use super::{CaseRuns, TransducerRuns};
use crate::campaign::{self, cells, columns, digits, or_dash};
use crate::evidence::Error;
use report::TableBlock;

/// Explanation of the outcome columns.
const OUTCOMES: &str = "Locked: within 1 Hz, or 0.5 % of the bandwidth if that is more. Good: locked outside that, where \
                        the tip velocity per volt is at most 1 % below its maximum. Reported: by limit 97, 98 or 107, \
                        or, half a bandwidth off, by fault 33 or 34. Silent: locked with a larger loss, without a \
                        report. False fault: ended by a fault whose documented reason does not apply, as every \
                        transducer is healthy. True fault: ended by a fault whose documented reason applies. Late: not \
                        locked in time, or ended by fault 31 or 32. Lock and power-on: median and 95 % of the time to \
                        within 20 Hz, or the bound if that is more, from the first sample of the lock stage and from \
                        power-on, of all runs that end locked. Bias: median and 95 % of its absolute value, of the same \
                        runs. The outcomes in transducers.csv are locked, good, named, silent, accused, refused and \
                        late.";
/// Headings of the outcomes.
const HEADER: &str =
    "runs | locked | good | reported | silent | false fault | true fault | late | lock [ms] | power-on [ms] | bias [Hz]";
/// Ranges of Q in the table by range.
const QUALITIES: [(f64, f64); 4] = [(0.0, 10.0), (10.0, 100.0), (100.0, 1000.0), (1000.0, f64::INFINITY)];
/// Ranges of the coupling in the table by range.
const COUPLINGS: [(f64, f64); 5] = [(0.0, 0.05), (0.05, 0.1), (0.1, 0.2), (0.2, 0.4), (0.4, 1.0)];

/// Builds all tables.
pub(super) fn tables(set: &[TransducerRuns], wide: &[TransducerRuns], cases: &[CaseRuns]) -> Vec<TableBlock> {
    let wider = outcomes_by_kind("wider", "Wider set, by kind", "Columns as above.", wide);
    vec![by_kind(set), wider, by_range(set), coverage(set), fault_codes(set), breaking_points(cases)]
}

/// Some transducers of the set, with their heading.
type Part<'a> = (String, Vec<&'a TransducerRuns>);

fn part<'a>(name: impl Into<String>, set: &'a [TransducerRuns], of: impl Fn(&TransducerRuns) -> bool) -> Part<'a> {
    (name.into(), set.iter().filter(|member| of(member)).collect())
}

fn summary(part: &Part) -> Summary {
    Summary::from_runs(part.1.iter().map(|member| &member.observer.judged))
}

fn kinds(set: &[TransducerRuns]) -> Vec<Part<'_>> {
    let of_kind = |kind: &'static super::draw::Kind| part(kind.name, set, move |member| member.transducer.kind == kind);
    KINDS.iter().map(of_kind).chain([part("all", set, |_| true)]).collect()
}

fn by_kind(set: &[TransducerRuns]) -> TableBlock {
    outcomes_by_kind("kinds", "Random set, by kind", OUTCOMES, set)
}

fn outcomes_by_kind(name: &str, title: &str, caption: &str, set: &[TransducerRuns]) -> TableBlock {
    let rows = kinds(set).iter().map(|part| outcomes(&part.0, &summary(part))).collect();
    TableBlock::new(name, title, caption, &columns(&format!("kind | {HEADER}")), rows)
}

fn by_range(set: &[TransducerRuns]) -> TableBlock {
    let quality = QUALITIES.map(|(from, to)| {
        let name = if to.is_finite() { format!("Q {from} to {to}") } else { format!("Q from {from}") };
        part(name, set, move |member| (from..to).contains(&member.transducer.q))
    });
    let coupling = COUPLINGS.map(|(from, to)| {
        let name = if to < 1.0 { format!("k {from} to {to}") } else { format!("k from {from}") };
        part(name, set, move |member| (from..to).contains(&member.transducer.coupling))
    });
    let prior = [("only the band is known", true), ("all nominal values are known, but wrong", false)]
        .map(|(name, band_only)| part(name, set, move |member| member.transducer.band_only == band_only));
    let parts = quality.into_iter().chain(coupling).chain(prior);
    let mut rows: Vec<_> = parts.map(|part| outcomes(&part.0, &summary(&part))).collect();
    rows.push(outcomes(
        "all, by `phase_lock`",
        &Summary::from_runs(set.iter().filter_map(|member| Some(&member.phase_lock.as_ref()?.judged))),
    ));
    let caption = "Columns as above. The last row shows the same transducers with `tracking.mode = \"phase_lock\"`, which \
                   begins with a scan of the window; all other rows are with the observer.";
    let title = "Random set, by quality factor, coupling, nominal values and tracking mode";
    TableBlock::new("ranges", title, caption, &columns(&format!("part | {HEADER}")), rows)
}

/// Formats a row of outcomes.
fn outcomes(name: &str, of: &Summary) -> Vec<String> {
    let Counts { runs, locked, good, reported, silent, false_faults, true_faults, late } = &of.counts;
    let [lock, power_on, bias] =
        [&of.lock_ms, &of.power_on_ms, &of.bias_hz].map(|of| format!("{}, {}", digits(of.median), digits(of.p95)));
    cells![name, runs, locked, good, reported, silent, false_faults, true_faults, late, lock, power_on, bias]
}

fn coverage(set: &[TransducerRuns]) -> TableBlock {
    let row = |part: &Part| {
        let Summary { counts, stated, covered, beyond_stated, beyond_half_bandwidth, .. } = summary(part);
        let all = (stated > 0).then_some(stated as f64);
        let shares = covered.map(|count| or_dash(all, |all| format!("{:.0} %", 100.0 * count as f64 / all)));
        let end_locked = counts.locked + counts.good + counts.silent;
        [cells![part.0, end_locked, stated], shares.to_vec(), cells![beyond_stated, beyond_half_bandwidth]].concat()
    };
    let within: String = PARAMETERS.iter().map(|name| format!("{name} within 2 sd | ")).collect();
    let header = format!("kind | end locked | with deviations | {within}bias beyond 3 sd | bias beyond half a bandwidth");
    let caption = "Runs that end locked without a limit. With deviations: runs that state standard deviations of the \
                   transducer. Within 2 sd: share of these whose true value is within two stated standard deviations (95 % \
                   would be correct). The last columns: runs whose bias is beyond three standard deviations of the \
                   resonance, or beyond half a bandwidth.";
    TableBlock::new(
        "coverage",
        "Random set, stated uncertainties",
        caption,
        &columns(&header),
        kinds(set).iter().map(row).collect(),
    )
}

fn fault_codes(set: &[TransducerRuns]) -> TableBlock {
    let row = |(code, (fault, all, holds)): (u8, (firmware::seam::fault::Fault, usize, usize))| {
        let of_kind = |part: &Part| {
            let count =
                part.1.iter().filter(|member| fault_of(&member.observer.judged).is_some_and(|(found, _)| found == fault)).count();
            (count > 0).then(|| format!("{count} {}", part.0))
        };
        let kinds = kinds(set);
        let kinds: Vec<String> = kinds[..KINDS.len()].iter().filter_map(of_kind).collect();
        cells![code, fault.called(), all, holds, kinds.join(", ")]
    };
    let rows = faults(set.iter().map(|member| &member.observer.judged)).into_iter().map(row).collect();
    let caption = "Faults that ended a run. A fault is true if its documented reason applies: a resonance outside the \
                   window (30), a C0 more than 40 % off its nominal value (25), an Lm off by more than a factor of two \
                   (34), more current than the range (21, 28). Faults 31 and 32 only report that there is no lock, and \
                   count as true.";
    TableBlock::new("faults", "Random set, faults", caption, &["fault", "name", "runs", "of which true", "kinds"], rows)
}

fn breaking_points(cases: &[CaseRuns]) -> TableBlock {
    let row = |case: &CaseRuns| {
        let runs = || case.runs.iter().map(|run| &run.judged);
        let summary = Summary::from_runs(runs());
        let codes = faults(runs()).into_iter().map(|(code, (_, count, _))| format!("{count} × {code}"));
        [outcomes(&case.name, &summary), cells![codes.collect::<Vec<_>>().join(", "), case.group]].concat()
    };
    let header = format!("case | {HEADER} | faults | group");
    let caption = "Columns as above. Faults: number of runs that ended in each fault. A run with a step is judged at its \
                   end; its times are those before the step.";
    TableBlock::new("breaking-points", "Breaking points", caption, &columns(&header), cases.iter().map(row).collect())
}

/// Returns the outcome as in the CSV file, and the number of its fault.
fn outcome(judged: &JudgedRun) -> [String; 2] {
    let fault = fault_of(judged).map_or_else(String::new, |(fault, _)| fault.code().to_string());
    let name = match judged.outcome {
        Outcome::Locked => "locked",
        Outcome::Good => "good",
        Outcome::Reported => "named",
        Outcome::Silent => "silent",
        Outcome::FalseFault(_) => "accused", // words: an outcome in the CSV
        Outcome::TrueFault(_) => "refused",
        Outcome::Late(_) => "late",
    };
    [name.to_owned(), fault]
}

/// Formats each transducer with its outcome and the command that repeats its run, as CSV.
pub(super) fn csv(set: &[TransducerRuns]) -> Result<String, Error> {
    let rows = set.iter().map(|TransducerRuns { transducer, observer, phase_lock }| {
        let (judged, nominal) = (&observer.judged, &transducer.nominal);
        let given = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.6e}"));
        let Transducer { number, kind, band_only, hz, q, coupling, c0_f, .. } = *transducer;
        let drawn = [hz, q, coupling, c0_f, transducer.rm_ohm(), transducer.figure_of_merit(), nominal.hz, nominal.q];
        let known = [nominal.lm_h, Some(transducer.lm_h()), nominal.c0_f].map(given);
        let times = [judged.bias_hz, judged.lock_ms, judged.power_on_ms].map(given);
        let quality = judged.quality.map(|quality| [quality.loss, quality.others, quality.misfit].map(f64::from));
        let quality: [String; 3] = core::array::from_fn(|place| given(quality.map(|quality| quality[place])));
        let stated = (0..PARAMETERS.len()).flat_map(|place| {
            let stated = judged.stated.map(|stated| stated[place]);
            [stated.map(|stated| stated.error), stated.map(|stated| stated.deviation)].map(given)
        });
        let stated: Vec<String> = stated.collect();
        let named = cells![number, kind.name, band_only];
        let drawn = drawn.map(|value| given(Some(value)));
        let other = phase_lock.as_ref().map_or_else(Default::default, |run| outcome(&run.judged));
        let own =
            [drawn.to_vec(), known.to_vec(), outcome(judged).to_vec(), times.to_vec(), quality.to_vec(), stated, other.to_vec()]
                .concat();
        [named, own, cells![observer.command]].concat()
    });
    campaign::csv(
        "number,kind,band_only,series_resonance_hz,q,coupling,c0_f,rm_ohm,figure_of_merit,nominal_hz,nominal_q,nominal_lm_h,\
         true_lm_h,nominal_c0_f,outcome,fault,bias_hz,lock_ms,power_on_ms,lock_loss,lock_others,lock_misfit,\
         resonance_error_hz,resonance_deviation_hz,q_error,q_deviation,rm_error_ohm,rm_deviation_ohm,\
         lm_error_h,lm_deviation_h,c0_error_f,c0_deviation_f,phase_lock_outcome,phase_lock_fault,command",
        rows,
    )
}
