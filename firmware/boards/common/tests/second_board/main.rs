//! A whole board of another kind, built of the common parts: blocks of 64 samples at 500 kHz, a processor of 150 MHz, and two lanes behind a buffer of four
//! words. Its rings, its counters of DMA and its time are simulated; a capacitor is at its pins.

mod board;
mod part;

use boards_common::packing::word;
use firmware::seam::block::{LATENCY_BLOCKS, Orders, Request};
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;

use self::board::{BLOCK, Board, CYCLES_PER_BLOCK, SILENCE};
use self::part::Stream;

/// What the interrupt takes in the most usual of blocks, cycles.
const USUAL: u32 = CYCLES_PER_BLOCK / 2;

/// A board that drives.
fn driving() -> Board {
    let mut board = Board::new();
    board.order(Orders { sequence: 1, attempt: 1, request: Request::Run, ..Orders::default() });
    let drives = (0..400).any(|_| {
        board.block(USUAL);
        board.latest().mode == Mode::Run && board.latest().envelope > 0.9
    });
    assert!(drives, "{:?}", board.latest());
    board
}

/// Whether all of the last block that has played is silent.
fn is_silent(board: &Board) -> bool {
    board.part.played.iter().rev().take(BLOCK).all(|&played| played == word(SILENCE, SILENCE))
}

#[test]
fn drives_and_plays_each_answer_two_blocks_later() {
    let mut board = driving();
    // However long the interrupt takes, as long as it is in time: a block less the four samples that are fetched early, 93 %.
    for parts in [1, 40, 90, 93, 2].into_iter().cycle().take(100) {
        board.block(CYCLES_PER_BLOCK / 100 * parts);
        assert_eq!((board.missed(), board.latest().fault), (Some(0), None));
    }
    let answered =
        board.answers.iter().flat_map(|answer| answer.lanes[0].iter().zip(&answer.lanes[1]).map(|(a, b)| word(*a, *b)));
    let played = &board.part.played[LATENCY_BLOCKS * BLOCK..];
    assert!(answered.zip(played).all(|(answered, played)| answered == *played));
    assert!(!is_silent(&board) && !board.has_ended);
}

#[test]
fn a_block_that_is_written_too_late_mutes_with_the_next() {
    let mut board = driving();
    board.block(CYCLES_PER_BLOCK + 1000);
    assert_eq!((board.missed(), board.latest().fault), (Some(0), None));
    board.block(USUAL);
    assert_eq!((board.missed(), board.latest().fault), (Some(1), Some(Fault::LateBlock)));
    board.block(USUAL);
    board.block(USUAL);
    assert!(is_silent(&board) && !board.has_ended, "the streams are whole, and go on");
}

#[test]
fn a_block_that_is_missed_mutes_with_the_next() {
    let mut board = driving();
    board.mask(CYCLES_PER_BLOCK);
    board.block(USUAL);
    assert_eq!((board.missed(), board.latest().fault), (Some(1), Some(Fault::LateBlock)));
    board.block(USUAL);
    board.block(USUAL);
    assert!(is_silent(&board) && !board.has_ended, "the streams are whole, and go on");
    assert_eq!(board.missed(), Some(0));
}

#[test]
fn a_lost_trigger_of_either_converter_ends_the_stream_in_silence() {
    for stream in [Stream::Adc, Stream::Dac] {
        let mut board = driving();
        board.part.lose_a_trigger(stream);
        board.block(USUAL);
        assert!(board.has_ended, "{stream:?}");
        board.part.advance(CYCLES_PER_BLOCK + CYCLES_PER_BLOCK / 4);
        assert!(is_silent(&board), "{stream:?}");
    }
}
