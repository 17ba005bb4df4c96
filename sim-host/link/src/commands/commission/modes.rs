//! The modes of a transducer: found window by window, then each looked at again closely.

use std::f64::consts::TAU;

use firmware::seam::fault::Fault;
use firmware::seam::transducer::{MOST_MODES, Resonance, Transducer};

use super::band::{Band, Window};
use super::board_settings::BoardSettings;
use super::limits::Bounds;
use super::probe::{self, Scanned};
use super::tones::Load;
use crate::link_error::LinkError;
use crate::session::Session;

/// Nominal quality factors of the passes: a scan finds a resonance whose Q is within a factor of about four of it.
const PASSES: [f32; 3] = [160.0, 20.0, 1500.0];
/// Current that the clamped capacitance draws in the first scan: part of the limit, and codes at least.
const CAPACITIVE: (f64, f64) = (0.02, 24.0);
/// From one level to the next.
const STEP: f64 = 4.0;
/// Part of the current limit that is expected in a closer look.
const EXPECTED: f64 = 0.5;
/// Bandwidths from the middle of a closer look to its ends, and its least and its largest span.
const CLOSE: (f64, f64, f64) = (4.0, 0.01, 0.15);
/// Resonances nearer than this part of a bandwidth, or of their frequency, are one.
const SAME: (f64, f64) = (0.5, 5e-4);
/// Modes with less than this part of the largest strength are not looked at again.
const WEAKEST: f64 = 3e-3;
/// A resonance that a closer look finds beyond so many bandwidths, or so much of its frequency, is another one.
const MOVED: (f64, f64) = (1.0, 2e-3);
/// Clamped capacitances that transducers have, F: a resonance may make the tones look like another one.
const CAPACITANCES_F: (f64, f64) = (0.1e-9, 20e-6);
/// How far beyond the band a mode may be, relative.
const EDGE: f64 = 0.005;

/// A mode that was looked at closely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// The mode as identified.
    pub transducer: Transducer,
    /// Peak voltage of the scan, V.
    pub volts: f64,
}

impl Mode {
    /// Series resonance, Hz.
    pub fn hz(&self) -> f64 {
        self.transducer.series_resonance_hz.into()
    }

    /// Motional capacitance, F: how strong the mode is, whatever damps it.
    pub fn strength(&self) -> f64 {
        self.transducer.cm_f.into()
    }
}

/// Motional capacitance of a resonance, F.
fn cm_f(resonance: &Resonance) -> f64 {
    1.0 / ((TAU * f64::from(resonance.hz)).powi(2) * f64::from(resonance.lm_h))
}

/// The larger of a part of the bandwidth and a part of the frequency, Hz.
fn beyond_hz((bandwidths, part): (f64, f64), hz: f64, q: f64) -> f64 {
    (bandwidths * hz / q).max(part * hz)
}

/// Whether a resonance belongs to a band.
fn is_in(band: &Band, hz: f64) -> bool {
    hz > band.low_hz * (1.0 - EDGE) && hz < band.high_hz * (1.0 + EDGE)
}

/// Finds the modes of a band, at rising frequencies.
pub fn find(
    band: &Band,
    load: &Load,
    bounds: &Bounds,
    board: &mut BoardSettings,
    session: &mut Session,
) -> Result<Vec<Mode>, LinkError> {
    let code_a = session.scale()?.ampere_per_lsb;
    let capacitive_a = (CAPACITIVE.0 * bounds.amperes).max(CAPACITIVE.1 * code_a);
    let siemens = (TAU * band.high_hz * load.capacitance_f).abs().max(1e-9);
    let mut volts = (capacitive_a / siemens).clamp(bounds.least_v, bounds.volts);
    let mut most_v = bounds.volts;
    loop {
        for q in PASSES {
            let (rough, quieter_v) = sweep(band, load, volts, q, bounds, board, session)?;
            if quieter_v < volts {
                // What was too loud once is not tried again.
                (volts, most_v) = (quieter_v, quieter_v);
            }
            let modes = look_closely(&rough, volts, band, load, bounds, board, session)?;
            if !modes.is_empty() {
                return Ok(modes);
            }
        }
        if volts >= most_v {
            return Ok(Vec::new());
        }
        volts = (STEP * volts).min(most_v);
    }
}

/// Scans all windows of the band. Gives what was found, strongest first, and the voltage that was left after what drew too much current.
fn sweep(
    band: &Band,
    load: &Load,
    volts: f64,
    q: f32,
    bounds: &Bounds,
    board: &mut BoardSettings,
    session: &mut Session,
) -> Result<(Vec<Resonance>, f64), LinkError> {
    let mut volts = volts;
    let mut found: Vec<Resonance> = Vec::new();
    for window in band.windows() {
        session.live.stage(&format!("scan of {:.0} Hz, {:.1} % to each side, at {volts:.3} V", window.hz, 100.0 * window.span));
        let (scanned, quieter_v) = scan_quieter(&window, volts, (q, None), load, bounds, board, session)?;
        volts = quieter_v;
        for resonance in scanned.found.found.into_iter().flatten() {
            let (hz, q) = (f64::from(resonance.hz), f64::from(resonance.q));
            let known = found.iter().any(|other| (f64::from(other.hz) - hz).abs() < beyond_hz(SAME, hz, q));
            if is_in(band, hz) && !known && resonance.lm_h > 0.0 && resonance.q > 0.5 {
                found.push(resonance);
            }
        }
    }
    found.sort_by(|a, b| cm_f(b).total_cmp(&cm_f(a)));
    Ok((found, volts))
}

/// Looks at the strongest ones again, each alone.
fn look_closely(
    rough: &[Resonance],
    volts: f64,
    band: &Band,
    load: &Load,
    bounds: &Bounds,
    board: &mut BoardSettings,
    session: &mut Session,
) -> Result<Vec<Mode>, LinkError> {
    let mut modes: Vec<Mode> = Vec::new();
    let strongest = rough.first().map_or(0.0, cm_f);
    for resonance in rough.iter().filter(|resonance| cm_f(resonance) > WEAKEST * strongest).take(MOST_MODES) {
        let hz = f64::from(resonance.hz);
        session.live.stage(&format!("a closer look at {hz:.0} Hz"));
        let window = Window { hz, span: (CLOSE.0 / f64::from(resonance.q)).clamp(CLOSE.1, CLOSE.2) };
        let siemens = f64::from(resonance.conductance_s) + TAU * hz * load.capacitance_f.abs();
        let loud_v = (EXPECTED * bounds.amperes / siemens).clamp(volts.min(bounds.least_v), bounds.volts);
        let told = (resonance.q.clamp(2.0, 1e5), Some(resonance.lm_h));
        let (scanned, at_v) = scan_quieter(&window, loud_v, told, load, bounds, board, session)?;
        let Some(transducer) = scanned.transducer else { continue };
        let (found_hz, q) = (f64::from(transducer.series_resonance_hz), f64::from(transducer.q));
        let moved = (found_hz - hz).abs() >= beyond_hz(MOVED, hz, f64::from(resonance.q));
        let again = modes.iter().any(|mode| (mode.hz() - found_hz).abs() < beyond_hz(SAME, found_hz, q));
        if !moved && !again && is_in(band, found_hz) && transducer.c0_f > 0.0 {
            modes.push(Mode { transducer, volts: at_v });
        }
    }
    modes.sort_by(|a, b| a.hz().total_cmp(&b.hz()));
    Ok(modes)
}

/// Scans a window, at less voltage as often as the current is too much, and beside it where the self-test's tone meets a resonance.
fn scan_quieter(
    window: &Window,
    volts: f64,
    (q, lm_h): (f32, Option<f32>),
    load: &Load,
    bounds: &Bounds,
    board: &mut BoardSettings,
    session: &mut Session,
) -> Result<(Scanned, f64), LinkError> {
    let mut volts = volts;
    let mut window = *window;
    let mut shifts = [0.03, -0.06, 0.09].into_iter();
    loop {
        let c0_f = if board.can_be_none("tracking.nominal_c0_f") {
            f32::INFINITY
        } else {
            load.capacitance_f.clamp(CAPACITANCES_F.0, CAPACITANCES_F.1) as f32
        };
        let lm = lm_h.or(board.can_be_none("tracking.nominal_lm_h").then_some(f32::INFINITY));
        let mut settings = bounds.settings();
        settings.extend([
            ("drive.frequency_hz", window.hz as f32),
            ("drive.amplitude_v", volts as f32),
            ("drive.scan_volts", volts as f32),
            ("tracking.mode", 1.0),
            ("tracking.span", window.span as f32),
            ("tracking.nominal_q", q),
            ("tracking.nominal_c0_f", c0_f),
        ]);
        settings.extend(lm.map(|lm_h| ("tracking.nominal_lm_h", lm_h)));
        board.apply(&settings, session)?;
        let scanned = probe::scan(session)?;
        match scanned.fault {
            Some(Fault::OverCurrent | Fault::SenseSaturated) if volts > bounds.quietest_v => {
                volts = (volts / STEP).max(bounds.quietest_v);
            }
            Some(fault) if probe::is_of_self_test(fault) => match shifts.next() {
                Some(shift) => {
                    let span = (window.span + f64::abs(shift)).min(0.2);
                    window = Window { hz: window.hz * (1.0 + shift), span };
                }
                None => return Ok((scanned, volts)),
            },
            _ => return Ok((scanned, volts)),
        }
    }
}
