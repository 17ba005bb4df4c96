//! Metrics of a belt under a horn. Its pull reaches the reduced value after more than a second, not
//! within the ring-up of the vibration.

use firmware::seam::mode::Mode;

use crate::instruments::View;
use crate::metrics::Metrics;
use crate::record::Row;
use crate::schedule::first_on;
use report::statistics::mean;

/// Duration of the average at the end of each state, s.
const AVERAGE_S: f64 = 0.002;

impl View<'_> {
    /// Returns the first ON window commanded in `Run`, as played, s.
    pub fn belt_window(&self) -> Option<(f64, f64)> {
        let (ordered_s, _) = first_on(&self.scene, self.plays_from(Mode::Run)?)?;
        self.on_windows().into_iter().find(|(_, to_s)| *to_s > ordered_s)
    }

    /// Adds the metrics of the belt, if the scene has a belt that moves.
    pub(super) fn belt(&self, metrics: &mut Metrics) {
        if !self.scene.belt().is_some_and(|(_, belt)| belt.speed_m_per_s != 0.0) {
            return;
        }
        let Some((from_s, to_s)) = self.belt_window() else { return };
        let until = |end_s: f64, on: bool| {
            let within = move |row: &&Row| {
                row.mode == Mode::Run
                    && (row.envelope > 0.0) == on
                    && (end_s - AVERAGE_S..end_s).contains(&(row.time_s - self.block_s))
            };
            self.rows.iter().filter(within)
        };
        let (before, last) = (|| until(from_s, false), || until(to_s, true));
        let ends = |of: fn(&Row) -> f64| (mean(before().map(of)), mean(last().map(of)));
        let ratio = |(off, on): (Option<f64>, Option<f64>)| off.zip(on).map(|(off, on)| on / off);
        let percent = |ratio: f64| 100.0 * (1.0 - ratio);
        let (pull, cell) = (ends(|row| row.truth.friction_mean_n), ends(|row| row.truth.load_cell_n));
        metrics.put("friction_off_n", pull.0);
        metrics.put("friction_on_n", pull.1);
        metrics.put("friction_ratio", ratio(pull));
        metrics.put("reduction_percent", ratio(pull).map(percent));
        metrics.put("load_cell_off_n", cell.0);
        metrics.put("load_cell_on_n", cell.1);
        metrics.put("load_cell_reduction_percent", ratio(cell).map(percent));
        let horn = |row: &Row| row.truth.horn.unwrap_or_default();
        metrics.put("amplitude_fraction", mean(last().map(|row| horn(row).amplitude_fraction)));
        metrics.put("lasting_reduction_percent", mean(last().map(|row| 100.0 * horn(row).lasting_reduction)));
        metrics.put("on_time_s", to_s - from_s);
    }
}
