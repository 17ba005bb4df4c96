//! `calibrate`: lanes that are measured and trimmed.

use std::time::Duration;

use firmware::board::command::Command;

use super::scan::is_over;
use super::settings::trims;
use crate::answer::Answer;
use crate::link_error::LinkError;
use crate::session::Session;

/// Longest that a calibration may take; four lanes at 40 kHz take about a second.
const LONGEST: Duration = Duration::from_secs(10);

/// Calibrates, and says what came out.
pub fn run(session: &mut Session) -> Result<Answer, LinkError> {
    let before = session.status()?;
    session.check(&before)?;
    session.begins_to_drive()?;
    session.client.order(Command::Calibrate)?;
    let ended = session.watch(LONGEST, 1, |report| is_over(report, &before).then_some(*report))?;
    let report = ended.ok_or_else(|| LinkError::Failed(format!("no calibration within {} s", LONGEST.as_secs())))?;
    session.is_silent();
    session.check(&report)?;
    let answer = trims(session, Answer::to("calibrate"))?;
    Ok(answer.line("the drive is silent"))
}
