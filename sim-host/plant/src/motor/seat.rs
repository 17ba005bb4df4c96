//! Height of the rotor at which the mean normal force equals its preload.
//!
//! The crests pass at 40 kHz, and a standing part of the wave rises and falls at 80 kHz. A rotor of
//! 10 g on a contact of 1e8 N/m follows neither within a period, but settles within a few: its
//! height is constant in the crest's frame and follows the *mean* force. The height is therefore
//! not a state, but the root of
//!
//! ```text
//! preload = mean over a turn of psi of (S / pi) (R sin pc - h pc),   cos pc = h / R,   R^2 = A^2 + B^2 + 2 A B cos psi
//! ```
//!
//! with `A` and `B` the amplitudes of the waves in either direction and `S` the layer's stiffness.
//! The contact opens while a standing part lowers the crests below `h`. A wave smaller than
//! `preload / S` touches everywhere, with `h = -preload / S`. The right side falls with `h` and is
//! convex, so Newton's method from the left always converges.

use std::f64::consts::PI;

use crate::motor::crest::Crest;

/// Number of values of `psi` in half a turn. The integrand is smooth apart from the square root at
/// which the contact opens.
const PSI_VALUES: usize = 16;
/// Largest number of steps; six are enough for a wave that grows by a tenth.
const MAX_STEPS: usize = 40;
/// Relative accuracy of the normal force.
const FORCE_ACCURACY_REL: f64 = 1e-9;

/// Returns the height, m, for waves of amplitude `forward` and `backward`, m, on a layer of
/// `stiffness`, N/m, under `preload`, N. `before` is the previous height.
pub fn height(forward: f64, backward: f64, stiffness: f64, preload: f64, before: f64) -> f64 {
    let pressed_in = -preload / stiffness;
    let places = if forward * backward == 0.0 { 1 } else { PSI_VALUES };
    let crests: [f64; PSI_VALUES] = std::array::from_fn(|n| {
        let psi = PI * (n as f64 + 0.5) / places as f64;
        let cross = if places == 1 { 0.0 } else { 2.0 * forward * backward * libm::cos(psi) };
        (forward * forward + backward * backward + cross).max(0.0).sqrt()
    });
    let mut h = before.max(pressed_in);
    for _ in 0..MAX_STEPS {
        let (mut force, mut angle) = (0.0, 0.0);
        for &height_m in &crests[..places] {
            let crest = Crest { height_m, rotor_m: h, ..Crest::default() };
            let zone = crest.zone();
            force += height_m * libm::sin(zone) - h * zone;
            angle += zone;
        }
        let (force, slope) = (stiffness / PI * force / places as f64, stiffness / PI * angle / places as f64);
        if (force - preload).abs() <= FORCE_ACCURACY_REL * preload {
            break;
        }
        // Without contact there is no slope: restart at the far left.
        h = if slope > 0.0 { (h + (force - preload) / slope).max(pressed_in) } else { pressed_in };
    }
    h
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::crest::Layer;

    const STIFFNESS: f64 = 5e7;
    const PRELOAD: f64 = 5.0;

    fn mean_force(forward: f64, backward: f64, h: f64) -> f64 {
        let layer = Layer { mu: 0.2, stiffness_n_per_m: STIFFNESS };
        let slices = 100_000;
        let force = |n: i32| {
            let psi = PI * (f64::from(n) + 0.5) / f64::from(slices);
            let height_m = (forward * forward + backward * backward + 2.0 * forward * backward * psi.cos()).sqrt();
            Crest { height_m, rotor_m: h, along_m_per_s: 1.0, ..Crest::default() }.friction(&layer, 0.0).normal_n
        };
        (0..slices).map(force).sum::<f64>() / f64::from(slices)
    }

    #[test]
    fn the_mean_force_is_the_preload() {
        let mut worst = 0.0f64;
        for forward in [1e-9, 5e-8, 1e-7, 5e-7, 1e-6, 1e-5] {
            for part in [0.0, 0.05, 0.3, 0.9, 1.0] {
                let h = height(forward, part * forward, STIFFNESS, PRELOAD, 0.0);
                worst = worst.max((mean_force(forward, part * forward, h) / PRELOAD - 1.0).abs());
                // The result does not depend on the previous height.
                let again = height(forward, part * forward, STIFFNESS, PRELOAD, 1e-3);
                assert!((again - h).abs() < 1e-9 * (forward + PRELOAD / STIFFNESS), "{h:e} {again:e}");
            }
        }
        // Sixteen values: the square root at which a standing wave opens the contact limits the
        // accuracy.
        assert!(worst < 5e-3, "{worst:e}");
    }

    #[test]
    fn a_small_wave_touches_everywhere() {
        assert!((height(0.9e-7, 0.0, STIFFNESS, PRELOAD, 0.0) + 1e-7).abs() < 1e-15);
        assert!(height(1.2e-7, 0.0, STIFFNESS, PRELOAD, 0.0) > -1e-7);
    }
}
