//! The rings: halves, slots, steps, late blocks, packed words, received bytes.

use firmware::seam::block::{DriveBlock, LATENCY_BLOCKS, SenseBlock};
use std::cell::Cell;

use nucleo_g474re::blocks::{BLOCK, Beat, CYCLES_PER_BLOCK, Half, RING, Step, is_in_time, position, slot};
use nucleo_g474re::packing;
use nucleo_g474re::ring::Reader;

/// DMA's own count: it begins at the size, and again after one.
fn remaining(moved: usize) -> u16 {
    (RING - moved % RING) as u16
}

#[test]
fn a_position_counts_up_while_dma_counts_down() {
    let block = BLOCK as u16;
    assert_eq!([2 * block, 2 * block - 1, block + 1, block, 1].map(position), [0, 1, BLOCK - 1, BLOCK, RING - 1]);
    // A state that it may show for a moment after a restart.
    assert_eq!(position(0), 0);
    assert!((0..3 * RING).all(|moved| position(remaining(moved)) == moved % RING));
}

/// A DAC and an ADC in lockstep, with an interrupt whenever a half of the ADC's ring is full, that leaves the number of the block and the sample:
/// what plays while the ADC converts sample `n` of block `k` is what was left for it `LATENCY_BLOCKS` before.
#[test]
fn a_block_plays_two_blocks_later_with_its_own_samples() {
    let mut ring = [usize::MAX; RING];
    let (mut fetched, mut held, mut played) = (0, usize::MAX, Vec::new());
    for trigger in 0..8 * BLOCK {
        // The trigger plays what is held, and then asks for the next one.
        played.push(held);
        held = ring[fetched % RING];
        fetched += 1;
        // The sample is converted before the next trigger.
        let converted = trigger + 1;
        if converted.is_multiple_of(BLOCK) {
            let half = Half::at(position(remaining(converted))).other();
            let block = converted / BLOCK - 1;
            for sample in 0..BLOCK {
                ring[slot(half, sample)] = (block + LATENCY_BLOCKS) * BLOCK + sample;
            }
            assert!(is_in_time(half, fetched % RING));
        }
    }
    let first = LATENCY_BLOCKS * BLOCK;
    assert_eq!(played[first..], (first..8 * BLOCK).collect::<Vec<_>>()[..]);
}

#[test]
fn a_block_is_late_once_its_first_sample_may_have_been_fetched() {
    // The first half begins in the last place of the ring: in time while DMA is in the second half before that.
    let in_time = |half| (0..RING).filter(|&next| is_in_time(half, next)).collect::<Vec<_>>();
    assert_eq!(in_time(Half::First), (BLOCK - 1..RING - 1).collect::<Vec<_>>());
    assert_eq!(in_time(Half::Second), (0..BLOCK - 1).chain([RING - 1]).collect::<Vec<_>>());
}

#[test]
fn missed_blocks_are_counted_across_wrap_and_jitter() {
    let mut beat = Beat::default();
    let start = u32::MAX - CYCLES_PER_BLOCK;
    let at = |blocks: f32| start.wrapping_add((blocks * CYCLES_PER_BLOCK as f32) as u32);
    // The last one: one was missed, and the next came early after a late one.
    let missed = [0.0, 1.0, 2.4, 3.0, 5.0, 9.4, 10.0, 10.4, 12.0].map(|blocks| beat.missed(at(blocks)));
    assert_eq!(missed, [0, 0, 0, 0, 1, 3, 0, 0, 1]);
}

/// Positions in both rings at a time in samples: the DAC is two ahead, and moves an eighth of a sample before the ADC; `lost` samples of each are lost.
fn positions(at: f64, lost: (usize, usize)) -> (usize, usize) {
    let (adc, dac) = (at + RING as f64, at + RING as f64 + 2.125);
    ((adc as usize - lost.0) % RING, (dac as usize - lost.1) % RING)
}

#[test]
fn streams_are_in_step_until_one_has_lost_a_sample() {
    // Each block is looked at somewhere in its first sample, the first one too. In the moment in which the DAC has moved and the ADC has not, what one has lost
    // may not show: the next block shows it.
    for first in 0..20 {
        for part in 0..20 {
            for lost in [(0, 0), (1, 0), (0, 1), (2, 0), (0, 3)] {
                let mut step = Step::default();
                let mut holds = |mut at: f64, lost| {
                    step.holds(positions(at, lost), || {
                        at += 1.0 / 3.0;
                        positions(at, lost)
                    })
                };
                assert!(holds(BLOCK as f64 + f64::from(first) / 20.0, (0, 0)));
                let holds = holds(RING as f64 + f64::from(part) / 20.0, lost);
                assert!(holds == (lost == (0, 0)) || part > 17, "{first} {part} {lost:?}");
                assert!(holds || lost != (0, 0), "{first} {part}");
            }
        }
    }
}

#[test]
fn words_hold_both_channels_and_both_lanes() {
    let mut sense = SenseBlock::default();
    packing::sense(&[0x1ffe_0003, 0x0000_1fff], |word| *word, &mut sense);
    assert_eq!((&sense.v[..], &sense.i[..]), (&[0x0003, 0x1fff][..], &[0x1ffe, 0x0000][..]));
    // Nothing of the one before stays.
    const ODD: usize = BLOCK - 3;
    let ring: [u32; ODD] = core::array::from_fn(|n| (n << 16 | (n + 1)) as u32);
    packing::sense(&ring, |word| *word, &mut sense);
    assert_eq!((sense.v.len(), sense.v[0], sense.i[ODD - 1]), (ODD, 1, ODD as u16 - 1));

    let lanes = |codes: &[u16]| codes.iter().copied().collect();
    let drive = DriveBlock {
        lanes: [lanes(&[1, 2]), lanes(&[3, 4]), lanes(&[5, 6])].into_iter().collect(),
        listen: 0,
        drops_queue: false,
    };
    let words = |pair: usize| {
        let ring = [const { Cell::new(0) }; 2];
        packing::drive(&drive, pair, 2048, (&ring[1], &ring[..1]), Cell::set);
        [ring[1].get(), ring[0].get()]
    };
    assert_eq!(words(0), [0x0003_0001, 0x0004_0002]);
    // The fourth lane is not there, nor is a third pair.
    assert_eq!(words(1), [0x0800_0005, 0x0800_0006]);
    assert_eq!(words(2), [0x0800_0800; 2]);
}

#[test]
fn bytes_are_taken_once_and_in_order_around_the_rings_end() {
    const ROOM: usize = 8;
    let mut reader = Reader::<ROOM>::default();
    let (mut ring, mut filled, mut taken) = ([0; ROOM], 0usize, Vec::new());
    for burst in [3, 0, 7, 1, 5, 2, 7] {
        for _ in 0..burst {
            ring[filled % ROOM] = filled;
            filled += 1;
        }
        let remaining = (ROOM - filled % ROOM) as u16;
        assert_eq!(reader.waiting(remaining), burst);
        while let Some(place) = reader.take(remaining) {
            taken.push(ring[place]);
        }
    }
    assert_eq!(taken, (0..filled).collect::<Vec<_>>());
}
