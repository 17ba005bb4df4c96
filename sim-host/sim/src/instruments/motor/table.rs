//! Table of a motor's measured values and their closed forms.

use crate::metrics::Metrics;
use crate::numbers::number;
use report::TableBlock;
use scene::Driven;

/// Returns the backward wave, %, of four lanes with these errors on a perfect ring with tabs a
/// quarter wave apart. The difference of two lanes drives each mode; the waves are half the sum and
/// half the difference of the modes.
fn of_errors(phase_deg: &[f64], gain: &[f64]) -> f64 {
    let entry = |list: &[f64], lane: usize| list.get(lane).copied().unwrap_or(0.0);
    let lane = |lane: usize| {
        let (sin, cos) = entry(phase_deg, lane).to_radians().sin_cos();
        ((1.0 + entry(gain, lane)) * cos, (1.0 + entry(gain, lane)) * sin)
    };
    let pushed = |one: (f64, f64), other: (f64, f64)| (one.0 + other.0, one.1 + other.1);
    let (a, b) = (pushed(lane(0), lane(2)), pushed(lane(1), lane(3)));
    100.0 * (a.0 - b.0).hypot(a.1 - b.1) / (a.0 + b.0).hypot(a.1 + b.1)
}

/// Returns the table of measured values and closed forms.
pub(super) fn closed_forms(scene: &Driven, metrics: &Metrics) -> Option<TableBlock> {
    scene.stator()?;
    let amplifier = scene.amplifier;
    let metric = |name: &str| metrics.get(name);
    let mut rows = vec![(
        "backward wave [%]",
        metric("backward_wave_percent"),
        Some(of_errors(&amplifier.lane_phase_error_deg, &amplifier.lane_gain_error)),
        "amplifier errors, no trims, no rotor, a perfect ring: tan(eps / 2) for phase, g / (2 + g) for gain",
    )];
    if let Some(rotor) = scene.rotor() {
        let limit = rotor.mu * rotor.preload_n * rotor.radius_m;
        rows.extend([
            (
                "rotor speed over surface speed",
                metric("rotor_speed_ratio"),
                metric("rotor_speed_ratio_closed_form"),
                "a pure wave of the same amplitude at the same torque",
            ),
            ("normal force [N]", metric("normal_force_n"), Some(rotor.preload_n), "preload"),
            ("torque [mN m]", metric("rotor_torque_nm").map(|torque| 1e3 * torque), Some(1e3 * rotor.torque_nm), "load"),
            ("maximum torque before full slip [mN m]", None, Some(1e3 * limit), "mu x preload x radius"),
        ]);
    }
    let cell = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), number);
    let rows = rows.into_iter().map(|(what, measured, closed, of)| vec![what.into(), cell(measured), cell(closed), of.into()]);
    Some(TableBlock::new(
        "closed-forms",
        "Motor: measured values and closed forms",
        "Measured on the simulated motor, including the reaction of friction on the wave.",
        &["", "measured", "closed form", "assumptions"],
        rows.collect(),
    ))
}

#[cfg(test)]
mod tests {
    use super::of_errors;

    #[test]
    fn simple_errors_have_simple_forms() {
        let half_tan = 100.0 * 5f64.to_radians().tan();
        assert!((of_errors(&[0.0, 10.0, 0.0, 10.0], &[]) - half_tan).abs() < 1e-12);
        assert!((of_errors(&[], &[0.0, 0.1, 0.0, 0.1]) - 100.0 * 0.1 / 2.1).abs() < 1e-12);
        assert_eq!(of_errors(&[], &[]), 0.0);
    }
}
