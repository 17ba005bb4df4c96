//! Metrics of a carriage: pulled by a spring, and released under a constant force.

use super::stretch::{DriveSection, sections};
use crate::instruments::View;
use crate::metrics::Metrics;
use crate::record::Row;

/// Speed at which a carriage counts as released, relative to its final speed.
const RELEASED_REL: f64 = 0.5;
/// Speed at which a carriage counts as stopped, relative to its final speed.
const STOPPED_REL: f64 = 0.01;

/// Adds the metrics of a carriage that is pulled by a spring: the worst of all sections with the
/// drive ON, and of all with it OFF.
pub(super) fn pulled(run: &View, metrics: &mut Metrics) {
    if !run.scene.carriage().is_some_and(|(_, carriage)| carriage.pull_m_per_s != 0.0) {
        return;
    }
    let stretches = sections(run);
    let worst = |on: bool, of: &dyn Fn(&DriveSection) -> Option<f64>| {
        stretches.iter().filter(|stretch| stretch.on == on).filter_map(of).reduce(f64::max)
    };
    metrics.put("breakaway_off_n", worst(false, &|stretch| stretch.largest_pull_n()));
    metrics.put("breakaway_on_n", worst(true, &|stretch| stretch.largest_pull_n()));
    metrics.put("slip_jump_off_m", worst(false, &|stretch| Some(stretch.jump_m())));
    metrics.put("slip_jump_on_m", worst(true, &|stretch| Some(stretch.jump_m())));
    metrics.put("speed_ripple_off", worst(false, &|stretch| stretch.ripple()));
    metrics.put("speed_ripple_on", worst(true, &|stretch| stretch.ripple()));
    metrics.put("stick_slip_hz", worst(false, &slips_hz));
    let wound = stretches.iter().filter(|stretch| stretch.on && stretch.wound);
    metrics.put("release_overshoot_m", wound.map(DriveSection::lead_m).reduce(f64::max));
}

/// Returns the slips per second; `None` for fewer than two.
fn slips_hz(stretch: &DriveSection) -> Option<f64> {
    let slips = stretch.slips_s();
    let (first, last) = (slips.first()?, slips.last()?);
    (slips.len() > 1).then(|| (slips.len() - 1) as f64 / (last - first))
}

/// Adds the metrics of a carriage under a constant force, in the last ON window.
pub(super) fn released(run: &View, metrics: &mut Metrics) {
    let Some((contact, carriage)) = run.scene.carriage() else { return };
    if carriage.force_n == 0.0 {
        return;
    }
    metrics.put("holding_margin", contact.mu * carriage.normal_n / carriage.force_n.abs());
    let stretches = sections(run);
    let Some(on) = stretches.iter().rposition(|stretch| stretch.on) else { return };
    let (release, after) = (&stretches[on], stretches.get(on + 1));
    metrics.put("creep_m", release.rows.first().map(|row| row.truth.belt_position_m.abs()));
    let speed = |row: &Row| row.truth.belt_speed_m_per_s.abs();
    let Some(last) = release.rows.last() else { return };
    let goes = release.rows.iter().find(|row| speed(row) >= RELEASED_REL * speed(last)).filter(|_| speed(last) > 0.0);
    metrics.put("release_time_ms", goes.map(|row| 1e3 * (row.time_s - release.begins_s())));
    metrics.put("release_speed_m_per_s", speed(last));
    metrics.put("release_way_m", displacement_m(release.rows).abs());
    metrics.put("release_energy_j", energy_j(run, release, |row| Some(row.truth.power_w)));
    metrics.put("release_energy_estimate_j", energy_j(run, release, sensed_w));
    let Some(after) = after else { return };
    let stands = after.rows.iter().find(|row| speed(row) <= STOPPED_REL * speed(last));
    metrics.put("hold_time_ms", stands.map(|row| 1e3 * (row.time_s - after.begins_s())));
    metrics.put("hold_way_m", displacement_m(after.rows).abs());
}

/// Returns the displacement from the first of these blocks to the last, m.
fn displacement_m(rows: &[Row]) -> f64 {
    let place = |row: Option<&Row>| row.map_or(0.0, |row| row.truth.belt_position_m);
    place(rows.last()) - place(rows.first())
}

/// Returns the power into the motional branch from the controller's measurements, W:
/// `|Im|^2 / (2 G)`. Holds at the resonance, where the measured conductance is the motional one.
pub(super) fn sensed_w(row: &Row) -> Option<f64> {
    let (conductance, _) = row.admittance_s?;
    (conductance > 0.0).then(|| 0.5 * row.motional_current_a.powi(2) / conductance)
}

/// Returns the energy of a section, J; a block without a value counts as one without power.
fn energy_j(run: &View, stretch: &DriveSection, power_w: impl Fn(&Row) -> Option<f64>) -> f64 {
    stretch.rows.iter().filter_map(power_w).sum::<f64>() * run.block_s
}
