//! Files that are not a valid update for this board are refused with their defect, and no image
//! changes.

use std::vec::Vec;

use firmware::board::update::{UpdateDefect as Defect, UpdateState};

use super::board::{Board, ORIGIN, PROTOCOL, file, image, target};
use super::flash::{DamagedRead, PAGE_BYTES};
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
fn the_development_key_is_the_one_that_is_published() {
    assert_eq!(public(&DEVELOPMENT_SEED), DEVELOPMENT);
}
