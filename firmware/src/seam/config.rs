//! The configuration of a user, in SI units.
//! [`Controller::build`](crate::controller::Controller::build) checks it.
//!
//! Each table of settings is defined once, in its own file: type, unit, range, default and meaning
//! of each setting, its key on the link, and its name in a scene. From it follow the checks of the
//! build, the parameters of the link, the keys of a scene with their JSON Schema, and
//! `docs/scene-keys.md`.

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

/// Tables of settings in a scene: double precision, with keys and defaults.
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

/// Complete configuration of a controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Config {
    /// Sample rate of DAC and ADC, Hz.
    pub sample_hz: f32,
    /// Number of samples in a block.
    pub block_samples: u16,
    /// Number of drive lanes, 1 to 4.
    pub lanes: u8,
    /// Scale of the converters.
    pub front_end: FrontEnd,
    /// Frequency, amplitude and waveform of the drive.
    pub drive: Drive,
    /// Sweep of the frequency in a run.
    pub sweep: Sweep,
    /// Lane offsets and trims.
    pub phasing: Phasing,
    /// Schedule of the bursts.
    pub burst: Burst,
    /// Search and tracking of the resonance.
    pub tracking: Tracking,
    /// Temperature of the stack.
    pub thermometer: Thermometer,
    /// Thermistor at the amplifier's heat sink.
    pub heat_sink: HeatSink,
    /// Supply of the amplifier.
    pub supply: Supply,
    /// Limits that must never be exceeded.
    pub limits: Limits,
    /// Friction switch, which sets amplitude and bursts in a run. The drive's amplitude is its
    /// maximum.
    pub friction: Option<Friction>,
    /// Restraint of a seat belt at a D-ring, which decides ON and OFF instead of burst schedule and
    /// gate; `None` without a belt.
    pub restraint: Option<Restraint>,
    /// Link to the host.
    pub link: Link,
}

impl Config {
    /// Sample rate, Hz.
    pub(crate) const SAMPLE_HZ: Setting = Setting { name: "sample_hz", min: 1e3, max: 20e6 };
    /// Number of samples in a block.
    pub const BLOCK_SAMPLES: Setting = Setting { name: "block_samples", min: 8.0, max: MAX_BLOCK_SAMPLES as f64 };
    /// Number of drive lanes, up to that of the board.
    pub const LANES: Setting = Setting { name: "lanes", ..FrontEnd::DRIVE_LANES };

    /// Parameters outside of tables: the lanes, and the presence of optional tables.
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

    /// Checks that every value of the tables that every image has is within its range. The error
    /// names the first that is not. Chirp, friction switch and restraint check their own tables.
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
        self.thermometer.check_balance()?;
        self.heat_sink.check()?;
        self.supply.check()?;
        self.supply.check_window()?;
        self.limits.check()?;
        self.link.check()
    }
}

/// Returns `true` if a value is the default, which a table of a scene omits.
#[cfg(feature = "scene")]
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
