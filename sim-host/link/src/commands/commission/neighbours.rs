//! Whether the chosen resonance is alone: its circle, fitted with one resonance, with two and with three.
//!
//! A further mode within a few bandwidths bends the circle, and moves what a scan identifies, and the lock, without a word.

use firmware::seam::transducer::{Deviations, Transducer};
use import::admittance::circuit::Branch;

use super::ALIKE;
use super::fit::{Fit, Point, fit};
use super::proposal::bound_hz;
use crate::link_error::LinkError;

/// Starting values of a further resonance: distances, in bandwidths of the first; Q and conductance, as parts of the first.
const DISTANCES: [f64; 8] = [0.2, 0.5, 1.0, 2.0, -0.2, -0.5, -1.0, -2.0];
const QUALITIES: [f64; 3] = [0.3, 1.0, 3.0];
const CONDUCTANCE: f64 = 0.1;
/// A further resonance is there where it explains so many times as much of the squares as it would of noise.
const SIGNIFICANT: f64 = 6.0;
/// So many standard deviations of the series resonance are within the bound.
const SIGMAS: f64 = 2.0;
/// Mean square of the distances, in deviations, from which on a fit is none.
const CROOKED: f64 = 16.0;
/// Most resonances of a circuit.
const MOST: usize = 3;

/// The circuit of the fewest resonances that explains the points; the first is that of `start`. None where there are too few points.
fn circuit(points: &[Point], start: Branch) -> Option<Fit> {
    let mut best = fit(points, &[start])?;
    while best.resonances.len() < MOST {
        let Some(more) = with_one_more(points, &best).filter(|more| explains(&best, more)) else { break };
        best = more;
    }
    Some(best)
}

/// The best fit with one resonance more.
fn with_one_more(points: &[Point], of: &Fit) -> Option<Fit> {
    let first = of.resonances.first()?;
    let width_hz = first.hz / first.q;
    let starts = DISTANCES.iter().flat_map(|distance| QUALITIES.iter().map(move |quality| (distance, quality)));
    let fits = starts.filter_map(|(distance, quality)| {
        let further =
            Branch { hz: first.hz + distance * width_hz, q: (first.q * quality).max(1.0), siemens: CONDUCTANCE * first.siemens };
        fit(points, &[of.resonances.as_slice(), &[further]].concat())
    });
    fits.min_by(|a, b| a.squares.total_cmp(&b.squares))
}

/// Whether a fit with more parameters explains more than noise: the ratio of an F test.
fn explains(fewer: &Fit, more: &Fit) -> bool {
    let gained = (fewer.squares - more.squares) / (fewer.free - more.free) as f64;
    gained > SIGNIFICANT * more.mean_square().max(1.0)
}

/// A resonance, with what is near it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolved {
    /// The resonance as the circle has it, with the scan's values where only one resonance is there.
    pub transducer: Transducer,
    /// Number of resonances that the circle has.
    pub resonances: usize,
    /// Rms distance of the points from the fitted circuit, in parts of the conductance.
    pub distance: f64,
}

/// The resonance of a circle. Fails where the circle does not determine it.
pub fn resolve(points: &[Point], of: &Transducer, by_number: bool) -> Result<Resolved, LinkError> {
    let (hz, bound_hz) = (f64::from(of.series_resonance_hz), bound_hz(of));
    let start = Branch { hz, q: of.q.into(), siemens: 1.0 / f64::from(of.rm_ohm) };
    let refused =
        |why: String| LinkError::Failed(format!("a resonance was identified at {hz:.2} Hz, and it is not alone: {why}"));
    let circuit = circuit(points, start).ok_or_else(|| refused("the admittance round it cannot be fitted".into()))?;
    let distance = circuit.distance(points) / circuit.resonances[0].siemens;
    if circuit.mean_square() > CROOKED {
        return Err(refused(format!(
            "the admittance round it is {:.1} % off that of a circuit of {}. Another mode is near it, or a load that changes",
            100.0 * distance,
            ["one resonance", "two resonances", "three resonances"][circuit.resonances.len().clamp(1, MOST) - 1]
        )));
    }
    // By its number it is the one that was looked at, else the strongest.
    let place = if by_number { 0 } else { circuit.strongest() };
    let (found, deviation_hz) = (circuit.resonances[place], circuit.deviations_hz[place]);
    let others: Vec<Branch> = circuit.resonances.iter().enumerate().filter(|(at, _)| *at != place).map(|(_, it)| *it).collect();
    if let Some(alike) = others.iter().find(|it| !by_number && it.cm_f() > ALIKE * found.cm_f()) {
        return Err(refused(format!(
            "another one of {:.0} % of its strength is at {:.1} Hz",
            100.0 * alike.cm_f() / found.cm_f(),
            alike.hz
        )));
    }
    if SIGMAS * deviation_hz > bound_hz {
        let near = others.iter().map(|it| format!("{:.1} Hz", it.hz)).collect::<Vec<_>>().join(" and ");
        return Err(refused(format!(
            "{} near it hides where it is: it is known to {:.2} Hz, and {bound_hz:.2} Hz are asked for. Two transducers in parallel, or a transducer with two modes \
             that near",
            if near.is_empty() { "something".into() } else { format!("another mode at {near}") },
            SIGMAS * deviation_hz
        )));
    }
    if others.is_empty() && (found.hz - hz).abs() <= bound_hz {
        return Ok(Resolved { transducer: *of, resonances: 1, distance });
    }
    Ok(Resolved { transducer: with(of, &circuit, place), resonances: circuit.resonances.len(), distance })
}

/// A transducer with the resonance of a fit.
fn with(of: &Transducer, circuit: &Fit, place: usize) -> Transducer {
    let (it, c0_f) = (circuit.resonances[place], circuit.c0_f());
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

    /// The resonance as a scan has identified it, so many hertz off.
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

    /// Seventeen points to 2.5 bandwidths beside the resonance, beside 300 nF, a ten-thousandth of the conductance off to changing sides.
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
    fn a_resonance_alone_is_left_as_identified() {
        let of = identified(1.0);
        let resolved = resolve(&points(&[]), &of, false).unwrap();
        assert_eq!((resolved.transducer, resolved.resonances), (of, 1));
        assert!(resolved.distance < 2e-4, "{resolved:?}");
    }

    #[test]
    fn a_neighbour_within_a_bandwidth_is_taken_off() {
        for hz in [40.4e3, 40.8e3, 39.4e3] {
            let neighbour = Branch { hz, q: 70.0, siemens: 0.06 };
            let resolved = resolve(&points(&[neighbour]), &identified(60.0), false).unwrap();
            assert_eq!(resolved.resonances, 2, "{hz}");
            let it = resolved.transducer;
            assert!((f64::from(it.series_resonance_hz) - MAIN.hz).abs() < 4.0, "{hz}: {it:?}");
            assert!((f64::from(it.cm_f) / MAIN.cm_f() - 1.0).abs() < 0.03, "{hz}: {it:?}");
        }
    }

    #[test]
    fn what_cannot_be_told_is_refused_by_name() {
        let alike = Branch { hz: 40.6e3, q: 50.0, siemens: 0.27 };
        let error = |points: &[Point]| resolve(points, &identified(0.0), false).unwrap_err().to_string();
        assert!(error(&points(&[alike])).contains("of its strength is at"), "{}", error(&points(&[alike])));
        let mut crooked = points(&[]);
        crooked.iter_mut().step_by(3).for_each(|point| point.siemens *= 1.02);
        assert!(error(&crooked).contains("off that of a circuit of"), "{}", error(&crooked));
        assert!(error(&crooked[..2]).contains("cannot be fitted"), "{}", error(&crooked[..2]));
    }
}
