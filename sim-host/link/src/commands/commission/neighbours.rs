//! Search for further resonances near the chosen one, by fitting its circle with one, two and three
//! resonances.
//!
//! A further mode within a few bandwidths bends the circle. Undetected, it falsifies the result of
//! a scan and the frequency of a lock.

use firmware::seam::transducer::{Deviations, Transducer};
use import::admittance::circuit::Branch;

use super::ALIKE_CM_REL;
use super::fit::{Fit, Point, fit};
use super::proposal::{bound_hz, uncertain_hz};
use crate::link_error::LinkError;

/// Starting distances of a further resonance, in bandwidths of the first one.
const START_DISTANCES: [f64; 8] = [0.2, 0.5, 1.0, 2.0, -0.2, -0.5, -1.0, -2.0];
/// Starting quality factors of a further resonance, relative to the first one.
const START_Q_RATIOS: [f64; 3] = [0.3, 1.0, 3.0];
/// Starting conductance of a further resonance, relative to the first one.
const START_CONDUCTANCE_REL: f64 = 0.1;
/// Largest distance of another mode that the circle can show, in distances of its last point.
const REACH_RADII: f64 = 2.0;
/// Smallest F ratio of a further resonance: reduction of the sum of squares per parameter, relative
/// to the mean square.
const MIN_F_RATIO: f64 = 6.0;
/// Largest standard deviation of a resonance next to others, bandwidths.
const MAX_DEVIATION_BANDWIDTHS: f64 = 0.1;
/// Number of standard deviations of the series resonance that must be within the bound.
const MAX_ERROR_SIGMAS: f64 = 2.0;
/// Mean square of the distances, in standard deviations, above which a fit is rejected.
const MAX_MEAN_SQUARE: f64 = 16.0;
/// Maximum number of resonances of a circuit.
const MAX_RESONANCES: usize = 3;

/// Returns the circuit with the fewest resonances that explains the points. Its first resonance was
/// fitted from `start`; the scans have shown the `known` ones. Returns `None` if there are too few
/// points.
fn circuit(points: &[Point], start: Branch, known: &[Branch]) -> Option<Fit> {
    let mut best = fit(points, &[start])?;
    while best.resonances.len() < MAX_RESONANCES {
        let Some(more) = with_one_more(points, &best, known).filter(|more| is_significant(&best, more)) else { break };
        best = more;
    }
    Some(best)
}

/// Returns the best fit with one more resonance.
fn with_one_more(points: &[Point], of: &Fit, known: &[Branch]) -> Option<Fit> {
    let first = of.resonances.first()?;
    let width_hz = first.hz / first.q;
    let starts = START_DISTANCES.iter().flat_map(|distance| START_Q_RATIOS.iter().map(move |quality| (distance, quality)));
    let near = starts.map(|(distance, quality)| Branch {
        hz: first.hz + distance * width_hz,
        q: (first.q * quality).max(1.0),
        siemens: START_CONDUCTANCE_REL * first.siemens,
    });
    let fits =
        near.chain(known.iter().copied()).filter_map(|further| fit(points, &[of.resonances.as_slice(), &[further]].concat()));
    fits.filter(is_determined).min_by(|a, b| a.squares.total_cmp(&b.squares))
}

/// Returns `true` if the points determine the strongest resonance. Two resonances at nearly the
/// same frequency can cancel each other: they fit the noise.
fn is_determined(fit: &Fit) -> bool {
    let place = fit.strongest();
    let it = fit.resonances[place];
    fit.resonances.iter().all(|it| it.siemens > 0.0) && fit.deviations_hz[place] < MAX_DEVIATION_BANDWIDTHS * it.hz / it.q
}

/// Returns `true` if a fit with more parameters explains more than noise, by an F test.
fn is_significant(fewer: &Fit, more: &Fit) -> bool {
    let gained = (fewer.squares - more.squares) / (fewer.free - more.free) as f64;
    gained > MIN_F_RATIO * more.mean_square().max(1.0)
}

/// Resonance, separated from its neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolved {
    /// Resonance as fitted to the circle, or as identified by the scan if the circle has only one.
    pub transducer: Transducer,
    /// Number of resonances of the circle.
    pub resonances: usize,
    /// Rms distance of the points from the fitted circuit, relative to the conductance.
    pub distance: f64,
}

/// Returns the resonance of a circle. `others`: the other modes that the scans have shown. Fails if
/// the circle does not determine it.
pub fn resolve(points: &[Point], of: &Transducer, others: &[Transducer], by_number: bool) -> Result<Resolved, LinkError> {
    let (hz, bound_hz) = (f64::from(of.series_resonance_hz), bound_hz(of));
    let branch =
        |of: &Transducer| Branch { hz: of.series_resonance_hz.into(), q: of.q.into(), siemens: 1.0 / f64::from(of.rm_ohm) };
    let reach_hz = REACH_RADII * points.iter().map(|point| (point.hz - hz).abs()).fold(0.0, f64::max);
    let known: Vec<Branch> = others.iter().map(branch).filter(|it| (it.hz - hz).abs() < reach_hz).collect();
    let refused =
        |why: String| LinkError::Failed(format!("a resonance was identified at {hz:.2} Hz, but it is not alone: {why}"));
    let circuit =
        circuit(points, branch(of), &known).ok_or_else(|| refused("the admittance around it cannot be fitted".into()))?;
    let distance = circuit.distance(points) / circuit.resonances[0].siemens;
    if circuit.mean_square() > MAX_MEAN_SQUARE {
        return Err(refused(format!(
            "the admittance around it is {:.1} % off that of a circuit of {}. Another mode is nearby, or the load changes",
            100.0 * distance,
            ["one resonance", "two resonances", "three resonances"][circuit.resonances.len().clamp(1, MAX_RESONANCES) - 1]
        )));
    }
    // A mode chosen by its number is the one that was measured; otherwise the strongest is used.
    let place = if by_number { 0 } else { circuit.strongest() };
    let (found, deviation_hz) = (circuit.resonances[place], circuit.deviations_hz[place]);
    let others: Vec<Branch> = circuit.resonances.iter().enumerate().filter(|(at, _)| *at != place).map(|(_, it)| *it).collect();
    if let Some(alike) = others.iter().find(|it| !by_number && it.cm_f() > ALIKE_CM_REL * found.cm_f()) {
        return Err(refused(format!(
            "another resonance with {:.0} % of its strength is at {:.1} Hz",
            100.0 * alike.cm_f() / found.cm_f(),
            alike.hz
        )));
    }
    if MAX_ERROR_SIGMAS * deviation_hz > uncertain_hz(of) {
        let near = others.iter().map(|it| format!("{:.1} Hz", it.hz)).collect::<Vec<_>>().join(" and ");
        return Err(refused(format!(
            "{} makes its frequency uncertain by {:.2} Hz, but {:.2} Hz are required. Two transducers are in parallel, \
             or the transducer has two modes close to each other",
            if near.is_empty() { "a disturbance".into() } else { format!("another mode at {near}") },
            MAX_ERROR_SIGMAS * deviation_hz,
            uncertain_hz(of)
        )));
    }
    if others.is_empty() && (found.hz - hz).abs() <= bound_hz {
        return Ok(Resolved { transducer: *of, resonances: 1, distance });
    }
    Ok(Resolved { transducer: with(of, &circuit, place), resonances: circuit.resonances.len(), distance })
}

/// Returns a transducer with a resonance of a fit.
fn with(of: &Transducer, circuit: &Fit, place: usize) -> Transducer {
    // Strong resonances just outside the circle can make its background inductive.
    let c0_f = Some(circuit.c0_f()).filter(|c0_f| *c0_f > 0.0).unwrap_or(of.c0_f.into());
    let it = circuit.resonances[place];
    Transducer {
        series_resonance_hz: it.hz as f32,
        parallel_resonance_hz: it.parallel_hz(c0_f) as f32,
        q: it.q as f32,
        rm_ohm: it.rm_ohm() as f32,
        lm_h: it.lm_h() as f32,
        cm_f: it.cm_f() as f32,
        c0_f: c0_f as f32,
        coupling: it.coupling(c0_f) as f32,
        deviations: Deviations { series_resonance_hz: circuit.deviations_hz[place] as f32, ..of.deviations },
        ..*of
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use realfft::num_complex::Complex64;

    use super::*;

    const MAIN: Branch = Branch { hz: 40e3, q: 50.0, siemens: 0.3 };

    /// Returns the resonance as a scan would identify it, with this frequency error.
    fn identified(apart_hz: f64) -> Transducer {
        let c0_f = 300e-9;
        let cm_f = MAIN.cm_f();
        Transducer {
            series_resonance_hz: (MAIN.hz + apart_hz) as f32,
            q: 52.0,
            rm_ohm: (1.0 / MAIN.siemens) as f32,
            cm_f: cm_f as f32,
            c0_f,
            ..Transducer::default()
        }
    }

    /// Returns seventeen points up to 2.5 bandwidths from the resonance, with 300 nF in parallel
    /// and a changing deviation of a ten-thousandth of the conductance.
    fn points(further: &[Branch]) -> Vec<Point> {
        let off = 1e-4 * MAIN.siemens;
        (0..17)
            .map(|n| {
                let hz = MAIN.hz + 400.0 * ((f64::from(n) / 8.0 - 1.0) * 5f64.atan()).tan();
                let y: Complex64 = [MAIN].iter().chain(further).map(|it| it.admittance(hz)).sum();
                let noise = off * [Complex64::ONE, -Complex64::I, -Complex64::ONE, Complex64::I][n as usize % 4];
                Point { hz, siemens: y + Complex64::new(0.0, TAU * hz * 300e-9) + noise, deviation: off }
            })
            .collect()
    }

    #[test]
    fn a_single_resonance_keeps_its_identified_values() {
        let of = identified(1.0);
        let resolved = resolve(&points(&[]), &of, &[], false).unwrap();
        assert_eq!((resolved.transducer, resolved.resonances), (of, 1));
        assert!(resolved.distance < 2e-4, "{resolved:?}");
    }

    #[test]
    fn a_neighbour_within_a_bandwidth_is_separated() {
        for hz in [40.4e3, 40.8e3, 39.4e3] {
            let neighbour = Branch { hz, q: 70.0, siemens: 0.06 };
            let resolved = resolve(&points(&[neighbour]), &identified(60.0), &[], false).unwrap();
            assert_eq!(resolved.resonances, 2, "{hz}");
            let it = resolved.transducer;
            assert!((f64::from(it.series_resonance_hz) - MAIN.hz).abs() < 4.0, "{hz}: {it:?}");
            assert!((f64::from(it.cm_f) / MAIN.cm_f() - 1.0).abs() < 0.03, "{hz}: {it:?}");
        }
    }

    /// A strong mode beyond the points bends their circle; no start near the first one leads to it.
    #[test]
    fn a_known_mode_beyond_the_circle_is_fitted_with_it() {
        let far = Branch { hz: 37.2e3, q: 80.0, siemens: 0.2 };
        let of = |it: Branch| Transducer {
            series_resonance_hz: it.hz as f32,
            q: it.q as f32,
            rm_ohm: it.rm_ohm() as f32,
            ..identified(0.0)
        };
        let points = points(&[far]);
        assert!(resolve(&points, &identified(0.0), &[], false).is_err());
        let resolved = resolve(&points, &identified(0.0), &[of(far)], false).unwrap();
        assert_eq!(resolved.resonances, 2);
        assert!((f64::from(resolved.transducer.series_resonance_hz) - MAIN.hz).abs() < 1.0, "{resolved:?}");
    }

    #[test]
    fn an_ambiguous_circle_is_refused_with_the_reason() {
        let similar = Branch { hz: 40.6e3, q: 50.0, siemens: 0.27 };
        let error = |points: &[Point]| resolve(points, &identified(0.0), &[], false).unwrap_err().to_string();
        assert!(error(&points(&[similar])).contains("of its strength is at"), "{}", error(&points(&[similar])));
        let mut crooked = points(&[]);
        crooked.iter_mut().step_by(3).for_each(|point| point.siemens *= 1.02);
        assert!(error(&crooked).contains("off that of a circuit of"), "{}", error(&crooked));
        assert!(error(&crooked[..2]).contains("cannot be fitted"), "{}", error(&crooked[..2]));
    }
}
