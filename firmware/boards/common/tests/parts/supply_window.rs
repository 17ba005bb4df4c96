//! The window of the amplifier's supply.

use boards_common::supply_window::SupplyWindow;
use firmware::seam::config::Supply;

/// 24 V by 1 to 11 at 3.3 V and 12 bits: 8.86 mV a code, as much as 36.3 V.
const SUPPLY: Supply = Supply { divider: Some(11.0), min_v: 20.0, max_v: 28.0 };

#[test]
fn within_the_window_it_holds_to_a_code() {
    let window = SupplyWindow::of(&SUPPLY, 3.3, 4096.0).expect("it is measured");
    let volts = |code: u16| f64::from(code) * 11.0 * 3.3 / 4096.0;
    for code in 0..4096 {
        assert_eq!(window.holds(code), (20.0..=28.0).contains(&volts(code)), "{code}: {} V", volts(code));
    }
}

#[test]
fn what_the_divider_cannot_show_is_outside() {
    let open_above = SupplyWindow::of(&Supply { max_v: 1e4, ..SUPPLY }, 3.3, 4096.0).expect("it is measured");
    assert_eq!([2256, 2257, 4094, 4095].map(|code| open_above.holds(code)), [false, true, true, false]);
}

#[test]
fn without_a_divider_there_is_no_window() {
    assert_eq!(SupplyWindow::of(&Supply::default(), 3.3, 4096.0), None);
}
