//! Derivation of the scene's stator from the thesis's sheet (Figure B.8) on an aluminium ring, by
//! the bending theory of B.2.

use std::f64::consts::TAU;

use super::stator;

/// Thickness of the PZT-5A sheet, m.
const SHEET_M: f64 = 0.040 * 25.4e-3;
/// Modulus of the sheet, Pa.
const SHEET_PA: f64 = 6.6e10;
/// Density of the sheet, kg/m^3.
const SHEET_KG_M3: f64 = 7800.0;
/// Piezoelectric constant d31 of the sheet, m/V.
const D31_M_PER_V: f64 = 190e-12;
/// Free permittivity of the sheet, F/m.
const PERMITTIVITY: f64 = 1800.0 * 8.854e-12;
/// Coupling k31 of the sheet.
const K31: f64 = 0.35;
/// Thickness of the aluminium ring, m.
const BACK_M: f64 = 2.252e-3;
/// Modulus of the ring, Pa.
const BACK_PA: f64 = 7e10;
/// Density of the ring, kg/m^3.
const BACK_KG_M3: f64 = 2700.0;
/// Width of the ring, m.
const WIDTH_M: f64 = 6e-3;

fn near(what: &str, scene: f64, computed: f64) {
    assert!((scene / computed - 1.0).abs() < 1e-3, "{what}: {scene:e} in the scene, {computed:e} computed");
}

#[test]
fn the_stator_is_the_sheet_on_an_aluminium_ring() {
    let scene = stator();
    let pitch = scene.tab_width_m + scene.tab_gap_m;
    near("wave length", scene.wave_length_m, 4.0 * pitch);
    let k = TAU / scene.wave_length_m;

    // Layers from the sheet's free face down; height of the neutral plane, bending stiffness and
    // mass per length and width.
    let (middle, back) = (0.5 * SHEET_M, SHEET_M + 0.5 * BACK_M);
    let (stiff, stiff_back) = (SHEET_PA * SHEET_M, BACK_PA * BACK_M);
    let neutral = (stiff * middle + stiff_back * back) / (stiff + stiff_back);
    let bending = stiff * (SHEET_M.powi(2) / 12.0 + (middle - neutral).powi(2))
        + stiff_back * (BACK_M.powi(2) / 12.0 + (back - neutral).powi(2));
    let mass = SHEET_KG_M3 * SHEET_M + BACK_KG_M3 * BACK_M;
    // Thesis B.12: k^2 = omega sqrt(mass / bending).
    near("resonance", scene.series_resonance_hz, k * k * (bending / mass).sqrt() / TAU);
    near("surface height", scene.surface_height_m, SHEET_M + BACK_M - neutral);
    // Half the ring: the mean square of a sine.
    near("modal mass", scene.modal_mass_kg, 0.5 * mass * WIDTH_M * f64::from(scene.tabs) * pitch);
    // A volt causes the moment e31 b z; a tab on a crest converts it into 2 k sin(k width / 2) of
    // modal force. Three tabs a lane.
    let tab = D31_M_PER_V * SHEET_PA * WIDTH_M * (neutral - middle) * 2.0 * k * (0.5 * k * scene.tab_width_m).sin();
    near("force factor", scene.force_factor_n_per_v, 3.0 * tab);
    let free = PERMITTIVITY * 3.0 * scene.tab_width_m * WIDTH_M / SHEET_M;
    near("clamped capacitance", scene.c0_f, free * (1.0 - K31 * K31));
}

/// The sheet alone: the wave of the electrodes has 9.1 kHz, and the wave at 40 kHz is 11.6 mm long.
#[test]
fn the_bare_sheet_does_not_carry_the_wave_of_its_electrodes() {
    let speed = SHEET_M * (SHEET_PA / (12.0 * SHEET_KG_M3)).sqrt();
    let hz = (TAU / stator().wave_length_m).powi(2) * speed / TAU;
    assert!((hz - 9.08e3).abs() < 10.0, "{hz}");
    let wave = TAU / (TAU * 40e3 / speed).sqrt();
    assert!((wave - 11.58e-3).abs() < 0.01e-3, "{wave}");
}
