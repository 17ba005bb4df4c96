//! Participation of the lanes in the modes: the integral of the mode's shape over the electrode
//! tabs of the lane.
//!
//! Tab `j` belongs to lane `j mod 4`. Its centre is at `x_j = x_0 + j (width + gap)`. A voltage on
//! it bends the stator. The modal force of a mode of shape `phi` is proportional to
//! `integral phi(x) dx` over the tab (the work of the moment on the curvature, which for a sine has
//! the shape itself):
//!
//! ```text
//! integral sin kx dx = (2 / k) sin(k width / 2) sin k x_j,   integral cos kx dx = (2 / k) sin(k width / 2) cos k x_j
//! ```
//!
//! This is divided by the value for tabs that are all at crests, so that a lane with such tabs has
//! participation one. With tabs a quarter wave apart, lanes 0 and 2 drive one mode and lanes 1 and
//! 3 the other, with opposite signs; any other pitch mixes them.

use std::f64::consts::TAU;

use firmware::seam::block::MAX_LANES;

use scene::Stator;

/// Number of modes: sine and cosine.
pub const MODES: usize = 2;

/// Participation of each lane in the sine and in the cosine mode, -1 to 1.
pub type Participation = [[f64; MODES]; MAX_LANES];

/// Returns the participation of the lanes of a stator.
pub fn participation(stator: &Stator) -> Participation {
    let pitch_turns = (stator.tab_width_m + stator.tab_gap_m) / stator.wave_length_m;
    let tabs = usize::from(stator.tabs);
    std::array::from_fn(|lane| {
        let of_lane = || (lane..tabs).step_by(MAX_LANES);
        let count = of_lane().count().max(1) as f64;
        let (sine, cosine) = of_lane()
            .map(|tab| (TAU * (stator.first_tab_turns + tab as f64 * pitch_turns)).sin_cos())
            .fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
        [sine / count, cosine / count]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::tests::stator;

    #[test]
    fn a_quarter_wave_of_pitch_separates_the_modes() {
        let expected = [[0.0, 1.0], [1.0, 0.0], [0.0, -1.0], [-1.0, 0.0]];
        for (got, expected) in participation(&stator()).iter().flatten().zip(expected.iter().flatten()) {
            assert!((got - expected).abs() < 1e-12, "{got} {expected}");
        }
    }

    /// Independent of the closed form: the midpoint rule over every tab.
    #[test]
    fn the_sum_is_the_integral_over_the_tabs() {
        for turns in [0.0, 0.1, 0.37] {
            let odd = Stator { wave_length_m: 0.021, first_tab_turns: turns, ..stator() };
            let k = TAU / odd.wave_length_m;
            let slices = 2000;
            let over_tab = |centre: f64, shape: fn(f64) -> f64| {
                let dx = odd.tab_width_m / f64::from(slices);
                (0..slices).map(|n| shape(k * (centre + dx * (f64::from(n) + 0.5) - 0.5 * odd.tab_width_m)) * dx).sum::<f64>()
            };
            let crest = over_tab(0.0, f64::cos);
            for (lane, got) in participation(&odd).iter().enumerate() {
                for (got, shape) in got.iter().zip([f64::sin as fn(f64) -> f64, f64::cos]) {
                    let sum: f64 = (lane..12)
                        .step_by(4)
                        .map(|tab| over_tab(turns * odd.wave_length_m + tab as f64 * (odd.tab_width_m + odd.tab_gap_m), shape))
                        .sum();
                    assert!((got - sum / (3.0 * crest)).abs() < 1e-6, "{lane}: {got} {}", sum / (3.0 * crest));
                }
            }
        }
    }
}
