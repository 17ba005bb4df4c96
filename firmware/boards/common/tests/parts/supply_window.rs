//! Permitted range of the amplifier's supply.

use boards_common::supply_window::SupplyWindow;
use firmware::seam::config::Supply;

/// A supply of 24 V, divided 11 to 1, at 3.3 V and 12 bits: 8.86 mV per code, up to 36.3 V.
const SUPPLY: Supply = Supply { divider: Some(11.0), min_v: 20.0, max_v: 28.0 };

#[test]
fn the_range_is_exact_to_a_code() {
    let window = SupplyWindow::from_settings(&SUPPLY, 3.3, 4096.0).expect("it is measured");
    let volts = |code: u16| f64::from(code) * 11.0 * 3.3 / 4096.0;
    for code in 0..4096 {
        assert_eq!(window.holds(code), (20.0..=28.0).contains(&volts(code)), "{code}: {} V", volts(code));
    }
}

#[test]
fn the_highest_code_is_outside() {
    let open_above = SupplyWindow::from_settings(&Supply { max_v: 1e4, ..SUPPLY }, 3.3, 4096.0).expect("it is measured");
    assert_eq!([2256, 2257, 4094, 4095].map(|code| open_above.holds(code)), [false, true, true, false]);
}

#[test]
fn without_a_divider_there_is_no_window() {
    assert_eq!(SupplyWindow::from_settings(&Supply::default(), 3.3, 4096.0), None);
}
