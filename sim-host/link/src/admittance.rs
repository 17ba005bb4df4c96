//! Admittance loop of a transducer: of the identified circuit, and as measured.
//!
//! ```text
//! Y(f) = j 2 pi f C0 + sum over resonances of  G / (1 + j Q (f / fs - fs / f))
//! ```

use std::time::Duration;

use firmware::board::command::{Command, ResonanceReport};
use firmware::seam::block::Gate;
use firmware::seam::fault::Limit;
use firmware::seam::mode::Mode;
use firmware::seam::transducer::{Resonance, Transducer};
use firmware::seam::units::Hertz;
use import::admittance::circuit::{Branch, Equivalent};
use realfft::num_complex::Complex64;

use crate::answer::Answer;
use crate::commands::lock::{LockArgs, acquire};
use crate::files::ResultFolder;
use crate::link_error::LinkError;
use crate::session::Session;
use crate::terminal_plot::TerminalPlot;
use report::{self, Along, Axis, Figure, Marker, Report, Series, Style};
use sim::provenance::Provenance;

/// Number of points of a drawn loop, less one.
const LOOP_STEPS: usize = 400;
/// Settling time of a measured point, ring-up time constants.
const SETTLE_TIME_CONSTANTS: f64 = 12.0;
/// Minimum settling time of a measured point, s.
const MIN_SETTLE_S: f64 = 2e-3;

/// Converts a resonance of a scan report.
pub fn branch(found: &Resonance) -> Branch {
    Branch { hz: found.hz.into(), q: found.q.into(), siemens: found.conductance_s.into() }
}

/// Returns the phase along curves of admittances over frequency.
pub fn phases(curves: &[&[(f64, Complex64)]]) -> Along {
    let phase = |curve: &&[(f64, Complex64)]| curve.iter().map(|(_, y)| y.arg().to_degrees()).collect();
    Along { csv_column: "phase_deg".into(), values: curves.iter().map(phase).collect() }
}

/// Admittance loop of a transducer.
#[derive(Clone, Debug)]
pub struct Loop {
    circuit: Equivalent,
    /// Resonance of the working mode, if a scan has chosen one.
    chosen: Option<Branch>,
    /// Measured frequencies, Hz, with the admittances there, S.
    pub measured: Vec<(f64, Complex64)>,
}

impl Loop {
    /// Creates the loop of a scan's result.
    pub fn from_scan(transducer: Option<&Transducer>, found: &ResonanceReport) -> Self {
        let branches = found.found.iter().flatten().map(branch).collect();
        let chosen = found.chosen.and_then(|place| found.found.get(usize::from(place))?.as_ref()).map(branch);
        let c0_f = transducer.map_or(0.0, |found| found.c0_f.into());
        Loop { circuit: Equivalent { c0_f, loss_tangent: 0.0, branches }, chosen, measured: Vec::new() }
    }

    /// Returns frequencies that show the loop, Hz, denser near the resonance.
    fn places(&self) -> Vec<f64> {
        let Some(about) = &self.chosen else { return Vec::new() };
        let half_hz = about.hz / (2.0 * about.q);
        // Equal steps of the angle on the circle of the resonance.
        let angle = |n: usize| (n as f64 / LOOP_STEPS as f64 - 0.5) * std::f64::consts::PI * 0.97;
        (0..=LOOP_STEPS).map(|n| about.hz + half_hz * angle(n).tan()).collect()
    }

    /// Adds the largest distance of the measured points from the circuit, relative to the
    /// conductance of the resonance.
    pub fn compared(&self, answer: Answer) -> Answer {
        let (Some(about), false) = (&self.chosen, self.measured.is_empty()) else { return answer };
        let apart = |&(hz, y): &(f64, Complex64)| (y - self.circuit.admittance(hz)).norm() / about.siemens;
        let worst = self.measured.iter().map(apart).fold(0.0, f64::max);
        answer
            .line(format!(
                "{} points measured, {:.0} to {:.0} Hz; distance from the circuit at most {:.2} % of the loop's diameter",
                self.measured.len(),
                self.measured.iter().map(|(hz, _)| *hz).fold(f64::INFINITY, f64::min),
                self.measured.iter().map(|(hz, _)| *hz).fold(0.0, f64::max),
                100.0 * worst
            ))
            .field("points", self.measured.len())
            .field("worst_distance_percent", 100.0 * worst)
    }

    /// Draws the loop in characters: conductance to the right, susceptance upwards.
    pub fn in_terminal(&self) -> String {
        let places: Vec<Complex64> = self.places().into_iter().map(|hz| 1e3 * self.circuit.admittance(hz)).collect();
        if places.is_empty() {
            return "the scan has chosen no resonance: no loop is drawn".into();
        }
        let mut plot = TerminalPlot::new("G [mS]", "B [mS]");
        plot.line(places.iter().map(|y| (y.re, y.im)));
        plot.marks(self.measured.iter().map(|(_, y)| (1e3 * y.re, 1e3 * y.im)));
        plot.drawn()
    }

    /// Writes the loop as SVG, PNG and CSV.
    pub fn write(&self, folder: &ResultFolder, provenance: &Provenance) -> Result<(), LinkError> {
        let places = self.places();
        let drawn: Vec<(f64, Complex64)> = places.iter().map(|&hz| (hz, self.circuit.admittance(hz))).collect();
        let mut curves = vec![("identified circuit", "admittance_identified", Style::Line, &drawn[..])];
        if !self.measured.is_empty() {
            curves.push(("measured, settled", "admittance_measured", Style::Points, &self.measured[..]));
        }
        let series = |x: fn(&(f64, Complex64)) -> f64, y: fn(&(f64, Complex64)) -> f64| {
            let one = |(name, column, style, points): &(&str, &str, Style, &[(f64, Complex64)])| Series {
                name: (*name).into(),
                csv_column: (*column).into(),
                x: points.iter().map(x).collect(),
                y: points.iter().map(y).collect(),
                style: style.clone(),
            };
            curves.iter().map(one).collect()
        };
        let mark = |hz: f64, label: String| {
            let y = 1e3 * self.circuit.admittance(hz);
            Marker { x: y.re, y: y.im, label }
        };
        let markers = self.chosen.iter().map(|about| mark(about.hz, format!("f_s {:.1} Hz", about.hz))).collect();
        let points: Vec<&[(f64, Complex64)]> = curves.iter().map(|curve| curve.3).collect();
        let hz = points.iter().map(|points| points.iter().map(|(hz, _)| *hz).collect()).collect();
        let axis = |label: &str| Axis { label: label.into(), ..Axis::default() };
        let figures = vec![
            Figure {
                id: "admittance".into(),
                title: "Admittance loop".into(),
                x: axis("conductance [mS]"),
                y: axis("susceptance [mS]"),
                series: series(|(_, y)| 1e3 * y.re, |(_, y)| 1e3 * y.im),
                markers,
                along: Some(Along { csv_column: "frequency_hz".into(), values: hz }),
                equal_aspect: true,
                ..Figure::default()
            },
            Figure {
                id: "admittance_over_frequency".into(),
                title: "Admittance over frequency".into(),
                x: axis("frequency [kHz]"),
                y: Axis { log: true, ..axis("admittance [mS]") },
                series: series(|(hz, _)| 1e-3 * hz, |(_, y)| 1e3 * y.norm()),
                along: Some(phases(&points)),
                ..Figure::default()
            },
        ];
        let footer = provenance.footer();
        folder.report(&Report { title: "Scan".into(), figures, footer, ..Report::default() })
    }
}

/// Locks, drives at a number of offsets from the resonance, and measures the settled admittance at
/// each. Stops the drive at the end.
pub fn measure(points: u16, reach: f64, about: &Loop, session: &mut Session) -> Result<Vec<(f64, Complex64)>, LinkError> {
    let Some(resonance) = &about.chosen else { return Ok(Vec::new()) };
    let bandwidth_hz = resonance.hz / resonance.q;
    let settle_s = (SETTLE_TIME_CONSTANTS / (std::f64::consts::PI * bandwidth_hz)).max(MIN_SETTLE_S);
    session.client.order(Command::Gate(Gate::On))?;
    session.client.order(Command::Detune(Hertz(0.0)))?;
    acquire(&LockArgs::default(), session)?;
    let mut measured = Vec::new();
    for n in 0..points {
        let part = if points > 1 { 2.0 * f64::from(n) / f64::from(points - 1) - 1.0 } else { 0.0 };
        // Equal steps on the circle.
        let detune_hz = 0.5 * bandwidth_hz * (part * (2.0 * reach).atan()).tan();
        session.client.order(Command::Detune(Hertz(detune_hz as f32)))?;
        session.wait(Duration::from_secs_f64(settle_s))?;
        let report = session.status()?;
        session.check(&report)?;
        if report.mode != Mode::Run {
            return Err(LinkError::Failed("the run ended while the admittance was measured".into()));
        }
        if report.limit == Some(Limit::FrequencyWindow) {
            // Beyond the window, the point at its edge would be measured again and again.
            continue;
        }
        let complex = |x: firmware::seam::phasor::Phasor| Complex64::new(x.re.into(), x.im.into());
        measured.push((f64::from(report.frequency.0), complex(report.i) / complex(report.v)));
    }
    session.client.order(Command::Idle)?;
    session.mark_silent();
    session.client.order(Command::Detune(Hertz(0.0)))?;
    session.client.order(Command::Gate(Gate::Scheduled))?;
    Ok(measured)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one() -> Loop {
        let branch = Branch { hz: 40e3, q: 65.0, siemens: 0.325 };
        let circuit = Equivalent { c0_f: 300e-9, loss_tangent: 0.0, branches: vec![branch] };
        Loop { circuit, chosen: Some(branch), measured: Vec::new() }
    }

    #[test]
    fn the_drawn_loop_covers_most_of_its_circle() {
        let drawn = one();
        let middle = Complex64::new(0.1625, std::f64::consts::TAU * 40e3 * 300e-9);
        let radii: Vec<f64> = drawn.places().iter().map(|&hz| (drawn.circuit.admittance(hz) - middle).norm()).collect();
        // The susceptance of C0 increases with the frequency: 0.075 S next to a radius of 0.1625 S,
        // and over 1000 Hz by a fortieth of that.
        assert!(radii.iter().all(|radius| (radius / 0.1625 - 1.0).abs() < 0.2), "{radii:?}");
        assert!(drawn.in_terminal().lines().count() > 15);
    }
}
