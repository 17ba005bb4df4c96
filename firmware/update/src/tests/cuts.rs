//! Power cuts at each operation of the flash, once or several times: the old or the new image
//! always starts.

use std::vec::Vec;

use firmware::board::update::{CHUNK, Standing, UpdateState, UpdateVerb, Updates};

use super::board::{Board, target, update_to};
use super::flash::DamagedRead;
use crate::check::Depth;

const DAMAGED_READS: [DamagedRead; 2] = [DamagedRead::Zeros, DamagedRead::Bits];

/// Updates from version 1 to 2 and confirms it, unless the power fails.
fn update(board: &Board) {
    if board.update(update_to(2)).is_ok() && board.start().is_some() {
        board.confirm();
    }
}

/// Returns the number of flash operations of an action.
fn operations(board: &Board, act: impl Fn(&Board)) -> u64 {
    let board = board.copy();
    let before = board.part.borrow().operations;
    act(&board);
    let after = board.part.borrow().operations;
    after - before
}

/// Runs an action with the power cut in operation `n`, counted from one.
fn cut(board: &Board, n: u64, act: impl Fn(&Board)) -> Board {
    let board = board.copy();
    {
        let mut part = board.part.borrow_mut();
        part.cut = Some(part.operations + n);
    }
    act(&board);
    assert!(board.part.borrow().is_off(), "the power was cut");
    board.part.borrow_mut().power();
    board
}

#[test]
fn an_update_starts_on_trial_and_stays_once_confirmed() {
    let board = Board::new(DamagedRead::Zeros);
    assert_eq!(board.start(), Some(1));
    assert_eq!(board.update(update_to(2)), Ok(UpdateState::Marked));
    assert_eq!(board.start(), Some(2));
    assert_eq!(board.confirm(), Standing::Confirmed);
    assert_eq!([board.start(), board.start()], [Some(2); 2]);
    // A further update replaces it.
    assert_eq!(board.update(update_to(3)), Ok(UpdateState::Marked));
    assert_eq!(board.start(), Some(3));
}

#[test]
fn an_image_that_is_not_confirmed_is_rolled_back() {
    let board = Board::new(DamagedRead::Zeros);
    board.update(update_to(2)).expect("received");
    assert_eq!([board.start(), board.start(), board.start()], [Some(2), Some(1), Some(1)]);
    let mut receiver = board.receiver();
    assert_eq!(receiver.report().standing, Standing::RolledBack);
    // The board can still be updated.
    update(&board);
    assert_eq!(board.start(), Some(2));
}

#[test]
fn the_board_starts_after_a_cut_at_any_operation() {
    for reads in DAMAGED_READS {
        let fresh = Board::new(reads);
        let mut versions = [0; 3];
        let count = operations(&fresh, update);
        for n in 1..=count {
            let board = cut(&fresh, n, update);
            let version = board.start().unwrap_or_else(|| panic!("{reads:?}, cut at {n} of {count}: nothing starts"));
            versions[usize::from(version)] += 1;
            // The next update must succeed after any cut. Only some cuts are tested, because
            // signatures take time.
            board.confirm();
            if n % 16 != 0 {
                continue;
            }
            assert_eq!(board.update(update_to(3)), Ok(UpdateState::Marked), "{reads:?}, cut at {n}");
            assert_eq!(board.start(), Some(3), "{reads:?}, cut at {n}");
        }
        std::println!("{count} operations, {reads:?}: old image after {}, new image after {}", versions[1], versions[2]);
        assert!(versions[1] > 0 && versions[2] > 0);
    }
}

#[test]
fn a_cut_during_the_rollback_leaves_the_former_image() {
    for reads in DAMAGED_READS {
        let trial = Board::new(reads);
        trial.update(update_to(2)).expect("received");
        assert_eq!(trial.start(), Some(2));
        let start = |board: &Board| {
            board.start();
        };
        for n in 1..=operations(&trial, start) {
            assert_eq!(cut(&trial, n, start).start(), Some(1), "{reads:?}, cut at {n}");
        }
    }
}

#[test]
fn further_cuts_do_no_harm() {
    let start = |board: &Board| {
        board.start();
    };
    let (mut seed, mut cuts) = (1_u64, 0);
    for reads in DAMAGED_READS {
        let fresh = Board::new(reads);
        // The first cut is at every fifth operation, each followed by two more cuts at random
        // operations.
        for n in (1..=operations(&fresh, update)).step_by(5) {
            let mut board = cut(&fresh, n, update);
            for _ in 0..2 {
                let left = operations(&board, start);
                if left == 0 {
                    break;
                }
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                board = cut(&board, 1 + (seed >> 33) % left, start);
                cuts += 1;
            }
            assert!(board.start().is_some(), "{reads:?}, first cut at {n}");
        }
    }
    std::println!("{cuts} further cuts");
}

#[test]
fn a_damaged_slot_is_replaced_from_the_store() {
    // After a swap the former image is one page further on.
    let board = Board::new(DamagedRead::Zeros);
    update(&board);
    board.part.borrow_mut().damage(1000);
    assert_eq!(board.start(), Some(1));
    // An update that was received but not installed.
    let board = Board::new(DamagedRead::Zeros);
    let mut receiver = board.receiver();
    receive(&mut receiver, update_to(2));
    board.part.borrow_mut().damage(1000);
    assert_eq!(board.start(), Some(2));
    // Without an image in the store nothing starts, for any content of the slot.
    let board = Board::new(DamagedRead::Zeros);
    board.part.borrow_mut().damage(1000);
    assert_eq!(board.start(), None);
    assert!(target().image(&mut board.slot(), 0, Depth::Checksum).is_err());
}

fn receive(receiver: &mut impl Updates, file: &[u8]) {
    let mut bytes: Vec<u8> = file.to_vec();
    bytes.resize(file.len().next_multiple_of(CHUNK), 0xff);
    receiver.obey(&UpdateVerb::Begin(file.len() as u32)).expect("accepted");
    for (n, piece) in bytes.chunks_exact(CHUNK).enumerate() {
        let chunk = core::array::from_fn(|row| core::array::from_fn(|n| piece[32 * row + n]));
        receiver.obey(&UpdateVerb::Write((n * CHUNK) as u32, chunk)).expect("accepted");
    }
}
