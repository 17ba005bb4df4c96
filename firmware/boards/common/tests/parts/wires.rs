//! Check of the encoder's wires.

use boards_common::wires::Wires;

/// Checks the wires over this number of blocks and returns the first block in which a line counts
/// as broken. A period of a channel takes `period` blocks; a broken wire is low.
fn looks(period: usize, blocks: usize, broken: [bool; 4]) -> Option<usize> {
    let mut wires = Wires::default();
    (0..blocks).find(|&block| {
        let high = |quarter: usize| (4 * block / period + quarter) % 4 < 2;
        let [a, b] = [high(0), high(1)];
        let [a, not_a, b, not_b] = core::array::from_fn(|n| [a, !a, b, !b][n] && !broken[n]);
        wires.look([(a, not_a), (b, not_b)])
    })
}

#[test]
fn one_broken_wire_is_found_in_motion_and_two_at_rest() {
    for wire in 0..4 {
        let broken = core::array::from_fn(|n| n == wire);
        // Within one period of any length, and within 24 blocks for a period of four.
        for period in [4, 40, 400] {
            let found = looks(period, 2 * period + 24, broken);
            assert!(found.is_some(), "wire {wire}, period {period}");
        }
    }
    assert_eq!(looks(1_000_000, 100, [true, true, false, false]), Some(2));
}

#[test]
fn intact_wires_are_accepted_even_during_an_edge() {
    assert_eq!(looks(4, 1000, [false; 4]), None);
    assert_eq!(looks(400, 1000, [false; 4]), None);
    let mut wires = Wires::default();
    let glitches = |block: usize| block.is_multiple_of(5);
    assert!((0..1000).all(|block| !wires.look([(true, glitches(block)), (false, true)])));
}

#[test]
fn a_repaired_line_is_accepted_after_a_delay() {
    let mut wires = Wires::default();
    assert!((0..20).fold(false, |_, _| wires.look([(false, false), (true, false)])));
    let sound = (0..100).position(|_| !wires.look([(true, false), (true, false)]));
    assert_eq!(sound, Some(23));
}
