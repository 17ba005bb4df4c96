//! Positions, halves and slots of rings, and late blocks, for the block lengths of several boards
//! and for DACs that fetch words early.

use boards_common::half::Half;
use boards_common::position::position;
use firmware::seam::block::LATENCY_BLOCKS;

/// Returns the counter of DMA: it starts at the size, and restarts there after one.
fn remaining<const RING: usize>(moved: usize) -> usize {
    RING - moved % RING
}

#[test]
fn a_position_counts_up_while_dma_counts_down() {
    assert_eq!([200, 199, 101, 100, 1].map(position::<200>), [0, 1, 99, 100, 199]);
    // DMA may show this value for a moment after a restart.
    assert_eq!(position::<200>(0), 0);
    assert!((0..3 * 128).all(|moved| position::<128>(remaining::<128>(moved)) == moved % 128));
}

/// Simulates a DAC and an ADC in lockstep, with an interrupt whenever a half of the ADC's ring is
/// full.
///
/// The interrupt writes the number of the block and the sample. While the ADC converts sample `n`
/// of block `k`, the DAC must play the value that was written for it `LATENCY_BLOCKS` earlier.
fn plays_its_own_samples<const RING: usize, const AHEAD: usize>() {
    let block = Half::<RING>::BLOCK;
    let mut ring = [usize::MAX; RING];
    let (mut fetched, mut held, mut played) = (0, vec![usize::MAX; AHEAD], Vec::new());
    for trigger in 0..8 * block {
        // The trigger plays the oldest held word, then requests the next one.
        held.push(ring[fetched % RING]);
        played.push(held.remove(0));
        fetched += 1;
        // The sample is converted before the next trigger.
        let converted = trigger + 1;
        if converted.is_multiple_of(block) {
            let half = Half::<RING>::at(position::<RING>(remaining::<RING>(converted))).other();
            let number = converted / block - 1;
            for sample in 0..block {
                ring[half.slot::<AHEAD>(sample)] = (number + LATENCY_BLOCKS) * block + sample;
            }
            assert!(half.is_in_time::<AHEAD>(fetched % RING));
        }
    }
    let first = LATENCY_BLOCKS * block;
    assert_eq!(played[first..], (first..8 * block).collect::<Vec<_>>()[..], "{RING} {AHEAD}");
}

#[test]
fn a_block_plays_two_blocks_later_with_its_own_samples() {
    plays_its_own_samples::<200, 1>();
    plays_its_own_samples::<128, 1>();
    plays_its_own_samples::<64, 0>();
    plays_its_own_samples::<128, 4>();
    plays_its_own_samples::<6, 2>();
}

fn has_each_place_once<const RING: usize, const AHEAD: usize>() {
    let ring: [usize; RING] = core::array::from_fn(|place| place);
    for half in [Half::<RING>::First, Half::Second] {
        let (head, tail) = half.played::<AHEAD, _>(&ring);
        let slots: Vec<_> = (0..Half::<RING>::BLOCK).map(|sample| half.slot::<AHEAD>(sample)).collect();
        assert_eq!([&head[..], tail].concat(), slots, "{RING} {AHEAD} {half:?}");
        assert_eq!(half.filled(&ring), (half.start()..half.start() + Half::<RING>::BLOCK).collect::<Vec<_>>());
    }
}

#[test]
fn the_places_of_a_half_are_its_slots_in_order() {
    has_each_place_once::<200, 1>();
    has_each_place_once::<128, 4>();
    has_each_place_once::<64, 0>();
}

#[test]
fn a_block_is_late_once_its_first_sample_may_have_been_fetched() {
    const BLOCK: usize = 100;
    const RING: usize = 2 * BLOCK;
    // The first half begins in the last place of the ring: it is in time while DMA is in the second
    // half before that place.
    let in_time = |half: Half<RING>| (0..RING).filter(|&next| half.is_in_time::<1>(next)).collect::<Vec<_>>();
    assert_eq!(in_time(Half::First), (BLOCK - 1..RING - 1).collect::<Vec<_>>());
    assert_eq!(in_time(Half::Second), (0..BLOCK - 1).chain([RING - 1]).collect::<Vec<_>>());
    // With four words early it begins in the fourth place before the end.
    let in_time = |half: Half<RING>| (0..RING).filter(|&next| half.is_in_time::<4>(next)).collect::<Vec<_>>();
    assert_eq!(in_time(Half::First), (BLOCK - 4..RING - 4).collect::<Vec<_>>());
}
