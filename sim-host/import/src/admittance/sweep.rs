//! Order of a sweep: one pass over ascending, distinct frequencies.

use super::measured::Measured;
use crate::error::ImportError;

/// Steps to which exporters round, Hz.
const STEPS_HZ: [(f64, &str); 4] = [(1e6, "1 MHz"), (1e3, "1 kHz"), (100.0, "100 Hz"), (10.0, "10 Hz")];

/// Returns the sweep with ascending frequencies; a descending one is reversed.
pub(super) fn ordered(lines: &[usize], mut sweep: Measured) -> Result<Measured, ImportError> {
    let hz = &sweep.hz;
    if let Some(at) = hz.iter().position(|hz| !(*hz > 0.0 && *hz < 1e12)) {
        let what = format!("{} Hz is not a valid frequency", hz[at]);
        return Err(ImportError::BadLine { line: lines[at], what });
    }
    if let Some(at) = hz.windows(2).position(|pair| pair[0] == pair[1]) {
        let step =
            STEPS_HZ.iter().find(|(step, _)| hz.iter().all(|hz| (hz / step).fract().min(1.0 - (hz / step).fract()) < 1e-9));
        let step = step.map_or_else(String::new, |(_, name)| format!(" to {name}"));
        return Err(ImportError::FrequenciesEqual { first: lines[at], second: lines[at + 1], hz: hz[at], step });
    }
    let falls = hz.len() > 1 && hz[1] < hz[0];
    if let Some(at) = hz.windows(2).position(|pair| (pair[1] < pair[0]) != falls) {
        return Err(ImportError::FrequenciesUnordered { line: lines[at + 1], hz: hz[at + 1] });
    }
    if falls {
        sweep.hz.reverse();
        sweep.admittance.reverse();
        sweep.seen.reverse();
    }
    Ok(sweep)
}
