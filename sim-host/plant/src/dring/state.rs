//! Positions of torso, webbing and spool, their tensions, and the amplitude of the actuator.

/// Direction in which webbing slides over the D-ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Webbing slides towards the torso.
    Out,
    /// Webbing slides towards the spool.
    Back,
}

impl Way {
    /// Returns the sign of the payout's speed.
    pub fn sign(self) -> f64 {
        if self == Way::Out { 1.0 } else { -1.0 }
    }
}

/// Ramp of the actuator's amplitude: `at + rate (t - from)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ramp {
    /// Amplitude at `from_s`, 0 to 1.
    pub at: f64,
    /// Rate of the amplitude, 1/s.
    pub rate_per_s: f64,
    /// Beginning of the ramp, s.
    pub from_s: f64,
}

impl Ramp {
    /// Returns the amplitude at a moment.
    pub fn amplitude(&self, time_s: f64) -> f64 {
        (self.at + self.rate_per_s * (time_s - self.from_s)).clamp(0.0, 1.0)
    }

    /// Returns the time at which the amplitude reaches 0 or 1, s; infinite for a constant
    /// amplitude.
    pub fn end_s(&self) -> f64 {
        match self.rate_per_s {
            rate if rate > 0.0 => self.from_s + (1.0 - self.at) / rate,
            rate if rate < 0.0 => self.from_s - self.at / rate,
            _ => f64::INFINITY,
        }
    }
}

/// Positions, and the work since the beginning. Lengths in m, relative to rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Position of the torso, m.
    pub x_m: f64,
    /// Speed of the torso, m/s.
    pub v_m_per_s: f64,
    /// Webbing that has moved over the D-ring, m.
    pub payout_m: f64,
    /// Webbing that the spool has released, m.
    pub spool_m: f64,
    /// Work of the pulse on the torso, J.
    pub input_j: f64,
    /// Heat at the D-ring, J.
    pub friction_j: f64,
    /// Work on the spool, J.
    pub spool_j: f64,
}

impl State {
    /// Returns the state after `step_s` seconds at these rates.
    pub fn after(&self, rates: &State, step_s: f64) -> State {
        State {
            x_m: self.x_m + step_s * rates.x_m,
            v_m_per_s: self.v_m_per_s + step_s * rates.v_m_per_s,
            payout_m: self.payout_m + step_s * rates.payout_m,
            spool_m: self.spool_m + step_s * rates.spool_m,
            input_j: self.input_j + step_s * rates.input_j,
            friction_j: self.friction_j + step_s * rates.friction_j,
            spool_j: self.spool_j + step_s * rates.spool_j,
        }
    }
}

/// Tensions on both sides of the D-ring, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tensions {
    /// Tension at the shoulder, N.
    pub shoulder_n: f64,
    /// Tension at the spool, N.
    pub retractor_n: f64,
}

impl Tensions {
    /// Returns the tension that pulls in this direction, and the opposing tension.
    pub fn along(self, way: Way) -> (f64, f64) {
        if way == Way::Out { (self.shoulder_n, self.retractor_n) } else { (self.retractor_n, self.shoulder_n) }
    }
}
