//! Table 3.2 and related numbers, row by row.

use std::f64::consts::TAU;

use super::{AMPLITUDES, FULL_M, SPEED_M_PER_S};
use report::{TableBlock, significant};

const FREQUENCY_HZ: f64 = 20e3;
const HALF_WAVE_M: f64 = 5.0 * 0.0254;
/// Young's modulus of steel, Pa, as tabulated in the literature.
const STEEL_PA: f64 = 200e9;
/// Density of steel, kg/m^3, as tabulated in the literature.
const STEEL_KG_PER_M3: f64 = 7850.0;
const PA_PER_PSI: f64 = 6894.757;
const STROKE_M: f64 = 12.0 * 0.0254;

/// Tabulates Table 3.2: printed and computed values.
pub fn table() -> TableBlock {
    let ram_m2 = 670.0 / (60.0 * PA_PER_PSI);
    let speed = |part: f64| significant(TAU * FREQUENCY_HZ * FULL_M * part);
    let row =
        |name: &str, printed: &str, follows: String, remark: &str| vec![name.into(), printed.into(), follows, remark.into()];
    let half_wave_hz = (STEEL_PA / STEEL_KG_PER_M3).sqrt() / (2.0 * HALF_WAVE_M);
    let rows = vec![
        row("operating frequency", "20 000 Hz", "–".into(), "given"),
        row(
            "half wavelength, heat treated steel",
            "5 inches",
            format!("{} Hz", significant(half_wave_hz)),
            "agrees: c/2l with 200 GPa and 7850 kg/m^3",
        ),
        row(
            "maximum amplitude",
            "85 microns",
            format!("{}, {}, {} m/s at 50, 70, 100 %", speed(AMPLITUDES[0]), speed(AMPLITUDES[1]), speed(1.0)),
            "open: zero to peak (here) or peak to peak (half of it)",
        ),
        row("power", "2.5 kW", "1200 W at 670 N (5.2)".into(), "given"),
        row(
            "maximum normal load",
            "1500 N",
            format!("{} psi on the ram", significant(1500.0 / ram_m2 / PA_PER_PSI)),
            "670 N at 60 psi (3.2.2) correspond to a ram of 45 mm bore",
        ),
        row(
            "ram",
            "60 psi, 670 N",
            format!("{} mm bore", significant(2e3 * (ram_m2 / std::f64::consts::PI).sqrt())),
            "load over pressure",
        ),
        row("air pressure for pneumatic cylinder", "14-45 psi", "–".into(), "given: the pulling cylinder, not the ram"),
        row(
            "stroke at 0.025 m/s",
            "12 inches",
            format!("{} s", significant(STROKE_M / SPEED_M_PER_S)),
            "enough for 2.5 s ON, but hardly for more than one run",
        ),
    ];
    let caption = "Printed values (Table 3.2 and 3.2.2), and values computed from them.";
    TableBlock::new("table-3-2", "Table 3.2: welder of experiment 2", caption, &["", "printed", "computed", "remark"], rows)
}
