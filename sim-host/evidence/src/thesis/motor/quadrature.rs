//! The phase shifter: a first-order all-pass filter (B.4.2), whose phase is -2 atan(f/f0).

use super::MEASURED_HZ;
use super::backward::{AMPLIFIER_DEG, StandingWaveErrors};
use crate::thesis::claim::{Check, Claim, number};

/// Returns the phase of an all-pass filter, degrees: -90 at its own frequency.
pub fn all_pass_deg(frequency_hz: f64, own_hz: f64) -> f64 {
    -2.0 * (frequency_hz / own_hz).atan().to_degrees()
}

/// Judges the claim that the filter's signals are in quadrature.
pub fn claim() -> Claim {
    let [low, high] = MEASURED_HZ;
    let check = |condition: &str, own: f64, at: f64| {
        let phase = all_pass_deg(at, own);
        let error = -90.0 - phase;
        let numbers = vec![
            number("phase [deg]", phase),
            number("deviation from a quarter period [deg]", error),
            number("backward wave", StandingWaveErrors::degrees(error).backward()),
        ];
        Check::new(condition, error.abs() < AMPLIFIER_DEG[1], numbers)
    };
    Claim {
        id: "all-pass-quadrature",
        section: "B.4.2, B.5",
        says: "An all-pass filter turns the sine into the cosine (within the 10 degrees that the amplifier adds).",
        checks: vec![
            check("set for 20 kHz, at 20 kHz", low, low),
            check("set for 40 kHz, at 40 kHz", high, high),
            check("set for 20 kHz, at 40 kHz", low, high),
            check("set for 40 kHz, at 20 kHz", high, low),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use realfft::num_complex::Complex64;

    #[test]
    fn the_phase_is_that_of_the_circuit() {
        // (1 - i w R C)/(1 + i w R C).
        let circuit = |x: f64| (Complex64::new(1.0, -x) / Complex64::new(1.0, x)).arg().to_degrees();
        for x in [0.1, 0.5, 1.0, 2.0, 7.0] {
            assert!((all_pass_deg(x, 1.0) - circuit(x)).abs() < 1e-12);
        }
    }
}
