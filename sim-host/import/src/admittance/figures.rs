//! Figures of a fitted admittance: magnitude and phase over frequency, the circle, the residuals.

use num_complex::Complex64;

use super::coordinate::Coordinate;
use super::result::Admittance;
use crate::complex::{angle, size};
use crate::thinned::thinned;
use report::statistics::ascending;
use report::{Axis, Figure, Marker, Series, Style};

/// Number of points of the fitted curve around each resonance, less one.
const RESONANCE_STEPS: i32 = 240;

/// Returns all figures.
pub(super) fn figures(found: &Admittance) -> Vec<Figure> {
    let hz = frequencies(found);
    let fitted: Vec<Complex64> = hz.iter().map(|hz| found.equivalent.admittance(*hz)).collect();
    let fit = (hz.as_slice(), fitted.as_slice());
    let all = vec![
        over_frequency(found, fit, ("admittance-size", "Admittance: magnitude", "|Y| [S]", "admittance"), "s", true, size),
        over_frequency(found, fit, ("admittance-phase", "Admittance: phase", "phase [deg]", "phase"), "deg", false, |y| {
            angle(y).to_degrees()
        }),
        circle(found, &fitted),
        residuals(found),
    ];
    all.into_iter().map(thinned).collect()
}

/// Returns the frequencies of the fitted curve: those of the sweep, and more around each resonance
/// in equal steps of its phase.
fn frequencies(found: &Admittance) -> Vec<f64> {
    let measured = &found.measured.hz;
    let (from, to) = (measured[0], measured[measured.len() - 1]);
    let mut hz = measured.clone();
    for branch in &found.equivalent.branches {
        let about = (-RESONANCE_STEPS / 2..=RESONANCE_STEPS / 2).map(|n| {
            let phase = std::f64::consts::FRAC_PI_2 * f64::from(n) / (f64::from(RESONANCE_STEPS) / 2.0 + 3.0);
            branch.hz * (1.0 + libm::tan(phase) / (2.0 * branch.q))
        });
        hz.extend(about.filter(|hz| (from..=to).contains(hz)));
    }
    ascending(hz)
}

fn axis(label: &str) -> Axis {
    Axis { label: label.into(), ..Axis::default() }
}

fn khz(hz: &[f64]) -> Vec<f64> {
    hz.iter().map(|hz| 1e-3 * hz).collect()
}

fn over_frequency(
    found: &Admittance,
    (hz, fitted): (&[f64], &[Complex64]),
    (id, title, label, column): (&str, &str, &str, &str),
    unit: &str,
    log: bool,
    of: impl Fn(Complex64) -> f64,
) -> Figure {
    let series = |name: &str, x: Vec<f64>, y: &[Complex64], style| Series {
        name: name.into(),
        csv_column: format!("{column}_{name}_{unit}"),
        x,
        y: y.iter().map(|y| of(*y)).collect(),
        style,
    };
    Figure {
        id: id.into(),
        title: title.into(),
        caption: "Dots: measured, after the correction of the fixture if one is given. Line: fitted circuit.".into(),
        x: axis("frequency [kHz]"),
        y: Axis { label: label.into(), log, ..Axis::default() },
        series: vec![
            series("measured", khz(&found.measured.hz), &found.measured.admittance, Style::Points),
            series("fitted", khz(hz), fitted, Style::Line),
        ],
        ..Figure::default()
    }
}

fn circle(found: &Admittance, fitted: &[Complex64]) -> Figure {
    let series = |name: &str, y: &[Complex64], style| Series {
        name: name.into(),
        csv_column: format!("susceptance_{name}_s"),
        x: y.iter().map(|y| y.re).collect(),
        y: y.iter().map(|y| y.im).collect(),
        style,
    };
    let at = |hz: f64, label: &str| {
        let y = found.equivalent.admittance(hz);
        Marker { x: y.re, y: y.im, label: label.into() }
    };
    let circuit = &found.circuit;
    Figure {
        id: "admittance-circle".into(),
        title: "Admittance circle".into(),
        caption: "A resonance is a circle with the diameter 1 / Rm, shifted up by the clamped capacitance. A second loop is a \
                  second resonance."
            .into(),
        x: axis("conductance [S]"),
        y: axis("susceptance [S]"),
        series: vec![series("measured", &found.measured.admittance, Style::Points), series("fitted", fitted, Style::Line)],
        markers: vec![at(circuit.series_resonance_hz.value, "series resonance")],
        equal_aspect: true,
        ..Figure::default()
    }
}

fn residuals(found: &Admittance) -> Figure {
    let names = match found.measured.coordinate {
        Coordinate::Scattering(..) => ["real part", "imaginary part"],
        Coordinate::Immittance => ["size", "angle"],
    };
    let series = |at: usize, of: fn(&Complex64) -> f64| Series {
        name: names[at].into(),
        csv_column: format!("residual_{}_sd", names[at].replace(' ', "_")),
        x: khz(&found.measured.hz),
        y: found.residuals.iter().map(of).collect(),
        style: Style::Points,
    };
    Figure {
        id: "residuals".into(),
        title: "Residuals of the fit".into(),
        caption: "Fitted minus measured, in standard deviations of the noise. If the circuit fits, the points are scattered \
                  between -3 and 3. A wave around the resonance is an effect that the circuit does not contain."
            .into(),
        x: axis("frequency [kHz]"),
        y: axis("residual [standard deviations]"),
        series: vec![series(0, |e| e.re), series(1, |e| e.im)],
        hlines: vec![(-2.0, String::new()), (2.0, "2 sd".into())],
        ..Figure::default()
    }
}
