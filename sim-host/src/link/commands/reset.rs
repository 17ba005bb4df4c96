//! `reset`: the board begins anew.

use std::time::Duration;

use firmware::command::Command;

use super::fault::start_in_words;
use crate::link::answer::Answer;
use crate::link::link_error::LinkError;
use crate::link::session::Session;

/// Blocks by which a board comes back.
const YOUNG: u32 = 1000;
/// How long a board may take to come back.
const COMEBACK: Duration = Duration::from_secs(3);

/// Resets, and waits until the board answers again.
pub fn run(session: &mut Session) -> Result<Answer, LinkError> {
    let before = session.client.status()?.map(|report| report.block);
    session.client.order(Command::Reset)?;
    session.drives(false);
    let until = session.client.now() + COMEBACK;
    session.identity = loop {
        match session.client.connect() {
            Ok(identity) => break identity,
            Err(error) if error.is_lost() && session.client.now() < until => {}
            Err(error) => return Err(error),
        }
    };
    let after = session.client.status()?.map(|report| report.block);
    // Its blocks are counted from the beginning; a board that has only just begun cannot be told from one that has begun anew.
    if before > Some(YOUNG) && after >= before {
        return Err(LinkError::Failed("the board goes on as it was: the order has not arrived. Try again".into()));
    }
    session.scale = None;
    session.agree_on_patience()?;
    let start = start_in_words(session)?;
    Ok(Answer::to("reset").line(format!("the board has begun anew; it says: {start}")).field("last_start", start))
}
