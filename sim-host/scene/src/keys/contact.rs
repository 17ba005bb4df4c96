//! `[contact]`: the friction contact.

mod compliant;
mod expression;
mod pair;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use contact::empirical::EmpiricalLaw;

pub use compliant::{Compliant, Held};
pub use expression::{Expression, Relay};
pub use pair::Pair;

/// The friction contact. Give exactly one model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Pair of materials that gives the coefficient of friction of the model, instead of `mu`.
    #[serde(default, skip_serializing)]
    pub pair: Option<Pair>,
    /// Coulomb's model of friction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coulomb: Option<Coulomb>,
    /// Dahl's model of friction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dahl: Option<Dahl>,
    /// The LuGre model of friction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lugre: Option<Lugre>,
    /// Hertz's contact under vibration across the surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hertz: Option<Hertz>,
    /// A contact with constant stiffness in both directions, under vibration across the surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compliant: Option<Compliant>,
    /// A friction law of your own, as text; [Extend it](extend.md) explains the names and
    /// functions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expression: Option<Expression>,
    /// A fitted law of a seat belt under vibration across it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub empirical: Option<Empirical>,
}

/// Coulomb's model: `F = mu N sgn(V)`. For contact studies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Coulomb {
    /// Coefficient of friction of the contact.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub mu: f64,
    /// Normal force, N. Default with `rig.sdof`: the weight of its mass, m g with g = 9.81 m/s^2.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-9, max = 1e6))]
    pub normal_n: Option<f64>,
    /// Sign of the vibration in the slip velocity of a contact study, passive by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sign: Option<Sign>,
}

/// Dahl's model with exponent one: `dF/dz = Kt (1 - F sgn(V) / Fc)`, `Fc = mu N`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Dahl {
    /// Coefficient of friction of the contact.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub mu: f64,
    /// Normal force, N. Default with `rig.sdof`: the weight of its mass, m g with g = 9.81 m/s^2.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-9, max = 1e6))]
    pub normal_n: Option<f64>,
    /// Tangential contact stiffness Kt, N/m.
    #[schemars(range(min = 1.0, max = 1e12))]
    pub stiffness_n_per_m: f64,
    /// Exponent of the model: 1, as in the thesis, which is solved exactly in slip.
    #[serde(default = "default::alpha")]
    pub alpha: f64,
    /// Sign of the vibration in the slip velocity of a contact study, passive by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sign: Option<Sign>,
}

/// The LuGre model: `z' = V - |V| z / G(V)`, `F = Kt z + sigma1 z' + sigma2 V`,
/// `Kt G(V) = N (mu + (static_mu - mu) exp(-(V / Vs)^2))`. For contact studies, and under
/// `rig.carriage`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lugre {
    /// Coefficient of kinetic friction.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub mu: f64,
    /// Coefficient of static friction, at least `mu`.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub static_mu: f64,
    /// Normal force, N. Default with `rig.sdof`: the weight of its mass, m g with g = 9.81 m/s^2.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-9, max = 1e6))]
    pub normal_n: Option<f64>,
    /// Bristle stiffness Kt, N/m.
    #[schemars(range(min = 1.0, max = 1e12))]
    pub stiffness_n_per_m: f64,
    /// Stribeck velocity Vs, m/s: velocity scale on which friction falls from static to kinetic.
    #[schemars(range(min = 1e-9, max = 1e3))]
    pub stribeck_m_per_s: f64,
    /// Damping of the bristles, N s/m.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1e9))]
    pub sigma1: f64,
    /// Viscous friction, N s/m.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1e9))]
    pub sigma2: f64,
    /// Sign of the vibration in the slip velocity of a contact study, passive by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sign: Option<Sign>,
}

/// Hertz's contact, `N = K d^1.5`, with friction in proportion to the contact area, under a
/// vibration across the surface. The vibration is prescribed (`rig.kinematic`), or is that of a
/// mass on the contact that a force excites (`rig.sdof`); it bounces if the force is large.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Hertz {
    /// Coefficient of friction of the contact.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub mu: f64,
    /// Mean normal force, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-9, max = 1e6))]
    pub normal_n: Option<f64>,
    /// Hertzian stiffness K, N/m^1.5.
    #[schemars(range(min = 1.0, max = 1e18))]
    pub stiffness_n_per_m15: f64,
}

/// A law fitted to the thesis's second experiment. Vibration across a seat belt removes the part
/// `R` of its friction, `R = reduction g(v) (W / reference_load_n)^-load_exponent (a /
/// reference_amplitude_fraction)^e`, with `e = amplitude_exponent min(1, (reference_load_n /
/// W)^amplitude_load_exponent)`. `g` is one at the reference speed and falls as `1 / (1 + v /
/// speed_scale_m_per_s)`. For `rig.belt`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Empirical {
    /// Coefficient of friction of the pull without vibration, both faces of the belt together.
    /// Assumed; the reduction is a part of it.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub mu: f64,
    /// Part of the friction that a lasting vibration removes at reference load, amplitude and
    /// speed.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub reduction: f64,
    /// Reference load of the law, N.
    #[schemars(range(min = 1.0, max = 1e4))]
    pub reference_load_n: f64,
    /// Reference amplitude, as a part of the full amplitude.
    #[schemars(range(min = 1e-3, max = 1.0))]
    pub reference_amplitude_fraction: f64,
    /// Reference speed of the law, m/s.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub reference_speed_m_per_s: f64,
    /// Speed at which the effect is half that on a creeping belt, m/s; not from the thesis, which
    /// has one speed.
    #[schemars(range(min = 1e-6, max = 1e3))]
    pub speed_scale_m_per_s: f64,
    /// Exponent with which the effect falls with the load.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub load_exponent: f64,
    /// Exponent with which the effect rises with the amplitude, at the reference load and below.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub amplitude_exponent: f64,
    /// Exponent with which `amplitude_exponent` falls with the load.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub amplitude_load_exponent: f64,
    /// Smallest amplitude tested, as a part of the full amplitude. Below it, the effect falls in
    /// proportion to the amplitude.
    #[schemars(range(min = 1e-3, max = 1.0))]
    pub lowest_amplitude_fraction: f64,
}

impl Default for Empirical {
    fn default() -> Self {
        let law = EmpiricalLaw::FITTED;
        Empirical {
            mu: 0.3,
            reduction: law.reduction,
            reference_load_n: law.load_n,
            reference_amplitude_fraction: law.amplitude_fraction,
            reference_speed_m_per_s: law.speed_m_per_s,
            speed_scale_m_per_s: law.speed_scale_m_per_s,
            load_exponent: law.load_exponent,
            amplitude_exponent: law.amplitude_exponent,
            amplitude_load_exponent: law.amplitude_load_exponent,
            lowest_amplitude_fraction: law.lowest_amplitude_fraction,
        }
    }
}

impl Empirical {
    /// Returns the empirical law with these constants.
    pub fn law(&self) -> EmpiricalLaw {
        EmpiricalLaw {
            reduction: self.reduction,
            load_n: self.reference_load_n,
            amplitude_fraction: self.reference_amplitude_fraction,
            speed_m_per_s: self.reference_speed_m_per_s,
            speed_scale_m_per_s: self.speed_scale_m_per_s,
            load_exponent: self.load_exponent,
            amplitude_exponent: self.amplitude_exponent,
            amplitude_load_exponent: self.amplitude_load_exponent,
            lowest_amplitude_fraction: self.lowest_amplitude_fraction,
        }
    }
}

/// Sign of the vibration in the slip velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Sign {
    /// V = Vt + x': friction takes energy from the vibration.
    #[default]
    Passive,
    /// V = Vt - x', as printed in 4.14 and 4.16 of the thesis: friction feeds energy into the
    /// vibration.
    Literal,
}

/// The friction model of a contact study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Model<'a> {
    /// Coulomb's model of friction.
    Coulomb(&'a Coulomb),
    /// Dahl's model of friction.
    Dahl(&'a Dahl),
    /// The LuGre model of friction.
    Lugre(&'a Lugre),
    /// Hertz's contact under vibration across the surface.
    Hertz(&'a Hertz),
    /// Constant stiffness in both directions, under vibration across the surface.
    Compliant(&'a Compliant),
    /// A friction law of the user's own.
    Expression(&'a Expression),
}

impl Contact {
    /// Returns the model of the contact, or `None` if the table has none.
    pub fn model(&self) -> Option<Model<'_>> {
        let coulomb = self.coulomb.as_ref().map(Model::Coulomb);
        let dahl = self.dahl.as_ref().map(Model::Dahl);
        let lugre = self.lugre.as_ref().map(Model::Lugre);
        let hertz = self.hertz.as_ref().map(Model::Hertz);
        let compliant = self.compliant.as_ref().map(Model::Compliant);
        let expression = self.expression.as_ref().map(Model::Expression);
        coulomb.or(dahl).or(lugre).or(hertz).or(compliant).or(expression)
    }

    /// Fills in the default sign of a model that has a sign.
    pub(crate) fn complete(&mut self) {
        let coulomb = self.coulomb.iter_mut().map(|model| &mut model.sign);
        let dahl = self.dahl.iter_mut().map(|model| &mut model.sign);
        let lugre = self.lugre.iter_mut().map(|model| &mut model.sign);
        let expression = self.expression.iter_mut().map(|model| &mut model.sign);
        for sign in coulomb.chain(dahl).chain(lugre).chain(expression) {
            sign.get_or_insert_default();
        }
    }
}

impl Model<'_> {
    /// Returns the coefficient of (kinetic) friction.
    pub fn mu(&self) -> f64 {
        match self {
            Model::Coulomb(model) => model.mu,
            Model::Dahl(model) => model.mu,
            Model::Lugre(model) => model.mu,
            Model::Hertz(model) => model.mu,
            Model::Compliant(model) => model.mu,
            Model::Expression(model) => model.mu,
        }
    }

    /// Returns the normal force if it is given, N.
    pub fn normal_n(&self) -> Option<f64> {
        match self {
            Model::Coulomb(model) => model.normal_n,
            Model::Dahl(model) => model.normal_n,
            Model::Lugre(model) => model.normal_n,
            Model::Hertz(model) => model.normal_n,
            Model::Compliant(model) => model.normal_n,
            Model::Expression(model) => model.normal_n,
        }
    }

    /// Returns the sign of the vibration in the slip velocity.
    pub fn sign(&self) -> Sign {
        let given = match self {
            Model::Coulomb(model) => model.sign,
            Model::Dahl(model) => model.sign,
            Model::Lugre(model) => model.sign,
            Model::Expression(model) => model.sign,
            Model::Hertz(_) | Model::Compliant(_) => None,
        };
        given.unwrap_or_default()
    }
}

/// Defaults that serde needs as functions.
mod default {
    pub(super) fn alpha() -> f64 {
        1.0
    }
}
