//! Contact models as functions of a measured slip.
//!
//! ```text
//! Coulomb    F = Fc sgn V
//! Stribeck   F = sgn V (Fc + (Fs - Fc) exp(-(V / Vs)^2)) + s2 V
//! Dahl       dF/dz = Kt (1 - F sgn V / Fc)
//! LuGre      z' = V - |V| z / G(V),  F = Kt z + s2 V,  Kt G(V) = Fc + (Fs - Fc) exp(-(V / Vs)^2)
//! ```
//!
//! Within a sample the slip has one direction and one velocity. Dahl's and LuGre's equations are
//! then solved exactly by an exponential of the slip. The damping of LuGre's bristles is not a
//! parameter: it only matters during acceleration within the presliding, which hardly any log
//! resolves. Sources: P. Dahl, AIAA J. 14 (1976) 1675; C. Canudas de Wit et al., IEEE Trans. Autom.
//! Control 40 (1995) 419.

use super::log::Log;

/// Contact model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// Coulomb friction.
    Coulomb,
    /// Friction that falls with the velocity, with a viscous part.
    Stribeck,
    /// Dahl model.
    Dahl,
    /// LuGre model without damping of its bristles.
    Lugre,
    /// Generalised Maxwell slip model: springs that slide one after the other.
    Maxwell,
}

/// Parameter of a model: its name, and `true` if its logarithm is fitted.
pub(crate) type Parameter = (&'static str, bool);

const FC: Parameter = ("coulomb_n", true);
const EXCESS: Parameter = ("static_excess_n", true);
const STRIBECK: Parameter = ("stribeck_m_per_s", true);
/// Viscous coefficient. Its logarithm is not fitted: if a log has nearly no viscous friction, the
/// logarithm would drift towards minus infinity, where it has no effect and does not return.
const VISCOUS: Parameter = ("sigma2", false);
const STIFFNESS: Parameter = ("stiffness_n_per_m", true);
const START: Parameter = ("initial_force_n", false);

impl Model {
    /// Models that are fitted by a search.
    pub(crate) const SEARCHED: [Model; 4] = [Model::Coulomb, Model::Stribeck, Model::Dahl, Model::Lugre];

    /// Returns the name of the model, as in a scene.
    pub fn name(self) -> &'static str {
        match self {
            Model::Coulomb => "coulomb",
            Model::Stribeck => "stribeck",
            Model::Dahl => "dahl",
            Model::Lugre => "lugre",
            Model::Maxwell => "maxwell",
        }
    }

    pub(crate) fn parameters(self) -> &'static [Parameter] {
        match self {
            Model::Coulomb => &[FC],
            Model::Stribeck => &[FC, EXCESS, STRIBECK, VISCOUS],
            Model::Dahl => &[FC, STIFFNESS, START],
            Model::Lugre => &[FC, EXCESS, STRIBECK, VISCOUS, STIFFNESS, START],
            Model::Maxwell => &[],
        }
    }

    /// Converts the parameters of the fit to their values.
    pub(super) fn values(self, fitted: &[f64]) -> Vec<f64> {
        self.parameters().iter().zip(fitted).map(|((_, log), p)| if *log { libm::exp(*p) } else { *p }).collect()
    }

    /// Computes the friction at every sample, N.
    pub(crate) fn force(self, fitted: &[f64], log: &Log) -> Vec<f64> {
        let p = self.values(fitted);
        let steady = |fc: f64, excess: f64, vs: f64, v: f64| fc + excess * libm::exp(-(v / vs) * (v / vs));
        match self {
            Model::Coulomb => directions(log).into_iter().map(|sign| p[0] * sign).collect(),
            Model::Stribeck => directions(log)
                .into_iter()
                .zip(&log.velocity_m_per_s)
                .map(|(sign, v)| sign * steady(p[0], p[1], p[2], *v) + p[3] * v)
                .collect(),
            Model::Dahl => {
                let mut force = p[2];
                let step = |slip: &f64| {
                    let limit = p[0] * slip.signum();
                    force = limit + (force - limit) * libm::exp(-p[1] * slip.abs() / p[0]);
                    force
                };
                log.slip_m.iter().map(step).collect()
            }
            Model::Lugre => {
                let mut spring = p[5];
                let step = |(slip, v): (&f64, &f64)| {
                    let limit = steady(p[0], p[1], p[2], *v);
                    let to = limit * slip.signum();
                    spring = to + (spring - to) * libm::exp(-p[4] * slip.abs() / limit);
                    spring + p[3] * v
                };
                log.slip_m.iter().zip(&log.velocity_m_per_s).map(step).collect()
            }
            Model::Maxwell => Vec::new(),
        }
    }
}

/// Returns the direction of sliding at every sample; at rest, the last one.
fn directions(log: &Log) -> Vec<f64> {
    let first = log.slip_m.iter().find(|slip| **slip != 0.0).map_or(1.0, |slip| slip.signum());
    let mut last = first;
    let of = |slip: &f64| {
        if *slip != 0.0 {
            last = slip.signum();
        }
        last
    };
    log.slip_m.iter().map(of).collect()
}
