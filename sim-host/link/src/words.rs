//! Modes, faults and limits in words: what it is called, what it means, and what to do.

use firmware::board::kept::Kept;
use firmware::board::start::Start;
use firmware::seam::fault::{Fault, Limit};
use firmware::seam::mode::Mode;

/// A mode's name.
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
    let (name, hint) = fault_words(fault.code());
    format!("fault {}, {name}: {hint}", fault.code())
}

/// A fault's name.
pub fn fault_name(code: u8) -> &'static str {
    fault_words(code).0
}

/// A limit as number and meaning.
pub fn limit(limit: Limit) -> String {
    let code = u8::from(limit);
    format!("limit {code}, {}", limit_words(code))
}

/// What the board has stored over power-off, in a sentence.
pub fn stored(stored: Kept) -> String {
    match stored {
        Kept::Nothing => "the board has stored nothing".into(),
        Kept::Stored => "the board has stored its settings".into(),
        Kept::Damaged => "the stored settings cannot be read; `settings store` replaces them".into(),
        Kept::Version(version) => {
            format!("the stored settings are of version {version}, which the board's firmware does not read; `settings store` replaces them")
        }
        Kept::Due => "the board stores its settings as soon as its drive is silent".into(),
        Kept::Failed => "the board's flash does not store its settings".into(),
        Kept::Partly => {
            "some of the stored settings are not active as they are: the firmware does not know them, or they are out of range; `settings get` \
             shows the active values"
                .into()
        }
        Kept::Refused => {
            "the stored settings do not fit together: their limits are active, the drive is held within them, and what does not fit is left out; \
             `settings get` shows active and set values"
                .into()
        }
        Kept::Changed => "the set values differ from the stored ones: `settings store` stores them, a restart discards them".into(),
    }
}

/// What has started the board.
pub fn start(start: &Start) -> String {
    match start {
        Start::PowerOn => "power on".into(),
        Start::Pin => "reset by its pin".into(),
        Start::Ordered => "reset by order".into(),
        Start::Watchdog => "reset by the watchdog: the block stream or the slow side had died".into(),
        Start::Panic(place) => format!("reset after a panic at {}:{}", place.file.as_str(), place.line),
        Start::HardFault(address) => format!("reset after a hard fault at {address:#010x}"),
        Start::Unexpected(number) => format!("reset after interrupt {number}, which nobody has asked for"),
        Start::StreamLost(blocks) => format!("reset after a stream of samples that was lost after {blocks} blocks"),
    }
}

/// What a fault is called, and what to look at.
fn fault_words(code: u8) -> (&'static str, &'static str) {
    match code {
        10 => ("emergency stop", "release the stop and its line, then `fault clear`"),
        11 => ("late block", "the processor had no time, or the converters stood still: look at `fault log`"),
        12 => (
            "host lost",
            "the host said nothing for longer than the board's patience while it drove; see --host-timeout and --stay",
        ),
        20 => ("sense channel implausible", "a sense line is open, stuck or offset, or the amplifier is not on"),
        21 => ("over-current", "more current than `limits.current_a`: a shorted stack or cable, or a limit below the drive"),
        22 => ("load shorted", "look for a short in stack and cable"),
        23 => ("load open", "no stack, an open cable, or an amplifier that is off"),
        24 => ("lane implausible", "a lane is not heard or too far off: look at its amplifier and at the order of the lanes"),
        25 => ("capacitance shifted", "another stack than was told (`tracking.nominal_c0_f`), or one that has depoled"),
        26 => ("resonance damaged", "the stack rings otherwise than it was told: a crack, a loose horn, or another stack"),
        27 => ("sense channels swapped", "exchange V and I, or reverse one of them"),
        28 => ("sense channel saturated", "more than the front end can measure: lower the drive or the gain"),
        30 => ("no resonance", "none in the window: look at the nominal frequency and the span; is the horn on?"),
        31 => ("no lock", "it was found, but the loop did not pull in: too much damping, or a resonance that moves"),
        32 => ("loss of lock", "the resonance has gone: the load, or a stack that breaks; `lock` looks for it again"),
        33 => ("trackers disagree", "two ways to see the resonance say different things: look at the sense channels"),
        34 => ("wrong mode", "it locked to another resonance than it was told of: narrow the window"),
        40 => ("belt stopped", "the belt must move while it is driven"),
        41 => ("belt sensor lost", "look at the encoder's lines"),
        42 => ("belt sensor implausible", "the encoder counts while the force says that the belt stands"),
        43 => ("energy per length", "too much energy into each metre of belt: less drive, or a faster belt"),
        44 => ("over-temperature", "let board and stack cool"),
        45 => ("on-time exceeded", "the drive was ON for longer than `limits.on_time_s`"),
        46 => ("force sensor implausible", "look at the force channel"),
        _ => ("a fault that this program does not know", "see the documentation of the board's firmware"),
    }
}

fn limit_words(code: u8) -> &'static str {
    match code {
        96 => "the voltage asked for is over the voltage limit",
        97 => "the frequency stands at the edge of its window",
        98 => "the bursts are too short for the tracker to hear the resonance",
        99 => "the quadrature asked for is over a quarter turn",
        100 => "the amplitude is reduced: too hot, or at its mean power",
        101 => "muted until the belt moves",
        102 => "the belt is faster than the tip can be",
        103 => "the friction asked for is out of reach",
        104 => "the limits leave too little for a boosted edge",
        105 => "the seat has not said who sits in it",
        _ => "something that this program does not know",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_and_limit_of_the_firmware_has_words() {
        let unknown = |text: &str| text.contains("this program does not know");
        let faults: Vec<Fault> = (0..=255).filter_map(|code| Fault::try_from(code).ok()).collect();
        let limits: Vec<Limit> = (0..=255).filter_map(|code| Limit::try_from(code).ok()).collect();
        assert!(faults.len() >= 23 && limits.len() >= 10);
        assert!(faults.into_iter().all(|known| !unknown(&fault(known))));
        assert!(limits.into_iter().all(|known| !unknown(&limit(known))));
    }

    #[test]
    fn modes_are_spelt_as_in_files() {
        assert_eq!((mode(Mode::SelfTest), mode(Mode::Run)), ("self_test".into(), "run".into()));
    }
}
