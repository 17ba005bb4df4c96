//! `reset`: restarts the board.

use std::time::Duration;

use firmware::board::command::Command;

use super::fault::start_in_words;
use crate::answer::Answer;
use crate::link_error::LinkError;
use crate::session::Session;

/// Margin of the board's age against the time since the order, s. A board that is older has not
/// been reset.
const AGE_MARGIN_S: f64 = 5e-3;
/// Relative margin of the same comparison, for different clocks.
const CLOCK_SKEW_REL: f64 = 0.05;
/// Maximum time of a restart.
const RESTART_TIMEOUT: Duration = Duration::from_secs(3);

/// Resets the board, and waits until it answers again.
pub fn run(session: &mut Session) -> Result<Answer, LinkError> {
    let block_s = session.scale()?.block_s;
    let ordered = session.client.now();
    session.client.order(Command::Reset)?;
    session.mark_silent();
    let until = ordered + RESTART_TIMEOUT;
    // A board whose answers are late may begin the new session, and then restart.
    let report = loop {
        let answered = session.client.connect().and_then(|identity| {
            session.identity = identity;
            session.client.status()
        });
        match answered {
            Ok(report) => break report,
            Err(error) if error.is_lost() && session.client.now() < until => {}
            Err(error) => return Err(error),
        }
    };
    let age_s = report.map_or(0.0, |report| block_s * f64::from(report.block));
    let passed_s = (session.client.now() - ordered).as_secs_f64();
    if age_s > (1.0 + CLOCK_SKEW_REL) * passed_s + AGE_MARGIN_S {
        return Err(LinkError::Failed("the board has not restarted: the order has not arrived. Try again".into()));
    }
    session.scale = None;
    session.agree_on_host_timeout()?;
    let start = start_in_words(session)?;
    Ok(Answer::to("reset").line(format!("the board has restarted; reason: {start}")).field("last_start", start))
}
