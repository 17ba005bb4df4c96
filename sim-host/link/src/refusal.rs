//! Names of the refusals, and their messages for the user.

use firmware::seam::refusal::Refusal;

/// Returns a message with the reason of a refusal and the remedy.
pub fn sentence(command: &str, refusal: Refusal) -> String {
    let (why, what) = words(refusal);
    format!("the board refuses `{command}`: {why}. {what}")
}

/// Returns the name of a refusal, for programs.
pub fn name(refusal: Refusal) -> &'static str {
    match refusal {
        Refusal::Damaged => "damaged",
        Refusal::Version => "version",
        Refusal::Unknown => "unknown",
        Refusal::NotPlausible => "not_plausible",
        Refusal::Busy => "busy",
        Refusal::Driving => "driving",
        Refusal::Flash => "flash",
        Refusal::OutOfRange => "out_of_range",
        Refusal::NoSuchKey => "no_such_key",
        Refusal::NotCaptured => "not_captured",
        Refusal::NotConfigured => "not_configured",
        Refusal::LeftOut => "left_out",
        Refusal::NoBeltScale => "no_belt_scale",
        Refusal::LimitsUnsure => "limits_unsure",
        Refusal::DoesNotBuild(_) => "does_not_build",
        Refusal::Session => "session",
    }
}

fn words(refusal: Refusal) -> (&'static str, &'static str) {
    match refusal {
        Refusal::Damaged => ("every copy of it arrived damaged", "Check cable, ground and baud rate (921600)"),
        Refusal::Version => ("it is of another protocol version", "Flash the firmware that belongs to this program"),
        Refusal::Unknown => ("it does not know this command", "Its firmware is older than this program: flash it again"),
        Refusal::NotPlausible => {
            ("it contains an impossible number", "Give a finite, non-negative number within the range that `settings get` shows")
        }
        Refusal::Busy => (
            "earlier orders are still waiting: the block stream has stopped, or commands arrive too fast",
            "Try again; if it persists, the converters have stopped: power the board off and on, then read `fault log`",
        ),
        Refusal::Driving => ("this is done only while the drive is silent", "Send `stop` first"),
        Refusal::Flash => (
            "its flash memory has failed",
            "Try again after `reset`; if it persists, the flash is worn out or its pages are protected",
        ),
        Refusal::OutOfRange => (
            "a number in it is beyond its range",
            "`settings get` shows the ranges; a capture has 1024 samples of one lane of the board",
        ),
        Refusal::NoSuchKey => {
            ("its firmware has no such setting", "`settings get` lists its settings; newer firmware may have it")
        }
        Refusal::NotCaptured => ("its capture is not full yet", "Wait for the trigger, or arm it with another one"),
        Refusal::NotConfigured => (
            "the board is not configured for it",
            "`friction` needs a friction switch: [controller.friction] in a scene, `friction.enabled` and its contact at a \
             board. An update needs a first stage, and an occupant the restraint of a belt",
        ),
        Refusal::LeftOut => (
            "its image does not contain that part of the controller",
            "Flash an image with every part, as `cargo fw` builds it by default",
        ),
        Refusal::NoBeltScale => (
            "it drives at the D-ring of a belt, but without a belt scale it cannot detect a stop of the belt",
            "Set `front_end.metre_per_count`, the length of belt per count of its encoder, in m; then `settings store` and \
            `reset`",
        ),
        Refusal::LimitsUnsure => (
            "a stored limit may be inactive: the stored settings could not be read at start-up or were erased, or this image cannot check one \
             of them",
            "`settings get` shows the active values. Set the limits again and send `settings store`, or restore those of the \
             image by `settings clear`; then `reset`",
        ),
        Refusal::DoesNotBuild(_) => (
            "the new values do not fit together",
            "`settings get` shows them; for example, every drive voltage must be within `limits.voltage_v`",
        ),
        Refusal::Session => (
            "it belongs to another session: another client has connected since, or the board was reset",
            "End the other client, or read the cause of the reset from `fault log`; then connect again",
        ),
    }
}
