//! Frequency band of the search, and the windows in which the board scans it.

use std::str::FromStr;

use firmware::board::command::Converters;

use crate::number_with_unit::number_in;

/// Largest half-width of a window, relative to its middle. The board accepts 0.2, so that a
/// resonance at an edge is found by both windows.
const MAX_HALF_WIDTH_REL: f64 = 0.18;
/// Smallest half-width of a window, relative to its middle.
const MIN_HALF_WIDTH_REL: f64 = 0.01;
/// Minimum number of periods per block of samples, below which sine and cosine cannot be
/// distinguished.
const MIN_PERIODS: f64 = 0.5;
/// Highest frequency of the board's settings, relative to the sampling rate.
const MAX_FREQUENCY_REL: f64 = 0.45;
/// Highest frequency of the board's settings, Hz.
const MAX_FREQUENCY_HZ: f64 = 450e3;

/// Frequency band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Lower end, Hz.
    pub low_hz: f64,
    /// Upper end, Hz.
    pub high_hz: f64,
}

/// Window: the part of the band that the board scans at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Nominal frequency of the scan, Hz.
    pub hz: f64,
    /// Half-width, relative to the nominal frequency.
    pub span: f64,
}

impl FromStr for Band {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const FORM: &str = "expected a band as two frequencies in hertz, such as 20k:45k";
        let (low, high) = text.split_once(':').ok_or(FORM)?;
        let end = |text: &str| number_in(text, "Hz").map_err(|why| format!("{FORM}: {why}"));
        let band = Band { low_hz: end(low)?, high_hz: end(high)? };
        if band.low_hz > 0.0 && band.low_hz < band.high_hz {
            Ok(band)
        } else {
            Err(format!("{FORM}, both positive and the lower one first"))
        }
    }
}

impl Band {
    /// Returns the band that a board's converters can measure.
    pub fn from_converters(converters: &Converters) -> Band {
        let sample_hz = f64::from(converters.sample_hz);
        Band {
            low_hz: MIN_PERIODS * sample_hz / f64::from(converters.block_samples),
            high_hz: (MAX_FREQUENCY_REL * sample_hz).min(MAX_FREQUENCY_HZ),
        }
    }

    /// Returns `true` if another band is within this one.
    pub fn contains(&self, other: &Band) -> bool {
        self.low_hz <= other.low_hz && other.high_hz <= self.high_hz
    }

    /// Returns the geometric mean of the ends, Hz.
    pub fn middle_hz(&self) -> f64 {
        (self.low_hz * self.high_hz).sqrt()
    }

    /// Returns the adjacent windows of the band, in ascending order.
    pub fn windows(&self) -> Vec<Window> {
        let ratio = self.high_hz / self.low_hz;
        let count = (ratio.ln() / ((1.0 + MAX_HALF_WIDTH_REL) / (1.0 - MAX_HALF_WIDTH_REL)).ln()).ceil().max(1.0);
        let step = ratio.powf(1.0 / count);
        (0..count as u32)
            .map(|n| {
                let low_hz = self.low_hz * step.powi(n as i32);
                Window { hz: 0.5 * low_hz * (1.0 + step), span: ((step - 1.0) / (step + 1.0)).max(MIN_HALF_WIDTH_REL) }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_cover_the_band() {
        for (low_hz, high_hz) in [(20e3, 45e3), (28e3, 28.1e3), (15e3, 450e3)] {
            let windows = Band { low_hz, high_hz }.windows();
            let ends: Vec<(f64, f64)> = windows.iter().map(|at| (at.hz * (1.0 - at.span), at.hz * (1.0 + at.span))).collect();
            assert!(ends[0].0 <= low_hz * 1.000_001 && ends[ends.len() - 1].1 >= high_hz * 0.999_999, "{ends:?}");
            assert!(ends.windows(2).all(|pair| pair[1].0 <= pair[0].1 * 1.000_001), "{ends:?}");
            assert!(windows.iter().all(|window| window.span <= MAX_HALF_WIDTH_REL), "{windows:?}");
        }
    }

    #[test]
    fn a_band_is_parsed_with_prefixes() {
        assert_eq!("20k:45k".parse(), Ok(Band { low_hz: 20e3, high_hz: 45e3 }));
        assert_eq!("20khz:45 kHz".parse(), Ok(Band { low_hz: 20e3, high_hz: 45e3 }));
        assert_eq!("19500:0.1M".parse(), Ok(Band { low_hz: 19_500.0, high_hz: 100e3 }));
        for wrong in ["20k", "45k:20k", "0:1k", "20k:x", "nan:1k"] {
            assert!(wrong.parse::<Band>().unwrap_err().contains("20k:45k"), "{wrong}");
        }
    }
}
