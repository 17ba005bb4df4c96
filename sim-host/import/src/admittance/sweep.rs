//! Order of a sweep: one pass over ascending, distinct frequencies.

use super::measured::Measured;
use crate::error::ImportError;

/// Steps to which exporters round, Hz.
const STEPS_HZ: [(f64, &str); 4] = [(1e6, "1 MHz"), (1e3, "1 kHz"), (100.0, "100 Hz"), (10.0, "10 Hz")];

/// Minimum number of points per frequency that occurs twice.
const MIN_SEGMENT_POINTS: usize = 50;
/// Maximum number of frequencies that occur twice.
const MAX_SEGMENTS: usize = 32;

/// Returns the sweep with ascending frequencies; a descending one is reversed.
pub(super) fn ordered(lines: &[usize], mut sweep: Measured) -> Result<Measured, ImportError> {
    let (mut lines, hz) = (lines.to_vec(), &sweep.hz);
    if let Some(at) = hz.iter().position(|hz| !(*hz > 0.0 && *hz < 1e12)) {
        let what = format!("{} Hz is not a valid frequency", hz[at]);
        return Err(ImportError::BadLine { line: lines[at], what });
    }
    // Each frequency measured several times: the readings are averaged.
    let repeats = hz.iter().position(|other| *other != hz[0]).unwrap_or(hz.len());
    let is_repeated = |group: &[f64]| group.len() == repeats && group.iter().all(|other| *other == group[0]);
    let distinct = || hz.iter().step_by(repeats.max(1)).zip(hz.iter().step_by(repeats.max(1)).skip(1)).all(|(a, b)| a != b);
    if repeats > 1 && repeats < hz.len() && hz.chunks(repeats).all(is_repeated) && distinct() {
        let bins: Vec<_> = (0..hz.len() / repeats).map(|at| at * repeats..(at + 1) * repeats).collect();
        let lines: Vec<usize> = lines.iter().step_by(repeats).copied().collect();
        let mut remarks = std::mem::take(&mut sweep.remarks);
        remarks.push(format!("Each frequency was measured {repeats} times; the readings are averaged"));
        return ordered(&lines, Measured { remarks, ..sweep.averaged(&bins) });
    }
    let doubled: Vec<usize> = (1..hz.len()).filter(|at| hz[*at] == hz[at - 1]).collect();
    if let Some(&second) = doubled.first() {
        let first = second - 1;
        // Segments meet at one frequency; each of them has many points.
        if doubled.len() > (hz.len() / MIN_SEGMENT_POINTS).min(MAX_SEGMENTS)
            || doubled.windows(2).any(|pair| pair[1] - pair[0] < 2)
        {
            let step =
                STEPS_HZ.iter().find(|(step, _)| hz.iter().all(|hz| (hz / step).fract().min(1.0 - (hz / step).fract()) < 1e-9));
            let step = step.map_or_else(String::new, |(_, name)| format!(" to {name}"));
            return Err(ImportError::FrequenciesEqual { first: lines[first], second: lines[second], hz: hz[first], step });
        }
        sweep.remarks.push(format!(
            "Lines {} and {} both have {} Hz, as at the border of two segments; their readings are averaged ({} such pair(s))",
            lines[first],
            lines[second],
            hz[first],
            doubled.len()
        ));
        for at in doubled.into_iter().rev() {
            sweep.hz.remove(at);
            lines.remove(at);
            for values in [&mut sweep.admittance, &mut sweep.seen] {
                values[at - 1] = 0.5 * (values[at - 1] + values.remove(at));
            }
        }
    }
    let hz = &sweep.hz;
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

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::super::coordinate::Coordinate;
    use super::*;

    fn order(hz: &[f64]) -> Result<Measured, ImportError> {
        let lines: Vec<usize> = (2..2 + hz.len()).collect();
        let admittance: Vec<Complex64> = (0..hz.len()).map(|n| Complex64::new(n as f64, 1.0)).collect();
        let seen = admittance.clone();
        let coordinate = Coordinate::Immittance;
        ordered(&lines, Measured { hz: hz.to_vec(), admittance, seen, fixture: Vec::new(), coordinate, remarks: Vec::new() })
    }

    #[test]
    fn borders_of_segments_are_averaged_and_rounded_frequencies_refused() {
        for falls in [false, true] {
            let sorted = |mut hz: Vec<f64>| {
                hz.sort_by(|a, b| if falls { b.total_cmp(a) } else { a.total_cmp(b) });
                hz
            };
            let even: Vec<f64> = (0..200).map(|n| 4e4 + 10.0 * f64::from(n)).collect();
            let found = order(&sorted([even.clone(), vec![40_500.0, 41_000.0]].concat())).unwrap();
            assert_eq!((&found.hz, found.admittance.len(), found.remarks.len()), (&even, 200, 1));
            assert_eq!(found.admittance[50].re.fract(), 0.5);
            let rounded = even.iter().map(|hz| (hz / 50.0).round() * 50.0).collect();
            assert!(matches!(order(&sorted(rounded)), Err(ImportError::FrequenciesEqual { .. })));
            let triple = order(&sorted([even, vec![40_500.0; 2]].concat()));
            assert!(matches!(triple, Err(ImportError::FrequenciesEqual { .. })), "{triple:?}");
        }
    }
}
