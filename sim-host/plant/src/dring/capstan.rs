//! The D-ring as a capstan: `T_high = T_low exp(mu theta)` while webbing slides (Euler 1769,
//! Eytelwein 1808).
//!
//! If the friction is lowered to the ratio `r` everywhere on the arc,
//! `T_high = T_low exp(r mu theta)`. The force that presses the webbing on the ring is
//! `int T dphi = (T_high - T_low) / (r mu)`. The friction without an actuator would be
//! `Fc = mu int T dphi = (T_high - T_low) / r`.

/// D-ring with the friction of the webbing wrapped around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capstan {
    /// Angle of wrap, rad.
    pub wrap_rad: f64,
    /// Coefficient of friction without an actuator.
    pub mu_high: f64,
    /// Lowest coefficient of friction that an actuator can reach.
    pub mu_low: f64,
}

impl Capstan {
    /// Returns the higher tension divided by the lower one at a ratio of friction.
    pub fn gain(&self, ratio: f64) -> f64 {
        libm::exp(ratio * self.mu_high * self.wrap_rad)
    }

    /// Returns the ratio of friction at which two tensions, the higher one first, are in balance.
    pub fn ratio(&self, high_n: f64, low_n: f64) -> f64 {
        libm::log(high_n / low_n) / (self.mu_high * self.wrap_rad)
    }

    /// Returns the smallest ratio of friction.
    pub fn floor(&self) -> f64 {
        self.mu_low / self.mu_high
    }
}
