//! Flashes of the status LED.

use boards_common::led::is_lit;
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;

/// Returns the lengths of the flashes within a time, ms.
fn flashes(mode: Mode, fault: Option<Fault>, within: u32) -> Vec<u32> {
    let lit: Vec<bool> = (0..within).map(|ms| is_lit(mode, fault, ms)).collect();
    lit.chunk_by(|a, b| a == b).filter(|run| run[0]).map(|run| run.len() as u32).collect()
}

#[test]
fn a_fault_is_its_number_in_long_and_short_flashes() {
    for fault in Fault::ALL.iter().copied() {
        let (tens, units) = (usize::from(fault.code() / 10), usize::from(fault.code() % 10));
        let period = 700 * tens as u32 + 300 * units as u32 + 1200;
        let once = [vec![500; tens], vec![100; units]].concat();
        assert_eq!(flashes(Mode::Fault, Some(fault), period), once, "{fault:?}");
        assert_eq!(flashes(Mode::Fault, Some(fault), 3 * period), once.repeat(3), "{fault:?}");
    }
}

#[test]
fn idle_flashes_and_a_drive_is_lit() {
    assert_eq!(flashes(Mode::Idle, None, 6000), [50; 3]);
    for mode in [Mode::SelfTest, Mode::Scan, Mode::Lock, Mode::Run, Mode::Calibrate] {
        assert_eq!(flashes(mode, None, 5000), [5000], "{mode:?}");
    }
}
