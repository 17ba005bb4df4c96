//! Faults, which end the drive, and limits, which reduce it.
//!
//! A [`Fault`] mutes the drive until it is cleared. A [`Limit`] states why the drive is at present
//! below its set point, and ends by itself. Their numbers are for logs and other languages, and
//! never change their meaning.

use serde::{Deserialize, Serialize};

/// Defines an enum that is a number on the wire. Each variant has a meaning (its documentation), a
/// name in words, and a remedy. A new variant does not change the meaning of the others. The texts
/// take no flash in an image that does not print them.
macro_rules! numbered {
    ($(#[doc = $about:literal])+ $name:ident, $kind:literal;
     $($(#[doc = $meaning:literal])+ $variant:ident = $code:literal, $called:literal, $remedy:literal;)*) => {
        $(#[doc = $about])+
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(into = "u8", try_from = "u8")]
        #[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
        #[repr(u8)]
        pub enum $name {
            $($(#[doc = $meaning])+ $variant = $code,)*
        }

        impl $name {
            /// All variants, by rising number.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// Returns the number.
            pub fn code(self) -> u8 {
                self as u8
            }

            /// Returns the name in words.
            pub fn called(self) -> &'static str {
                match self { $(Self::$variant => $called),* }
            }

            /// Returns the condition under which it is raised, and the time until then.
            pub fn meaning(self) -> &'static str {
                match self { $(Self::$variant => concat!($($meaning),+)),* }.trim_start()
            }

            /// Returns the remedy.
            pub fn remedy(self) -> &'static str {
                match self { $(Self::$variant => $remedy),* }
            }

            /// Returns the place in the documentation with likely causes and checks.
            pub fn place(self) -> &'static str {
                match self { $(Self::$variant => concat!("docs/faults.md#", $kind, "-", $code)),* }
            }
        }

        impl From<$name> for u8 {
            fn from(value: $name) -> u8 {
                value as u8
            }
        }

        impl TryFrom<u8> for $name {
            type Error = &'static str;

            fn try_from(code: u8) -> Result<Self, Self::Error> {
                Self::ALL.iter().copied().find(|&known| known as u8 == code).ok_or("unknown number")
            }
        }
    };
}

numbered! {
    /// Fault for which the drive is muted; a number on the wire.
    Fault, "fault";
    /// The background task has requested an emergency stop, or the enable pin has dropped.
    EmergencyStop = 10, "emergency stop", "release the emergency stop and its line, then `fault clear`";
    /// A block was late, lost, or cut short. Detected in that block.
    LateBlock = 11, "late block", "the processor had no time, or the converters stopped: see `fault log`";
    /// While the drive is on, no valid frame has arrived from the host for longer than the host
    /// timeout (`link.patience_s`, 1 s by default, or the timeout of an order). Clearing it needs
    /// the host, and drives nothing.
    HostLost = 12, "host lost", "the host was silent for longer than its timeout while it drove; see --host-timeout and --stay";
    /// The amplifier's own fault output is active. Detected in that block.
    AmplifierFault = 13, "amplifier fault", "the power amplifier reports a fault: check its supply, temperature and load";
    /// The measured supply of the amplifier is below `supply.min_v` or above `supply.max_v`.
    /// Detected within 11 ms, and before anything is driven.
    AmplifierSupply = 14, "amplifier supply out of its window",
        "check the amplifier's supply, `supply.divider`, `supply.min_v` and `supply.max_v`";
    /// A sense channel is offset by more than 5 %, or is stuck. Or for 8 blocks (96 in the
    /// self-test) its voltage deviates from the fundamental played by more than a factor of 2, less
    /// the drop across a source of 0.5 ohm. Or the stack does not ring down. Under a steady sine,
    /// for 8 blocks: the voltage deviates by 15 % from its mean, unless a source of 5 ohm or a
    /// delay of 100 us explains it; or it exceeds 1.2 times the command; or it exceeds 1.15 times
    /// `limits.voltage_v`. At a tracked resonance: the tone leaves a tenth of a channel's energy
    /// unexplained; or the motional current jumps, although it needs a time constant to change; or
    /// the current becomes a sample late. Detected within 8 blocks; with several lanes within 16
    /// and a visit to each. Under a measuring tone, for 8 blocks (16 with several lanes): the
    /// voltage exceeds that limit or is not a tone. In silence, for as long: the voltage exceeds
    /// that limit.
    SensorImplausible = 20, "sense channel implausible",
        "a sense line is open, stuck or offset, or the amplifier is off or its gain too high; if it ends a run, the \
         self-test of the next `lock` shows more";
    /// Two samples of a block exceed `limits.current_a`, or the board's comparator has tripped.
    /// Detected in that block.
    OverCurrent = 21, "over-current",
        "the current exceeds `limits.current_a`: a shorted stack or cable, or a limit below the drive";
    /// In the self-test the current is eight times that of the nominal capacitance or, without a
    /// nominal one, that of 20 uF, in both tones; or it exceeds `limits.current_a`.
    LoadShorted = 22, "load shorted", "look for a short in stack and cable";
    /// In the self-test the current is below a third of that of the nominal capacitance or, without
    /// a nominal one, below that of 0.1 nF. In the run it is below a hundredth, or its codes are
    /// constant, for 8 blocks.
    LoadOpen = 23, "load open", "no stack, an open cable, an amplifier that is off, or a stuck current channel";
    /// The voltage of a lane deviates by more than 45 degrees or 3 dB from its expected value
    /// relative to lane 0: the lane is weak, dead, reversed, or exchanged with another one.
    /// Detected at the end of the self-test, and in a steady run within 40 ms. Or the calibration
    /// cannot measure a lane, finds a deviation that is too large to trim, or cannot verify its
    /// trim.
    LaneImplausible = 24, "lane implausible",
        "a lane is not measured or deviates too much: check its amplifier and the order of the lanes";
    /// The clamped capacitance deviates from its nominal value by more than 40 % (30 % without a
    /// nominal Lm) and three standard deviations. Or it deviates by more than 20 %, and Lm is five
    /// times its nominal value or, without a nominal Lm, no resonance stands out. Detected at the
    /// end of the calibration at power-on, 45 ms at 40 kHz.
    CapacitanceShifted = 25, "capacitance shifted", "the stack is not the nominal one (`tracking.nominal_c0_f`), or has depoled";
    /// The calibration at power-on finds a Q below 0.27 of the nominal one: detected after 43 to 60
    /// ms at 40 kHz. Less clear cases are left to a scan: it finds a Q below a third of the nominal
    /// one. After a loss of lock also a Q below 0.3 of the tracked one. Without a nominal C0 only
    /// the latter applies.
    ResonanceDamaged = 26, "resonance damaged",
        "the stack does not ring as its nominal values predict: a crack, a loose horn, or another stack";
    /// In the self-test the current lags the voltage, although the load is a capacitance there: the
    /// two sense channels are swapped, or one of them is reversed. Detected 4 blocks after the tone
    /// is measured.
    SenseSwapped = 27, "sense channels swapped", "exchange V and I, or reverse one of them";
    /// A sense channel is at the end of its range for more than an eighth of a block. Detected in
    /// that block. A current that exceeds its limit there is fault 21.
    SenseSaturated = 28, "sense channel saturated", "the signal exceeds the range of the front end: lower the drive or the gain";
    /// A lane other than the first has its voltage, but draws less than a quarter of the current of
    /// its clamped capacitance and of lane 0: nothing is connected. Detected as soon as fault 24.
    /// For lane 0 it is fault 23.
    LaneOpen = 29, "lane open", "an amplifier has no load: check the cable and the electrodes of lanes 1 to 3";
    /// The scan has found no resonance in the window; without an observer, twice.
    NoResonance = 30, "no resonance",
        "no resonance in the window: check the nominal frequency and the span; is the horn mounted?";
    /// The phase loop has not locked within 64 ms and 50 time constants, or within a 32nd of that
    /// at the edge of the frequency window. Or for 8 blocks it is more than 0.3 bandwidths from the
    /// resonance that two scans have found. Or the observer has not locked within 128 blocks in any
    /// attempt, the last one after a scan.
    NoLock = 31, "no lock", "a resonance was found, but the loop did not lock: too much damping, or a moving resonance";
    /// The lock is lost: the motional phase is off by 45 degrees for 2.6 ms, or for 4 time
    /// constants if that is longer; also at the edge of the frequency window. Without an observer
    /// also if the loop has leapt to that edge and stays there for 17 blocks.
    LossOfLock = 32, "loss of lock", "the resonance is gone: the load, or a stack that breaks; `lock` looks for it again";
    /// The observer has converged, but the motional phase, which it does not use, is off by 45
    /// degrees for as long as fault 32 takes.
    TrackersDisagree = 33, "trackers disagree", "two independent estimates of the resonance disagree: check the sense channels";
    /// The resonance is not the nominal one: in the scan none matches, or two match equally well.
    /// With the observer, after the lock: Lm is not within a factor of 2.2 of its nominal value.
    WrongMode = 34, "wrong mode", "the lock is on another resonance than the nominal one: narrow the window";
    /// The belt is at rest: a requested drive has been muted (limit 101) for 100 ms, or a
    /// measurement has driven for 100 ms. Or a belt that had moved stops during a measurement:
    /// detected at once.
    BeltStopped = 40, "belt stopped", "the belt must move while it is driven";
    /// A line to the belt's encoder is broken, or a configured encoder is absent. Detected in that
    /// block.
    BeltSensorLost = 41, "belt sensor lost", "check the encoder's lines";
    /// The encoder counts, but the force channel has shown a belt at rest for 3 ms: about 4 ms
    /// after the belt has stopped.
    BeltSensorImplausible = 42, "belt sensor implausible",
        "the encoder counts although the force shows a belt at rest: check both";
    /// The electrical energy exceeds `limits.energy_j_per_m` times the length of belt that has
    /// passed plus 10 mm.
    EnergyPerLength = 43, "energy per length", "too much energy per metre of belt: use less drive, or a faster belt";
    /// Driver or stack are hotter than `limits.temperature_c`. Detected in that block.
    OverTemperature = 44, "over-temperature", "let board and stack cool";
    /// The drive has been ON for longer than OFF by `limits.on_time_s`.
    OnTimeExceeded = 45, "on-time exceeded", "the drive was ON for longer than `limits.on_time_s`";
    /// A configured force channel is absent, or under drive its reading is not a number, or is the
    /// same to the last bit for 32 ms. Or the force in the survey of the contact cannot be
    /// friction.
    ForceSensorImplausible = 46, "force sensor implausible", "check the force channel";
    /// A restraint serves the D-ring of a belt, but the length of a count of the belt's encoder is
    /// not set, so that a stopped belt would be welded. Detected in the block after the order,
    /// before anything is driven.
    BeltScaleMissing = 47, "belt scale missing", "set `front_end.metre_per_count`, the length of belt per count of its encoder";
}

numbered! {
    /// Reason for which the drive is below its set point; a number on the wire.
    Limit, "limit";
    /// The voltage set point, of an order or of the amplitude loop, exceeds `limits.voltage_v`; it
    /// is clamped.
    OverVoltageRequest = 96, "the voltage set point exceeds the voltage limit",
        "lower the set point, or raise the limit in the configuration of the image";
    /// The tracker is at the edge of its frequency window, or an order sets a frequency beyond it;
    /// it is clamped.
    FrequencyWindow = 97, "the frequency is at the edge of its window",
        "check the nominal frequency and the span of the tracking";
    /// The bursts are too short for the tracker to measure the resonance: the frequency is held,
    /// and `locked` is not reported.
    NotTracking = 98, "the bursts are too short for the tracker to follow the resonance",
        "use longer bursts, or occasionally a long one";
    /// The quadrature set point exceeds a quarter turn; it is clamped.
    QuadratureRequest = 99, "the quadrature set point exceeds a quarter turn", "set a quarter turn or less";
    /// The amplitude is reduced: driver or stack are less than 20 K below `limits.temperature_c`,
    /// or the mean power is at `limits.power_w`.
    Derated = 100, "the amplitude is reduced: too hot, or at the mean power limit",
        "let board and stack cool, or lower the set point";
    /// The drive is muted until the belt moves.
    BeltMuted = 101, "muted until the belt moves", "the belt must move while it is driven";
    /// The belt is faster than the largest tip velocity: vibration does not change the friction.
    NoAuthority = 102, "the belt is faster than the largest tip velocity", "use a slower belt, or a larger amplitude";
    /// The friction set point is below the ratio at the maximum amplitude, above one, or unknown
    /// because the contact was not surveyed.
    RatioUnreachable = 103, "the friction set point is out of reach", "set a higher ratio, or survey the contact";
    /// The limits leave too little room above the drive for a boosted edge, which then ends below
    /// its level. Or the boost is omitted: off resonance, or because another mode is so near that a
    /// beat with it takes more than three time constants.
    BoostLimited = 104, "the limits or another mode leave too little room for a boosted edge",
        "use less amplitude, a higher limit, or a hard edge";
    /// The seat has read no torso mass, or an impossible one: no occupant is classified as light,
    /// and friction stays HIGH in a crash.
    RestraintUnclassified = 105, "the seat has not classified its occupant", "check the seat's sensor";
    /// The drive steps by 7 % of the bandwidth to both sides of the resonance to measure the
    /// clamped branch there: for some ring-down times after a lock or a change of the load, and as
    /// often as `tracking.c0_drift_per_s` requires.
    Probing = 106, "the clamped capacitance is being measured", "none: it is over after some ring-down times";
    /// The drive may lose more than 1 % of the tip velocity, because a resonance nearby cannot be
    /// resolved. Either the measurement at the lock point has moved it by more than 7 % of the
    /// bandwidth, or the clamped capacitances from a scan and from tones off resonance contradict
    /// each other. Further causes: two standard deviations of the resonance exceed 7 % of the
    /// bandwidth; the model does not fit the scan; other resonances have more admittance at the
    /// lock point.
    LockUncertain = 107, "another resonance is so near that the lock is uncertain",
        "check the scan: move the other mode away, or track that one";
    /// The amplitude is reduced: the set point would take more than 0.95 of `limits.current_a`.
    FoldedBack = 108, "the amplitude is reduced: the current is at its limit",
        "lower the set point, or raise the limit in the configuration of the image";
}
