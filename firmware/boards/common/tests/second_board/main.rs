//! Complete example board, built from the shared parts: blocks of 64 samples at 500 kHz, a 150 MHz
//! processor, and two lanes with a buffer of four words. Its rings, DMA counters and time are
//! simulated; a capacitor is connected to it.

mod board;
mod part;

use boards_common::packing::word;
use firmware::seam::block::{LATENCY_BLOCKS, Orders, Request};
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;

use self::board::{BLOCK, Board, CYCLES_PER_BLOCK, SILENCE};
use self::part::Stream;

/// Usual duration of the interrupt, cycles.
const USUAL_CYCLES: u32 = CYCLES_PER_BLOCK / 2;

/// Returns a board that drives.
fn driving() -> Board {
    let mut board = Board::new();
    board.order(Orders { sequence: 1, attempt: 1, request: Request::Run, ..Orders::default() });
    let drives = (0..400).any(|_| {
        board.block(USUAL_CYCLES);
        board.latest().mode == Mode::Run && board.latest().envelope > 0.9
    });
    assert!(drives, "{:?}", board.latest());
    board
}

/// Returns `true` if the last played block is completely silent.
fn is_silent(board: &Board) -> bool {
    board.part.played.iter().rev().take(BLOCK).all(|&played| played == word(SILENCE, SILENCE))
}

#[test]
fn drives_and_plays_each_answer_two_blocks_later() {
    let mut board = driving();
    // The interrupt may take any time up to its deadline: a block minus the four samples that are
    // fetched early, 93 %.
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
    board.block(USUAL_CYCLES);
    assert_eq!((board.missed(), board.latest().fault), (Some(1), Some(Fault::LateBlock)));
    board.block(USUAL_CYCLES);
    board.block(USUAL_CYCLES);
    assert!(is_silent(&board) && !board.has_ended, "the streams are complete and continue");
}

#[test]
fn a_block_that_is_missed_mutes_with_the_next() {
    let mut board = driving();
    board.mask(CYCLES_PER_BLOCK);
    board.block(USUAL_CYCLES);
    assert_eq!((board.missed(), board.latest().fault), (Some(1), Some(Fault::LateBlock)));
    board.block(USUAL_CYCLES);
    board.block(USUAL_CYCLES);
    assert!(is_silent(&board) && !board.has_ended, "the streams are complete and continue");
    assert_eq!(board.missed(), Some(0));
}

#[test]
fn a_lost_trigger_ends_the_stream_in_silence() {
    for stream in [Stream::Adc, Stream::Dac] {
        let mut board = driving();
        board.part.lose_a_trigger(stream);
        board.block(USUAL_CYCLES);
        assert!(board.has_ended, "{stream:?}");
        board.part.advance(CYCLES_PER_BLOCK + CYCLES_PER_BLOCK / 4);
        assert!(is_silent(&board), "{stream:?}");
    }
}
