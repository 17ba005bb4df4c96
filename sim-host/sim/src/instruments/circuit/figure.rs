//! The admittance loop: what the scan measured, the circle it found, and where the drive works.

use std::f64::consts::TAU;

use firmware::seam::mode::Mode;

use crate::instruments::View;
use crate::instruments::curves::axis;
use crate::record::Row;
use plant::circuit::Circuit;
use plant::circuit_of;
use report::{Figure, Marker, Series, Style};

/// Blocks over which the working point is averaged.
const WORKING_BLOCKS: usize = 1000;

/// Admittance of a circuit, S, as conductance and susceptance.
fn admittance(circuit: &Circuit, hz: f64) -> (f64, f64) {
    let omega = TAU * hz;
    let reactance = omega * circuit.lm_h - 1.0 / (omega * circuit.cm_f);
    let square = circuit.rm_ohm.powi(2) + reactance.powi(2);
    (circuit.rm_ohm / square, omega * circuit.c0_f - reactance / square)
}

fn locus_of(circuit: &Circuit, name: &str, csv_column: &str, style: Style) -> Series {
    // Equal steps of the motional phase are equal steps along the circle.
    let half_bandwidth = circuit.series_resonance_hz() / (2.0 * circuit.q());
    let points = (-199..200).map(|n| {
        let phase = std::f64::consts::FRAC_PI_2 * f64::from(n) / 205.0;
        admittance(circuit, circuit.series_resonance_hz() + half_bandwidth * phase.tan())
    });
    let (x, y) = points.unzip();
    Series { name: name.into(), csv_column: csv_column.into(), x, y, style }
}

/// The loop. Only for a study that has identified its transducer.
pub(super) fn locus(run: &View) -> Option<Figure> {
    let found = run.record.last.transducer?;
    let identified = Circuit {
        c0_f: found.c0_f.into(),
        cm_f: found.cm_f.into(),
        lm_h: found.lm_h.into(),
        rm_ohm: found.rm_ohm.into(),
        force_factor_n_per_v: 1.0,
    };
    let truth = circuit_of(&run.scene);
    let (x, y) = sweep_points(run.rows);
    let measured = Series {
        name: "played, last sweep of the scan".into(),
        csv_column: "susceptance_measured_s".into(),
        x,
        y,
        style: Style::Points,
    };
    let steady: Vec<(f64, f64)> = run.steady().filter_map(|row| row.admittance_s).collect();
    let last = &steady[steady.len().saturating_sub(WORKING_BLOCKS)..];
    let working = (!last.is_empty()).then(|| {
        let (g, b) = last.iter().fold((0.0, 0.0), |sum, y| (sum.0 + y.0, sum.1 + y.1));
        Marker { x: g / last.len() as f64, y: b / last.len() as f64, label: "working point".into() }
    });
    Some(Figure {
        id: "admittance".into(),
        title: "Admittance loop".into(),
        caption:
            "Dots: block by block, the scan's last sweep, in which nothing settles: the further off the circle, the higher Q. The identified circle includes what the converters' images make \
                  of the clamped capacitance. The working point is the mean over the last steady blocks; a load and friction move it."
                .into(),
        x: axis("conductance [S]"),
        y: axis("susceptance [S]"),
        series: vec![
            measured,
            locus_of(&truth, "true circuit", "susceptance_true_s", Style::Dashed),
            locus_of(&identified, "identified circuit", "susceptance_identified_s", Style::Line),
        ],
        markers: working.into_iter().collect(),
        equal_aspect: true,
        ..Figure::default()
    })
}

/// Current over voltage in each block of the scan's last sweep.
fn sweep_points(rows: &[Row]) -> (Vec<f64>, Vec<f64>) {
    let scanned: Vec<&Row> = rows.iter().filter(|row| row.mode == Mode::Scan && row.admittance_s.is_some()).collect();
    // A sweep runs upwards, and the next begins below where it ended; so does the ring-down, which has one frequency only.
    let passes = scanned.chunk_by(|before, after| after.frequency_hz >= before.frequency_hz);
    let moves = |pass: &[&Row]| pass.last().zip(pass.first()).is_some_and(|(last, first)| last.frequency_hz > first.frequency_hz);
    let last_pass = passes.rev().find(|pass| moves(pass)).unwrap_or(&[]);
    let tones = last_pass.chunk_by(|before, after| after.frequency_hz == before.frequency_hz);
    tones.filter_map(|tone| tone.last()?.admittance_s).unzip()
}
