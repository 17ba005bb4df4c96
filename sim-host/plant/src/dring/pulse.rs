//! The crash pulse: a half sine of deceleration, or a measured one.
//!
//! ```text
//! a(t) = a0 sin(pi (t - t0) / T)  for t0 <= t <= t0 + T, else 0;    change of speed: 2 a0 T / pi
//! ```
//!
//! 20 g over 110 ms change the speed by 13.7 m/s, 49 km/h. A measured pulse is linear between
//! samples.

use std::f64::consts::PI;

use scene::Profile;

/// Pulse of the vehicle's deceleration.
#[derive(Clone, Debug, PartialEq)]
pub struct Pulse {
    /// Beginning of the pulse, s.
    pub at_s: f64,
    /// Length of the pulse, s.
    pub length_s: f64,
    /// Time series of the pulse.
    pub course: Course,
}

/// Time series of a pulse.
#[derive(Clone, Debug, PartialEq)]
pub enum Course {
    /// A half sine of this peak, m/s^2.
    HalfSine(f64),
    /// A measured deceleration, m/s^2.
    Measured(Profile),
}

impl Pulse {
    /// Creates a half sine of this peak, m/s^2, that begins at `at_s` and is `length_s` long.
    pub fn half_sine(at_s: f64, peak_m_per_s2: f64, length_s: f64) -> Self {
        Pulse { at_s, length_s, course: Course::HalfSine(peak_m_per_s2) }
    }

    /// Returns the deceleration of the vehicle, m/s^2. `within` selects the side of an end, as a
    /// step of integration lies on one side.
    pub fn at(&self, time_s: f64, within: bool) -> f64 {
        match &self.course {
            _ if !within => 0.0,
            Course::HalfSine(peak_m_per_s2) => peak_m_per_s2 * libm::sin(PI * (time_s - self.at_s) / self.length_s),
            Course::Measured(profile) => profile.at(time_s - self.at_s),
        }
    }

    /// Returns `true` if a moment lies strictly inside the pulse.
    pub fn contains(&self, time_s: f64) -> bool {
        time_s > self.at_s && time_s < self.end_s()
    }

    /// Returns the end of the pulse, s.
    pub fn end_s(&self) -> f64 {
        self.at_s + self.length_s
    }

    /// Returns the first moment after `time_s` at which the slope jumps, s: a beginning, an end, or
    /// a sample.
    pub fn next_corner_s(&self, time_s: f64) -> f64 {
        let corner = match &self.course {
            Course::Measured(profile) if self.contains(time_s) => {
                profile.next_sample(time_s - self.at_s).map(|since_s| self.at_s + since_s)
            }
            _ => None,
        };
        let ends = [self.at_s, self.end_s()].into_iter().chain(corner).filter(|end| *end > time_s);
        ends.fold(f64::INFINITY, f64::min)
    }
}
