//! The load cell and its conditioner: a second-order Butterworth low-pass, advanced by its exact
//! flow. The thesis records a bandwidth of 80 Hz: the mean is preserved, the edges of a burst are
//! not.

use contact::flow::{Matrix, exponential};

/// Load cell that measures friction.
#[derive(Clone, Debug)]
pub struct LoadCell {
    flow: Matrix<3>,
    reading: f64,
    slope: f64,
}

impl LoadCell {
    /// Creates a cell of this bandwidth that is read every `step_s` seconds, at rest.
    pub fn new(bandwidth_hz: f64, step_s: f64) -> Self {
        let corner = std::f64::consts::TAU * bandwidth_hz * step_s;
        let flow = exponential(&[[0.0, corner, 0.0], [-corner, -corner * std::f64::consts::SQRT_2, corner], [0.0; 3]]);
        LoadCell { flow, reading: 0.0, slope: 0.0 }
    }

    /// Applies a mean force over one step. Returns the reading at its end, N.
    pub fn measure(&mut self, force: f64) -> f64 {
        let [reading, slope, _] = self.flow.map(|row| row[0] * self.reading + row[1] * self.slope + row[2] * force);
        (self.reading, self.slope) = (reading, slope);
        reading
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settles_on_the_mean_and_lags_the_edge() {
        let mut cell = LoadCell::new(80.0, 32e-6);
        let readings: Vec<f64> = (0..3000).map(|_| cell.measure(2.0)).collect();
        let rise = readings.iter().position(|&r| r > 1.8).map(|n| n as f64 * 32e-3);
        // Second-order Butterworth: 90 % after 2.8 / (2 pi 80 Hz) = 5.6 ms.
        assert!(rise.is_some_and(|ms| (5.0..6.5).contains(&ms)), "{rise:?}");
        assert!((readings[2999] - 2.0).abs() < 1e-6);
    }
}
