//! Hardware of the board: microcontroller, clock, longest block, option bytes. Part of `status` and
//! of `selftest`.

use firmware::board::command::{Command, Reply};
use firmware::board::hardware::{Clock, HardwareReport};
use firmware::seam::refusal::Refusal;
use nucleo_g474re::{errata, options};
use serde_json::Value;

use crate::answer::Answer;
use crate::client::unexpected;
use crate::link_error::LinkError;
use crate::session::Session;

/// Device number of the STM32G471 to STM32G484, DBGMCU_IDCODE.DEV_ID (RM0440 47.6.1).
const STM32G474: u16 = 0x469;

/// Requests the hardware of the board; `None` from an older firmware, which does not report it.
pub fn ask(session: &mut Session) -> Result<Option<HardwareReport>, LinkError> {
    match session.client.ask(Command::Hardware) {
        Ok(Reply::Hardware(report)) => Ok(Some(report)),
        Err(LinkError::Refused { refusal: Refusal::Unknown, .. }) => Ok(None),
        reply => Err(reply.map_or_else(|error| error, |reply| unexpected("status", &reply))),
    }
}

/// Adds the hardware to an answer, as text and fields. A simulated board has none.
pub fn in_words(answer: Answer, hardware: HardwareReport) -> Answer {
    let HardwareReport { device, revision, clock, core_hz, block_cycles, worst_cycles, .. } = hardware;
    if device == 0 {
        return answer;
    }
    let part = if device == STM32G474 { "STM32G474".to_owned() } else { format!("device {device:#05x}") };
    let silicon = match errata::letter(revision) {
        Some(letter) => format!("silicon revision {letter}"),
        None => format!("silicon revision {revision:#06x}, whose errata are unknown"),
    };
    let refused = if errata::is_refused(revision) { ", on which the amplifier stays off" } else { "" };
    let load = 100.0 * f64::from(worst_cycles) / f64::from(block_cycles.max(1));
    let answer = answer
        .line(format!("board      {part}, {silicon}{refused}; clock: {}, {} MHz", clock_in_words(clock), core_hz / 1_000_000))
        .line(format!("blocks     longest {worst_cycles} of {block_cycles} cycles ({load:.1} %)"));
    let answer = match options::names(hardware.option_bytes).collect::<Vec<_>>().as_slice() {
        [] => answer,
        wrong => answer.line(format!("options    wrong: {} (docs/board.md, option bytes)", wrong.join(", "))),
    };
    fields(answer, hardware)
}

fn fields(answer: Answer, hardware: HardwareReport) -> Answer {
    let wrong: Vec<&str> = options::names(hardware.option_bytes).collect();
    answer
        .field("device", hardware.device)
        .field("silicon_revision", hardware.revision)
        .field("silicon_letter", errata::letter(hardware.revision).map_or(Value::Null, |letter| letter.to_string().into()))
        .field("clock", clock_in_words(hardware.clock))
        .field("core_hz", hardware.core_hz)
        .field("block_cycles", hardware.block_cycles)
        .field("worst_block_cycles", hardware.worst_cycles)
        .field("option_bytes_wrong", wrong)
        .field("muted", hardware.muted)
}

fn clock_in_words(clock: Clock) -> &'static str {
    match clock {
        Clock::Unknown => "unknown",
        Clock::Crystal => "crystal",
        Clock::Internal => "internal oscillator, within 1 %",
    }
}
