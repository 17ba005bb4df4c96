//! `[integrator]`: method, step and tolerance for the contact.

use contact::{Method, ToleranceOf};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Part of a contact study to which its means belong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MeanWindow {
    /// The periodic steady state, which the run approaches; it does not depend on the start.
    Steady,
    /// `window_periods` of the run, or its second half.
    Run,
}

/// Step size for the contact; in a contact study also the method, the tolerance and the window of
/// the means.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Integrator {
    /// Method of a contact study. Default: auto.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<Method>,
    /// Minimum number of steps per period of the series resonance or of the excitation. Default:
    /// from the contact's stiffness.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 4, max = 100_000))]
    pub steps_per_period: Option<u32>,
    /// Order of linexp (2, 4, 6, 10) or of the Taylor series (8, 12, … 32), in a contact study.
    /// Default: the method's own choice.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 64))]
    pub order: Option<u32>,
    /// Largest error of a contact study: of its mean friction ratio, or of the quantity in
    /// `tolerance_of`. Default: 1e-7.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-13, max = 0.1))]
    pub tolerance: Option<f64>,
    /// Quantity that the tolerance applies to, mean by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance_of: Option<ToleranceOf>,
    /// Part of a contact study to which its means belong: the periodic steady state, which does
    /// not depend on the start, or `window_periods` of the run. Default: steady, unless
    /// `window_periods` or a measured curve is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window: Option<MeanWindow>,
    /// Window of the means of a contact study, in periods of the excitation: from, to. Without it,
    /// the second half of the run if there is no steady state.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 2, max = 2), inner(range(min = 0.0, max = 1e12)))]
    pub window_periods: Option<Vec<f64>>,
}
