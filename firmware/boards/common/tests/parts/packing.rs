//! Words of both channels and of two lanes.

use std::cell::Cell;

use boards_common::packing;
use firmware::seam::block::{DriveBlock, SenseBlock};

#[test]
fn words_hold_both_channels() {
    let mut sense = SenseBlock::default();
    packing::sense(&[0x1ffe_0003, 0x0000_1fff], |word| *word, &mut sense);
    assert_eq!((&sense.v[..], &sense.i[..]), (&[0x0003, 0x1fff][..], &[0x1ffe, 0x0000][..]));
    // Nothing of the previous block remains.
    const ODD: usize = 97;
    let ring: [u32; ODD] = core::array::from_fn(|n| (n << 16 | (n + 1)) as u32);
    packing::sense(&ring, |word| *word, &mut sense);
    assert_eq!((sense.v.len(), sense.v[0], sense.i[ODD - 1]), (ODD, 1, ODD as u16 - 1));
}

/// Returns the words of a pair of lanes, in the order in which they play.
fn words<const AHEAD: usize>(drive: &DriveBlock, pair: usize) -> Vec<u32> {
    let samples = drive.lanes.first().map_or(0, |codes| codes.len());
    let (head, tail) = ([const { Cell::new(0) }; AHEAD], vec![Cell::new(0); samples - AHEAD]);
    packing::drive(drive, pair, 2048, (&head, &tail), Cell::set);
    head.iter().chain(&tail).map(Cell::get).collect()
}

#[test]
fn words_hold_both_lanes() {
    let lanes = |codes: &[u16]| codes.iter().copied().collect();
    let drive = DriveBlock {
        lanes: [lanes(&[1, 2]), lanes(&[3, 4]), lanes(&[5, 6])].into_iter().collect(),
        listen: 0,
        drops_queue: false,
    };
    assert_eq!(words::<1>(&drive, 0), [0x0003_0001, 0x0004_0002]);
    // The fourth lane and the third pair do not exist.
    assert_eq!(words::<1>(&drive, 1), [0x0800_0005, 0x0800_0006]);
    assert_eq!(words::<1>(&drive, 2), [0x0800_0800; 2]);
    assert_eq!(words::<0>(&drive, 0), words::<1>(&drive, 0));
}

#[test]
fn lanes_of_any_length_are_written_whole() {
    for samples in [7, 64, 100] {
        let lane = |from: u16| (from..from + samples).collect();
        let both = DriveBlock { lanes: [lane(0), lane(1000)].into_iter().collect(), ..DriveBlock::default() };
        let one = DriveBlock { lanes: [lane(0)].into_iter().collect(), ..DriveBlock::default() };
        let expected: Vec<_> = (0..samples).map(|n| packing::word(n, 1000 + n)).collect();
        assert_eq!((words::<1>(&both, 0), words::<4>(&both, 0)), (expected.clone(), expected));
        let expected: Vec<_> = (0..samples).map(|n| packing::word(n, 2048)).collect();
        assert_eq!((words::<1>(&one, 0), words::<4>(&one, 0)), (expected.clone(), expected));
    }
}
