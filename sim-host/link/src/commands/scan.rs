//! `scan`: finds the resonances and draws the admittance loop.
//!
//! The scan of the board sweeps faster than a resonance can follow. It identifies a circuit, and
//! the loop of that circuit is drawn. With `--points` the drive then locks and is offset from the
//! resonance in steps. The settled admittance of each step is drawn as a dot, which must lie on the
//! loop.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use firmware::board::command::{Command, Reply, ResonanceReport};
use firmware::seam::fault::Limit;
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use firmware::seam::transducer::Transducer;
use serde_json::json;

use super::circuit::in_words;
use crate::admittance::{self, Loop, branch};
use crate::answer::{Answer, quantity, short};
use crate::client::unexpected;
use crate::link_error::LinkError;
use crate::session::Session;
use crate::words;

/// Maximum duration of a scan.
const SCAN_TIMEOUT: Duration = Duration::from_secs(10);

/// Arguments of the command.
#[derive(Args, Clone, Debug)]
pub struct ScanArgs {
    /// Also measure the settled admittance at this number of points around the resonance; this
    /// drives at the configured amplitude.
    #[arg(long, value_name = "N", num_args = 0..=1, default_value_t = 0, default_missing_value = "41")]
    points: u16,
    /// Largest offset of these points to either side, in bandwidths of the resonance.
    #[arg(long, value_name = "B", default_value_t = 2.0)]
    reach: f64,
    /// Folder for the loop as SVG, PNG and CSV.
    #[arg(short, long = "output", value_name = "DIR")]
    output: Option<PathBuf>,
}

/// Scans, measures points and draws.
pub fn run(args: &ScanArgs, session: &mut Session) -> Result<Answer, LinkError> {
    // An invalid folder is reported before the scan.
    let folder = session.folder("scan", args.output.as_deref())?;
    let report = scan(session)?;
    let found = ask(session)?;
    let mut drawn = Loop::from_scan(report.transducer.as_ref(), &found);
    if args.points > 0 {
        drawn.measured = admittance::measure(args.points, args.reach, &drawn, session)?;
    }
    let answer = in_words(&report, list(&found, report.transducer.as_ref(), Answer::to("scan")));
    let answer = drawn.compared(answer);
    let answer = match (&args.output, folder) {
        (Some(dir), Some(folder)) => {
            drawn.write(&folder, &session.provenance)?;
            folder.finish()?;
            answer.line(format!("written: {}", dir.join("admittance.svg").display()))
        }
        _ => answer.line(drawn.in_terminal()),
    };
    Ok(answer)
}

/// Orders a scan, and waits for its end.
fn scan(session: &mut Session) -> Result<Telemetry, LinkError> {
    let before = session.status()?;
    session.check(&before)?;
    session.begin_drive()?;
    session.client.order(Command::Scan)?;
    let mut stage = None;
    let live = session.live;
    let ended = session.watch(SCAN_TIMEOUT, 1, |report| {
        if stage != Some(report.mode) {
            stage = Some(report.mode);
            live.stage(&words::mode(report.mode));
        }
        is_over(report, &before).then_some(*report)
    })?;
    let report = ended.ok_or_else(|| LinkError::Failed(format!("the scan has not ended within {} s", SCAN_TIMEOUT.as_secs())))?;
    session.mark_silent();
    session.check(&report)?;
    Ok(report)
}

/// Returns `true` if the order sent after the report `before` has ended. It begins with the block
/// that takes the order.
pub(super) fn is_over(report: &Telemetry, before: &Telemetry) -> bool {
    report.mode == Mode::Fault || report.mode == Mode::Idle && report.orders_sequence != before.orders_sequence
}

/// Returns the resonances of the last scan.
pub(super) fn ask(session: &mut Session) -> Result<ResonanceReport, LinkError> {
    match session.client.ask(Command::Resonances)? {
        Reply::Resonances(found) => Ok(found),
        reply => Err(unexpected("scan", &reply)),
    }
}

/// Lists the resonances of the last scan if the lock is uncertain.
pub(super) fn alternatives(report: &Telemetry, session: &mut Session, answer: Answer) -> Result<Answer, LinkError> {
    if report.limit != Some(Limit::LockUncertain) {
        return Ok(answer);
    }
    let found = ask(session)?;
    if found.found.iter().all(Option::is_none) {
        return Ok(answer.line("the lock is uncertain; `scan` lists the resonances"));
    }
    let answer = answer.line("the lock is uncertain; resonances found by the scan (* is driven):");
    Ok(list(&found, report.transducer.as_ref(), answer))
}

/// Lists all resonances in a table.
fn list(found: &ResonanceReport, transducer: Option<&Transducer>, answer: Answer) -> Answer {
    let c0_f = transducer.map(|transducer| f64::from(transducer.c0_f)).filter(|&c0_f| c0_f > 0.0);
    let mut rows = Vec::new();
    let mut answer = answer.line("    f_s [Hz]    f_p [Hz]       Q         Rm           Lm");
    for (place, resonance) in found.found.iter().enumerate().filter_map(|(place, found)| Some((place, found.as_ref()?))) {
        let chosen = found.chosen.map(usize::from) == Some(place);
        let branch = branch(resonance);
        let (hz, rm_ohm) = (branch.hz, branch.rm_ohm());
        let parallel_hz = c0_f.map(|c0_f| branch.parallel_hz(c0_f));
        answer = answer.line(format!(
            "{} {hz:>10.2}  {:>10}  {:>6.1}  {:>10}  {:>10}",
            if chosen { "*" } else { " " },
            parallel_hz.map_or_else(|| "?".into(), |hz| format!("{hz:.2}")),
            resonance.q,
            quantity(rm_ohm, "ohm"),
            quantity(resonance.lm_h.into(), "H"),
        ));
        rows.push(json!({
            "series_resonance_hz": short(resonance.hz), "parallel_resonance_hz": parallel_hz, "q": short(resonance.q), "rm_ohm": rm_ohm,
            "lm_h": short(resonance.lm_h), "chosen": chosen,
        }));
    }
    if rows.is_empty() {
        answer = answer.line("  none");
    }
    answer.field("resonances", rows)
}
