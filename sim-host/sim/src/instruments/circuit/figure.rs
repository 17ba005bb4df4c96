//! Figures of the admittance, as a loop and over frequency: measured points of the scan, identified
//! circle, and working point of the drive.

use std::f64::consts::{FRAC_PI_2, TAU};

use firmware::seam::mode::Mode;

use crate::instruments::View;
use crate::instruments::curves::axis;
use crate::record::Row;
use plant::circuit::Circuit;
use plant::circuit_of;
use report::{Along, Axis, Figure, Marker, Panel, Series, Style};

/// Number of blocks over which the working point is averaged.
const WORKING_BLOCKS: usize = 1000;
/// Minimum margin of a Bode plot around the resonances, in half bandwidths.
const MARGIN_HALF_BANDWIDTHS: f64 = 12.0;
/// Number of equal frequency steps of a Bode plot.
const FREQUENCY_STEPS: u16 = 400;
/// Part of the caption that explains the dots.
const DOTS: &str = "Dots: blocks of the scan's last sweep. The stack does not settle during a sweep, so the dots deviate from \
                    the circle; more at higher Q. ";

/// Returns the admittance of a circuit, S, as conductance and susceptance.
fn admittance(circuit: &Circuit, hz: f64) -> (f64, f64) {
    let omega = TAU * hz;
    let reactance = omega * circuit.lm_h - 1.0 / (omega * circuit.cm_f);
    let square = circuit.rm_ohm.powi(2) + reactance.powi(2);
    (circuit.rm_ohm / square, omega * circuit.c0_f - reactance / square)
}

/// Returns frequencies about a resonance, Hz, in equal steps of the motional phase, which are equal
/// steps along the circle.
fn places(hz: f64, q: f64) -> impl Iterator<Item = f64> {
    let half_bandwidth = hz / (2.0 * q);
    (-199..200).map(move |n| hz + half_bandwidth * (FRAC_PI_2 * f64::from(n) / 205.0).tan())
}

/// Returns the admittance loop of a circuit, and the frequencies along it, Hz.
fn locus_of(circuit: &Circuit, name: &str, csv_column: &str, style: Style) -> (Series, Vec<f64>) {
    let frequencies: Vec<f64> = places(circuit.series_resonance_hz(), circuit.q()).collect();
    let (x, y) = frequencies.iter().map(|&hz| admittance(circuit, hz)).unzip();
    (Series { name: name.into(), csv_column: csv_column.into(), x, y, style }, frequencies)
}

/// Data of the figures of the admittance.
pub(super) struct Admittance {
    truth: Circuit,
    identified: Circuit,
    /// Frequency, Hz, and conductance and susceptance, S, of each tone of the scan's last sweep.
    measured: Vec<(f64, (f64, f64))>,
}

impl Admittance {
    /// Collects the data of a run; `None` if it has not identified its transducer.
    pub(super) fn from_run(run: &View) -> Option<Self> {
        let found = run.record.last.transducer?;
        let identified = Circuit {
            c0_f: found.c0_f.into(),
            cm_f: found.cm_f.into(),
            lm_h: found.lm_h.into(),
            rm_ohm: found.rm_ohm.into(),
            force_factor_n_per_v: 1.0,
        };
        Some(Admittance { truth: circuit_of(&run.scene), identified, measured: sweep_points(run.rows) })
    }
}

/// Returns the admittance loop.
pub(super) fn locus(run: &View, of: &Admittance) -> Figure {
    let mut curves = Vec::new();
    if !of.measured.is_empty() {
        let (x, y) = of.measured.iter().map(|&(_, y)| y).unzip();
        let name = "played, last sweep of the scan".into();
        let dots = Series { name, csv_column: "susceptance_measured_s".into(), x, y, style: Style::Points };
        curves.push((dots, of.measured.iter().map(|&(hz, _)| hz).collect()));
    }
    curves.push(locus_of(&of.truth, "true circuit", "susceptance_true_s", Style::Dashed));
    curves.push(locus_of(&of.identified, "identified circuit", "susceptance_identified_s", Style::Line));
    let (series, values) = curves.into_iter().unzip();
    let dots = if of.measured.is_empty() { "" } else { DOTS };
    let steady: Vec<(f64, f64)> = run.steady().filter_map(|row| row.admittance_s).collect();
    let last = &steady[steady.len().saturating_sub(WORKING_BLOCKS)..];
    let working = (!last.is_empty()).then(|| {
        let (g, b) = last.iter().fold((0.0, 0.0), |sum, y| (sum.0 + y.0, sum.1 + y.1));
        Marker { x: g / last.len() as f64, y: b / last.len() as f64, label: "working point".into() }
    });
    Figure {
        id: "admittance".into(),
        title: "Admittance loop".into(),
        caption: format!(
            "{dots}The identified circle includes the effect of the converters' images on the clamped capacitance. The working \
             point is the mean over the last steady blocks; a load and friction move it."
        ),
        x: axis("conductance [S]"),
        y: axis("susceptance [S]"),
        series,
        along: Some(Along { csv_column: "frequency_hz".into(), values }),
        markers: working.into_iter().collect(),
        equal_aspect: true,
        ..Figure::default()
    }
}

/// Returns the parallel resonance, Hz, of Lm with Cm and C0 in series.
fn parallel_hz(circuit: &Circuit) -> f64 {
    circuit.series_resonance_hz() * (1.0 + circuit.cm_f / circuit.c0_f).sqrt()
}

/// Returns the Bode plot: magnitude and phase of the admittance over frequency, about both
/// resonances.
pub(super) fn bode(of: &Admittance) -> Figure {
    let (series_hz, anti_hz) = (of.truth.series_resonance_hz(), parallel_hz(&of.truth));
    let half_bandwidth = series_hz / (2.0 * of.truth.q());
    let room = (MARGIN_HALF_BANDWIDTHS * half_bandwidth).max(0.5 * (anti_hz - series_hz));
    let (from, to) = (series_hz - room, anti_hz + room);
    let even = (0..=FREQUENCY_STEPS).map(|n| from + (to - from) * f64::from(n) / f64::from(FREQUENCY_STEPS));
    let both = [&of.truth, &of.identified].into_iter().flat_map(|circuit| {
        let about = |hz| places(hz, circuit.q());
        about(circuit.series_resonance_hz()).chain(about(parallel_hz(circuit)))
    });
    let measured = of.measured.iter().map(|&(hz, _)| hz);
    let mut frequencies: Vec<f64> = even.chain(both).chain(measured).filter(|hz| (from..=to).contains(hz)).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup();
    let none = (f64::NAN, f64::NAN);
    let tone = |hz: f64| of.measured.iter().find(|&&(tone, _)| tone == hz).map_or(none, |&(_, y)| y);
    let (mut magnitudes, mut phases) = (Vec::new(), Vec::new());
    let mut curve = |name: &str, column: &str, style: Style, values: Vec<(f64, f64)>| {
        let series = |csv_column: String, y: Vec<f64>, name: &str| Series {
            name: name.into(),
            csv_column,
            x: frequencies.clone(),
            y,
            style: style.clone(),
        };
        magnitudes.push(series(format!("admittance_{column}_s"), values.iter().map(|(g, b)| g.hypot(*b)).collect(), name));
        let degrees = values.iter().map(|(g, b)| b.atan2(*g).to_degrees()).collect();
        phases.push(series(format!("phase_{column}_deg"), degrees, name));
    };
    if of.measured.iter().any(|(hz, _)| (from..=to).contains(hz)) {
        curve("played, last sweep of the scan", "measured", Style::Points, frequencies.iter().map(|&hz| tone(hz)).collect());
    }
    for (circuit, name, column, style) in
        [(&of.truth, "true circuit", "true", Style::Dashed), (&of.identified, "identified circuit", "identified", Style::Line)]
    {
        curve(name, column, style, frequencies.iter().map(|&hz| admittance(circuit, hz)).collect());
    }
    Figure {
        id: "admittance-bode".into(),
        title: "Admittance over frequency (Bode plot)".into(),
        caption: "Magnitude and phase of the admittance about its series and its parallel resonance. The admittance loop shows \
                  the same values as conductance and susceptance."
            .into(),
        x: axis("frequency [Hz]"),
        y: Axis { log: true, ..axis("magnitude [S]") },
        series: magnitudes,
        panels: vec![Panel {
            y: Axis { range: Some((-100.0, 100.0)), ..axis("phase [°]") },
            series: phases,
            repeats: true,
            hlines: vec![(0.0, String::new())],
        }],
        interactive: true,
        ..Figure::default()
    }
}

/// Returns frequency, Hz, and current over voltage, S, of each tone of the scan's last sweep.
fn sweep_points(rows: &[Row]) -> Vec<(f64, (f64, f64))> {
    let scanned: Vec<&Row> = rows.iter().filter(|row| row.mode == Mode::Scan && row.admittance_s.is_some()).collect();
    // A sweep rises in frequency, and the next begins below its end. So does the ring-down, which
    // has only one frequency.
    let passes = scanned.chunk_by(|before, after| after.frequency_hz >= before.frequency_hz);
    let moves = |pass: &[&Row]| pass.last().zip(pass.first()).is_some_and(|(last, first)| last.frequency_hz > first.frequency_hz);
    let last_pass = passes.rev().find(|pass| moves(pass)).unwrap_or(&[]);
    let tones = last_pass.chunk_by(|before, after| after.frequency_hz == before.frequency_hz);
    tones.filter_map(|tone| tone.last().and_then(|row| Some((row.frequency_hz, row.admittance_s?)))).collect()
}
