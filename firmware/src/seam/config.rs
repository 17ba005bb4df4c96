//! What a user sets, in SI units. May be wrong: [`Controller::build`](crate::controller::Controller::build) checks it.
//!
//! Each table of settings is described once, in a file of its own: type, unit, range, default and meaning of each setting, its key over the link, and
//! its name in a scene. The build's check, the parameters of the link, the keys of a scene with their JSON Schema, and `docs/settings.md` follow.

mod burst;
mod drive;
mod friction;
mod front_end;
mod heat_sink;
mod limits;
mod link;
mod parameter;
mod phasing;
mod restraint;
mod setting;
mod supply;
mod sweep;
mod thermometer;
mod tracking;

use serde::{Deserialize, Serialize};

use crate::seam::block::{MAX_BLOCK_SAMPLES, MAX_LANES};
pub use crate::seam::config::burst::{Burst, Edge, MAX_WINDOWS, Schedule};
pub use crate::seam::config::drive::{Drive, ShapeKind};
pub use crate::seam::config::friction::{Friction, FrictionLaw, Prefer};
pub use crate::seam::config::front_end::FrontEnd;
pub use crate::seam::config::heat_sink::HeatSink;
pub use crate::seam::config::limits::Limits;
pub use crate::seam::config::link::Link;
use crate::seam::config::parameter::keys::{FRICTION_ENABLED, RESTRAINT_ENABLED};
pub(crate) use crate::seam::config::parameter::{Choice, Optional};
pub use crate::seam::config::parameter::{Parameter, Range, keys};
pub use crate::seam::config::phasing::{Direction, LaneTrims, MAX_TRIM_POINTS, Phasing, Trim, TrimPoint};
pub use crate::seam::config::restraint::Restraint;
pub use crate::seam::config::setting::Setting;
pub use crate::seam::config::supply::Supply;
pub use crate::seam::config::sweep::{Around, Chirp, ChirpKind, Sweep, Then};
pub use crate::seam::config::thermometer::Thermometer;
pub use crate::seam::config::tracking::{Tracking, TrackingMode};
use crate::seam::error::Error;

/// The tables of settings as a scene has them: in double precision, by their keys, with their defaults.
#[cfg(feature = "scene")]
pub mod scene {
    pub use super::burst::scene::Burst;
    pub use super::drive::scene::Drive;
    pub use super::friction::scene::Friction;
    pub use super::limits::scene::Limits;
    pub use super::phasing::scene::Phasing;
    pub use super::restraint::scene::Restraint;
    pub use super::sweep::scene::Sweep;
    pub use super::thermometer::scene::Thermometer;
    pub use super::tracking::scene::Tracking;
}

/// The whole configuration of a controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Config {
    /// Samples a second, of DAC and ADC alike, Hz.
    pub sample_hz: f32,
    /// Samples in a block.
    pub block_samples: u16,
    /// Drive lanes, 1 to 4.
    pub lanes: u8,
    /// What a converter code is worth.
    pub front_end: FrontEnd,
    /// Frequency, amplitude and waveform of the drive.
    pub drive: Drive,
    /// What the frequency does while running.
    pub sweep: Sweep,
    /// Lane offsets and trims.
    pub phasing: Phasing,
    /// Schedule of the bursts.
    pub burst: Burst,
    /// How the frequency is found and tracked.
    pub tracking: Tracking,
    /// The stack as a thermometer of itself.
    pub thermometer: Thermometer,
    /// The thermistor at the amplifier's heat sink.
    pub heat_sink: HeatSink,
    /// The amplifier's supply.
    pub supply: Supply,
    /// What must never be exceeded.
    pub limits: Limits,
    /// The friction switch, which then sets amplitude and bursts while running. The drive's amplitude is its maximum.
    pub friction: Option<Friction>,
    /// When the drive of a seat belt's D-ring is ON, in place of burst schedule and gate; `None`: it serves no belt.
    pub restraint: Option<Restraint>,
    /// The link to the host.
    pub link: Link,
}

impl Config {
    /// Samples a second.
    pub(crate) const SAMPLE_HZ: Setting = Setting { name: "sample_hz", min: 1e3, max: 20e6 };
    /// Samples in a block.
    pub const BLOCK_SAMPLES: Setting = Setting { name: "block_samples", min: 8.0, max: MAX_BLOCK_SAMPLES as f64 };
    /// Drive lanes: as many as the board has at most.
    pub const LANES: Setting = Setting { name: "lanes", ..FrontEnd::DRIVE_LANES };

    /// Parameters of the configuration itself: its lanes, and the tables that it may be without.
    pub(crate) const PARAMETERS: &'static [Parameter] = &[
        Parameter {
            key: 62,
            name: Self::LANES.name,
            range: Range::Whole(1, MAX_LANES as u8),
            read: |config| config.lanes.into(),
            write: |config, value| config.lanes = value as u8,
        },
        Parameter::flag(
            FRICTION_ENABLED,
            "friction.enabled",
            |config| bool::place(config.friction.is_some()),
            |config, value| config.friction = bool::at(value).then(|| config.friction.take().unwrap_or(Friction::DEFAULT)),
        ),
        Parameter::flag(
            RESTRAINT_ENABLED,
            "restraint.enabled",
            |config| bool::place(config.restraint.is_some()),
            |config, value| config.restraint = bool::at(value).then(|| config.restraint.take().unwrap_or(Restraint::DEFAULT)),
        ),
    ];

    /// Whether every value is within its range, of the tables that every image has; names the first that is not. Chirp, friction switch and restraint
    /// check theirs themselves, where the image has them.
    pub(crate) fn check_ranges(&self) -> Result<(), Error> {
        Self::SAMPLE_HZ.check(self.sample_hz)?;
        Self::BLOCK_SAMPLES.check(self.block_samples.into())?;
        self.front_end.check()?;
        Self::LANES.check_within(self.lanes.into(), 1.0, self.front_end.drive_lanes.into())?;
        self.drive.check()?;
        self.phasing.check()?;
        self.burst.check()?;
        self.burst.check_schedule()?;
        self.tracking.check()?;
        self.thermometer.check()?;
        self.heat_sink.check()?;
        self.supply.check()?;
        self.supply.check_window()?;
        self.limits.check()?;
        self.link.check()
    }
}

/// A table in a scene leaves out what is the default.
#[cfg(feature = "scene")]
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
