//! Search for the modes of a transducer: scans of all windows, then a closer scan of each mode.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use firmware::seam::fault::Fault;
use firmware::seam::transducer::{MOST_MODES, Resonance, Transducer};

use super::band::{Band, Window};
use super::board_settings::BoardSettings;
use super::limits::Bounds;
use super::load::Load;
use super::probe::{self, Scanned};
use crate::link_error::LinkError;
use crate::session::Session;

/// Nominal quality factors of the passes. A scan finds a resonance with a Q within a factor of
/// about four of the nominal one.
const NOMINAL_QS: [f32; 3] = [160.0, 20.0, 1500.0];
/// Current of the clamped capacitance in the first scan, relative to the limit.
const CAPACITIVE_CURRENT_REL: f64 = 0.02;
/// Minimum current of the clamped capacitance in the first scan, codes.
const MIN_CAPACITIVE_CODES: f64 = 24.0;
/// Ratio of the voltages of two successive levels.
const LEVEL_RATIO: f64 = 4.0;
/// Current expected in a closer scan, relative to the limit.
const EXPECTED_CURRENT_REL: f64 = 0.5;
/// Half-width of a closer scan, bandwidths.
const CLOSE_BANDWIDTHS: f64 = 4.0;
/// Minimum half-width of a closer scan, relative to the frequency.
const MIN_CLOSE_REL: f64 = 0.01;
/// Maximum half-width of a closer scan, relative to the frequency.
const MAX_CLOSE_REL: f64 = 0.15;
/// Distance below which two resonances are the same: in bandwidths, or relative to the frequency.
const SAME_MODE_DISTANCE: (f64, f64) = (0.5, 5e-4);
/// Smallest motional capacitance for a closer scan, relative to the largest one.
const MIN_STRENGTH_REL: f64 = 3e-3;
/// Distance above which the result of a closer scan is another resonance: in bandwidths, or
/// relative to the frequency.
const OTHER_MODE_DISTANCE: (f64, f64) = (1.0, 2e-3);
/// Smallest clamped capacitance of a transducer, F. A resonance may falsify the value of the tones.
const MIN_CAPACITANCE_F: f64 = 0.1e-9;
/// Largest clamped capacitance of a transducer, F.
const MAX_CAPACITANCE_F: f64 = 20e-6;
/// Factor of the nominal capacitance after the self-test has found too much or too little current;
/// it accepts a range of 24.
const CAPACITANCE_STEP: f64 = 12.0;
/// Maximum number of these steps for a window.
const MAX_CAPACITANCE_STEPS: u32 = 2;
/// Motional inductances that the settings of the board accept, H.
const LM_H: RangeInclusive<f32> = 1e-9..=1e4;
/// Largest distance of a mode outside the band, bandwidths.
const BAND_MARGIN_BANDWIDTHS: f64 = 0.1;
/// Largest distance of a resonance outside the band before its closer scan, relative.
const ROUGH_MARGIN_REL: f64 = 0.005;
/// Largest distance of a resonance from the middle of the window that has found it, relative.
const NEAR_REL: f64 = 0.25;

/// Mode as identified by a closer scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// Identified transducer.
    pub transducer: Transducer,
    /// Peak voltage of the scan, V.
    pub volts: f64,
}

impl Mode {
    /// Returns the series resonance frequency, Hz.
    pub fn hz(&self) -> f64 {
        self.transducer.series_resonance_hz.into()
    }

    /// Returns the motional capacitance, F, a measure of the mode's strength that is independent of
    /// its damping.
    pub fn strength(&self) -> f64 {
        self.transducer.cm_f.into()
    }
}

/// Result of the search.
#[derive(Clone, Debug, Default)]
pub struct Search {
    /// Modes in the band, in ascending order of frequency.
    pub modes: Vec<Mode>,
    /// Strongest mode next to the band, if there is none inside.
    pub outside: Option<Mode>,
    /// Last fault that prevented the scan of a window.
    pub fault: Option<Fault>,
}

/// Returns the motional capacitance of a resonance, F.
fn cm_f(resonance: &Resonance) -> f64 {
    1.0 / ((TAU * f64::from(resonance.hz)).powi(2) * f64::from(resonance.lm_h))
}

/// Returns the larger of a number of bandwidths and a fraction of the frequency, Hz.
fn beyond_hz((bandwidths, part): (f64, f64), hz: f64, q: f64) -> f64 {
    (bandwidths * hz / q).max(part * hz)
}

/// Returns `true` if a frequency is in a band, with a relative margin.
fn is_in(band: &Band, hz: f64, margin_rel: f64) -> bool {
    hz * (1.0 + margin_rel) > band.low_hz && hz * (1.0 - margin_rel) < band.high_hz
}

/// Finds the modes of a band.
pub fn find(
    band: &Band,
    load: &Load,
    bounds: &Bounds,
    board: &mut BoardSettings,
    session: &mut Session,
) -> Result<Search, LinkError> {
    let code_a = session.scale()?.ampere_per_lsb;
    let capacitive_a = (CAPACITIVE_CURRENT_REL * bounds.amperes).max(MIN_CAPACITIVE_CODES * code_a);
    let siemens = (TAU * band.high_hz * load.capacitance_f).abs().max(1e-9);
    let mut volts = (capacitive_a / siemens).clamp(bounds.first_v, bounds.volts);
    let mut most_v = bounds.volts;
    let mut search = Search::default();
    loop {
        for q in NOMINAL_QS {
            let swept = sweep(band, load, volts, q, bounds, board, session)?;
            if swept.volts < volts {
                // A voltage that drew too much current is not tried again.
                (volts, most_v) = (swept.volts, swept.volts);
            }
            search.fault = swept.fault;
            // One confirmed resonance outside the band is enough.
            let near = search.outside.is_none().then_some(&swept.outside);
            for rough in [Some(&swept.inside), near].into_iter().flatten() {
                let modes = scan_closely(rough, volts, load, bounds, board, session)?;
                let margin_rel = |mode: &Mode| BAND_MARGIN_BANDWIDTHS / f64::from(mode.transducer.q);
                let (inside, outside): (Vec<Mode>, Vec<Mode>) =
                    modes.into_iter().partition(|mode| is_in(band, mode.hz(), margin_rel(mode)));
                if !inside.is_empty() {
                    return Ok(Search { modes: inside, ..search });
                }
                search.outside = search.outside.into_iter().chain(outside).max_by(|a, b| a.strength().total_cmp(&b.strength()));
            }
        }
        if volts >= most_v {
            return Ok(search);
        }
        volts = (LEVEL_RATIO * volts).min(most_v);
    }
}

/// Result of the scans of all windows.
#[derive(Clone, Debug, Default)]
struct Swept {
    /// Resonances in the band, strongest first.
    inside: Vec<Resonance>,
    /// Resonances near the band, strongest first.
    outside: Vec<Resonance>,
    /// Peak voltage, V, reduced if the current was too large.
    volts: f64,
    /// Last fault that prevented a scan.
    fault: Option<Fault>,
}

/// Scans all windows of the band.
fn sweep(
    band: &Band,
    load: &Load,
    volts: f64,
    q: f32,
    bounds: &Bounds,
    board: &mut BoardSettings,
    session: &mut Session,
) -> Result<Swept, LinkError> {
    let mut swept = Swept { volts, ..Swept::default() };
    for window in band.windows() {
        let volts = swept.volts;
        session.live.stage(&format!("scan at {:.0} Hz +- {:.1} %, with {volts:.3} V", window.hz, 100.0 * window.span));
        let (scanned, reduced_v) = scan_within_limits(&window, volts, (q, None), load, bounds, board, session)?;
        swept.volts = reduced_v;
        swept.fault = scanned.fault.filter(|fault| !matches!(fault, Fault::NoResonance | Fault::WrongMode)).or(swept.fault);
        for resonance in scanned.found.found.into_iter().flatten() {
            let (hz, q) = (f64::from(resonance.hz), f64::from(resonance.q));
            let list = if is_in(band, hz, ROUGH_MARGIN_REL) { &mut swept.inside } else { &mut swept.outside };
            let known = list.iter().any(|other| (f64::from(other.hz) - hz).abs() < beyond_hz(SAME_MODE_DISTANCE, hz, q));
            let is_near = (hz / window.hz - 1.0).abs() < NEAR_REL;
            let is_plausible = LM_H.contains(&resonance.lm_h) && resonance.q > 0.5;
            if is_near && !known && is_plausible {
                list.push(resonance);
            }
        }
    }
    for list in [&mut swept.inside, &mut swept.outside] {
        list.sort_by(|a, b| cm_f(b).total_cmp(&cm_f(a)));
    }
    Ok(swept)
}

/// Scans each of the strongest resonances again, in a narrow window.
fn scan_closely(
    rough: &[Resonance],
    volts: f64,
    load: &Load,
    bounds: &Bounds,
    board: &mut BoardSettings,
    session: &mut Session,
) -> Result<Vec<Mode>, LinkError> {
    let mut modes: Vec<Mode> = Vec::new();
    let strongest = rough.first().map_or(0.0, cm_f);
    for resonance in rough.iter().filter(|resonance| cm_f(resonance) > MIN_STRENGTH_REL * strongest).take(MOST_MODES) {
        let hz = f64::from(resonance.hz);
        session.live.stage(&format!("closer scan at {hz:.0} Hz"));
        let window = Window { hz, span: (CLOSE_BANDWIDTHS / f64::from(resonance.q)).clamp(MIN_CLOSE_REL, MAX_CLOSE_REL) };
        let siemens = f64::from(resonance.conductance_s) + TAU * hz * load.capacitance_f.abs();
        let expected_v = (EXPECTED_CURRENT_REL * bounds.amperes / siemens).clamp(volts.min(bounds.first_v), bounds.volts);
        let nominal = (resonance.q.clamp(2.0, 1e5), Some(resonance.lm_h));
        let (scanned, at_v) = scan_within_limits(&window, expected_v, nominal, load, bounds, board, session)?;
        let Some(transducer) = scanned.transducer else { continue };
        let (found_hz, q) = (f64::from(transducer.series_resonance_hz), f64::from(transducer.q));
        let moved = (found_hz - hz).abs() >= beyond_hz(OTHER_MODE_DISTANCE, hz, f64::from(resonance.q));
        let again = modes.iter().any(|mode| (mode.hz() - found_hz).abs() < beyond_hz(SAME_MODE_DISTANCE, found_hz, q));
        if !moved && !again {
            modes.push(Mode { transducer, volts: at_v });
        }
    }
    let known = modes.clone();
    for mode in modes.iter_mut().filter(|mode| mode.transducer.c0_f <= 0.0) {
        subtract_others(mode, &known);
    }
    modes.retain(|mode| mode.transducer.c0_f > 0.0);
    modes.sort_by(|a, b| a.hz().total_cmp(&b.hz()));
    Ok(modes)
}

/// Subtracts the other modes from the clamped capacitance of a mode. Another mode acts at it as a
/// capacitor of `Cm / (1 - (f / fk)^2)`, a negative one above its resonance `fk`, which may be
/// larger.
fn subtract_others(mode: &mut Mode, known: &[Mode]) {
    let hz = mode.hz();
    let others = known.iter().filter(|other| other.hz() != hz);
    let others_f: f64 = others.map(|other| other.strength() / (1.0 - (hz / other.hz()).powi(2))).sum();
    let it = &mut mode.transducer;
    it.c0_f -= others_f as f32;
    it.coupling = (it.cm_f / (it.c0_f + it.cm_f)).sqrt();
    it.parallel_resonance_hz = it.series_resonance_hz * (1.0 + it.cm_f / it.c0_f).sqrt();
}

/// Scans a window. The voltage is reduced while the current is too large, and the window is shifted
/// if the tone of the self-test meets a resonance.
fn scan_within_limits(
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
    let needs_c0 = !board.can_be_none("tracking.nominal_c0_f");
    let mut c0_f = load.capacitance_f.clamp(MIN_CAPACITANCE_F, MAX_CAPACITANCE_F);
    // The tones measure the capacitance roughly if a resonance rings.
    let mut capacitance_steps = 0..MAX_CAPACITANCE_STEPS;
    loop {
        let lm = lm_h.or(board.can_be_none("tracking.nominal_lm_h").then_some(f32::INFINITY));
        let mut settings = bounds.settings();
        settings.extend([
            ("drive.frequency_hz", window.hz as f32),
            ("drive.amplitude_v", volts as f32),
            ("drive.scan_volts", volts as f32),
            ("tracking.mode", 1.0),
            ("tracking.span", window.span as f32),
            ("tracking.nominal_q", q),
            ("tracking.nominal_c0_f", if needs_c0 { c0_f as f32 } else { f32::INFINITY }),
        ]);
        settings.extend(lm.map(|lm_h| ("tracking.nominal_lm_h", lm_h)));
        board.apply(&settings, session)?;
        let scanned = probe::scan(session)?;
        match scanned.fault {
            Some(Fault::OverCurrent | Fault::SenseSaturated) if volts > bounds.min_v => {
                volts = (volts / LEVEL_RATIO).max(bounds.min_v);
            }
            Some(fault @ (Fault::LoadOpen | Fault::LoadShorted)) if needs_c0 && capacitance_steps.next().is_some() => {
                c0_f *= if fault == Fault::LoadOpen { 1.0 / CAPACITANCE_STEP } else { CAPACITANCE_STEP };
                c0_f = c0_f.clamp(MIN_CAPACITANCE_F, MAX_CAPACITANCE_F);
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
