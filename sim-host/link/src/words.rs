//! Modes, faults and limits in words.

use firmware::board::start::{Start, TripFailure};
use firmware::board::stored_state::StoredState;
use firmware::seam::fault::{Fault, Limit};
use firmware::seam::mode::Mode;

/// Name of a mode, in words.
pub fn mode(mode: Mode) -> String {
    let plain = format!("{mode:?}");
    // SelfTest is self_test.
    plain.char_indices().fold(String::new(), |mut name, (n, letter)| {
        if letter.is_uppercase() && n > 0 {
            name.push('_');
        }
        name.extend(letter.to_lowercase());
        name
    })
}

/// A fault as number, name and what to do.
pub fn fault(fault: Fault) -> String {
    format!("fault {}, {}: {}", fault.code(), fault.called(), fault.remedy())
}

/// A limit as number and name.
pub fn limit(limit: Limit) -> String {
    format!("limit {}, {}", limit.code(), limit.called())
}

/// What the board has stored over power-off, in a sentence.
pub fn stored(stored: StoredState) -> String {
    match stored {
        StoredState::Nothing => "the board has stored nothing".into(),
        StoredState::Stored => "the board has stored its settings".into(),
        StoredState::Damaged => {
            "neither copy of the stored settings can be read, and a lower limit may have been among them: the board drives nothing until \
             `settings store`, after the limits were set again, or `settings clear`, and `reset`"
                .into()
        }
        StoredState::Version(version) => {
            format!("the stored settings are of version {version}, which the board's firmware does not read: the board drives nothing until `settings store`, \
                 after the limits were set again, or `settings clear`, and `reset`")
        }
        StoredState::Due => "the board stores its settings as soon as its drive is silent".into(),
        StoredState::Failed => "the board's flash does not store its settings".into(),
        StoredState::Partly => {
            "some of the stored settings are not active as they are: the firmware does not know them, or they are out of range; `settings get` \
             shows the active values"
                .into()
        }
        StoredState::Refused => {
            "the stored settings do not fit together: their limits are active, the drive is held within them, and what does not fit is left out; \
             `settings get` shows active and set values"
                .into()
        }
        StoredState::Changed => "the set values differ from the stored ones: `settings store` stores them, a restart discards them".into(),
        StoredState::OneCopy => {
            "one of the two copies of the stored settings was older, or could not be read, when the board started: the latest one that can be read is \
             active; `settings store` writes both anew"
                .into()
        }
        StoredState::Unfinished => {
            "the board has stored nothing: its first `settings store` was cut off; it can be sent again".into()
        }
    }
}

/// What has started the board.
pub fn start(start: &Start) -> String {
    match start {
        Start::PowerOn => "power on".into(),
        Start::Pin => "reset by its pin".into(),
        Start::Ordered => "reset by order".into(),
        Start::Watchdog => "reset by the watchdog: the block stream or the background task had stopped".into(),
        Start::Panic(place) => format!("reset after a panic at {}:{}", place.file.as_str(), place.line),
        Start::HardFault(address) => format!("reset after a hard fault at {address:#010x}"),
        Start::Unexpected(number) => format!("reset after interrupt {number}, which is not enabled"),
        Start::StreamLost(blocks) => format!("reset after a stream of samples that was lost after {blocks} blocks"),
        Start::DamagedCode(address) => {
            format!("reset after a damaged word of the code at {address:#010x}: flash the board again")
        }
        Start::ClockFailed => "reset after a failure of the crystal: the clock is the internal oscillator, within 1 %".into(),
        Start::StackOverflow(address) => format!("reset after a stack overflow at {address:#010x}"),
        Start::SupplyLow => "reset after the supply was too low".into(),
        Start::RamParity => "reset after a parity error in RAM".into(),
        Start::TripFailed(failure) => {
            format!("the amplifier stays off, because the over-current trips failed their test: {}", trip_failure(failure))
        }
    }
}

fn trip_failure(failure: &TripFailure) -> &'static str {
    match failure {
        TripFailure::NotAtRest => "the current channel is not at the middle of its range",
        TripFailure::Wire => "the two inputs of the current differ; look at the wire to the negative trip",
        TripFailure::NoPositive => "the positive trip does not act",
        TripFailure::NoNegative => "the negative trip does not act",
        TripFailure::Standing => "a trip acts without a current",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_are_spelt_as_in_files() {
        assert_eq!((mode(Mode::SelfTest), mode(Mode::Run)), ("self_test".into(), "run".into()));
    }
}
