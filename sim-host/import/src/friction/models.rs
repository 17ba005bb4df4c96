//! Contact models as functions of a measured motion.
//!
//! ```text
//! Coulomb    F = Fc sgn V
//! Stribeck   F = sgn V (Fc + (Fs - Fc) exp(-(V / Vs)^2)) + s2 V
//! Dahl       dF/dz = Kt (1 - F sgn V / Fc)
//! LuGre      z' = V - |V| z / G(V),  F = Kt z + s2 V,  Kt G(V) = Fc + (Fs - Fc) exp(-(V / Vs)^2)
//! ```
//!
//! `Fc` and `Fs` are proportional to the normal force of each sample. Within a step of the slip
//! `d`, the limit `g = Kt G` of the spring force goes linearly from `g0` to `g1`:
//!
//! ```text
//! w1 = g1 + (w0 - g0) E - (g1 - g0) (1 - E) / a,   E = exp(-a),   a = 2 Kt |d| / (g0 + g1)
//! ```
//!
//! `w` is the spring force in the direction of the slip. For Dahl's model and a constant normal
//! force this is exact for any step. An offset and a linear drift of the force are added to each
//! model. The damping of LuGre's bristles is not a parameter: it only matters during acceleration
//! within the presliding, which hardly any log resolves. Sources: P. Dahl, AIAA J. 14 (1976) 1675;
//! C. Canudas de Wit et al., IEEE Trans. Autom. Control 40 (1995) 419.

use super::motion::{Motion, drift};

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

/// Parameters of all models, then those of the baseline of the force. The logarithm of the viscous
/// coefficient is not fitted: if a log has nearly no viscous friction, the logarithm would drift
/// towards minus infinity, where it has no effect and does not return.
const PARAMETERS: [Parameter; 8] = [
    ("coulomb_n", true),
    ("static_excess_n", true),
    ("stribeck_m_per_s", true),
    ("sigma2", false),
    ("stiffness_n_per_m", true),
    ("initial_force_n", false),
    ("offset_n", false),
    ("drift_n", false),
];
const FC: usize = 0;
const EXCESS: usize = 1;
const STRIBECK: usize = 2;
const VISCOUS: usize = 3;
const STIFFNESS: usize = 4;
const START: usize = 5;
const OFFSET: usize = 6;
const DRIFT: usize = 7;

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

    /// Returns `true` if the friction falls with the velocity.
    pub(super) fn falls(self) -> bool {
        matches!(self, Model::Stribeck | Model::Lugre)
    }

    /// Returns `true` if a spring carries the friction.
    pub(super) fn has_spring(self) -> bool {
        matches!(self, Model::Dahl | Model::Lugre)
    }

    /// Returns the places of the parameters in the list of all.
    fn places(self, baseline: usize) -> Vec<usize> {
        let own: &[usize] = match self {
            Model::Coulomb => &[FC],
            Model::Stribeck => &[FC, EXCESS, STRIBECK, VISCOUS],
            Model::Dahl => &[FC, STIFFNESS, START],
            Model::Lugre => &[FC, EXCESS, STRIBECK, VISCOUS, STIFFNESS, START],
            Model::Maxwell => &[],
        };
        own.iter().copied().chain(OFFSET..OFFSET + baseline).collect()
    }

    /// Returns the parameters, with this number of parameters of the baseline.
    pub(crate) fn parameters(self, baseline: usize) -> Vec<Parameter> {
        self.places(baseline).into_iter().map(|place| PARAMETERS[place]).collect()
    }

    /// Computes the force at every sample, N, and its derivatives by the parameters if `SLOPES`.
    pub(super) fn response<const SLOPES: bool>(self, fitted: &[f64], motion: &Motion) -> (Vec<f64>, Vec<Vec<f64>>) {
        let places = self.places(motion.baseline);
        let mut p = [0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        for (place, value) in places.iter().zip(fitted) {
            p[*place] = if PARAMETERS[*place].1 { libm::exp(*value) } else { *value };
        }
        let (falls, has_spring, count) = (self.falls(), self.has_spring(), motion.count);
        // Limit of the spring force with its derivatives.
        let limit = |v: f64, normal: f64| {
            let square = if falls { (v / p[STRIBECK]) * (v / p[STRIBECK]) } else { 0.0 };
            let (coulomb, excess) = (normal * p[FC], if falls { normal * p[EXCESS] * libm::exp(-square) } else { 0.0 });
            (coulomb + excess, [coulomb, excess, 2.0 * square * excess])
        };
        let mut force = Vec::with_capacity(count);
        let mut columns = vec![Vec::with_capacity(if SLOPES { count } else { 0 }); if SLOPES { places.len() } else { 0 }];
        let mut by = [0.0; OFFSET];
        by[START] = 1.0;
        let first = &motion.steps[0];
        let (mut g0, mut dg0) = limit(first.velocity_m_per_s, first.normal_rel);
        let mut sign = motion.steps.iter().find(|step| step.slip_m != 0.0).map_or(1.0, |step| step.slip_m.signum());
        let mut spring = p[START];
        for step in &motion.steps {
            let (g1, dg1) = limit(step.velocity_m_per_s, step.normal_rel);
            if step.slip_m != 0.0 {
                sign = step.slip_m.signum();
            }
            if !has_spring {
                spring = sign * g1;
                (0..VISCOUS).for_each(|at| by[at] = sign * dg1[at]);
            } else if step.slip_m != 0.0 {
                let a = 2.0 * p[STIFFNESS] * step.slip_m.abs() / (g0 + g1);
                let e = libm::exp(-a);
                // (1 - E) / a and its derivative, by their series if the slip is small.
                let part = if a > 1e-3 { (1.0 - e) / a } else { 1.0 - a * (0.5 - a / 6.0) };
                let by_a = if a > 1e-3 { (e - part) / a } else { a / 3.0 - 0.5 };
                let w = sign * spring;
                spring = sign * (g1 + (w - g0) * e - (g1 - g0) * part);
                if SLOPES {
                    let rate = sign * a * (-(w - g0) * e - (g1 - g0) * by_a);
                    by.iter_mut().for_each(|by| *by *= e);
                    for at in 0..VISCOUS {
                        let of_limit = (1.0 - part) * dg1[at] + (part - e) * dg0[at];
                        by[at] += sign * of_limit - rate * (dg0[at] + dg1[at]) / (g0 + g1);
                    }
                    by[STIFFNESS] += rate;
                }
            }
            (g0, dg0) = (g1, dg1);
            if step.is_sample {
                let (at, v) = (force.len(), step.velocity_m_per_s);
                let drift = drift(at, count);
                force.push(spring + p[VISCOUS] * v + p[OFFSET] + p[DRIFT] * drift);
                if SLOPES {
                    for (column, place) in columns.iter_mut().zip(&places) {
                        column.push(match *place {
                            VISCOUS => v,
                            OFFSET => 1.0,
                            DRIFT => drift,
                            place => by[place],
                        });
                    }
                }
            }
        }
        (force, columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::Log;

    #[test]
    fn slopes_are_the_differences_of_forces() {
        let at = |n: usize| libm::sin(n as f64 * 0.3) * (1.0 + n as f64 * 0.01);
        let log = Log {
            slip_m: (0..80).map(|n: usize| at(n) - at(n.max(1) - 1)).collect(),
            velocity_m_per_s: (0..80).map(|n| 0.5 * (at(n + 1) - at(n.max(1) - 1))).collect(),
            time_s: (0..80).map(f64::from).collect(),
            normal_n: 2.0,
            normals_n: (0..80).map(|n| 2.0 + 0.5 * at(n + 9)).collect(),
            on: vec![false; 80],
            ..Log::default()
        };
        for model in Model::SEARCHED {
            let (places, values) = (model.places(2), [0.2, -0.5, -2.0, 0.3, 2.5, 0.4, 0.1, 0.2]);
            let fitted: Vec<f64> = places.iter().map(|place| values[*place]).collect();
            let motion = Motion::new(&log, if model.falls() { 0.02 } else { f64::INFINITY }, 2);
            let (_, slopes) = model.response::<true>(&fitted, &motion);
            for (at, slope) in slopes.iter().enumerate() {
                let moved = |by: f64| {
                    let mut moved = fitted.clone();
                    moved[at] += by;
                    model.response::<false>(&moved, &motion).0
                };
                let differences: Vec<f64> = moved(1e-5).iter().zip(moved(-1e-5)).map(|(up, down)| (up - down) / 2e-5).collect();
                let is_same = |(slope, difference): (&f64, &f64)| (slope - difference).abs() < 1e-7 * (1.0 + difference.abs());
                assert!(slope.iter().zip(&differences).all(is_same), "{model:?} {at}: {slope:?} {differences:?}");
            }
        }
    }
}
