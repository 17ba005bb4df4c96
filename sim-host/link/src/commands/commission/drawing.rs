//! Drawing of the result: magnitude of the admittance over the band, with the measured tones.

use import::admittance::circuit::{Branch, Equivalent};
use realfft::num_complex::Complex64;

use super::Commissioned;
use super::modes::Mode;
use crate::terminal_plot::TerminalPlot;
use report::statistics::ascending;

/// Number of points of the line over the band, less one.
const BAND_STEPS: usize = 600;
/// Number of additional points around each mode, less one.
const MODE_STEPS: usize = 100;

/// Returns the admittance of the identified circuit, S.
pub fn admittance(found: &Commissioned, hz: f64) -> Complex64 {
    let branch = |mode: &Mode| {
        let it = &mode.transducer;
        Branch { hz: it.series_resonance_hz.into(), q: it.q.into(), siemens: 1.0 / f64::from(it.rm_ohm) }
    };
    let c0_f = found.proposal.transducer.c0_f.into();
    Equivalent { c0_f, loss_tangent: 0.0, branches: found.modes.iter().map(branch).collect() }.admittance(hz)
}

/// Returns frequencies over the band, denser around the modes, Hz.
pub fn places(found: &Commissioned) -> Vec<f64> {
    let band = &found.band;
    let even = (0..=BAND_STEPS).map(|n| band.low_hz + (band.high_hz - band.low_hz) * n as f64 / BAND_STEPS as f64);
    let dense = found.modes.iter().flat_map(|mode| {
        let width_hz = mode.hz() / f64::from(mode.transducer.q);
        (0..=MODE_STEPS).map(move |n| mode.hz() + width_hz * (6.0 * n as f64 / MODE_STEPS as f64 - 3.0))
    });
    ascending(even.chain(dense).filter(|hz| (band.low_hz..=band.high_hz).contains(hz)))
}

/// Draws the admittance in characters.
pub fn in_terminal(found: &Commissioned) -> String {
    let mut plot = TerminalPlot::new("kHz", "|Y| [dB over 1 S]").stretched();
    let decibels = |y: Complex64| 20.0 * y.norm().log10();
    plot.line(places(found).into_iter().map(|hz| (1e-3 * hz, decibels(admittance(found, hz)))));
    plot.marks(found.load.tones.iter().map(|tone| (1e-3 * tone.hz, decibels(tone.siemens))));
    plot.drawn()
}
