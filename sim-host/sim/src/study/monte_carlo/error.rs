//! Frequency error of each run over time, at the same times in all runs: dense at first, then in
//! equal ratios.

use firmware::seam::mode::Mode;

use crate::instruments::View;
use scene::Driven;

/// Ratio of successive times, if that is at least a block.
const RATIO: f64 = 1.04;

/// Times at which errors are recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Ends of blocks, s from the first sample of the lock stage.
    pub times_s: Vec<f64>,
}

impl Grid {
    /// Returns the times of a scene, from its first block to its duration.
    pub fn from_scene(scene: &Driven) -> Self {
        let block_s = f64::from(scene.controller.block_samples) / scene.sensors.sample_hz;
        let most = (scene.duration_s / block_s) as u64;
        let next = |&block: &u64| Some((block + 1).max((block as f64 * RATIO) as u64)).filter(|&block| block <= most);
        Grid { times_s: std::iter::successors(Some(1), next).map(|block| block as f64 * block_s).collect() }
    }

    /// Returns the distance of a run's drive from the true resonance at these times, Hz. It is
    /// infinite if the lock stage is never reached or a fault has muted the drive, and NaN without
    /// drive and after the end.
    pub fn errors_hz(&self, view: &View) -> Vec<f32> {
        let record = view.record;
        let Some(from_s) = view.plays_from(Mode::Lock) else { return vec![f32::INFINITY; self.times_s.len()] };
        let rows = view.after(from_s);
        let half_s = 0.5 * record.sample_s * record.block_samples as f64;
        let error = |&time_s: &f64| match rows.get(rows.partition_point(|row| row.time_s < from_s + time_s - half_s)) {
            None => f32::NAN,
            Some(row) if row.fault != 0 => f32::INFINITY,
            Some(row) if row.drive_v <= 0.0 => f32::NAN,
            Some(row) => (row.frequency_hz - row.truth.series_resonance_hz).abs() as f32,
        };
        self.times_s.iter().map(error).collect()
    }
}
