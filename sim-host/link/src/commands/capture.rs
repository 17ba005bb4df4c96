//! `capture`: records voltage, current and drive sample by sample around a trigger.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use firmware::board::capture::{Arm, CaptureReport, CaptureState, CaptureVerb, PARTS, SAMPLES, Trigger};
use firmware::board::command::{Command, Reply};

use super::seconds;
use crate::answer::{Answer, quantity};
use crate::client::unexpected;
use crate::files::ResultFolder;
use crate::link_error::LinkError;
use crate::scale::Scale;
use crate::session::Session;
use report::{self, Axis, Figure, Report, Series, Span};
use sim::provenance::Provenance;

/// Arguments of the command.
#[derive(Args, Clone, Debug)]
pub struct CaptureArgs {
    /// Trigger of the capture.
    #[arg(long, value_enum, default_value_t = When::Now)]
    trigger: When,
    /// Number of samples before the trigger, up to 1024.
    #[arg(long, value_name = "N", default_value_t = 256)]
    before: u16,
    /// Lane whose drive is recorded, from 0.
    #[arg(long, value_name = "L", default_value_t = 0)]
    lane: u8,
    /// Maximum time to wait for the trigger.
    #[arg(long, value_name = "S", default_value = "10", value_parser = seconds)]
    within: f64,
    /// Only arm; `capture --read` reads the result later.
    #[arg(long, conflicts_with_all = ["read", "output"])]
    arm: bool,
    /// Read the result of an earlier `capture --arm`.
    #[arg(long, conflicts_with = "trigger")]
    read: bool,
    /// Folder for `capture.csv` and the figures as SVG and PNG.
    #[arg(short, long = "output", value_name = "DIR")]
    output: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum When {
    Now,
    Fault,
    On,
    Locked,
    Unlocked,
}

impl When {
    fn trigger(self) -> Trigger {
        match self {
            When::Now => Trigger::Now,
            When::Fault => Trigger::Fault,
            When::On => Trigger::On,
            When::Locked => Trigger::Locked,
            When::Unlocked => Trigger::Unlocked,
        }
    }
}

/// Capture as read from the board.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Captured {
    /// State, trigger block and lengths.
    pub report: CaptureReport,
    /// Codes of the voltage channel.
    pub v: Vec<u16>,
    /// Codes of the current channel.
    pub i: Vec<u16>,
    /// Drive codes played at the same time.
    pub drive: Vec<u16>,
}

/// Arms a capture, waits for it, reads it and writes it.
pub fn run(args: &CaptureArgs, session: &mut Session) -> Result<Answer, LinkError> {
    // An invalid folder is reported before the trigger.
    let folder = session.folder("capture", args.output.as_deref())?;
    if !args.read {
        if usize::from(args.before) > SAMPLES {
            return Err(LinkError::Usage(format!("--before must be 0 to {SAMPLES} samples, not {}", args.before)));
        }
        let arm = Arm { trigger: args.trigger.trigger(), before: args.before, lane: args.lane };
        session.client.order(Command::Capture(CaptureVerb::Arm(arm)))?;
        if args.arm {
            let name = args.trigger.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned());
            return Ok(Answer::to("capture")
                .line(format!("armed for the trigger `{name}`; `capture --read` reads the result"))
                .field("state", "armed"));
        }
    }
    let captured = fetch(Duration::from_secs_f64(args.within), session)?;
    let scale = session.scale()?;
    let peak = |codes: &[u16], worth: &dyn Fn(u16) -> f64| codes.iter().map(|&code| worth(code).abs()).fold(0.0, f64::max);
    let (volts, amperes) = (peak(&captured.v, &|code| scale.volts(code)), peak(&captured.i, &|code| scale.amperes(code)));
    let drive = peak(&captured.drive, &|code| scale.drive_volts(code));
    let count = captured.v.len();
    let mut answer = Answer::to("capture")
        .line(format!(
            "{count} samples at {}, {} of them before block {}; peaks {}, {}, drive {}",
            quantity(scale.sample_hz, "Hz"),
            captured.report.before,
            captured.report.block,
            quantity(volts, "V"),
            quantity(amperes, "A"),
            quantity(drive, "V")
        ))
        .field("samples", count)
        .field("before", captured.report.before)
        .field("block", captured.report.block)
        .field("peak_voltage_v", volts)
        .field("peak_current_a", amperes)
        .field("peak_drive_v", drive);
    if let (Some(dir), Some(folder)) = (&args.output, folder) {
        let provenance = session.provenance.clone();
        session.meanwhile(|| write(&captured, &scale, folder, &provenance))??;
        answer = answer
            .line(format!("written: {}", dir.join("capture.csv").display()))
            .field("csv", dir.join("capture.csv").to_string_lossy());
    }
    Ok(answer)
}

/// Waits until the capture is full, and reads it.
pub fn fetch(within: Duration, session: &mut Session) -> Result<Captured, LinkError> {
    let until = session.client.now() + within;
    let report = loop {
        let report = match session.client.ask(Command::Capture(CaptureVerb::State))? {
            Reply::Capture(report) => report,
            reply => return Err(unexpected("capture", &reply)),
        };
        let late = session.client.now() >= until;
        match report.state {
            CaptureState::Full => break report,
            CaptureState::Empty => return Err(LinkError::Failed("nothing is recorded: send `capture --arm` first".into())),
            CaptureState::Armed if late => {
                let why = format!("no trigger within {} s; the capture stays armed for `capture --read`", within.as_secs_f64());
                return Err(LinkError::Failed(why));
            }
            CaptureState::Triggered if late => {
                return Err(LinkError::Failed(
                    "the trigger has come, but the capture does not fill: the block stream has stopped".into(),
                ));
            }
            CaptureState::Armed | CaptureState::Triggered => session.wait(Duration::from_millis(10))?,
        }
    };
    let mut captured = Captured { report, ..Captured::default() };
    for number in 0..PARTS {
        match session.client.ask(Command::Capture(CaptureVerb::Read(number)))? {
            Reply::Captured(part) if part.part == number => {
                captured.v.extend(part.v);
                captured.i.extend(part.i);
                captured.drive.extend(part.drive);
            }
            reply => return Err(unexpected("capture --read", &reply)),
        }
    }
    captured.v.truncate(report.samples.into());
    captured.i.truncate(report.samples.into());
    captured.drive.truncate(report.samples.into());
    Ok(captured)
}

/// Writes codes and SI units as CSV, and the figures.
fn write(captured: &Captured, scale: &Scale, folder: ResultFolder, provenance: &Provenance) -> Result<(), LinkError> {
    let time_s: Vec<f64> =
        (0..captured.v.len()).map(|n| (n as f64 - f64::from(captured.report.before)) / scale.sample_hz).collect();
    let rows = time_s.iter().zip(&captured.v).zip(&captured.i).zip(&captured.drive);
    let lines = rows.map(|(((time_s, &v), &i), &drive)| {
        let (volts, amperes, drive_v) = (scale.volts(v), scale.amperes(i), scale.drive_volts(drive));
        format!("{time_s:.9},{volts:.6e},{amperes:.6e},{drive_v:.6e},{v},{i},{drive}\n")
    });
    let text = "time_s,voltage_v,current_a,drive_v,v_code,i_code,drive_code\n".to_owned() + &lines.collect::<String>();
    folder.file("capture.csv", &text)?;
    let time_us: Vec<f64> = time_s.iter().map(|time| 1e6 * time).collect();
    let curve = |name: &str, column: &str, y: Vec<f64>| Series {
        name: name.into(),
        csv_column: column.into(),
        x: time_us.clone(),
        y,
        ..Series::default()
    };
    let figure = |id: &str, title: &str, label: &str, series: Vec<Series>| Figure {
        id: id.into(),
        title: title.into(),
        x: Axis { label: "time since the trigger [µs]".into(), ..Axis::default() },
        y: Axis { label: label.into(), ..Axis::default() },
        series,
        shaded: vec![Span { from: 0.0, to: time_us.last().copied().unwrap_or(0.0), label: "after the trigger".into() }],
        interactive: true,
        band_limited: true,
        ..Figure::default()
    };
    let of = |codes: &[u16], worth: &dyn Fn(u16) -> f64| codes.iter().map(|&code| worth(code)).collect::<Vec<f64>>();
    let voltages = vec![
        curve("voltage at the stack", "voltage_v", of(&captured.v, &|code| scale.volts(code))),
        curve("drive as played", "drive_v", of(&captured.drive, &|code| scale.drive_volts(code))),
    ];
    let currents = vec![curve("current into the stack", "current_a", of(&captured.i, &|code| scale.amperes(code)))];
    let page = Report {
        title: "Capture".into(),
        subtitle: format!(
            "{} samples, {} before the trigger at block {}",
            captured.v.len(),
            captured.report.before,
            captured.report.block
        ),
        figures: vec![
            figure("capture_voltage", "Voltage and drive", "voltage [V]", voltages),
            figure("capture_current", "Current", "current [A]", currents),
        ],
        footer: provenance.footer(),
        ..Report::default()
    };
    folder.report(&page)?;
    folder.finish()
}
