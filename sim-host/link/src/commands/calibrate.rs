//! `calibrate`: measures and trims the lanes.

use std::time::Duration;

use firmware::board::command::Command;

use super::scan::is_over;
use super::settings::trims;
use crate::answer::Answer;
use crate::link_error::LinkError;
use crate::session::Session;

/// Maximum duration of a calibration; four lanes at 40 kHz take about a second.
const CALIBRATION_TIMEOUT: Duration = Duration::from_secs(10);

/// Calibrates, and lists the lane trims.
pub fn run(session: &mut Session) -> Result<Answer, LinkError> {
    let before = session.status()?;
    session.check(&before)?;
    session.begin_drive()?;
    session.client.order(Command::Calibrate)?;
    let ended = session.watch(CALIBRATION_TIMEOUT, 1, |report| is_over(report, &before).then_some(*report))?;
    let report = ended.ok_or_else(|| LinkError::Failed(format!("no calibration within {} s", CALIBRATION_TIMEOUT.as_secs())))?;
    session.mark_silent();
    session.check(&report)?;
    let answer = trims(session, Answer::to("calibrate"))?;
    Ok(answer.line("the drive is silent"))
}
