//! The supervisor: may we drive, and what is limiting us?
//!
//! ```text
//! Idle -> SelfTest -> Scan | Clamped | Calibrate -> Lock -> Run
//!   ^        |          |        |          |      |
//!   |        +----------+--------+--+-------+------+--> Fault (sticky; the drive is muted)
//!   +--- order: Idle -------------------- order: clear ---+
//! ```
//!
//! An order to scan or to calibrate goes from anywhere to SelfTest, and from Scan or Calibrate back to Idle. A calibration that another order
//! ends has changed nothing.
//!
//! A [`Fault`] ends the drive and stays until it is cleared. A [`Limit`] does neither: it says why the drive does less than
//! was asked, right now. Numbers are for the log and for other languages, and never change their meaning.

use serde::{Deserialize, Serialize};

use crate::block::{Orders, Request};
use crate::config::TrackingMode;

/// What the controller is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub enum Mode {
    /// Silent, waiting for an order.
    #[default]
    Idle,
    /// Checking the sense channels and that there is a transducer.
    SelfTest,
    /// Looking for the resonance.
    Scan,
    /// Pulling in.
    Lock,
    /// Driving, by the burst schedule.
    Run,
    /// Muted by a fault.
    Fault,
    /// Measuring what each lane adds.
    Calibrate,
    /// Measuring the clamped branch, beside the resonance.
    Clamped,
}

/// How a run comes to its frequency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acquisition {
    /// It is told.
    Told,
    /// By a scan.
    Scanned,
    /// By an observer, which needs the clamped branch.
    Observed,
}

impl Acquisition {
    /// What a mode of tracking begins with.
    pub fn of(mode: TrackingMode) -> Self {
        match mode {
            TrackingMode::Observer => Acquisition::Observed,
            TrackingMode::PhaseLock | TrackingMode::ZeroPhase => Acquisition::Scanned,
            TrackingMode::Off => Acquisition::Told,
        }
    }
}

/// Why the drive is muted. On the wire it is its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "u8", try_from = "u8")]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[repr(u8)]
pub enum Fault {
    /// The slow side has asked for an emergency stop.
    EmergencyStop = 10,
    /// A block came late, was lost, or was cut short.
    LateBlock = 11,
    /// The host has been silent for longer than it may be while the drive is on.
    HostLost = 12,
    /// A sense channel is offset, stuck, or does not show what was played: 8 blocks, or the self-test's 96.
    SensorImplausible = 20,
    /// More current than the limit, seen here or by the comparator.
    OverCurrent = 21,
    /// Far more current than the clamped capacitance takes.
    LoadShorted = 22,
    /// Far less.
    LoadOpen = 23,
    /// A lane is not heard, is further off than a trim can be for, or does not do what its trim should make it do.
    LaneImplausible = 24,
    /// The clamped capacitance is more than 20 % off what it was told to be: a stack that has depoled, or another stack. Known at the end of the
    /// calibration at power-on, 45 ms at 40 kHz.
    CapacitanceShifted = 25,
    /// The resonance is missing, damped more than it was told, or has company it should not have: a crack. Known at the end of the calibration at
    /// power-on, 55 ms at 40 kHz.
    ResonanceDamaged = 26,
    /// The voltage leads where the current should: the two sense channels are swapped, or one of them is reversed. Known 4 blocks after the
    /// self-test's tone is heard.
    SenseSwapped = 27,
    /// A sense channel stands at the end of its range, for more than an eighth of a block: known with that block. Of the current, where the limit is
    /// beyond the range.
    SenseSaturated = 28,
    /// The scan has found no resonance in the window.
    NoResonance = 30,
    /// The loop has not locked in time.
    NoLock = 31,
    /// The loop was locked and is not any more.
    LossOfLock = 32,
    /// The observer and the motional phase, which it does not use, say different frequencies.
    TrackersDisagree = 33,
    /// It has locked to a resonance that is not the one it was told of.
    WrongMode = 34,
    /// The belt stands still under the drive: muted for 100 ms, or at once where a measurement was under way.
    BeltStopped = 40,
    /// A line to the belt's encoder is broken, or the encoder is gone: known with that block.
    BeltSensorLost = 41,
    /// The encoder counts, and the force is that of a belt that stands: about 4 ms after it has stopped.
    BeltSensorImplausible = 42,
    /// More electrical energy for each metre of belt than the limit.
    EnergyPerLength = 43,
    /// Board or stack are hotter than the limit.
    OverTemperature = 44,
    /// The drive has been ON for longer than the limit.
    OnTimeExceeded = 45,
    /// The force channel is missing, stuck for 32 ms, or reads no number.
    ForceSensorImplausible = 46,
}

impl Fault {
    /// The number of this fault.
    pub fn code(self) -> u8 {
        self as u8
    }
}

/// What keeps the drive from doing what was asked. On the wire it is its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "u8", try_from = "u8")]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[repr(u8)]
pub enum Limit {
    /// The voltage asked for (by an order or by the amplitude loop) is over the voltage limit.
    OverVoltageRequest = 96,
    /// The tracker stands at the edge of the frequency window, or an order asks for more.
    FrequencyWindow = 97,
    /// The drive has been ON for long, in bursts too short for the tracker to hear the resonance.
    NotTracking = 98,
    /// The quadrature asked for is over a quarter turn.
    QuadratureRequest = 99,
    /// The amplitude is reduced: board or stack are nearly too hot, or the mean power is at its limit.
    Derated = 100,
    /// The drive is muted until the belt moves.
    BeltMuted = 101,
    /// The belt is faster than the tip can be: vibration does not change the friction.
    NoAuthority = 102,
    /// The friction ratio asked for is below what the loudest drive does, above one, or nobody knows what it is.
    RatioUnreachable = 103,
    /// The limits leave too little above the drive for a boosted edge: it ends below its level, or it is left out beside the resonance.
    BoostLimited = 104,
    /// The seat has read no torso mass, or one that cannot be: nobody is light, and friction stays HIGH in a crash.
    RestraintUnclassified = 105,
}

/// A number on the wire, and back: a variant that is added later does not change the meaning of the others.
macro_rules! numbered {
    ($name:ident, $($variant:ident)*) => {
        impl From<$name> for u8 {
            fn from(value: $name) -> u8 {
                value as u8
            }
        }

        impl TryFrom<u8> for $name {
            type Error = &'static str;

            fn try_from(code: u8) -> Result<Self, Self::Error> {
                [$($name::$variant),*].into_iter().find(|&known| known as u8 == code).ok_or("a number without a meaning")
            }
        }
    };
}

numbered!(Fault, EmergencyStop LateBlock HostLost SensorImplausible OverCurrent LoadShorted LoadOpen LaneImplausible CapacitanceShifted ResonanceDamaged SenseSwapped SenseSaturated NoResonance NoLock LossOfLock TrackersDisagree WrongMode BeltStopped BeltSensorLost BeltSensorImplausible EnergyPerLength OverTemperature OnTimeExceeded ForceSensorImplausible);
numbered!(Limit, OverVoltageRequest FrequencyWindow NotTracking QuadratureRequest Derated BeltMuted NoAuthority RatioUnreachable BoostLimited RestraintUnclassified);

/// How a stage of the way to [`Mode::Run`] is getting on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// It goes on.
    Busy,
    /// It is over.
    Done,
    /// It has to go back to an earlier one.
    Back(Mode),
    /// It has failed.
    Failed(Fault),
}

/// The mode, the fault, and what the last order was.
#[derive(Clone, Debug)]
pub struct Supervisor {
    acquisition: Acquisition,
    mode: Mode,
    fault: Option<Fault>,
    obeyed: u32,
    /// The attempt that is done.
    done: Option<u32>,
}

impl Supervisor {
    /// Idle, for runs that come to their frequency in this way.
    pub fn new(acquisition: Acquisition) -> Self {
        Supervisor { acquisition, mode: Mode::Idle, fault: None, obeyed: 0, done: None }
    }

    /// What the controller is doing.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Why the drive is muted.
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// Takes this block's order and what the guard has found. Returns whether a new attempt begins.
    pub fn judge(&mut self, orders: &Orders, found: Option<Fault>) -> bool {
        let cleared = orders.clear_fault && orders.sequence != self.obeyed;
        self.obeyed = orders.sequence;
        if cleared && self.mode == Mode::Fault {
            self.fault = None;
            self.mode = Mode::Idle;
        }
        // Silence is judged too, except for what a muted drive cannot harm: a fault is only news while driving.
        let driving = !matches!(self.mode, Mode::Idle | Mode::Fault);
        if orders.emergency_stop {
            self.raise(Fault::EmergencyStop);
        } else if orders.host_lost {
            self.raise(Fault::HostLost);
        } else if let Some(fault) = found.filter(|_| driving) {
            self.raise(fault);
        }
        match (self.mode, orders.request) {
            (Mode::Fault, _) => false,
            (_, Request::Idle) => {
                self.mode = Mode::Idle;
                false
            }
            // Both are done once for each order: the mode returns to idle, and only a new order repeats them.
            (Mode::Idle, Request::Scan | Request::Calibrate) if self.done == Some(orders.attempt) => false,
            // A new order of either also ends a run, and any other a calibration.
            (Mode::Idle, _)
            | (Mode::Lock | Mode::Run, Request::Scan | Request::Calibrate)
            | (Mode::Scan | Mode::Clamped, Request::Calibrate)
            | (Mode::Clamped, Request::Scan)
            | (Mode::Calibrate, Request::Scan | Request::Run) => {
                self.mode = Mode::SelfTest;
                true
            }
            _ => false,
        }
    }

    /// Moves on when the present stage is over.
    pub fn advance(&mut self, orders: &Orders, progress: Progress) {
        match progress {
            Progress::Busy => {}
            Progress::Failed(fault) => self.raise(fault),
            Progress::Back(mode) => self.mode = mode,
            Progress::Done => {
                self.mode = match self.mode {
                    Mode::SelfTest if orders.request == Request::Calibrate => Mode::Calibrate,
                    Mode::SelfTest if orders.request == Request::Scan => Mode::Scan,
                    Mode::SelfTest => match self.acquisition {
                        Acquisition::Told => Mode::Run,
                        Acquisition::Scanned => Mode::Scan,
                        Acquisition::Observed => Mode::Clamped,
                    },
                    Mode::Clamped => Mode::Lock,
                    Mode::Calibrate => self.end(orders),
                    Mode::Scan if orders.request == Request::Scan => self.end(orders),
                    Mode::Scan => Mode::Lock,
                    Mode::Lock => Mode::Run,
                    other => other,
                }
            }
        }
    }

    /// The order is carried out.
    fn end(&mut self, orders: &Orders) -> Mode {
        self.done = Some(orders.attempt);
        Mode::Idle
    }

    fn raise(&mut self, fault: Fault) {
        if self.mode != Mode::Fault {
            self.fault = Some(fault);
            self.mode = Mode::Fault;
        }
    }
}
