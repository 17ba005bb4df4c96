//! Metrics of the friction switch: set point, estimate and truth.

use firmware::seam::fault::Limit;
use firmware::seam::mode::Mode;

use super::set_point::at_place;
use crate::instruments::View;
use crate::metrics::Metrics;
use crate::record::Row;
use plant::circuit_of;
use report::statistics::mean;
use scene::{Disturbance, DisturbedKey, Driven, Friction};

/// Time after a new set point until it counts as held, s; amplitude and smoothed force have then
/// settled.
const HOLD_S: f64 = 0.05;
/// Relative change of the friction from one block to the next below which a contact slides
/// steadily.
const STEADY_REL: f64 = 1e-3;

/// Set point of the friction ratio, with its estimate and truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Set point of the ratio; with detents, its mean over them.
    pub set_point: f64,
    /// Ratio estimated by the controller.
    pub estimate: Option<f64>,
    /// Ratio measured by the force channel.
    pub sensed: Option<f64>,
    /// True ratio of the simulated contact.
    pub truth: f64,
    /// Limit that the controller reported, or zero.
    pub limit: u8,
    /// `true` if the ratio was reached by bursts.
    pub bursts: bool,
}

impl Step {
    /// Returns `true` if the controller has reported that the set point cannot be reached.
    pub fn is_refused(&self) -> bool {
        [Limit::NoAuthority, Limit::RatioUnreachable].iter().any(|&limit| limit as u8 == self.limit)
    }

    /// Returns the true ratio minus the set point.
    pub fn error(&self) -> f64 {
        self.truth - self.set_point
    }
}

impl<'a> View<'a> {
    /// Returns the friction without vibration, N: of settled OFF blocks, or of the last block
    /// before the first drive if the contact already slid steadily and nothing changes it. A
    /// carriage may be at rest; then it is the sliding friction.
    pub fn silent_friction_n(&self) -> Option<f64> {
        if let Some((contact, carriage)) = self.scene.carriage() {
            return Some(contact.mu * carriage.normal_n);
        }
        mean(self.settled(0.0, self.settle_s).map(|row| row.truth.friction_mean_n)).or_else(|| {
            let is_changed = |it: &Disturbance| matches!(it.key, DisturbedKey::Load | DisturbedKey::Speed);
            if self.scene.disturbance.iter().any(is_changed) {
                return None;
            }
            let before = &self.rows[..self.rows.iter().position(|row| row.envelope != 0.0)?];
            let [.., earlier, last] = before else { return None };
            let (earlier, last) = (earlier.truth.friction_mean_n, last.truth.friction_mean_n);
            ((last - earlier).abs() <= STEADY_REL * last.abs()).then_some(last)
        })
    }

    /// Returns the time from which the last set point is held, s.
    pub(in crate::instruments) fn held_from_s(&self) -> f64 {
        let Some(friction) = &self.scene.controller.friction else { return f64::NEG_INFINITY };
        self.surveyed_s().unwrap_or(f64::INFINITY).max(friction.step_s.last().copied().unwrap_or(0.0))
    }

    /// Returns the end of the survey, s.
    fn surveyed_s(&self) -> Option<f64> {
        self.rows.iter().find(|row| row.friction.is_some()).map(|row| row.time_s)
    }

    /// Returns the rows over which the last set point is held; `None` if the friction is not
    /// switched.
    pub(in crate::instruments) fn held(&self) -> Option<&'a [Row]> {
        self.scene.controller.friction.as_ref()?;
        Some(self.whole_bursts(self.held_from_s(), f64::INFINITY))
    }

    /// Returns the rows in whole burst periods, from [`HOLD_S`] after one time to another time.
    pub(in crate::instruments) fn whole_bursts(&self, from_s: f64, to_s: f64) -> &'a [Row] {
        let rows = self.after(from_s + HOLD_S);
        let rows = &rows[..rows.partition_point(|row| row.time_s < to_s)];
        let period_s = self.scene.controller.burst.as_ref().and_then(|burst| burst.period_s);
        let blocks = period_s.map_or(rows.len(), |period_s| {
            let periods = (rows.len() as f64 * self.block_s / period_s).floor();
            (periods * period_s / self.block_s).round() as usize
        });
        &rows[rows.len() - blocks.min(rows.len())..]
    }

    /// Returns all set points of the ratio with their results.
    pub fn steps(&self) -> Vec<Step> {
        let Some(friction) = &self.scene.controller.friction else { return Vec::new() };
        let (Some(surveyed_s), Some(coulomb_n)) = (self.surveyed_s(), self.silent_friction_n()) else { return Vec::new() };
        let first = configured(friction, coulomb_n).map(|ratio| (surveyed_s, ratio));
        let ordered = friction.step_s.iter().copied().zip(friction.step_ratio.iter().copied());
        let all: Vec<_> = first.into_iter().chain(ordered).collect();
        let ends = all.iter().skip(1).map(|step| step.0).chain([f64::INFINITY]);
        let step = |(&(from_s, ordered), to_s): (&(f64, f64), f64)| {
            let rows = self.whole_bursts(from_s.max(surveyed_s), to_s);
            let over_detents = || mean(rows.iter().map(|row| at_place(friction, ordered, row)));
            let set_point = if friction.detent_pitch_m == 0.0 { ordered } else { over_detents()? };
            let estimates = || rows.iter().filter_map(|row| row.friction);
            Some(Step {
                set_point,
                estimate: mean(estimates().map(|estimate| estimate.ratio.into())),
                sensed: mean(estimates().filter_map(|estimate| estimate.force_ratio).map(f64::from)),
                truth: mean(rows.iter().map(|row| row.truth.friction_mean_n))? / coulomb_n,
                limit: rows.last()?.limit,
                bursts: mean(rows.iter().map(|row| f64::from(u8::from(row.envelope == 0.0))))
                    .is_some_and(|off| off > 0.0 && off < 1.0),
            })
        };
        all.iter().zip(ends).filter_map(step).collect()
    }

    pub(super) fn switch(&self, metrics: &mut Metrics) {
        let Some(held) = self.held() else { return };
        let steps = self.steps();
        let last = steps.last();
        metrics.put("friction_ratio_wanted", last.map(|step| step.set_point));
        metrics.put("friction_ratio_estimate", last.and_then(|step| step.estimate));
        metrics.put("friction_ratio_sensed", last.and_then(|step| step.sensed));
        let errors = steps.iter().filter(|step| !step.is_refused()).map(Step::error);
        metrics.put("friction_ratio_error", errors.max_by(|one, other| one.abs().total_cmp(&other.abs())));
        metrics.put("ratios_refused", steps.iter().filter(|step| step.is_refused()).count() as f64);
        metrics.put(
            "friction_floor_estimate",
            mean(held.iter().filter_map(|row| row.friction).map(|estimate| estimate.floor.into())),
        );
        let last = held.last().and_then(|row| row.friction);
        metrics.put("kappa_estimate", last.map(|estimate| f64::from(estimate.kappa)));
        metrics.put("kappa_deviation", last.map(|estimate| f64::from(estimate.kappa_deviation)));
        metrics.put("kappa", largest_kappa(&self.scene));
        let began_s = self.rows.iter().find(|row| row.mode == Mode::Run).map(|row| row.time_s);
        metrics.put("survey_time_ms", began_s.zip(self.surveyed_s()).map(|(began, ended)| 1e3 * (ended - began)));
    }
}

/// Returns the configured set point of the ratio, which applies until another is commanded; a force
/// is divided by the friction without vibration, N.
pub fn configured(friction: &Friction, coulomb_n: f64) -> Option<f64> {
    friction.target_ratio.or(friction.target_force_n.map(|newtons| newtons / coulomb_n))
}

/// Returns `Kt Vv / (w Fc)` at the maximum amplitude of the switch.
fn largest_kappa(scene: &Driven) -> Option<f64> {
    let (contact, slider) = scene.sliding()?;
    let coulomb_n = contact.mu * (slider.load_n + slider.self_weight_n);
    let tip_m_per_s = scene.controller.drive.velocity_m_per_s?;
    Some(contact.stiffness_n_per_m * tip_m_per_s / (circuit_of(scene).omega() * coulomb_n))
}
