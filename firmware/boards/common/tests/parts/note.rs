//! Note of the reason why a run ended.

use boards_common::note::{Cause, Note};
use firmware::board::start::{FileName, Place, Start};

#[test]
fn a_note_is_read_back_with_the_end_of_a_long_name() {
    let note = Note::new(Cause::Panic, "src/image.rs", 81);
    assert_eq!(note.read(), Some((Cause::Panic, "src/image.rs", 81)));
    let long = format!("/{}/src/lib.rs", "x".repeat(60));
    let (_, name, _) =
        Note::new(Cause::StreamLost, &long, 7).read().map(|(cause, name, line)| (cause, name.to_owned(), line)).unwrap();
    assert_eq!((name.len(), name.ends_with("x/src/lib.rs")), (40, true));
}

#[test]
fn a_note_gives_the_cause_of_the_start() {
    let file = FileName::of("src/image.rs");
    let rows = [
        (Cause::Panic, Start::Panic(Place { file, line: 81 })),
        (Cause::HardFault, Start::HardFault(81)),
        (Cause::Unexpected, Start::Unexpected(81)),
        (Cause::StreamLost, Start::StreamLost(81)),
        (Cause::Ordered, Start::Ordered),
        (Cause::DamagedCode, Start::DamagedCode(81)),
        (Cause::ClockFailed, Start::ClockFailed),
        (Cause::StackOverflow, Start::StackOverflow(81)),
        (Cause::SupplyLow, Start::SupplyLow),
        (Cause::RamParity, Start::RamParity),
    ];
    assert_eq!(rows.map(|(cause, _)| cause), Cause::ALL);
    // These numbers are part of the stored format: another image may read the note.
    assert_eq!(rows.map(|(cause, _)| cause as u8), [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]);
    for (cause, start) in rows {
        assert_eq!(Note::new(cause, "src/image.rs", 81).start(), Some(start));
    }
    assert_eq!(Note::BLANK.start(), None);
}

#[test]
fn random_ram_is_not_a_note() {
    assert_eq!(Note::BLANK.read(), None);
    // One bit has changed since.
    let mut note = Note::new(Cause::Panic, "src/image.rs", 81);
    note.line = 80;
    assert_eq!(note.read(), None);
    assert!(Note::new(Cause::HardFault, "", 0x0800_1234).read().is_some());
    // The cut splits a character of two bytes.
    let cut = Note::new(Cause::Panic, &"ä".repeat(21)[..42].replacen('ä', "-", 1), 1);
    assert!(cut.read().is_some());
}
