//! Scene: everything a run needs, as one TOML file. The same file is command-line input, test case
//! and snapshot.
//!
//! These types are the only description of the contents of a scene. The JSON Schema, the checks on
//! keys, types and ranges, and the comments of `sim-host show` are all derived from them. The rules
//! add the checks that a schema cannot express.
//!
//! # Example
//!
//! ```
//! use sonoglide_scene::load::load;
//!
//! let loaded = load("lock", &["controller.drive.amplitude_v=2.5".to_owned()])?;
//! let scene = loaded.scene.driven().expect("the firmware drives it");
//! assert_eq!(scene.controller.drive.amplitude_v, Some(2.5));
//!
//! // Every mistake is reported, with its place and the nearest name.
//! let wrong = load("lock", &["controller.drive.amplitud_v=2.5".to_owned()]).unwrap_err();
//! assert!(wrong.to_string().contains("amplitude_v"));
//! # Ok::<(), sonoglide_scene::load::LoadError>(())
//! ```
#![forbid(unsafe_code)]

mod keys;
pub mod metrics;
pub mod numbers;
mod pages;
pub mod problem;
mod read;
pub mod replaced;
pub mod settings;
mod views;

#[cfg(test)]
mod tests;

pub use design::keys::Design;
pub use firmware::seam::config::scene::{Burst, Drive, Friction, Limits, Phasing, Restraint, Sweep, Thermometer, Tracking};
pub use firmware::seam::config::{
    Around, ChirpKind, Direction, Edge, FrictionLaw, Prefer, ShapeKind as Shape, Then, TrackingMode,
};
pub use keys::carriage::Carriage;
pub use keys::circuit;
pub use keys::comparison::{Case, Comparison, Equal};
pub use keys::contact::{Compliant, Contact, Coulomb, Dahl, Empirical, Expression, Held, Hertz, Lugre, Model, Relay, Sign};
pub use keys::controller::Controller;
pub use keys::course::{Disturbance, DisturbedKey, Fault, FaultKind};
pub use keys::dring::{ActuatorKind, Dring, NormalPartKind, Occupant, RingVibration};
pub use keys::excitation::{Excitation, Match, VibrationVelocity, Waveform};
pub use keys::integrator::{Integrator, MeanWindow};
pub use keys::measured_curve::Overlay;
pub use keys::plant::{Amplifier, Bvd, LAW_FACTORS, Mode, Sensors, Stack, StackDesign, Thermal};
pub use keys::profile::Profile;
pub use keys::results::{Expect, Grid, MAX_CONTOURS, Over, Signal, Trace, TraceFormat};
pub use keys::rig::{Belt, Kinematic, Rig, Rotor, Sdof, Slider};
pub use keys::stator::Stator;
pub use keys::vary::{Range, Vary};
use keys::{carriage, contact, dring, plant};
pub use metrics::figures;
pub use pages::{all_keys, keys_page, resolved, settings_page};
pub use read::nearest::shown;
pub use read::{builtin, diagnostic, load, nearest, schema, suite};
use read::{distribution, exclusive, overlay, profile, rules, tree, unknown, walk, wording};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
pub use views::{Body, Designed, Driven, Excited, Kind, Transducer};

/// A scene, in which the firmware drives a transducer, a contact is studied alone, or a transducer
/// is designed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// One line that states what the scene shows.
    pub title: String,
    /// Source of the numbers.
    #[serde(default)]
    pub source: String,
    /// Notes for the reader of the report, one paragraph each: choices and their reasons.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Simulated time of the run, s. A design has none.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(required, range(min = 1e-4, max = 1e5))]
    pub duration_s: f64,
    /// Seed of all noise: the same seed gives the same run, bit for bit.
    #[serde(default = "default::seed")]
    #[schemars(range(max = 9_007_199_254_740_992_u64))] // every JSON reader keeps it exactly
    pub seed: u64,
    /// Number of runs. If there are several, each has its own seed and draws the keys of
    /// `[[vary]]`; metrics are then medians, percentiles and intervals.
    #[serde(default = "default::runs", skip_serializing_if = "is_one")]
    #[schemars(range(min = 1, max = 100_000), extend("default" = 1))]
    pub runs: u32,
    /// The settings of the firmware that drives the transducer. A scene has this table,
    /// `[excitation]` or `[design]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub controller: Option<Controller>,
    /// The excitation of a contact study. A scene has this table, `[controller]` or `[design]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub excitation: Option<Excitation>,
    /// The mechanical design of a transducer or horn, from which its circuit follows. A scene has
    /// this table, `[controller]` or `[excitation]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub design: Option<Design>,
    /// The power amplifier between DAC and stack.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplifier: Option<Amplifier>,
    /// The converters and the load cell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensors: Option<Sensors>,
    /// The piezo stack that the firmware drives.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stack: Option<Stack>,
    /// The stator of a travelling-wave motor that the firmware drives. A driven scene has this or
    /// `[stack]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stator: Option<Stator>,
    /// The friction contact. Needs a rig that presses on it and moves it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact: Option<Contact>,
    /// The mechanism that presses on the contact and moves it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rig: Option<Rig>,
    /// Solver of a contact study: method, step and tolerance.
    #[serde(default)]
    pub integrator: Integrator,
    /// Changes of plant values during the run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub disturbance: Vec<Disturbance>,
    /// Faults during the run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fault: Vec<Fault>,
    /// Numbers that are drawn anew in each run, if there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub vary: Vec<Vary>,
    /// Metrics over the values of some keys, run in addition to the scene itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<Grid>,
    /// Comparison of cases at equal peak, rms, power or reduction; run after the scene itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub comparison: Option<Comparison>,
    /// Signals that are recorded in addition to the standard figures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trace: Option<Trace>,
    /// Measured curves that are drawn over the figures.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub overlay: Vec<Overlay>,
    /// Expected values of metrics.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub expect: Vec<Expect>,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Returns `true` for the default. Serde passes a reference.
fn is_one(runs: &u32) -> bool {
    *runs == 1
}

/// Defaults that serde needs as functions.
mod default {
    pub(super) fn runs() -> u32 {
        1
    }

    pub(super) fn seed() -> u64 {
        1
    }
}
