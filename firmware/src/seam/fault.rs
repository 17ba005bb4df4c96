//! Why the controller does not drive, or drives less than was asked, each by a number.
//!
//! A [`Fault`] ends the drive and stays until it is cleared. A [`Limit`] does neither: it says why the drive does less than
//! was asked, right now. Numbers are for the log and for other languages, and never change their meaning.

use serde::{Deserialize, Serialize};

/// An enum of numbers on the wire, each with its meaning (the documentation), a name in words, and a remedy. A variant that is added later does not
/// change the meaning of the others. In an image that does not print them the texts take no room.
macro_rules! numbered {
    ($(#[doc = $about:literal])+ $name:ident $($(#[doc = $meaning:literal])+ $variant:ident = $code:literal, $called:literal, $remedy:literal;)*) => {
        $(#[doc = $about])+
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(into = "u8", try_from = "u8")]
        #[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
        #[repr(u8)]
        pub enum $name {
            $($(#[doc = $meaning])+ $variant = $code,)*
        }

        impl $name {
            /// All of them, by their numbers.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// Number of the fault.
            pub fn code(self) -> u8 {
                self as u8
            }

            /// The name in words.
            pub fn called(self) -> &'static str {
                match self { $(Self::$variant => $called),* }
            }

            /// When it is raised, and how soon.
            pub fn meaning(self) -> &'static str {
                match self { $(Self::$variant => concat!($($meaning),+)),* }.trim_start()
            }

            /// What to do about it.
            pub fn remedy(self) -> &'static str {
                match self { $(Self::$variant => $remedy),* }
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
                Self::ALL.iter().copied().find(|&known| known as u8 == code).ok_or("a number without a meaning")
            }
        }
    };
}

numbered! {
    /// Why the drive is muted. On the wire it is its number.
    Fault
    /// The background task has asked for an emergency stop, or the enable pin has dropped before.
    EmergencyStop = 10, "emergency stop", "release the stop and its line, then `fault clear`";
    /// A block came late, was lost, or was cut short: known with that block.
    LateBlock = 11, "late block", "the processor had no time, or the converters stood still: look at `fault log`";
    /// No frame that is understood has come from the host for longer than the host timeout (`link.patience_s`, 1 s where nothing else is set, or an
    /// order) while the drive is on. Clearing it needs the host back, and drives nothing.
    HostLost = 12, "host lost", "the host said nothing for longer than its timeout while it drove; see --host-timeout and --stay";
    /// The amplifier's own fault output is active: known with that block.
    AmplifierFault = 13, "amplifier fault", "the power amplifier reports a fault of its own: look at its supply, temperature and load";
    /// The amplifier's supply, where it is measured, is below `supply.min_v` or above `supply.max_v`: known within 11 ms, and before anything is driven.
    AmplifierSupply = 14, "amplifier supply out of its window", "look at the amplifier's supply, and at `supply.divider`, `supply.min_v` and `supply.max_v`";
    /// A sense channel is offset by more than 5 %, stuck, or for 8 blocks (in the self-test 96) does not show within a factor of 2 the fundamental
    /// that was played, less what a source of 0.5 ohm takes of it under the current; or the stack does not ring down. Or, of a steady sine, for 8 blocks the voltage is 15 %
    /// off what it was, other than a source of 5 ohm or a delay of 100 us make it, 1.2 times louder than ordered, or 1.15 times more than `limits.voltage_v`; and of a resonance that is tracked the tone leaves
    /// a tenth of a channel's energy unexplained, or the motional current jumps, which takes a time constant to change: known after 8 blocks at most, of several lanes after 16 and a visit to each.
    /// Of a tone that measures the voltage is more than that limit, or no tone, and in silence beyond it, for 8 blocks; of several lanes for 16.
    SensorImplausible = 20, "sense channel implausible", "a sense line is open, stuck or offset, or the amplifier is off or too loud; where it ends a run, the self-test of the next `lock` tells more";
    /// Two samples of a block are over `limits.current_a`, or the board's comparator has seen more: known with that block.
    OverCurrent = 21, "over-current", "more current than `limits.current_a`: a shorted stack or cable, or a limit below the drive";
    /// In the self-test eight times as much current as the nominal capacitance takes, or, without a nominal one, as much as 20 uF.
    LoadShorted = 22, "load shorted", "look for a short in stack and cable";
    /// In the self-test a third of the current that the nominal capacitance takes, or, without a nominal one, that of 0.1 nF; in the run a hundredth, or one code of
    /// the current, for 8 blocks.
    LoadOpen = 23, "load open", "no stack, an open cable, an amplifier that is off, or a current channel that stands";
    /// The voltage of a lane is more than 45 degrees or 3 dB off the one that it should have beside lane 0: weak, dead, reversed, or exchanged with another
    /// one. Known at the end of the self-test, and in a steady run within 40 ms. Or the calibration does not measure a lane, finds it further off
    /// than a trim can be for, or its trim does not verify.
    LaneImplausible = 24, "lane implausible", "a lane is not measured or too far off: look at its amplifier and at the order of the lanes";
    /// The clamped capacitance is more than 40 % off its nominal value, without a nominal Lm 30 %, and three standard deviations; or more than 20 %, with an Lm
    /// of five times its nominal value, or, where none is given, without a resonance that stands out: known at the end of the calibration at power-on, 45 ms at 40 kHz.
    CapacitanceShifted = 25, "capacitance shifted", "another stack than the nominal one (`tracking.nominal_c0_f`), or one that has depoled";
    /// The calibration at power-on finds a Q below 0.27 of the nominal one: known after 43 to 60 ms at 40 kHz. Or a scan, to which it leaves what is less clear, finds one below a
    /// third of the nominal one, or below half of it with a second resonance within 3.5 % of at least a tenth of the strength. After a loss of lock also a Q
    /// below 0.3 of what was tracked. Without a nominal C0 only this.
    ResonanceDamaged = 26, "resonance damaged", "the stack rings otherwise than its nominal values say: a crack, a loose horn, or another stack";
    /// In the self-test the current lags the voltage where only a capacitance can be: the two sense channels are swapped, or one of them is
    /// reversed. Known 4 blocks after the tone is measured.
    SenseSwapped = 27, "sense channels swapped", "exchange V and I, or reverse one of them";
    /// A sense channel stands at the end of its range for more than an eighth of a block: known with that block. A current that is over its limit
    /// there is fault 21.
    SenseSaturated = 28, "sense channel saturated", "more than the front end can measure: lower the drive or the gain";
    /// A lane other than the first has its voltage, and draws less than a quarter of the current of its clamped capacitance and of lane 0: nothing is
    /// connected. Known when fault 24 is. Lane 0 is fault 23.
    LaneOpen = 29, "lane open", "an amplifier has no load: look at the cable and the electrodes of lanes 1 to 3";
    /// The scan has found no resonance in the window: without an observer, twice.
    NoResonance = 30, "no resonance", "none in the window: look at the nominal frequency and the span; is the horn on?";
    /// The phase loop has not locked within 64 ms and 50 time constants, or a 32nd of that at the edge of the frequency window, or has gone elsewhere than where two scans
    /// have found the resonance: 0.3 bandwidths for 8 blocks. Or the observer has found nothing within 128 blocks each way that it seeks, by a scan at last.
    NoLock = 31, "no lock", "it was found, but the loop did not pull in: too much damping, or a resonance that moves";
    /// The lock is lost: the motional phase is 45 degrees off for 2.6 ms, or for 4 time constants if that is more; at the edge of the frequency window, too. Without an observer the loop has leapt there, and stands there for 17 blocks.
    LossOfLock = 32, "loss of lock", "the resonance has gone: the load, or a stack that breaks; `lock` looks for it again";
    /// The observer has converged, and the motional phase, which it does not use, is 45 degrees off for as long as fault 32 takes.
    TrackersDisagree = 33, "trackers disagree", "two ways to see the resonance say different things: look at the sense channels";
    /// The resonance is not the nominal one: in the scan none fits, or two are alike; in the observer, once it has locked, Lm is not within a
    /// factor of two of its nominal value.
    WrongMode = 34, "wrong mode", "it locked to another resonance than the nominal one: narrow the window";
    /// The belt stands still: muted (limit 101) for 100 ms while the drive is asked for, or at once where a measurement was under way over a belt
    /// that had moved.
    BeltStopped = 40, "belt stopped", "the belt must move while it is driven";
    /// A line to the belt's encoder is broken, or there is no encoder where one is configured: known with that block.
    BeltSensorLost = 41, "belt sensor lost", "look at the encoder's lines";
    /// The encoder counts, and the force channel has said for 3 ms that the belt stands: about 4 ms after it has stopped.
    BeltSensorImplausible = 42, "belt sensor implausible", "the encoder counts while the force says that the belt stands";
    /// More electrical energy than `limits.energy_j_per_m` times the belt that has passed, and 10 mm.
    EnergyPerLength = 43, "energy per length", "too much energy into each metre of belt: less drive, or a faster belt";
    /// Driver or stack are hotter than `limits.temperature_c`: known with that block.
    OverTemperature = 44, "over-temperature", "let board and stack cool";
    /// The drive has been ON for `limits.on_time_s` longer than OFF.
    OnTimeExceeded = 45, "on-time exceeded", "the drive was ON for longer than `limits.on_time_s`";
    /// There is no force channel where one is configured, it reads no number or the same to the last bit for 32 ms under drive; or the force in the
    /// survey of the contact is none of friction.
    ForceSensorImplausible = 46, "force sensor implausible", "look at the force channel";
    /// A restraint serves the D-ring of a belt, and the length of a count of that belt's encoder is not set, so that a belt that stops would be welded:
    /// known in the block after the order, before anything is driven.
    BeltScaleMissing = 47, "belt scale missing", "set `front_end.metre_per_count`, the length of belt from one count of its encoder to the next";
}

numbered! {
    /// What keeps the drive from doing what was asked. On the wire it is its number.
    Limit
    /// The voltage asked for, by an order or by the amplitude loop, is over `limits.voltage_v`; it is clamped.
    OverVoltageRequest = 96, "the voltage asked for is over the voltage limit", "ask for less, or raise the limit in the configuration of the image";
    /// The tracker stands at the edge of its frequency window, or an order asks for a frequency beyond it; it is clamped.
    FrequencyWindow = 97, "the frequency stands at the edge of its window", "look at the nominal frequency and the span of the tracking";
    /// Under drive, but in bursts too short for the tracker to measure the resonance: the frequency is held, and `locked` is not claimed.
    NotTracking = 98, "the bursts are too short for the tracker to follow the resonance", "use longer bursts, or now and then a long one";
    /// The quadrature asked for is over a quarter turn; it is clamped.
    QuadratureRequest = 99, "the quadrature asked for is over a quarter turn", "ask for a quarter turn or less";
    /// The amplitude is reduced: driver or stack are less than 20 K below `limits.temperature_c`, or the mean power is at `limits.power_w`.
    Derated = 100, "the amplitude is reduced: too hot, or at its mean power", "let board and stack cool, or ask for less";
    /// The drive is muted until the belt moves.
    BeltMuted = 101, "muted until the belt moves", "the belt must move while it is driven";
    /// The belt is faster than the tip can be: vibration does not change the friction.
    NoAuthority = 102, "the belt is faster than the tip can be", "a slower belt, or a larger amplitude";
    /// The friction ratio asked for is below what the maximum amplitude gives, above one, or not known, because the contact was not surveyed.
    RatioUnreachable = 103, "the friction asked for is out of reach", "ask for a higher ratio, or survey the contact";
    /// The limits leave too little above the drive for a boosted edge, which then ends below its level; or it is left out beside the resonance, or because
    /// another mode is so near that a beat with it takes more than three time constants.
    BoostLimited = 104, "the limits or another mode leave too little for a boosted edge", "less amplitude, a higher limit, or a hard edge";
    /// The seat has read no torso mass, or one that cannot be: no occupant is classified as light, and friction stays HIGH in a crash.
    RestraintUnclassified = 105, "the seat has not said who sits in it", "look at the seat's sensor";
    /// The drive steps by 7 % of the bandwidth to both sides of the resonance, to measure the clamped branch there: some ring-down times after a lock or a change of the load.
    Probing = 106, "the clamped capacitance is being measured", "nothing: it is over in some ring-down times";
    /// Another resonance is so near that the lock may be off by more than half a per cent of the bandwidth, even after a scan; or a scan that such a lock was left to has found no other.
    LockUncertain = 107, "another resonance is so near that the lock is uncertain", "look at the scan: move the other mode away, or track that one";
    /// The amplitude is reduced: as much as is asked for would take more than 0.95 of `limits.current_a`.
    FoldedBack = 108, "the amplitude is reduced: the current is at its limit", "ask for less, or raise the limit in the configuration of the image";
}
