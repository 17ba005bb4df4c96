//! Schedule and edges of the bursts.

use config_macro::settings;
use heapless::Vec;
#[cfg(feature = "scene")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Choice, Config};
use crate::seam::config::{Parameter, Range};
use crate::seam::error::Error;

/// Largest number of ON windows of a burst schedule.
pub const MAX_WINDOWS: usize = 8;

/// Schedule and edges of the bursts, from the order to run, or from a calibration before it.
#[settings(table = "burst", scene = Burst)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Burst {
    /// Schedule of ON and OFF.
    #[setting(controller, default)]
    pub schedule: Schedule,
    /// Start times of the ON windows, s.
    #[setting(scene, min = 0.0, max = 1e5)]
    pub on_s: Vec<f64, MAX_WINDOWS>,
    /// End times of the ON windows, s.
    #[setting(scene, min = 0.0, max = 1e5)]
    pub off_s: Vec<f64, MAX_WINDOWS>,
    /// Period of periodic bursts, s.
    #[setting(scene, min = 1e-5, max = 1e5)]
    pub period_s: Option<f64>,
    /// Fraction of the period that is ON.
    #[setting(scene, min = 0.0, max = 1.0, key = 20, read = duty, write = set_duty)]
    pub duty: Option<f64>,
    /// Shape of the edges.
    #[setting(default, key = 25)]
    pub edge: Edge,
    /// Length of a soft edge, drive periods.
    #[setting(default = 5.0, min = 0.5, max = 1e4, key = 26)]
    pub edge_cycles: f32,
    /// Stops the vibration at the end of each burst by driving against it, within
    /// `limits.voltage_v` and `limits.current_a`.
    #[setting(default, key = 27, quiet)]
    pub brake: bool,
}

impl Burst {
    /// Period as a parameter; zero means that the drive is always on.
    pub(crate) const PERIOD: &'static [Parameter] = &[Parameter {
        key: 19,
        name: Self::PERIOD_S.name,
        range: Range::Within(0.0, Self::PERIOD_S.max as f32),
        read: |config| periodic(config).0 as f32,
        write: |config, value| {
            config.burst.schedule = match periodic(config) {
                _ if value == 0.0 => Schedule::Continuous,
                (_, duty) => Schedule::Periodic { period_s: value.into(), duty },
            }
        },
    }];

    /// Ends of the windows as parameters, numbered from one. A window from zero to zero is absent.
    /// Windows replace a period.
    pub(crate) const WINDOWS: &'static [Parameter] = &[
        window::<0, ON>(40, "burst.on_1_s"),
        window::<0, OFF>(41, "burst.off_1_s"),
        window::<1, ON>(42, "burst.on_2_s"),
        window::<1, OFF>(43, "burst.off_2_s"),
        window::<2, ON>(44, "burst.on_3_s"),
        window::<2, OFF>(45, "burst.off_3_s"),
        window::<3, ON>(46, "burst.on_4_s"),
        window::<3, OFF>(47, "burst.off_4_s"),
        window::<4, ON>(48, "burst.on_5_s"),
        window::<4, OFF>(49, "burst.off_5_s"),
        window::<5, ON>(50, "burst.on_6_s"),
        window::<5, OFF>(51, "burst.off_6_s"),
        window::<6, ON>(52, "burst.on_7_s"),
        window::<6, OFF>(53, "burst.off_7_s"),
        window::<7, ON>(54, "burst.on_8_s"),
        window::<7, OFF>(55, "burst.off_8_s"),
    ];

    /// Checks the ranges of the schedule. The build checks that a period has at least one sample.
    pub(super) fn check_schedule(&self) -> Result<(), Error> {
        match &self.schedule {
            Schedule::Continuous => Ok(()),
            Schedule::Windows(windows) => windows.iter().try_for_each(|&(on, off)| {
                Self::ON_S.check_double(on)?;
                Self::OFF_S.check_double(off).map(drop)
            }),
            &Schedule::Periodic { period_s, duty } => {
                Self::DUTY.check_double(duty)?;
                Self::PERIOD_S.check_double(period_s).map(drop)
            }
        }
    }
}

/// Schedule of ON and OFF.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Schedule {
    /// The drive is on throughout a run.
    #[default]
    Continuous,
    /// ON in each window, given as its start and its end, s.
    Windows(Vec<(f64, f64), MAX_WINDOWS>),
    /// ON for the first part `duty` of every `period_s`.
    Periodic {
        /// Period, s.
        period_s: f64,
        /// Fraction of the period that is ON, 0 to 1.
        duty: f64,
    },
}

/// Shape of the edges between OFF and ON.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "scene", derive(JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Edge {
    // It changes at zero crossings of the first lane, and lasts whole periods.
    /// The envelope changes at once.
    #[default]
    Hard,
    /// The envelope is a raised cosine.
    Soft,
    /// The vibration changes as fast as `limits.voltage_v` allows: a larger drive at the start, a
    /// drive against the residual vibration at the end. For sines with a tracked resonance.
    Boost,
}

impl Choice for Edge {
    const ALL: &'static [Self] = &[Edge::Hard, Edge::Soft, Edge::Boost];
    const NAMES: &'static [&'static str] = &["hard", "soft", "boost"];
}

/// Returns the period, s, and its ON fraction; zero and one without a period.
fn periodic(config: &Config) -> (f64, f64) {
    match config.burst.schedule {
        Schedule::Periodic { period_s, duty } => (period_s, duty),
        Schedule::Continuous | Schedule::Windows(_) => (0.0, 1.0),
    }
}

/// Returns the duty as a parameter. It applies only to a period, and is therefore set after it.
fn duty(config: &Config) -> f32 {
    periodic(config).1 as f32
}

fn set_duty(config: &mut Config, value: f32) {
    if let Schedule::Periodic { duty, .. } = &mut config.burst.schedule {
        *duty = value.into();
    }
}

/// Start of a window.
const ON: bool = false;
/// End of a window.
const OFF: bool = true;

/// Creates the parameter of one end of window `N`.
const fn window<const N: usize, const END: bool>(key: u8, name: &'static str) -> Parameter {
    Parameter { key, name, range: Range::Within(0.0, Burst::ON_S.max as f32), read: end::<N, END>, write: set_end::<N, END> }
}

fn end<const N: usize, const END: bool>(config: &Config) -> f32 {
    let window = match &config.burst.schedule {
        Schedule::Windows(windows) => windows.get(N).copied(),
        Schedule::Continuous | Schedule::Periodic { .. } => None,
    };
    window.map_or(0.0, |(on, off)| if END == ON { on } else { off }) as f32
}

fn set_end<const N: usize, const END: bool>(config: &mut Config, value: f32) {
    set_window_end(&mut config.burst.schedule, N, END, value.into());
}

/// Sets one end of window `n`, and removes absent windows at the end of the list.
fn set_window_end(schedule: &mut Schedule, n: usize, end: bool, value: f64) {
    let mut windows = match schedule {
        Schedule::Windows(windows) => core::mem::take(windows),
        Schedule::Continuous | Schedule::Periodic { .. } if value == 0.0 => return,
        Schedule::Continuous | Schedule::Periodic { .. } => Vec::new(),
    };
    if windows.len() <= n {
        let _ = windows.resize(n + 1, (0.0, 0.0));
    }
    if let Some((on, off)) = windows.get_mut(n) {
        *(if end == ON { on } else { off }) = value;
    }
    while windows.last() == Some(&(0.0, 0.0)) {
        windows.pop();
    }
    *schedule = if windows.is_empty() { Schedule::Continuous } else { Schedule::Windows(windows) };
}
