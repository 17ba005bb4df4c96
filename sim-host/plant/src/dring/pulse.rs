//! The crash pulse: half a sine of deceleration.
//!
//! ```text
//! a(t) = a0 sin(pi (t - t0) / T)  for t0 <= t <= t0 + T, else 0;    change of speed: 2 a0 T / pi
//! ```
//!
//! 20 g over 110 ms take 13.7 m/s, 49 km/h.

use std::f64::consts::PI;

/// Half-sine pulse of the vehicle's deceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// When it begins, s.
    pub at_s: f64,
    /// Peak deceleration of the pulse, m/s^2.
    pub peak_m_per_s2: f64,
    /// Length of the pulse, s.
    pub length_s: f64,
}

impl Pulse {
    /// Deceleration of the vehicle, m/s^2. `within` says on which side of an end: a step of integration lies on one.
    pub fn at(&self, time_s: f64, within: bool) -> f64 {
        if within { self.peak_m_per_s2 * libm::sin(PI * (time_s - self.at_s) / self.length_s) } else { 0.0 }
    }

    /// Whether a moment that is no end lies within the pulse.
    pub fn contains(&self, time_s: f64) -> bool {
        time_s > self.at_s && time_s < self.end_s()
    }

    /// When it ends, s.
    pub fn end_s(&self) -> f64 {
        self.at_s + self.length_s
    }
}
