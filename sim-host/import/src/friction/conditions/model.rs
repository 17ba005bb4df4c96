//! Mean friction as a function of speed, normal force and strength of the vibration.
//!
//! The steady state under a prescribed vibration depends on two numbers ([`contact::closed`]):
//!
//! ```text
//! xi = v / Vv,   kappa = Kt Vv / (w mu N),   mean friction ON = mu N r(xi, kappa)
//! Vv = c times the strength of the vibration, or the measured tip velocity
//! mu(V) = mu (V / V0)^b    if the OFF data demand a trend; V: rms of the slip velocity, within the OFF speeds
//! ```

use super::measurement::Measurement;
use contact::closed;

/// Parameters of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Parameters {
    /// Logarithm of the coefficient of friction at the reference speed.
    pub(super) ln_mu: f64,
    /// Exponent of the speed.
    pub(super) trend: f64,
    /// Logarithm of the tip velocity per strength of the vibration.
    pub(super) ln_tip: f64,
    /// Logarithm of stiffness over angular frequency, N s/m.
    pub(super) ln_compliance: f64,
}

/// Condition, with or without vibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    /// Sliding speed, m/s.
    pub(super) speed_m_per_s: f64,
    /// Normal force, N; one if it is unknown.
    pub(super) normal_n: f64,
    /// Strength of the vibration; `None` if it is OFF.
    pub(super) drive: Option<f64>,
}

/// Model of all measurements.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Model {
    /// `true` if the tip velocity is fitted.
    pub(super) fits_tip: bool,
    /// `true` if the coefficient of friction depends on the speed.
    pub(super) has_trend: bool,
    /// Slowest and fastest speed without vibration, m/s.
    pub(super) off_speeds: (f64, f64),
}

impl Point {
    pub(super) fn new(measurement: &Measurement) -> Self {
        let drive = measurement.tip_m_per_s.or(measurement.level).unwrap_or(1.0);
        let drive = measurement.on.then_some(drive);
        Point { speed_m_per_s: measurement.speed_m_per_s, normal_n: measurement.normal_n.unwrap_or(1.0), drive }
    }
}

impl Model {
    /// Returns the number of parameters, apart from the stiffness.
    pub(super) fn count(&self) -> usize {
        1 + usize::from(self.has_trend) + usize::from(self.fits_tip)
    }

    /// Returns the parameters of the fit for a stiffness over angular frequency.
    pub(super) fn parameters(&self, fitted: &[f64], ln_compliance: f64) -> Parameters {
        let trend = if self.has_trend { fitted[1] } else { 0.0 };
        let ln_tip = if self.fits_tip { fitted[self.count() - 1] } else { 0.0 };
        Parameters { ln_mu: fitted[0], trend, ln_tip, ln_compliance }
    }

    /// Returns the mean friction over the normal force.
    pub(super) fn mu(&self, of: &Parameters, point: &Point) -> f64 {
        let (slow, fast) = self.off_speeds;
        let reference = (slow * fast).sqrt();
        let speed = point.speed_m_per_s;
        let coefficient = |slip: f64| libm::exp(of.ln_mu + of.trend * libm::log(slip.clamp(slow, fast) / reference));
        let Some(drive) = point.drive else { return coefficient(speed) };
        let tip = drive * libm::exp(of.ln_tip);
        let mu = coefficient((speed * speed + 0.5 * tip * tip).sqrt());
        let kappa = libm::exp(of.ln_compliance) * tip / (mu * point.normal_n);
        mu * closed::friction_ratio(speed / tip, kappa)
    }

    /// Returns the friction with vibration over that without at the same speed.
    pub(super) fn ratio(&self, of: &Parameters, point: &Point) -> f64 {
        self.mu(of, point) / self.mu(of, &Point { drive: None, ..*point })
    }
}
