//! Files that are not a valid update for this board are refused with their defect, and no image
//! changes.

use std::vec::Vec;

use firmware::board::update::{UpdateDefect as Defect, UpdateState};

use super::board::{Board, ORIGIN, PROTOCOL, file, image, target, update_to};
use super::flash::{DamagedRead, PAGE_BYTES};
use crate::check::{Depth, GROUP_ORDER, Target};
use crate::identity::board;
use crate::key::{DEVELOPMENT, DEVELOPMENT_SEED, public};
use crate::manifest::{MANIFEST, Manifest, SIGNED};

/// Returns the defect of a refused file. Checks that the slot, the state and the started image do
/// not change.
fn refused(file: &[u8]) -> Defect {
    let board = Board::new(DamagedRead::Zeros);
    let parts = |board: &Board| {
        let (slot, state, part) = (board.slot(), board.state(), board.part.borrow());
        [slot, state].map(|area| part.bytes[area.from..area.from + area.size].to_vec())
    };
    let before = parts(&board);
    let state = board.update(file).expect("obeyed");
    assert_eq!(parts(&board), before, "{state:?}");
    assert_eq!(board.start(), Some(1));
    let UpdateState::Refused(defect) = state else { panic!("{state:?}") };
    defect
}

/// Returns a file whose manifest was changed before it was signed.
fn with(change: impl FnOnce(&mut Manifest)) -> Vec<u8> {
    let (mut manifest, image) = image(2);
    change(&mut manifest);
    file((manifest, image))
}

#[test]
fn another_board_protocol_origin_or_length_is_refused() {
    assert_eq!(refused(&with(|manifest| manifest.identity.board = board("another"))), Defect::OtherBoard);
    assert_eq!(refused(&with(|manifest| manifest.identity.protocol = PROTOCOL - 1)), Defect::OlderProtocol(PROTOCOL - 1));
    assert_eq!(refused(&with(|manifest| manifest.origin = 0x0800_0000)), Defect::OtherOrigin(0x0800_0000));
    assert_eq!(refused(&with(|manifest| manifest.length -= 1)), Defect::Length(image(2).0.length - 1));
    let mut long = file(image(2));
    long.resize(target().room as usize + MANIFEST + 1, 0);
    assert_eq!(refused(&long), Defect::Length(long.len() as u32));
    assert_eq!(refused(&[0x7f; 3 * PAGE_BYTES]), Defect::NotAnUpdate);
    assert_eq!(refused(&[]), Defect::Length(0));
}

#[test]
fn every_damaged_byte_of_a_file_is_detected() {
    let whole = file(image(2));
    // All used bytes of the manifest, and every 31st byte of the image.
    for at in (0..SIGNED + 64 + 4).chain((MANIFEST..whole.len()).step_by(31)) {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x10;
        let expected = if at < 8 { Defect::NotAnUpdate } else { Defect::Damaged };
        assert_eq!(refused(&damaged), expected, "byte {at}");
    }
}

#[test]
fn an_unsigned_file_or_one_signed_by_another_key_is_refused() {
    let (manifest, image) = image(2);
    let unsigned = [manifest.encode().as_slice(), &image].concat();
    assert_eq!(refused(&unsigned), Defect::Unsigned);
    let stranger = [manifest.signed_by(&[7; 32]).encode().as_slice(), &image].concat();
    assert_eq!(refused(&stranger), Defect::WrongSignature);
    // A signature by the right key, but of another image.
    let other = Manifest { signature: super::board::image(3).0.signed_by(&DEVELOPMENT_SEED).signature, ..manifest };
    assert_eq!(refused(&[other.encode().as_slice(), &image].concat()), Defect::WrongSignature);
    // A forged checksum does not help: the digest is signed.
    let mut forged = image.clone();
    forged[100] ^= 1;
    let checksum = Manifest::of(manifest.identity, ORIGIN, &forged).checksum;
    let manifest = Manifest { checksum, ..manifest }.signed_by(&DEVELOPMENT_SEED);
    assert_eq!(refused(&[manifest.encode().as_slice(), &forged].concat()), Defect::WrongSignature);
}

#[test]
fn the_first_stage_starts_no_image_that_was_only_marked() {
    use embassy_boot::BlockingFirmwareState;
    use embedded_storage::nor_flash::NorFlash as _;
    let (manifest, image) = image(2);
    for file in [[manifest.signed_by(&[7; 32]).encode().as_slice(), &image].concat(), [0xff; 3 * PAGE_BYTES].to_vec()] {
        let board = Board::new(DamagedRead::Zeros);
        let mut bytes = file;
        bytes.resize(bytes.len().next_multiple_of(8), 0xff);
        board.store().write(0, &bytes).expect("written");
        BlockingFirmwareState::new(board.state(), &mut [0; 8]).mark_updated().expect("marked");
        assert_eq!([board.start(), board.start()], [Some(1); 2]);
    }
}

#[test]
fn a_signature_with_the_group_order_added_is_refused() {
    let (manifest, image) = image(2);
    let mut manifest = manifest.signed_by(&DEVELOPMENT_SEED);
    let mut carry = 0;
    for (byte, order) in manifest.signature[32..].iter_mut().zip(GROUP_ORDER) {
        let sum = u16::from(*byte) + u16::from(order) + carry;
        (*byte, carry) = (sum as u8, sum >> 8);
    }
    assert_eq!(refused(&[manifest.encode().as_slice(), &image].concat()), Defect::WrongSignature);
}

#[test]
fn each_key_of_a_board_is_accepted() {
    let (manifest, image) = image(2);
    let board = Board::new(DamagedRead::Zeros);
    for seed in [DEVELOPMENT_SEED, [7; 32]] {
        board.part.borrow_mut().load(0, &[manifest.signed_by(&seed).encode().as_slice(), &image].concat());
        let keys = Vec::leak(Vec::from([DEVELOPMENT, public(&[7; 32])]));
        assert!(Target { keys, ..target() }.image(&mut board.slot(), 0, Depth::Signature).is_ok());
    }
    assert_eq!(target().image(&mut board.slot(), 0, Depth::Signature), Err(Defect::WrongSignature));
}

#[test]
fn an_older_version_is_refused_unless_it_is_confirmed_at_the_board() {
    let board = Board::new(DamagedRead::Zeros);
    board.update(update_to(2)).expect("received");
    assert_eq!(board.start(), Some(2));
    // On trial the version is not yet the lowest accepted one: the former image returns.
    let returned = board.copy();
    assert_eq!(returned.start(), Some(1));
    assert_eq!(returned.update(update_to(1)), Ok(UpdateState::Marked));
    board.confirm();
    let older = Defect::OlderVersion { running: [0, 0, 2], offered: [0, 0, 1] };
    for _ in 0..2 {
        assert_eq!(board.update(update_to(1)), Ok(UpdateState::Refused(older)));
        assert_eq!(board.copy().update(update_to(2)), Ok(UpdateState::Marked), "an equal version");
        // Power off and on.
        board.part.borrow_mut().power();
        assert_eq!(board.start(), Some(2));
    }
    let held = Board { is_confirmed: || true, ..board };
    assert_eq!(held.update(update_to(1)), Ok(UpdateState::Marked));
    assert_eq!(held.start(), Some(1));
}
