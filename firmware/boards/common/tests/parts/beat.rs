//! Missed blocks, counted by a cycle counter.

use boards_common::beat::Beat;

fn are_counted<const CYCLES_PER_BLOCK: u32>() {
    let mut beat = Beat::<CYCLES_PER_BLOCK>::default();
    let start = u32::MAX - CYCLES_PER_BLOCK;
    let at = |blocks: f32| start.wrapping_add((blocks * CYCLES_PER_BLOCK as f32) as u32);
    // The last call: one block was missed, and the call is early after a late one.
    let missed = [0.0, 1.0, 2.4, 3.0, 5.0, 9.4, 10.0, 10.4, 12.0].map(|blocks| beat.missed(at(blocks)));
    assert_eq!(missed, [0, 0, 0, 0, 1, 3, 0, 0, 1], "{CYCLES_PER_BLOCK}");
}

#[test]
fn missed_blocks_are_counted_across_wrap_and_jitter() {
    are_counted::<17_000>();
    are_counted::<19_200>();
    are_counted::<61_440>();
}
