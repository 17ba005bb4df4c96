//! The D-ring as a capstan: `T_high = T_low exp(mu theta)` while webbing slides (Euler 1769, Eytelwein 1808).
//!
//! With friction lowered to the ratio `r` of itself everywhere on the arc, `T_high = T_low exp(r mu theta)`. The force that presses the webbing on
//! the ring is `int T dphi = (T_high - T_low) / (r mu)`, and what friction would be there without an actuator is
//! `Fc = mu int T dphi = (T_high - T_low) / r`.

/// D-ring with the friction of webbing that wraps around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capstan {
    /// Angle of wrap, rad.
    pub wrap_rad: f64,
    /// Coefficient of friction without an actuator.
    pub mu_high: f64,
    /// Coefficient of friction below which no actuator brings it.
    pub mu_low: f64,
}

impl Capstan {
    /// How much larger the higher tension is than the lower at a ratio of friction.
    pub fn gain(&self, ratio: f64) -> f64 {
        libm::exp(ratio * self.mu_high * self.wrap_rad)
    }

    /// The ratio of friction that two tensions need, whose higher one comes first.
    pub fn ratio(&self, high_n: f64, low_n: f64) -> f64 {
        libm::log(high_n / low_n) / (self.mu_high * self.wrap_rad)
    }

    /// The smallest ratio of friction.
    pub fn floor(&self) -> f64 {
        self.mu_low / self.mu_high
    }
}
