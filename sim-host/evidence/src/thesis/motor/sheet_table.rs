//! Table of the sheet and its wave.

use std::f64::consts::TAU;

use super::sheet::{
    D31_M_PER_V, D33_M_PER_V, DENSITY_KG_PER_M3, DENSITY_SIMULATED_KG_PER_M3, IN_PLANE_PA, PERMITTIVITY, POISSON, SIDE_M, Sheet,
    THICKNESS_M, THROUGH_PA, VACUUM_F_PER_M,
};
use super::{MEASURED_M, wave};
use report::{TableBlock, significant};

/// Tabulates the values of Figure B.8, and values computed from them at the two measured
/// frequencies.
pub fn table() -> TableBlock {
    let row = |name: &str, [low, high]: [f64; 2], source: &str| {
        vec![name.to_owned(), significant(low), significant(high), source.to_owned()]
    };
    let same = |name: &str, value: f64, source: &str| row(name, [value, value], source);
    let at = |of: &dyn Fn(f64) -> f64| super::MEASURED_HZ.map(of);
    let (beam, plate) = (Sheet::BEAM, Sheet::PLATE);
    let simulated = Sheet { density_kg_per_m3: DENSITY_SIMULATED_KG_PER_M3, ..beam };
    let through = Sheet { modulus_pa: THROUGH_PA, ..beam };
    // k31^2 = d31^2 E / eps.
    let permittivity = VACUUM_F_PER_M * PERMITTIVITY;
    let coupling = |d: f64, modulus: f64| (d * d * modulus / permittivity).sqrt();
    let rows = vec![
        same("thickness [mm]", 1e3 * THICKNESS_M, "B.4"),
        same("side [mm]", 1e3 * SIDE_M, "B.4"),
        same("density [kg/m^3]", DENSITY_KG_PER_M3, "Figure B.8; Table B.1 has 7750"),
        same("Young's modulus along the sheet [Pa]", IN_PLANE_PA, "Figure B.8; applies to bending"),
        same("Young's modulus through the sheet [Pa]", THROUGH_PA, "Figure B.8; does not apply to bending"),
        same("Poisson's ratio", POISSON, "assumed: -s12/s11 of PZT-5A"),
        same("k31 by d31, modulus and permittivity", coupling(D31_M_PER_V, IN_PLANE_PA), "Figure B.8 states 0.35"),
        same("k33 by d33, modulus and permittivity", coupling(D33_M_PER_V, THROUGH_PA), "Figure B.8 states 0.72"),
        same("bending stiffness per width, beam [N m]", beam.stiffness_n_m(), "E h^3/12"),
        same("bending stiffness per width, plate [N m]", plate.stiffness_n_m(), "E h^3/(12 (1 - nu^2))"),
        same("c of B.10 [m^2/s]", beam.c_m2_per_s(), "sqrt(EI/(rho A)); not a speed"),
        row("wave number k, beam [rad/m]", at(&|hz| beam.wave_number(hz)), "B.12"),
        row("k with the density of Table B.1", at(&|hz| simulated.wave_number(hz)), "B.12"),
        row("k with the modulus through the sheet", at(&|hz| through.wave_number(hz)), "B.12; wrong modulus"),
        row("k, plate", at(&|hz| plate.wave_number(hz)), "B.12 with the plate's stiffness"),
        row("k, beam with shear and rotary inertia", at(&|hz| wave::timoshenko(&beam, hz)), "Timoshenko 1921"),
        row("wave length [mm]", at(&|hz| 1e3 * TAU / beam.wave_number(hz)), "2 pi/k"),
        row("phase speed [m/s]", at(&|hz| TAU * hz / beam.wave_number(hz)), "w/k"),
        row("z k at the face", at(&|hz| beam.face_m() * beam.wave_number(hz)), "B.13: u over w"),
        row("crest's speed at 20 nm [mm/s]", at(&|hz| 1e3 * beam.crest_m_per_s(MEASURED_M, hz)), "a w z k, by B.13"),
    ];
    let caption = "The sheet of Figure B.8 as the thin beam of B.12, at the two frequencies of the measurement.";
    TableBlock::new("table-b", "Appendix B: the sheet and its wave", caption, &["quantity", "20 kHz", "40 kHz", "source"], rows)
}
