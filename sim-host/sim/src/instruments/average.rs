//! Friction and power averaged over ON and OFF: the benefit of a drive, and its cost.

use firmware::seam::mode::Mode;

use super::{Instrument, Line, View};
use crate::metrics::Metrics;
use crate::record::Row;
use report::statistics::mean;

/// Instrument of periodic bursts, and of a sliding contact under a continuous drive. Bursts at
/// given times have no period to average over, and a belt that stops has no mean friction.
pub(super) struct Average;

impl Instrument for Average {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        let slides = run.scene.sliding().is_some_and(|(_, slider)| slider.speed_m_per_s != 0.0);
        let moves = slides && run.scene.belt_stops_s().is_none();
        let Some(rows) = whole_periods(run).filter(|_| moves || run.scene.controller.burst.is_some()) else { return };
        let power_w = mean(rows.iter().map(|row| row.truth.power_w));
        metrics.put("mean_power_w", power_w);
        if !moves {
            return;
        }
        let friction_n = mean(rows.iter().map(|row| row.truth.friction_mean_n));
        let silent_n = run.silent_friction_n();
        let saved_n = silent_n.zip(friction_n).map(|(silent, friction)| (silent - friction) * silent.signum());
        metrics.put("mean_friction_n", friction_n);
        metrics.put("mean_reduction_percent", saved_n.zip(silent_n).map(|(saved, silent)| 100.0 * saved / silent.abs()));
        let per_watt = saved_n.zip(power_w).filter(|&(_, power)| power > 0.0).map(|(saved, power)| saved / power);
        metrics.put("friction_saved_n_per_w", per_watt);
    }

    fn headline(&self) -> &'static [Line] {
        &[("mean friction reduction", "mean_reduction_percent", "%"), ("mean power", "mean_power_w", "W")]
    }
}

/// Returns the blocks of whole burst periods from the last change to the end or to a fault, or all
/// steady blocks of a continuous drive; `None` if there are none.
pub(super) fn whole_periods<'a>(run: &View<'a>) -> Option<Vec<&'a Row>> {
    let rows: Vec<&Row> = if let Some(held) = run.held() {
        held.iter().take_while(|row| row.mode == Mode::Run).collect()
    } else if let Some(burst) = &run.scene.controller.burst {
        burst.period_s?;
        let from_s = run.steps_s.iter().copied().fold(run.plays_from(Mode::Run)?, f64::max);
        let fault = run.rows.iter().find(|row| row.mode == Mode::Fault);
        run.whole_bursts(from_s, fault.map_or(f64::INFINITY, |row| row.time_s)).iter().collect()
    } else {
        run.steady().collect()
    };
    (!rows.is_empty()).then_some(rows)
}
