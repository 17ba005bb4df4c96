//! The band that a transducer is looked for in, and the windows that the board scans it by.

use std::str::FromStr;

use firmware::board::command::Converters;

/// Widest window on each side of its middle, as a part of it; the board takes 0.2 at most, and a resonance at an edge is seen from both sides.
const WIDEST: f64 = 0.18;
/// Narrowest window.
const NARROWEST: f64 = 0.01;
/// Periods that a block of samples has at least: fewer do not tell sine from cosine.
const LEAST_PERIODS: f64 = 0.5;
/// Highest frequency as a part of the sample rate, as the board's settings have it, and at most, Hz.
const HIGHEST: (f64, f64) = (0.45, 450e3);

/// A band of frequencies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Lower end, Hz.
    pub low_hz: f64,
    /// Upper end, Hz.
    pub high_hz: f64,
}

/// A part of the band that the board scans at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Nominal frequency of the scan, Hz.
    pub hz: f64,
    /// Distance of the ends from it, as a part of it.
    pub span: f64,
}

impl FromStr for Band {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const FORM: &str = "a band is two frequencies in hertz, such as 20k:45k";
        let (low, high) = text.split_once(':').ok_or(FORM)?;
        let band = Band { low_hz: hertz(low).ok_or(FORM)?, high_hz: hertz(high).ok_or(FORM)? };
        if band.low_hz > 0.0 && band.low_hz < band.high_hz {
            Ok(band)
        } else {
            Err(format!("{FORM}: the lower one first, and above zero"))
        }
    }
}

fn hertz(text: &str) -> Option<f64> {
    let text = text.trim();
    let (number, factor) = match text.strip_suffix(['k', 'M']) {
        Some(number) => (number, if text.ends_with('k') { 1e3 } else { 1e6 }),
        None => (text, 1.0),
    };
    number.parse::<f64>().ok().filter(|hz| hz.is_finite()).map(|hz| factor * hz)
}

impl Band {
    /// The lowest and the highest frequency that a board's converters measure, Hz.
    pub fn of_converters(converters: &Converters) -> Band {
        let sample_hz = f64::from(converters.sample_hz);
        Band {
            low_hz: LEAST_PERIODS * sample_hz / f64::from(converters.block_samples),
            high_hz: (HIGHEST.0 * sample_hz).min(HIGHEST.1),
        }
    }

    /// Whether another band is within this one.
    pub fn has(&self, other: &Band) -> bool {
        self.low_hz <= other.low_hz && other.high_hz <= self.high_hz
    }

    /// The middle of the band on a logarithmic scale, Hz.
    pub fn middle_hz(&self) -> f64 {
        (self.low_hz * self.high_hz).sqrt()
    }

    /// The windows of the band, at rising frequencies; they meet at their ends.
    pub fn windows(&self) -> Vec<Window> {
        let ratio = self.high_hz / self.low_hz;
        let count = (ratio.ln() / ((1.0 + WIDEST) / (1.0 - WIDEST)).ln()).ceil().max(1.0);
        let step = ratio.powf(1.0 / count);
        (0..count as u32)
            .map(|n| {
                let low_hz = self.low_hz * step.powi(n as i32);
                Window { hz: 0.5 * low_hz * (1.0 + step), span: ((step - 1.0) / (step + 1.0)).max(NARROWEST) }
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
            assert!(windows.iter().all(|window| window.span <= WIDEST), "{windows:?}");
        }
    }

    #[test]
    fn a_band_is_read_with_its_prefixes() {
        assert_eq!("20k:45k".parse(), Ok(Band { low_hz: 20e3, high_hz: 45e3 }));
        assert_eq!("19500:0.1M".parse(), Ok(Band { low_hz: 19_500.0, high_hz: 100e3 }));
        for wrong in ["20k", "45k:20k", "0:1k", "20k:x", "nan:1k"] {
            assert!(wrong.parse::<Band>().unwrap_err().contains("20k:45k"), "{wrong}");
        }
    }
}
