//! Table 3.1 row by row, and the values that the scene `experiment-1` derives from it.

use std::f64::consts::TAU;

use report::{TableBlock, significant};

/// Number of discs of the stack, n.
pub(in crate::thesis) const DISCS: f64 = 62.0;
/// Piezoelectric coefficient d33, m/V.
pub(in crate::thesis) const D33_M_PER_V: f64 = 730e-12;
/// Required displacement, m.
pub(in crate::thesis) const REQUIRED_M: f64 = 0.7e-6;
/// Frequency, Hz.
pub(in crate::thesis) const FREQUENCY_HZ: f64 = 40e3;
/// Capacitance, F.
pub(in crate::thesis) const CAPACITANCE_F: f64 = 300e-9;
/// Preload, N.
const PRELOAD_N: f64 = 670.0;
/// Maximum current, A.
pub(in crate::thesis) const PRINTED_CURRENT_A: f64 = 1.75;
/// Impedance, ohm.
pub(in crate::thesis) const PRINTED_IMPEDANCE_OHM: f64 = 8.84;
/// Stiffness of the stack, N/m.
pub(in crate::thesis) const STACK_N_PER_M: f64 = 3.14e8;
/// Stiffness of the bolt, N/m.
pub(in crate::thesis) const BOLT_N_PER_M: f64 = 3.7e7;
/// Nominal displacement, m.
pub(in crate::thesis) const NOMINAL_M: f64 = 36e-6;
/// Young's modulus of the rod of the half-wave model (3.1.2), Pa.
pub(in crate::thesis) const MODULUS_PA: f64 = 120e9;
/// Density of the rod, kg/m^3.
pub(in crate::thesis) const DENSITY_KG_PER_M3: f64 = 7900.0;
/// Length of the rod, m.
pub(in crate::thesis) const LENGTH_M: f64 = 0.048_76;
/// Drive voltage of experiment 1 (3.1.4), V peak.
pub(in crate::thesis) const DRIVE_V: f64 = 3.0;
/// Drive current of experiment 1 (3.1.4), A peak.
pub(in crate::thesis) const DRIVE_A: f64 = 1.0;
/// Assumed coupling of the scene's stack.
const COUPLING: f64 = 0.25;

/// Largest relative difference between a printed and a computed value that agree.
const AGREES_REL: f64 = 0.01;

/// Returns the voltage for the required displacement, V: the table's maximum.
pub(in crate::thesis) fn voltage_v() -> f64 {
    REQUIRED_M / (D33_M_PER_V * DISCS)
}

/// Tabulates Table 3.1: printed and computed values.
pub fn table() -> TableBlock {
    let voltage = voltage_v();
    let speed = (MODULUS_PA / DENSITY_KG_PER_M3).sqrt();
    let area = STACK_N_PER_M * LENGTH_M / MODULUS_PA;
    let mass = DENSITY_KG_PER_M3 * area * LENGTH_M;
    let susceptance = TAU * FREQUENCY_HZ * CAPACITANCE_F;
    let conductance = ((DRIVE_A / DRIVE_V).powi(2) - susceptance.powi(2)).sqrt();
    let motional_f = CAPACITANCE_F * COUPLING.powi(2) / (1.0 - COUPLING.powi(2));
    let inductance = 1.0 / ((TAU * FREQUENCY_HZ).powi(2) * motional_f);
    // Half of the rod's mass moves at the tip; the inductance is its electrical equivalent.
    let factor = (0.5 * mass / inductance).sqrt();
    let tip = conductance * DRIVE_V / factor;
    let given = |name: &str, printed: String| vec![name.into(), printed, "–".into(), "given".into()];
    let derived = |name: &str, printed: f64, unit: &str, follows: f64, by: &str| {
        let agrees = (follows / printed - 1.0).abs() <= AGREES_REL;
        let verdict = if agrees { format!("agrees: {by}") } else { format!("contradicts: {by}") };
        vec![name.into(), format!("{} {unit}", significant(printed)), format!("{} {unit}", significant(follows)), verdict]
    };
    let ours = |name: &str, value: String, by: &str| vec![name.into(), "–".into(), value, by.into()];
    let rows = vec![
        given("discs n", format!("{DISCS}")),
        given("d33", "730e-12 m/V (printed without the V)".into()),
        given("required displacement", "0.7 um".into()),
        derived("voltage, maximum", 15.466, "V", voltage, "displacement over d33 n"),
        given("frequency", "40 kHz".into()),
        derived("preload", PRELOAD_N, "N", 150.0 * 4.448_222, "150 lb"),
        given("capacitance", "300 nF".into()),
        derived("current, maximum", PRINTED_CURRENT_A, "A", susceptance * voltage, "2 pi f C V"),
        derived("impedance", PRINTED_IMPEDANCE_OHM, "ohm", 1.0 / susceptance, "1/(2 pi f C)"),
        given("stiffness of stack, of bolt", "3.14e8 N/m, 3.7e7 N/m".into()),
        derived("deflection by the preload", 2.133, "um", 1e6 * PRELOAD_N / STACK_N_PER_M, "preload over stiffness"),
        given("nominal displacement", "36 um".into()),
        derived(
            "displacement, maximum",
            32.2,
            "um",
            1e6 * NOMINAL_M * STACK_N_PER_M / (STACK_N_PER_M + BOLT_N_PER_M),
            "nominal value and stiffnesses; but 0.7 um at the maximum voltage",
        ),
        derived("speed of sound (3.1.2)", 3900.0, "m/s", speed, "sqrt(E/rho), 120 GPa and 7900 kg/m^3"),
        derived("first mode (3.1.2)", 40_000.0, "Hz", speed / (2.0 * LENGTH_M), "c/2l, 1.92 in"),
        ours(
            "section and mass of the rod",
            format!("{} mm^2, {} g", significant(1e6 * area), significant(1e3 * mass)),
            "K l/E, rho A l",
        ),
        ours(
            "motional conductance",
            format!("{} S", significant(conductance)),
            "6 V and 2 A peak to peak (3.1.4), parallel to 300 nF",
        ),
        ours("motional resistance", format!("{} ohm", significant(1.0 / conductance)), "scene experiment-1: 3.08 ohm"),
        ours(
            "motional C and L, Q",
            format!(
                "{} nF, {} mH, {}",
                significant(1e9 * motional_f),
                significant(1e3 * inductance),
                significant(TAU * FREQUENCY_HZ * inductance * conductance)
            ),
            "ASSUMED: coupling 0.25 (by the table it would exceed 1)",
        ),
        ours("force factor", format!("{} N/V", significant(factor)), "square root of half the rod's mass over the inductance"),
        ours("tip velocity at 3 V", format!("{} m/s", significant(tip)), "set point of the scene: 0.175 m/s"),
        ours("tip amplitude at 3 V", format!("{} um", significant(1e6 * tip / (TAU * FREQUENCY_HZ))), "required: 0.7 um"),
    ];
    let caption =
        "Computed: from the other rows; agreement is within one per cent. The last rows are the stack of the scene experiment-1.";
    TableBlock::new("table-3-1", "Table 3.1: transducer of experiment 1", caption, &["", "printed", "computed", "verdict"], rows)
}
