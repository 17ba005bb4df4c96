//! Where torso, webbing and spool are, what pulls on them, and how far the actuator is.

/// Which way webbing slides over the D-ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Webbing slides towards the torso.
    Out,
    /// Webbing slides towards the spool.
    Back,
}

impl Way {
    /// Sign of the payout's speed.
    pub fn sign(self) -> f64 {
        if self == Way::Out { 1.0 } else { -1.0 }
    }
}

/// How far the actuator's amplitude has risen: `at + rate (t - from)`.
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
    /// Amplitude at a moment.
    pub fn amplitude(&self, time_s: f64) -> f64 {
        (self.at + self.rate_per_s * (time_s - self.from_s)).clamp(0.0, 1.0)
    }

    /// When it is all or nothing, s; a ramp that does not move never is.
    pub fn end_s(&self) -> f64 {
        match self.rate_per_s {
            rate if rate > 0.0 => self.from_s + (1.0 - self.at) / rate,
            rate if rate < 0.0 => self.from_s - self.at / rate,
            _ => f64::INFINITY,
        }
    }
}

/// Where everything is, and what work has been done since the beginning. Lengths in m, counted from rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Position of the torso, m.
    pub x_m: f64,
    /// Speed of the torso, m/s.
    pub v_m_per_s: f64,
    /// Webbing that has come over the D-ring.
    pub payout_m: f64,
    /// Webbing that the spool has let go.
    pub spool_m: f64,
    /// Work of the pulse on the torso, J.
    pub input_j: f64,
    /// Heat at the D-ring, J.
    pub friction_j: f64,
    /// Work on the spool, J.
    pub spool_j: f64,
}

impl State {
    /// The state after `step_s` seconds at these rates.
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

/// Tensions before and behind the D-ring, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tensions {
    /// Tension at the shoulder, N.
    pub shoulder_n: f64,
    /// Tension at the spool, N.
    pub retractor_n: f64,
}

impl Tensions {
    /// The one that pulls this way, and the other.
    pub fn along(self, way: Way) -> (f64, f64) {
        if way == Way::Out { (self.shoulder_n, self.retractor_n) } else { (self.retractor_n, self.shoulder_n) }
    }
}
