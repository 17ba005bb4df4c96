//! `selftest`: checks a bare Nucleo before an amplifier is connected.
//!
//! ```text
//! PA4 ──┬── PA0 (V)         PC3 ── 3.3 V         PA10 (enable) stays low
//!       ├── PA1 (I)
//!       └── PA7 (I)
//! ```
//!
//! The enable is muted first. A capture at rest gives mean, noise and histogram of both channels. A
//! scan order then begins with the tone of the controller's own self-test, which ends in a fault
//! because a wire is not a transducer. A second capture, triggered by that tone, gives gain, skew,
//! delay and distortion.

mod tone;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use firmware::board::capture::{Arm, CaptureVerb, Trigger};
use firmware::board::command::Command;
use firmware::seam::mode::Mode;
use firmware::seam::refusal::Refusal;
use serde_json::{Value, json};

use self::tone::Tone;
use super::capture::{Captured, fetch};
use super::{hardware, seconds};
use crate::answer::{Answer, quantity};
use crate::files::ResultFolder;
use crate::link_error::LinkError;
use crate::parameter::{parameter, report};
use crate::scale::Scale;
use crate::session::Session;
use report::{Axis, Figure, Report, Series};

/// Maximum time for a capture.
const CAPTURE_TIMEOUT: Duration = Duration::from_secs(2);
/// Largest accepted delay between the channels, s: the controller removes a constant one up to
/// this. A sample is 1 us.
const MAX_SKEW_S: f64 = 200e-9;
/// Largest accepted deviation of the gain from that of a wire, relative.
const MAX_GAIN_ERROR_REL: f64 = 0.05;
/// Largest accepted offset at rest, relative to half of the range (front-end test of the board).
const MAX_OFFSET_REL: f64 = 0.05;
/// Largest accepted deviation of the block rate from the nominal one, relative, in addition to the
/// uncertainty of its measurement: the internal oscillator is within 1 %.
const MAX_CLOCK_ERROR_REL: f64 = 5e-3;

/// Arguments of the command.
#[derive(Args, Clone, Debug)]
pub struct SelftestArgs {
    /// Time over which the clock of the board is compared with that of this computer.
    #[arg(long, value_name = "S", default_value = "1", value_parser = seconds)]
    clock_for: f64,
    /// Folder for `selftest.json` with the raw captures, and the figures; `sim-host compare`
    /// compares two such folders.
    #[arg(short, long = "output", value_name = "DIR")]
    output: Option<PathBuf>,
}

/// Rest of a channel, codes.
struct Rest {
    mean: f64,
    deviation: f64,
    histogram: BTreeMap<u16, usize>,
}

impl Rest {
    fn new(codes: &[u16]) -> Self {
        let count = codes.len().max(1) as f64;
        let mean = codes.iter().map(|&code| f64::from(code)).sum::<f64>() / count;
        let square = codes.iter().map(|&code| (f64::from(code) - mean).powi(2)).sum::<f64>() / count;
        let mut histogram = BTreeMap::new();
        codes.iter().for_each(|&code| *histogram.entry(code).or_default() += 1);
        Rest { mean, deviation: square.sqrt(), histogram }
    }
}

/// Runs the checks with the enable muted, and releases it afterwards.
pub fn run(args: &SelftestArgs, session: &mut Session) -> Result<Answer, LinkError> {
    let folder = session.folder("selftest", args.output.as_deref())?;
    if !matches!(session.status()?.mode, Mode::Idle | Mode::Fault) {
        return Err(LinkError::Failed("the self-test needs a silent board: send `stop` first".into()));
    }
    match session.client.order(Command::Mute(true)) {
        Err(LinkError::Refused { refusal: Refusal::Unknown, .. }) => {
            return Err(LinkError::Failed("the firmware of this board is too old: it cannot keep the enable low".into()));
        }
        done => done?,
    }
    let checked = check(args, folder, session);
    // In every case the controller is silent and without a fault before the enable is released.
    session.client.ignore_ctrl_c();
    let released = [Command::Idle, Command::ClearFault].into_iter().try_for_each(|order| session.client.order(order));
    let released =
        released.and_then(|()| session.wait(Duration::from_millis(20))).and_then(|()| session.client.order(Command::Mute(false)));
    let answer = checked?;
    released?;
    Ok(answer)
}

fn check(args: &SelftestArgs, folder: Option<ResultFolder>, session: &mut Session) -> Result<Answer, LinkError> {
    let scale = session.scale()?;
    let mut answer = Answer::to("selftest").line("the enable of the amplifier stays low");
    answer = hardware::ask(session)?.into_iter().fold(answer, hardware::in_words);
    let mut failures = Vec::new();
    let clock = clock(args.clock_for, &scale, session)?;
    answer = answer
        .line(format!("clock      {:+.2} % of this computer's, within {:.2} %", 100.0 * clock.0, 100.0 * clock.1))
        .field("clock_error", clock.0)
        .field("clock_error_uncertainty", clock.1);
    if clock.0.abs() > MAX_CLOCK_ERROR_REL + clock.1 {
        failures.push("the clock of the board deviates from that of this computer".to_owned());
    }
    session.client.order(Command::ClearFault)?;
    let at_rest = capture(Trigger::Now, session)?;
    let rests = [("V", Rest::new(&at_rest.v)), ("I", Rest::new(&at_rest.i))];
    for (name, rest) in &rests {
        let offset = rest.mean - scale.sense_mid_code;
        answer = answer
            .line(format!("rest {name}     mean {:.2} codes off the middle, noise {:.2} codes rms", offset, rest.deviation))
            .field(&format!("rest_{}_codes", name.to_lowercase()), offset)
            .field(&format!("noise_{}_codes", name.to_lowercase()), rest.deviation);
        if offset.abs() > MAX_OFFSET_REL * scale.sense_mid_code {
            failures.push(format!("{name} at rest is not at the middle of its range: wire PA4 to PA0, PA1 and PA7"));
        }
    }
    session.client.order(Command::Capture(CaptureVerb::Arm(Arm { trigger: Trigger::On, before: 0, lane: 0 })))?;
    session.client.order(Command::Scan)?;
    let played = fetch(CAPTURE_TIMEOUT, session).map_err(|error| {
        let fault = session.status().ok().and_then(|report| report.fault);
        let why = fault.map_or_else(|| error.to_string(), crate::words::fault);
        LinkError::Failed(format!("the board played no tone: {why}. Wire PA4 to PA0, PA1 and PA7, and PC3 to 3.3 V"))
    })?;
    let nominal_hz = report(parameter("drive.frequency_hz")?, &mut session.client)?.acts.into();
    let block_samples = session.identity.converters.block_samples.into();
    let found = tone::find(&played.v, &played.i, &played.drive, block_samples, scale.sample_hz, nominal_hz)
        .ok_or_else(|| LinkError::Failed("the capture of the tone contains no tone".into()))?;
    answer = tone_in_words(answer, &found, &scale, &mut failures);
    answer = answer.field("passed", failures.is_empty()).field("failures", failures.clone());
    if let (Some(folder), Some(dir)) = (folder, &args.output) {
        write(&answer, [&at_rest, &played], &rests, &scale, folder, session)?;
        answer = answer.line(format!("written: {}", dir.join("selftest.json").display()));
    }
    let verdict = if failures.is_empty() { "passed".to_owned() } else { format!("FAILED: {}", failures.join("; ")) };
    Ok(answer.line(verdict))
}

/// Adds the tone to the answer, and violated limits to the failures. The distortion is not judged:
/// it includes that of the buffer of the DAC.
fn tone_in_words(answer: Answer, tone: &Tone, scale: &Scale, failures: &mut Vec<String>) -> Answer {
    let wire = scale.sense_mid_code / scale.drive_mid_code;
    for (name, gain) in [("V", tone.v_gain), ("I", tone.i_gain)] {
        if (gain / wire - 1.0).abs() > MAX_GAIN_ERROR_REL {
            failures.push(format!("{name} has {gain:.3} codes per code of the DAC, a wire {wire:.0}"));
        }
    }
    // Without a tone in both channels, the skew is that of their noise.
    if failures.is_empty() && tone.skew_s.abs() > MAX_SKEW_S {
        failures.push("I is not sampled with V (a whole sample is 1 us)".to_owned());
    }
    answer
        .line(format!(
            "tone       {}, {:.1} codes of the DAC, in {} blocks",
            quantity(tone.frequency_hz, "Hz"),
            tone.played_codes,
            tone.blocks
        ))
        .line(format!("gain       V {:.4}, I {:.4} codes per code of the DAC; a wire has {wire:.0}", tone.v_gain, tone.i_gain))
        .line(format!("skew       I {:+.1} ns after V; V {:.2} us after the DAC", 1e9 * tone.skew_s, 1e6 * tone.delay_s))
        .line(format!("distortion {:.2} % (THD of V, harmonics 2 to 5; not judged)", 100.0 * tone.thd))
        .field("tone_hz", tone.frequency_hz)
        .field("tone_codes", tone.played_codes)
        .field("v_gain", tone.v_gain)
        .field("i_gain", tone.i_gain)
        .field("skew_s", tone.skew_s)
        .field("delay_s", tone.delay_s)
        .field("thd", tone.thd)
}

/// Returns the deviation of the board's block rate from the nominal one by this computer's clock,
/// and its uncertainty, relative.
fn clock(time_s: f64, scale: &Scale, session: &mut Session) -> Result<(f64, f64), LinkError> {
    let read = |session: &mut Session| -> Result<(f64, f64, u32), LinkError> {
        let before = session.client.now();
        let block = session.status()?.block;
        let after = session.client.now();
        Ok((0.5 * (before + after).as_secs_f64(), 0.5 * (after - before).as_secs_f64(), block))
    };
    let (began_s, began_within_s, first) = read(session)?;
    session.wait(Duration::from_secs_f64(time_s))?;
    let (ended_s, ended_within_s, last) = read(session)?;
    let board_s = f64::from(last.wrapping_sub(first)) * scale.block_s;
    let host_s = (ended_s - began_s).max(scale.block_s);
    // A block at each end, and half of each round trip.
    Ok((board_s / host_s - 1.0, (began_within_s + ended_within_s + scale.block_s) / host_s))
}

fn capture(trigger: Trigger, session: &mut Session) -> Result<Captured, LinkError> {
    session.client.order(Command::Capture(CaptureVerb::Arm(Arm { trigger, before: 0, lane: 0 })))?;
    fetch(CAPTURE_TIMEOUT, session)
}

/// Writes the raw captures with all results, a summary for `compare`, and the figures.
fn write(
    answer: &Answer,
    [at_rest, played]: [&Captured; 2],
    rests: &[(&str, Rest); 2],
    scale: &Scale,
    folder: ResultFolder,
    session: &Session,
) -> Result<(), LinkError> {
    let codes = |captured: &Captured| json!({ "v": captured.v, "i": captured.i, "drive": captured.drive });
    let raw = json!({ "port": session.client.port(), "results": answer.fields, "rest": codes(at_rest), "tone": codes(played) });
    let numbers = answer.fields.iter().filter(|(_, value)| value.is_f64());
    let metrics: serde_json::Map<String, Value> = numbers.map(|(name, value)| (name.clone(), value.clone())).collect();
    for (name, content) in [("selftest.json", raw), ("summary.json", json!({ "metrics": metrics }))] {
        folder.file(name, &format!("{content:#}\n"))?;
    }
    let series =
        |name: &str, x: Vec<f64>, y: Vec<f64>| Series { name: name.into(), csv_column: name.into(), x, y, ..Series::default() };
    let time_us: Vec<f64> = (0..played.v.len()).map(|n| 1e6 * n as f64 / scale.sample_hz).collect();
    let swing = |codes: &[u16], middle: f64| codes.iter().map(|&code| f64::from(code) - middle).collect();
    let wave = Figure {
        id: "tone".into(),
        title: "Tone of the self-test".into(),
        x: Axis { label: "time [µs]".into(), ..Axis::default() },
        y: Axis { label: "codes off the middle".into(), ..Axis::default() },
        series: vec![
            series("dac_codes", time_us.clone(), swing(&played.drive, scale.drive_mid_code)),
            series("v_codes", time_us.clone(), swing(&played.v, scale.sense_mid_code)),
            series("i_codes", time_us, swing(&played.i, scale.sense_mid_code)),
        ],
        ..Figure::default()
    };
    let counts = |(name, rest): &(&str, Rest)| {
        let (x, y) = rest.histogram.iter().map(|(&code, &count)| (f64::from(code) - scale.sense_mid_code, count as f64)).unzip();
        series(&format!("{}_samples", name.to_lowercase()), x, y)
    };
    let rest = Figure {
        id: "rest".into(),
        title: "Codes at rest".into(),
        x: Axis { label: "codes off the middle".into(), ..Axis::default() },
        y: Axis { label: "samples".into(), ..Axis::default() },
        series: rests.iter().map(counts).collect(),
        ..Figure::default()
    };
    let footer = session.provenance.footer();
    folder.report(&Report { title: "Self-test".into(), figures: vec![wave, rest], footer, ..Report::default() })?;
    folder.finish()
}
