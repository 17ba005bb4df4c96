//! Motion of a belt, or of the slider of experiment 1: a speed with a ripple, until it stops.
//!
//! ```text
//! v(t) = s(t) (V + r V n(t)),    n = a cos(2 pi f t) + b sin(2 pi f t)
//! ```
//!
//! `a` and `b` are Gaussian with unit variance and a memory of `MEMORY_PERIODS` periods (Ornstein
//! and Uhlenbeck 1930, stepped exactly). This gives a ripple of rms `r` in a narrow band about `f`.
//! It falls below a level `L` standard deviations away `f exp(-L^2 / 2)` times a second (Rice
//! 1944). `s` is one, and falls linearly to zero when the belt stops. The speed is constant during
//! a step.

use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Memory of the ripple, periods.
const MEMORY_PERIODS: f64 = 5.0;

/// The motion of a belt.
#[derive(Clone, Debug)]
pub struct BeltMotion {
    nominal_m_per_s: f64,
    ripple: Option<Ripple>,
    halt: Option<Halt>,
    time_s: f64,
    speed_m_per_s: f64,
    position_m: f64,
}

#[derive(Clone, Debug)]
struct Ripple {
    rms: f64,
    hz: f64,
    /// Step for which `decay` and `fresh` are computed, s.
    step_s: f64,
    /// Decay of a quadrature over one step.
    decay: f64,
    /// Scale of the new random part.
    fresh: f64,
    quadratures: [f64; 2],
    random: Xoshiro256PlusPlus,
}

/// A stop.
#[derive(Clone, Copy, Debug)]
struct Halt {
    /// Beginning of the stop, s.
    at_s: f64,
    /// Duration of the stop, s.
    takes_s: f64,
}

impl BeltMotion {
    /// Creates a belt that moves at this speed, m/s, without a ripple.
    pub fn new(speed_m_per_s: f64) -> Self {
        BeltMotion { nominal_m_per_s: speed_m_per_s, ripple: None, halt: None, time_s: 0.0, speed_m_per_s, position_m: 0.0 }
    }

    /// Adds a ripple of this rms (relative to the speed) about this frequency, Hz. The seed
    /// determines the ripple.
    pub fn with_ripple(mut self, rms: f64, hz: f64, seed: u64) -> Self {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let quadratures = std::array::from_fn(|_| StandardNormal.sample(&mut random));
        self.ripple = (rms > 0.0).then_some(Ripple { rms, hz, step_s: 0.0, decay: 1.0, fresh: 0.0, quadratures, random });
        self
    }

    /// Returns the speed without its ripple, m/s.
    pub fn nominal_m_per_s(&self) -> f64 {
        self.nominal_m_per_s
    }

    /// Sets the nominal speed of the belt, m/s.
    pub fn set_nominal(&mut self, speed_m_per_s: f64) {
        self.nominal_m_per_s = speed_m_per_s;
    }

    /// Stops the belt permanently: the speed falls to zero within `takes_s`, from `at_s` on.
    pub fn halt(&mut self, at_s: f64, takes_s: f64) {
        self.halt = Some(Halt { at_s, takes_s });
    }

    /// Advances by `step_s`. Returns the speed during that step, m/s.
    pub fn advance(&mut self, step_s: f64) -> f64 {
        let ripple = self.ripple.as_mut().map_or(0.0, |ripple| ripple.next(self.time_s, step_s));
        let part = self.halt.map_or(1.0, |halt| halt.part(self.time_s));
        self.speed_m_per_s = part * self.nominal_m_per_s * (1.0 + ripple);
        self.position_m += self.speed_m_per_s * step_s;
        self.time_s += step_s;
        self.speed_m_per_s
    }

    /// Returns the speed of the belt in the last step, m/s.
    pub fn speed_m_per_s(&self) -> f64 {
        self.speed_m_per_s
    }

    /// Returns the position at the end of the last step, m.
    pub fn position_m(&self) -> f64 {
        self.position_m
    }
}

impl Ripple {
    fn next(&mut self, time_s: f64, step_s: f64) -> f64 {
        if step_s != self.step_s {
            let decay = libm::exp(-step_s * self.hz / MEMORY_PERIODS);
            (self.step_s, self.decay, self.fresh) = (step_s, decay, (1.0 - decay * decay).sqrt());
        }
        for quadrature in &mut self.quadratures {
            let normal: f64 = StandardNormal.sample(&mut self.random);
            *quadrature = self.decay * *quadrature + self.fresh * normal;
        }
        let (sine, cosine) = libm::sincos(std::f64::consts::TAU * self.hz * time_s);
        self.rms * (self.quadratures[0] * cosine + self.quadratures[1] * sine)
    }
}

impl Halt {
    /// Returns the factor by which the speed is reduced, 1 before the stop and 0 after it.
    fn part(self, time_s: f64) -> f64 {
        let since_s = time_s - self.at_s;
        if since_s < 0.0 { 1.0 } else { (1.0 - since_s / self.takes_s.max(f64::MIN_POSITIVE)).max(0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 32e-6;

    #[test]
    fn a_plain_belt_keeps_its_speed_and_stops_along_a_line() {
        let mut belt = BeltMotion::new(0.05);
        belt.halt(1000.0 * STEP_S, 500.0 * STEP_S);
        (0..2000).for_each(|_| {
            belt.advance(STEP_S);
        });
        assert_eq!(belt.speed_m_per_s(), 0.0);
        // The mean speed during the stop is one half; the step in which the slope begins counts
        // half a step too much.
        let expected = 0.05 * STEP_S * (1000.0 + 250.0 + 0.5);
        assert!((belt.position_m() - expected).abs() < 1e-12, "{} for {expected}", belt.position_m());
        belt.halt(0.0, 0.0);
        assert_eq!(belt.advance(STEP_S), 0.0);
    }

    /// Measured: rms 0.1979 for 0.2; 3.05 times a second below two standard deviations. Rice: 2.71
    /// (for the nominal rms).
    #[test]
    fn ripple_has_its_rms_and_the_dip_rate_of_rice() {
        let (mut belt, seconds) = (BeltMotion::new(1.0).with_ripple(0.2, 20.0, 3), 200.0);
        let (mut sum, mut dips, mut above) = (0.0, 0, true);
        let steps = (seconds / 1e-4) as usize;
        for _ in 0..steps {
            let speed = belt.advance(1e-4);
            sum += (speed - 1.0).powi(2);
            // A little hysteresis, as a process with a short memory is rough.
            if above && speed < 0.59 {
                (dips, above) = (dips + 1, false);
            } else if speed > 0.61 {
                above = true;
            }
        }
        let (rms, rate) = ((sum / steps as f64).sqrt(), f64::from(dips) / seconds);
        assert!((rms / 0.2 - 1.0).abs() < 0.05, "{rms}");
        assert!((rate / (20.0 * (-2.0f64).exp()) - 1.0).abs() < 0.2, "{rate}");
    }
}
