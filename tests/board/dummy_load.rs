//! The dummy load of docs/board.md: its electrical values, and that the board's configuration
//! accepts it as a stack.
//!
//!     cargo test -p scenarios board::dummy_load -- --nocapture
//!
//! prints its table.

use std::f64::consts::{PI, SQRT_2};

use nucleo_g474re::config::{config, range_a};

/// Inductance of the coil, H.
const L_H: f64 = 820e-6;
/// Loss resistance of the coil at 40 kHz, ohm.
const LOSS_OHM: f64 = 1.2;
/// Capacitance in series with the coil, F.
const C_F: f64 = 19.2e-9;
/// Resistance in series with the coil, ohm.
const R_OHM: f64 = 2.0;
/// Capacitance in parallel with the branch, F.
const C0_F: f64 = 300e-9;
/// Drive voltage, V peak.
const DRIVE_V: f64 = 3.0;

#[test]
fn the_board_accepts_the_dummy_load() {
    let series_hz = 1.0 / (2.0 * PI * (L_H * C_F).sqrt());
    let parallel_hz = series_hz * (1.0 + C_F / C0_F).sqrt();
    let coupling = (C_F / (C0_F + C_F)).sqrt();
    let reactance = 2.0 * PI * series_hz * L_H;
    let resistance = LOSS_OHM + R_OHM;
    let q = reactance / resistance;
    let motional_a = DRIVE_V / resistance;
    let clamped_a = DRIVE_V * 2.0 * PI * series_hz * C0_F;
    let total_a = motional_a.hypot(clamped_a);
    println!("| of the dummy load | |\n|---|---|");
    println!("| series resonance, antiresonance | {series_hz:.0} Hz, {parallel_hz:.0} Hz |");
    println!("| Q, coupling | {q:.1}, {coupling:.4} |");
    println!("| Rm, Lm, Cm, C0 | {resistance:.1} Ω, {:.0} µH, {:.1} nF, {:.0} nF |", L_H * 1e6, C_F * 1e9, C0_F * 1e9);
    println!("| at {DRIVE_V:.0} V peak: current of the branch, total current | {motional_a:.2} A, {total_a:.2} A peak |");
    println!("| across coil and capacitor | {:.0} V peak |", motional_a * reactance);
    println!(
        "| loss in the resistors, in the coil | {:.1} W, {:.1} W |",
        R_OHM * (motional_a / SQRT_2).powi(2),
        LOSS_OHM * (motional_a / SQRT_2).powi(2)
    );

    let config = config();
    let (nominal_hz, tracking) = (f64::from(config.drive.frequency_hz), &config.tracking);
    assert!((series_hz / nominal_hz - 1.0).abs() < 0.02, "{series_hz}");
    assert!((0.5..2.0).contains(&(q / f64::from(tracking.nominal_q))), "{q}");
    assert!((f64::from(tracking.c0_f()) / C0_F - 1.0).abs() < 0.05);
    // Far from the limit, and from the end of the channel.
    assert!(total_a < 0.5 * f64::from(config.limits.current_a) && total_a < f64::from(range_a()), "{total_a}");
    // Voltage across the capacitor of the branch, which is rated for 630 V.
    assert!(motional_a * reactance < 0.5 * 630.0);
}
