//! What each refusal means for who is refused.

use firmware::seam::refusal::Refusal;

/// Why the board does not do this, and what to do.
pub fn sentence(command: &str, refusal: Refusal) -> String {
    let (why, what) = words(refusal);
    format!("the board refuses `{command}`: {why}. {what}")
}

/// The refusal's name, for programs.
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
        Refusal::Damaged => ("every copy of it arrived damaged", "Look at cable, ground and baud rate (921600)"),
        Refusal::Version => ("it is of another protocol version", "Flash the firmware that belongs to this program"),
        Refusal::Unknown => ("it does not know this command", "Its firmware is older than this program: flash it again"),
        Refusal::NotPlausible => {
            ("a number in it cannot be", "Give a finite number, not below zero, and within the range that `settings get` shows")
        }
        Refusal::Busy => (
            "earlier orders have not been taken yet: its block stream stands still, or commands come too fast",
            "Try again; if it stays so, the converters have stopped: power it off and on, and `fault log` says why",
        ),
        Refusal::Driving => ("this is done only while the drive is silent", "Send `stop` first"),
        Refusal::Flash => (
            "its flash does not do it",
            "Try again after `reset`; if it stays so, the flash is worn out or its pages are protected",
        ),
        Refusal::OutOfRange => (
            "a number in it is beyond its range",
            "`settings get` shows the ranges; a capture has 1024 samples, of a lane that the board has",
        ),
        Refusal::NoSuchKey => ("its firmware has no such setting", "`settings get` lists what it has; or flash it again"),
        Refusal::NotCaptured => ("its capture is not full yet", "Wait for the trigger, or arm it with another one"),
        Refusal::NotConfigured => (
            "nothing of it is configured for that",
            "An image with a friction switch, and settings for its contact, would have it",
        ),
        Refusal::LeftOut => (
            "its image leaves out that part of the controller",
            "Flash an image with every part, as `cargo fw` builds it unless told otherwise",
        ),
        Refusal::NoBeltScale => (
            "it serves the D-ring of a belt, and would not know when that belt stops",
            "Set `front_end.metre_per_count`, the length of belt that a count of its encoder stands for, in m; then `settings store` and `reset`",
        ),
        Refusal::LimitsUnsure => (
            "a limit that was stored may not act: its stored settings could not be read when it started, or nothing here judges one of them",
            "`settings get` shows what acts. Set the limits again and send `settings store`, or `settings clear` for those of the image; then `reset`",
        ),
        Refusal::DoesNotBuild(_) => (
            "the set values do not fit together",
            "`settings get` shows them; a drive, for one, must be within `limits.voltage_v`",
        ),
        Refusal::Session => (
            "it is of another session: another client has connected since, or the board was reset",
            "End the other client, or see by `fault log` what has reset the board; then connect again",
        ),
    }
}
