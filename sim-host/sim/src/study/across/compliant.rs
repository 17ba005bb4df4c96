//! A compliant contact under a given vibration normal to the surface.

use std::f64::consts::TAU;

use super::{Across, ratios, timed};
use contact::compliant::{self, CompliantProblem};
use contact::{Clock, Method, Numerics, Problem, Solution, SolveError, State};
use scene::{Compliant, Held};

/// Results of a compliant contact in addition to the normal direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compliance {
    /// Sliding speed above which the contact never sticks, m/s.
    pub critical_m_per_s: f64,
    /// Fraction of the window in which the contact sticks.
    pub stick_share: f64,
    /// Mean friction over mu times the mean normal force.
    pub coefficient_ratio: f64,
    /// Coefficient of friction.
    pub mu: f64,
    /// Normal stiffness, N/m.
    pub normal_n_per_m: f64,
    /// Mean position, m; positive for indentation.
    pub mean_place_m: f64,
}

impl Compliance {
    /// Returns the normal force at a displacement from the mean position, N.
    pub fn normal_n(&self, displacement_m: f64) -> f64 {
        self.normal_n_per_m * (self.mean_place_m + displacement_m).max(0.0)
    }
}

/// Solves the problem arc by arc; `watch` receives one steady period.
pub(in crate::study) fn solve<W: FnMut(&State)>(
    problem: &Problem,
    model: &Compliant,
    numerics: &Numerics,
    clock: Option<Clock>,
    watch: Option<&mut W>,
) -> Result<(Solution, Across), SolveError> {
    let hz = problem.waveform.frequency_hz();
    let normal_n = problem.coulomb_n / model.mu;
    let contact = CompliantProblem {
        mu: model.mu,
        press: model.press(normal_n),
        normal_n_per_m: model.normal_stiffness_n_per_m,
        tangential_n_per_m: model.stiffness_n_per_m,
        amplitude_m: problem.vibration_m_per_s() / (TAU * hz),
        frequency_hz: hz,
        sliding_m_per_s: problem.sliding_m_per_s,
    };
    let (found, ns) = timed(clock, || compliant::solve(&contact));
    let found = found?;
    if let Some(watch) = watch {
        for point in compliant::period(&contact)? {
            watch(&State {
                time_s: point.phase_turns / hz,
                x_m: point.indentation_m - found.mean_place_m,
                v_m_per_s: -problem.vibration_m_per_s() * (TAU * point.phase_turns).sin(),
                force_n: point.friction_n,
            });
        }
    }
    let from = problem.window_s.0 * hz;
    let early = if found.settle_periods.is_finite() {
        format!(
            "the window begins at period {from:.0}, before the steady state, but the result is steady: this is reached at period \
             {:.0}",
            found.settle_periods
        )
    } else {
        "without sliding, a spring that is relaxed at the start is never loaded: the result is the limit of slow \
         sliding"
            .to_owned()
    };
    let rounded = format!("the tolerance of {:e} is not met: round-off is {:.0e}", numerics.tolerance, found.error_estimate);
    let is_early = from + 1e-9 * from < found.settle_periods;
    let is_rounded = found.error_estimate > numerics.tolerance;
    let warnings = [is_early.then_some(early), is_rounded.then_some(rounded)].into_iter().flatten().collect();
    let held = match model.held {
        Held::Load => "load",
        Held::Indentation => "indentation",
    };
    let solution = Solution {
        method: Method::Closed,
        why: format!(
            "vibration normal to a compliant contact, quasi-static, mean {held} held: solved arc by arc, in contact for {:.1} % \
             of the period and sticking for {:.1} %",
            100.0 * found.contact_share,
            100.0 * found.stick_share
        ),
        steps_per_period: None,
        order: None,
        ratios: ratios(found.friction_ratio.unwrap_or(f64::NAN)),
        tally: None,
        error_estimate: Some(found.error_estimate),
        record_error_estimate: None,
        tolerance_met: !(is_early || is_rounded),
        warnings,
        states: 0,
        orbit: None,
        ns_per_period: ns.map(|ns| ns / (problem.duration_s * hz)),
    };
    let across = Across {
        contact_share: found.contact_share,
        mean_indentation_m: found.mean_normal_n / model.normal_stiffness_n_per_m,
        mean_normal_n: found.mean_normal_n,
        peak_normal_n: found.peak_normal_n,
        compliant: Some(Compliance {
            critical_m_per_s: found.critical_m_per_s,
            stick_share: found.stick_share,
            coefficient_ratio: found.coefficient_ratio,
            mu: model.mu,
            normal_n_per_m: model.normal_stiffness_n_per_m,
            mean_place_m: found.mean_place_m,
        }),
    };
    Ok((solution, across))
}
