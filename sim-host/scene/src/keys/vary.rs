//! `[[vary]]`: numbers that are drawn anew in each run of a scene with several `runs`: true values
//! of the plant, or nominal values of the controller.
//!
//! With a number `x` of the scene and `u`, uniform in `[0, 1)`:
//!
//! ```text
//! spread = s      x (1 + s (2 u - 1))      uniform within s of the value, relative
//! factor = k      x k^(2 u - 1)            log-uniform from x / k to x k
//! from, to        from + (to - from) u     uniform
//! from, to, log   from (to / from)^u       log-uniform
//! sd = s          x + s Phi^-1(u')         normal; u' excludes values beyond 4 s or the key's range
//! samples         one of them              each with the same probability
//! ```

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A number of the scene that is drawn anew in each of its `runs`; without effect if `runs` is 1.
/// Give `spread`, or `factor`, or `from` and `to`, or `sd`, or `samples`. A distribution instead
/// of a number is the same: `mu = { low = 0.05, high = 0.12 }`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Vary {
    /// Path of the number, a true value of the plant or a nominal value of the controller: tables
    /// and key, separated by dots.
    pub key: String,
    /// Uniform within this part of the scene's value on either side.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-9, max = 10.0))]
    pub spread: Option<f64>,
    /// Log-uniform, from the scene's value divided by this factor to the value times this factor.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0, max = 1e3))]
    pub factor: Option<f64>,
    /// Lower end of a uniform distribution, in the unit of the key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// Upper end of the uniform distribution, in the unit of the key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<f64>,
    /// `true` if `from` and `to` are the ends of a log-uniform distribution.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub log: Option<bool>,
    /// Standard deviation of a normal distribution around the scene's value, in the unit of the
    /// key. It is cut off at four standard deviations and at the range of the key.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub sd: Option<f64>,
    /// Values of which each is drawn with the same probability, in the unit of the key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub samples: Option<Vec<f64>>,
    /// Name of a set: keys of the same set are drawn together, for example from the same row of a
    /// table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub set: Option<String>,
}

/// Lowest and highest value of a key.
pub type Range = (Option<f64>, Option<f64>);

/// Number of standard deviations at which a normal distribution is cut off.
const CUT_OFF_SD: f64 = 4.0;
/// Part of a normal distribution that is cut off at each end: the end of a key's range, often zero,
/// need not be a valid value.
const CUT_OFF_PART: f64 = 1e-6;

impl Vary {
    /// Returns the number at `part` of its range, from 0 to 1; `own` is the scene's own value, and
    /// `range` that of the key.
    pub fn value(&self, own: f64, range: Range, part: f64) -> f64 {
        let sided = 2.0 * part - 1.0;
        match self {
            Vary { spread: Some(spread), .. } => own * (1.0 + spread * sided),
            Vary { factor: Some(factor), .. } => own * libm::pow(*factor, sided),
            Vary { from: Some(from), to: Some(to), log: Some(true), .. } => from * libm::pow(to / from, part),
            Vary { from: Some(from), to: Some(to), .. } => from + (to - from) * part,
            Vary { sd: Some(sd), .. } => normal(own, *sd, range, part),
            Vary { samples: Some(samples), .. } => {
                let row = (part * samples.len() as f64) as usize;
                samples.get(row.min(samples.len().saturating_sub(1))).copied().unwrap_or(own)
            }
            _ => own,
        }
    }

    /// Returns the lowest and the highest number.
    pub fn ends(&self, own: f64, range: Range) -> [f64; 2] {
        match self {
            Vary { from: Some(from), to: Some(to), .. } => [*from, *to],
            Vary { samples: Some(samples), .. } => {
                [f64::min, f64::max].map(|of: fn(f64, f64) -> f64| samples.iter().copied().reduce(of).unwrap_or(own))
            }
            _ => [0.0, 1.0].map(|part| self.value(own, range, part)),
        }
    }
}

/// Returns the number at `part` of a normal distribution that is cut off.
fn normal(mean: f64, sd: f64, (least, most): Range, part: f64) -> f64 {
    let below = |z: f64| 0.5 * libm::erfc(-z * core::f64::consts::FRAC_1_SQRT_2);
    let [low, high] = [(least, -CUT_OFF_SD), (most, CUT_OFF_SD)]
        .map(|(end, cut)| below(end.map_or(cut, |end| ((end - mean) / sd).clamp(-CUT_OFF_SD, CUT_OFF_SD))));
    if let (Some(least), Some(most)) = (least, most)
        && high - low < CUT_OFF_PART
    {
        // Within the range the density is constant.
        return least + (most - least) * part;
    }
    let wanted = low + (high - low) * part.clamp(CUT_OFF_PART, 1.0 - CUT_OFF_PART);
    // Newton's method from the middle never overshoots, because the curve bends away from it.
    let mut z = 0.0;
    for _ in 0..64 {
        let step = (wanted - below(z)) * core::f64::consts::TAU.sqrt() * libm::exp(0.5 * z * z);
        z += step;
        if step.abs() < 1e-13 {
            break;
        }
    }
    (mean + sd * z).clamp(least.unwrap_or(f64::NEG_INFINITY), most.unwrap_or(f64::INFINITY))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FREE: Range = (None, None);

    #[test]
    fn values_match_the_distributions() {
        let at = |vary: Vary| [0.0, 0.5, 1.0].map(|part| vary.value(-50.0, FREE, part));
        assert_eq!(at(Vary { spread: Some(0.1), ..Vary::default() }), [-45.0, -50.0, -55.00000000000001]);
        assert_eq!(at(Vary { factor: Some(2.0), ..Vary::default() }), [-25.0, -50.0, -100.0]);
        assert_eq!(at(Vary { from: Some(1.0), to: Some(4.0), ..Vary::default() }), [1.0, 2.5, 4.0]);
        let log = Vary { from: Some(1.0), to: Some(4.0), log: Some(true), ..Vary::default() };
        assert_eq!((at(log.clone()), log.ends(0.0, FREE)), ([1.0, 2.0, 4.0], [1.0, 4.0]));
        assert_eq!(at(Vary { samples: Some(vec![3.0, 1.0, 2.0]), ..Vary::default() }), [3.0, 1.0, 2.0]);
        assert_eq!(Vary { samples: Some(vec![3.0, 1.0, 2.0]), ..Vary::default() }.ends(0.0, FREE), [1.0, 3.0]);
    }

    /// The quantiles of a normal distribution are tabulated in every handbook; the cut at four
    /// standard deviations shifts them by less than 1e-3 of one. A distribution that is cut off at
    /// its mean has those of the half normal distribution.
    #[test]
    fn a_normal_distribution_has_its_quantiles() {
        let vary = Vary { sd: Some(0.1), ..Vary::default() };
        for (part, z) in [(0.5, 0.0), (0.841344746, 1.0), (0.975, 1.959964), (0.025, -1.959964)] {
            assert!((vary.value(0.3, FREE, part) - (0.3 + 0.1 * z)).abs() < 1e-4, "{part}: {}", vary.value(0.3, FREE, part));
        }
        assert!((vary.value(0.3, (Some(0.3), None), 0.5) - 0.3674490).abs() < 1e-5);
        let [least, most] = vary.ends(0.3, (Some(0.0), None));
        assert!(0.0 < least && least < 1e-3 && (0.69..0.7).contains(&most), "{least} {most}");
        let broad = Vary { sd: Some(1e9), ..Vary::default() };
        assert_eq!(broad.value(0.3, (Some(0.0), Some(5.0)), 0.25), 1.25);
    }
}
