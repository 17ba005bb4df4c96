//! `identify`: requests the identity of the board.

use firmware::board::command::Identity;

use super::update::ask_keys;
use crate::answer::{Answer, quantity};
use crate::link_error::LinkError;
use crate::session::Session;

/// Requests the identity of the board again, and measures the round trip.
pub fn run(session: &mut Session) -> Result<Answer, LinkError> {
    let began = session.client.now();
    let identity = session.client.identify()?;
    let round_trip_ms = 1e3 * (session.client.now() - began).as_secs_f64();
    session.identity = identity;
    let Identity { protocol, firmware: [major, minor, patch], converters, .. } = identity;
    let counts = session.client.counts();
    let version = format!("{major}.{minor}.{patch}");
    let answer = Answer::to("identify")
        .line(format!("{}: a Sonoglide board, firmware {version}, protocol {protocol}", session.client.port()))
        .line(format!(
            "converters: {}, {} samples per block, {} of 4 lanes",
            quantity(converters.sample_hz.into(), "Hz"),
            converters.block_samples,
            converters.lanes
        ))
        .line(format!(
            "link: answered in {round_trip_ms:.2} ms; {} commands, {} repeated, {} frames damaged, {} answers late, reopened {} \
             times",
            counts.commands, counts.repeated, counts.damaged, counts.late, counts.reopened
        ))
        .field("port", session.client.port())
        .field("firmware", version)
        .field("protocol", protocol)
        .field("sample_hz", converters.sample_hz)
        .field("block_samples", converters.block_samples)
        .field("lanes", converters.lanes)
        .field("round_trip_ms", round_trip_ms)
        .field("repeated", counts.repeated)
        .field("damaged", counts.damaged);
    ask_keys(answer, session)
}
