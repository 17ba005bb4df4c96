//! The ceramic: hysteresis of its strain, and its limits of stress and strain.
//!
//! ```text
//! P = Ps tanh((E -+ Ec) / 2 d),   d = Ec / ln((1 + Pr/Ps) / (1 - Pr/Ps)),   S = Q P^2
//! ```
//!
//! The saturated polarisation loop of S. L. Miller et al., J. Appl. Phys. 68 (1990) 6463, and the
//! electrostrictive strain. Both are drawn relative to the coercive field and to the strain at
//! saturation, because the thesis gives no numbers.

use super::super::picture;
use super::super::picture::{axis, column, line};
use report::{Axis, Figure, Series};

/// Remanent polarisation relative to the saturated one.
const REMANENT_REL: f64 = 0.8;
/// Points of a curve.
const POINTS: usize = 400;
/// Points of an edge of a parallelogram.
const EDGE_POINTS: u32 = 20;
/// Compression by the prestress, MPa.
const PRESTRESS_MPA: f64 = 30.0;
/// Largest compression, MPa: the largest prestress that a maker of power transducers advises for
/// PZT-8.
const COMPRESSION_MPA: f64 = 60.0;

/// Creates a figure of loops, whose x is not in order.
fn figure(id: &str, title: &str, caption: String, axes: [Axis; 2], series: Vec<Series>) -> Figure {
    Figure { interactive: false, ..picture::figure(id, title, caption, axes, series) }
}

/// Returns the polarisation at a field, relative to the saturated one; the field rises if `rising`.
fn polarisation(field: f64, rising: bool) -> f64 {
    let width = 1.0 / ((1.0 + REMANENT_REL) / (1.0 - REMANENT_REL)).ln();
    let shift = if rising { -1.0 } else { 1.0 };
    ((field + shift) / (2.0 * width)).tanh()
}

/// Returns a field that falls from `most` to `least` and rises again, with the strain.
fn loop_between(least: f64, most: f64) -> (Vec<f64>, Vec<f64>) {
    let at = |point: usize| most + (least - most) * point as f64 / POINTS as f64;
    let branch = |rising: bool| {
        let points: Vec<usize> = if rising { (0..=POINTS).rev().collect() } else { (0..=POINTS).collect() };
        points.into_iter().map(move |point| (at(point), polarisation(at(point), rising).powi(2)))
    };
    branch(false).chain(branch(true)).unzip()
}

/// Draws Figure 2.7: strain of a poled ceramic that is not driven to its coercive field.
pub(super) fn strain() -> Figure {
    let series = [-0.3, 0.0].map(|least| {
        let (field, strain) = loop_between(least, 2.0);
        let label = format!("from {least} Ec");
        line(&label, column("strain", &label), &field, strain)
    });
    let caption =
        "Strain over field by Miller's saturated loop and electrostriction; the remanent polarisation is assumed to be \
                   0.8 of the saturated one. The state depends on the history: rising and falling field differ."
            .to_owned();
    figure(
        "fig-2-07",
        "Strain over field below depolarisation",
        caption,
        [axis("field / coercive field"), axis("strain / strain at saturation")],
        series.to_vec(),
    )
}

/// Draws Figure 2.8: the loop beyond the coercive field.
pub(super) fn butterfly() -> Figure {
    let (field, strain) = loop_between(-3.0, 3.0);
    let caption =
        "The same beyond the coercive field: the ceramic contracts, its domains reverse, and it expands again.".to_owned();
    let series = vec![line("strain", "strain", &field, strain)];
    figure(
        "fig-2-08",
        "Strain over field with reversal",
        caption,
        [axis("field / coercive field"), axis("strain / strain at saturation")],
        series,
    )
}

/// Draws Figure 2.10: limits of stress and strain, without and with prestress.
pub(super) fn stress_and_strain() -> Figure {
    let ceramic = &design::library::MATERIALS
        .iter()
        .find(|known| known.material.name == "apc-841")
        .unwrap_or_else(|| unreachable!())
        .material;
    let (modulus_mpa, most) =
        (1e-6 * ceramic.modulus_pa, ceramic.d33_m_per_v.unwrap_or(0.0) * ceramic.field_v_per_m.unwrap_or(0.0));
    let bounds = |label: &str, (low, high): (f64, f64)| {
        // At one end of the stress, over both fields, at the other end, and back.
        let corners = [(low, -1.0), (low, 1.0), (high, 1.0), (high, -1.0), (low, -1.0)];
        let edge = |pair: &[(f64, f64)]| {
            let ((x1, y1), (x2, y2)) = (pair[0], pair[1]);
            (0..EDGE_POINTS)
                .map(move |point| f64::from(point) / f64::from(EDGE_POINTS))
                .map(move |t| (x1 + t * (x2 - x1), y1 + t * (y2 - y1)))
        };
        let outline: Vec<(f64, f64)> = corners.windows(2).flat_map(edge).chain([corners[0]]).collect();
        let strain = |&(stress, sign): &(f64, f64)| 1e6 * (stress / modulus_mpa + sign * most);
        line(
            label,
            column("strain", label),
            &outline.iter().map(|(stress, _)| *stress).collect::<Vec<_>>(),
            outline.iter().map(strain).collect(),
        )
    };
    let series = vec![
        bounds("without prestress: no tension", (-COMPRESSION_MPA, 0.0)),
        bounds("alternating stress that 30 MPa allow", (-PRESTRESS_MPA, PRESTRESS_MPA)),
    ];
    let caption = format!(
        "Strain over stress of APC 841 at a field of {} V/mm of either sign. A ceramic is not loaded in tension; with a prestress \
         of {PRESTRESS_MPA} MPa, the alternating part may be tension.",
        1e-3 * ceramic.field_v_per_m.unwrap_or(0.0)
    );
    figure("fig-2-10", "Limits of stress and strain", caption, [axis("stress [MPa]"), axis("strain [1e-6]")], series)
}
