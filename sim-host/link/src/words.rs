//! Text for modes, faults, limits, stored settings and causes of a start.

use firmware::board::start::{Start, TripFailure};
use firmware::board::stored_state::StoredState;
use firmware::seam::fault::{Fault, Limit};
use firmware::seam::mode::Mode;

/// Returns the name of a mode in snake case.
pub fn mode(mode: Mode) -> String {
    let plain = format!("{mode:?}");
    // SelfTest becomes self_test.
    plain.char_indices().fold(String::new(), |mut name, (n, letter)| {
        if letter.is_uppercase() && n > 0 {
            name.push('_');
        }
        name.extend(letter.to_lowercase());
        name
    })
}

/// Returns the number, name and remedy of a fault.
pub fn fault(fault: Fault) -> String {
    format!("fault {}, {}: {} (see {})", fault.code(), fault.called(), fault.remedy(), fault.place())
}

/// Returns the number and name of a limit.
pub fn limit(limit: Limit) -> String {
    format!("limit {}, {}", limit.code(), limit.called())
}

/// Describes the stored settings of the board in a sentence.
pub fn stored(stored: StoredState) -> String {
    match stored {
        StoredState::Nothing => "the board has stored nothing".into(),
        StoredState::Stored => "the board has stored its settings".into(),
        StoredState::Damaged => {
            "neither copy of the stored settings can be read, or both were erased, and they may have contained a lower limit: \
             the board does not drive until the limits are set again and stored (`settings store`), or removed (`settings clear`), and then `reset`"
                .into()
        }
        StoredState::Version(version) => {
            format!(
                "the stored settings are of version {version}, which the board's firmware cannot read: the board does not \
                     drive until the limits are set again and stored (`settings store`), or removed (`settings clear`), and then \
                     `reset`"
            )
        }
        StoredState::Due => "the board stores its settings as soon as its drive is silent".into(),
        StoredState::Failed => "the board's flash cannot store its settings".into(),
        StoredState::Partly => {
            "some of the stored settings are not active as stored: the firmware does not know them, or they are out of range; \
             `settings get` shows the active values"
                .into()
        }
        StoredState::Refused => {
            "the stored settings do not fit together: their limits are active, the drive is kept within them, and conflicting \
             settings are ignored; `settings get` shows active and set values"
                .into()
        }
        StoredState::Changed => "the set values differ from the stored ones: `settings store` stores them, a restart discards \
                                 them"
            .into(),
        StoredState::OneCopy => {
            "one of the two copies of the stored settings was older, or unreadable, when the board started: the latest readable \
             copy is active; `settings store` writes both again"
                .into()
        }
        StoredState::Unfinished => {
            "the board has stored nothing: its first `settings store` was interrupted; send it again".into()
        }
    }
}

/// Describes the cause of the board's start.
pub fn start(start: &Start) -> String {
    match start {
        Start::PowerOn => "power on".into(),
        Start::Pin => "reset by its pin".into(),
        Start::Ordered => "reset by order".into(),
        Start::Watchdog => "reset by the watchdog: the block stream or the background task had stopped".into(),
        Start::Panic(place) => format!("reset after a panic at {}:{}", place.file.as_str(), place.line),
        Start::HardFault(address) => format!("reset after a hard fault at {address:#010x}"),
        Start::Unexpected(number) => format!("reset after interrupt {number}, which is not enabled"),
        Start::StreamLost(blocks) => format!("reset because the stream of samples was lost after {blocks} blocks"),
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
        Start::UnsupportedSilicon(revision) => format!(
            "the amplifier stays off, because the microcontroller has the silicon revision {revision:#06x}, with errata that \
             the firmware does not handle: use a Nucleo with another one (docs/errata.md)"
        ),
    }
}

fn trip_failure(failure: &TripFailure) -> &'static str {
    match failure {
        TripFailure::NotAtRest => "the current channel is not at the middle of its range",
        TripFailure::Wire => "the two inputs of the current differ; check the wire to the negative trip",
        TripFailure::NoPositive => "the positive trip does not act",
        TripFailure::NoNegative => "the negative trip does not act",
        TripFailure::Standing => "a trip is active without a current",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_have_snake_case_names() {
        assert_eq!((mode(Mode::SelfTest), mode(Mode::Run)), ("self_test".into(), "run".into()));
    }
}
