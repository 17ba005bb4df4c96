//! `[contact.expression]`: a friction law of the user's own, as text.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Sign;
use contact::custom::Source;

/// A friction law as text: the rates of its states, and its force. Names in the texts: `v` is the
/// slip velocity in m/s, `N` the normal force in N, `mu`, `Fc` = mu N, the states, the parameters,
/// the relays, `pi`, and in the force `d` and a state for its rate. Functions: exp, ln, log10,
/// sqrt, cbrt, sin, cos, tan, asin, acos, atan, sinh, cosh, tanh, abs, sign, max, min. For contact
/// studies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Expression {
    /// Coefficient of friction; `mu` N is the reference of the friction ratio.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub mu: f64,
    /// Normal force, N. Default with `rig.sdof`: the weight of its mass, m g with g = 9.81 m/s^2.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-9, max = 1e6))]
    pub normal_n: Option<f64>,
    /// Sign of the vibration in the slip velocity of a contact study, passive by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sign: Option<Sign>,
    /// Friction in N.
    pub force: String,
    /// Rate of each state, per second: `rate.z = "v - k*abs(v)*z/Fc"`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub rate: BTreeMap<String, String>,
    /// Values of the states at the start, zero by default.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub start: BTreeMap<String, f64>,
    /// Parameters of the law. The end of a name, such as `_n_per_m`, is shown as its unit.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameter: BTreeMap<String, f64>,
    /// Switches with memory: a relay is 0 at the start, becomes 1 when its `on` rises above zero,
    /// and 0 when its `off` does.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub relay: BTreeMap<String, Relay>,
}

/// Conditions of a relay.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Relay {
    /// Condition that switches the relay to 1, above zero.
    pub on: String,
    /// Condition that switches the relay to 0, above zero.
    pub off: String,
}

impl Expression {
    /// Returns the texts and numbers of the law.
    pub fn source(&self) -> Source {
        let relay = |(name, relay): (&String, &Relay)| (name.clone(), (relay.on.clone(), relay.off.clone()));
        Source {
            mu: self.mu,
            rates: self.rate.clone(),
            force: self.force.clone(),
            start: self.start.clone(),
            parameters: self.parameter.clone(),
            relays: self.relay.iter().map(relay).collect(),
        }
    }
}
