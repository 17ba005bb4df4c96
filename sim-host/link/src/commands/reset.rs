//! `reset`: restarts the board.

use std::time::Duration;

use firmware::board::command::Command;

use super::fault::start_in_words;
use crate::answer::Answer;
use crate::link_error::LinkError;
use crate::session::Session;

/// A board that is older than the order, by this and by this part of the time that has passed, has not been reset: clocks differ.
const YOUNG_S: f64 = 5e-3;
const SKEW: f64 = 0.05;
/// How long a board may take to come back.
const COMEBACK: Duration = Duration::from_secs(3);

/// Resets, and waits until the board answers again.
pub fn run(session: &mut Session) -> Result<Answer, LinkError> {
    let block_s = session.scale()?.block_s;
    let ordered = session.client.now();
    session.client.order(Command::Reset)?;
    session.is_silent();
    let until = ordered + COMEBACK;
    session.identity = loop {
        match session.client.connect() {
            Ok(identity) => break identity,
            Err(error) if error.is_lost() && session.client.now() < until => {}
            Err(error) => return Err(error),
        }
    };
    let age_s = session.client.status()?.map_or(0.0, |report| block_s * f64::from(report.block));
    let passed_s = (session.client.now() - ordered).as_secs_f64();
    if age_s > (1.0 + SKEW) * passed_s + YOUNG_S {
        return Err(LinkError::Failed("the board goes on as it was: the order has not arrived. Try again".into()));
    }
    session.scale = None;
    session.agree_on_host_timeout()?;
    let start = start_in_words(session)?;
    Ok(Answer::to("reset").line(format!("the board has restarted; reason: {start}")).field("last_start", start))
}
