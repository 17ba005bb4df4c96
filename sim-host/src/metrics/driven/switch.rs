//! Numbers of the friction switch: command, estimate and truth, over whole burst periods from 50 ms after the survey, or after the last step of
//! what is wanted.
//!
//! | metric | meaning |
//! |---|---|
//! | `friction_ratio_wanted` | command: what is wanted last |
//! | `friction_ratio_estimate` | what the controller believes, by its law and the tip velocity that it measures |
//! | `friction_ratio_sensed` | what its force channel says, over what that said in silence |
//! | `friction_ratio_error` | the true `friction_ratio` less what is wanted |
//! | `friction_floor_estimate` | the least ratio, as the controller believes |
//! | `kappa`, `kappa_estimate` | vibration amplitude in Dahl lengths at the loudest drive: the contact's, and as surveyed |
//! | `kappa_deviation` | standard deviation that the controller states of it, relative |
//! | `survey_time_ms` | from the first sample of the run to the end of the survey |

use firmware::supervisor::Mode;

use super::{View, mean};
use crate::metrics::Metrics;
use crate::plant::circuit_of;
use crate::record::Row;
use crate::scene::{Driven, Friction};

/// What is held comes so long after what was wanted, s: the amplitude has settled, and so has the smoothed force.
const HOLD_S: f64 = 0.05;

impl<'a> View<'a> {
    /// When the last wanted ratio began to be held, s.
    pub(super) fn held_from_s(&self, scene: &Driven) -> f64 {
        let Some(friction) = &scene.controller.friction else { return f64::NEG_INFINITY };
        let surveyed_s = self.rows.iter().find(|row| row.friction.is_some()).map_or(f64::INFINITY, |row| row.time_s);
        surveyed_s.max(friction.step_s.last().copied().unwrap_or(0.0))
    }

    /// The rows over which the friction is held: whole burst periods. None where it is not switched.
    pub(super) fn held(&self, scene: &Driven) -> Option<&'a [Row]> {
        scene.controller.friction.as_ref()?;
        let rows = self.after(self.held_from_s + HOLD_S);
        let period_s = scene.controller.burst.as_ref().and_then(|burst| burst.period_s);
        let blocks = period_s.map_or(rows.len(), |period_s| {
            let periods = (rows.len() as f64 * self.block_s / period_s).floor();
            (periods * period_s / self.block_s).round() as usize
        });
        Some(&rows[rows.len() - blocks..])
    }

    /// Friction without vibration, N.
    pub fn silent_friction_n(&self) -> Option<f64> {
        mean(self.settled(0.0, self.settle_s).map(|row| row.truth.friction_mean_n))
    }

    pub(super) fn switch(&self, scene: &Driven, metrics: &mut Metrics) {
        let Some((friction, held)) = scene.controller.friction.as_ref().zip(self.held(scene)) else { return };
        let wanted = wanted(friction, metrics.get("friction_off_n"));
        metrics.put("friction_ratio_wanted", wanted);
        let believed = || held.iter().filter_map(|row| row.friction);
        metrics.put("friction_ratio_estimate", mean(believed().map(|belief| belief.ratio.into())));
        metrics.put("friction_ratio_sensed", mean(believed().filter_map(|belief| belief.force_ratio).map(f64::from)));
        metrics.put("friction_ratio_error", metrics.get("friction_ratio").zip(wanted).map(|(got, wanted)| got - wanted));
        metrics.put("friction_floor_estimate", mean(believed().map(|belief| belief.floor.into())));
        let last = held.last().and_then(|row| row.friction);
        metrics.put("kappa_estimate", last.map(|belief| f64::from(belief.kappa)));
        metrics.put("kappa_deviation", last.map(|belief| f64::from(belief.kappa_deviation)));
        metrics.put("kappa", loudest_kappa(scene));
        let began_s = self.rows.iter().find(|row| row.mode == Mode::Run).map(|row| row.time_s);
        let ended_s = self.rows.iter().find(|row| row.friction.is_some()).map(|row| row.time_s);
        metrics.put("survey_time_ms", began_s.zip(ended_s).map(|(began, ended)| 1e3 * (ended - began)));
    }
}

/// The ratio that is wanted last; that of a force needs the friction in silence, N.
fn wanted(friction: &Friction, off_n: Option<f64>) -> Option<f64> {
    let of_force = || Some(friction.target_force_n? / off_n?);
    friction.step_ratio.last().copied().or(friction.target_ratio).or_else(of_force)
}

/// `Kt Vv / (w Fc)` at the loudest drive of the switch.
fn loudest_kappa(scene: &Driven) -> Option<f64> {
    let (contact, slider) = scene.sliding()?;
    let coulomb_n = contact.mu * (slider.load_n + slider.self_weight_n);
    let loudest = scene.controller.drive.velocity_m_per_s?;
    Some(contact.stiffness_n_per_m * loudest / (circuit_of(scene).omega() * coulomb_n))
}
