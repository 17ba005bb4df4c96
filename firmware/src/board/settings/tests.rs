//! Stored settings: their format in flash, and settings left by another version.

mod copies;
mod orders;

use embedded_storage::nor_flash::{ErrorType, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use heapless::spsc::Queue;

use super::*;
use crate::board::command::{Reply, Verb};
use crate::board::parameters::MAX_PARAMETERS;
use crate::board::power_up::PowerUp;
use crate::board::settings_store::SettingsStore;
use crate::seam::config::{Trim, TrimPoint};
use crate::seam::refusal::Refusal;

fn value<T: Serialize>(version: u8, number: u32, value: &T) -> std::vec::Vec<u8> {
    let mut buffer = [0; MAX_VALUE_BYTES];
    let body = postcard::to_slice(value, &mut buffer).unwrap();
    [&[version], &number.to_le_bytes()[..], body].concat()
}

/// Returns number, record and content of a value.
fn parse(bytes: &[u8]) -> Option<(u32, Record, Content)> {
    inspect(bytes, &[]).map(|found| (found.number, decode(bytes).unwrap_or_default(), found.content))
}

fn longest() -> Record {
    Record {
        trims: (0..5).map(|n| TrimPoint { hz: 40e3 + n as f32, lanes: [Trim { phase_turns: -0.1, gain: 0.9 }; 4] }).collect(),
        parameters: (0..MAX_PARAMETERS as u8).map(|key| (key + 100, 1.0 / f32::from(key + 1))).collect(),
    }
}

#[test]
fn the_longest_value_fits_and_reads_back() {
    let bytes = value(VERSION, 7, &longest());
    // The key precedes the value, and words have up to 32 bytes.
    assert!(bytes.len() + 1 + 32 <= MAX_VALUE_BYTES, "{}", bytes.len());
    let found = parse(&bytes).unwrap();
    assert_eq!(found, (7, longest(), Content::Record));
}

#[test]
fn a_trims_only_value_is_read() {
    let trims = longest().trims;
    let found = parse(&value(TRIMS_ONLY_VERSION, 7, &trims)).unwrap();
    assert_eq!(found, (7, Record { trims, parameters: Overrides::new() }, Content::Record));
}

#[test]
fn another_version_is_reported_and_not_read() {
    let found = parse(&value(VERSION + 1, 9, &longest())).unwrap();
    assert_eq!(found, (9, Record::default(), Content::Version(VERSION + 1)));
    // An earlier record is not used instead.
    let found = inspect(&value(VERSION + 1, 9, &longest()), &[]).unwrap();
    let before = inspect(&value(VERSION, 8, &longest()), &[]).unwrap();
    assert!(found.is_newer_than(&before) && !before.is_newer_than(&found));
}

#[test]
fn a_truncated_value_is_damaged() {
    for bytes in [value(VERSION, 7, &longest()), value(TRIMS_ONLY_VERSION, 7, &longest().trims)] {
        let counts = |length: usize| inspect(&bytes[..length], &[]).is_some_and(|found| found.is_valid());
        assert!((0..bytes.len()).all(|length| !counts(length)) && counts(bytes.len()));
    }
}

#[test]
fn record_numbers_wrap_and_an_unreadable_record_is_older() {
    let found = |number, content| HalfValue { number, content, is_expected: false };
    for content in [Content::Blank, Content::Unread, Content::Damaged] {
        assert!(
            !found(9, content).is_newer_than(&found(1, Content::Record))
                && found(1, Content::Record).is_newer_than(&found(9, content))
        );
    }
    let rows = [found(u32::MAX - 1, Content::Record), found(u32::MAX, Content::Version(3)), found(0, Content::Record)];
    for (n, newer) in rows.iter().enumerate() {
        assert!(rows[..n].iter().all(|older| newer.is_newer_than(older) && !older.is_newer_than(newer)), "{n}");
    }
}

#[test]
fn both_halves_determine_the_state() {
    let found = |number, content| HalfValue { number, content, is_expected: false };
    let state = |first: HalfValue, second: HalfValue| {
        Halves { newest: second.is_newer_than(&first).into(), found: [first, second], is_marked: false }.state()
    };
    let rows = [
        ((3, Content::Record), (3, Content::Record), StoredState::Stored),
        ((3, Content::Record), (2, Content::Record), StoredState::OneCopy),
        ((3, Content::Record), (0, Content::Blank), StoredState::OneCopy),
        ((3, Content::Record), (0, Content::Unread), StoredState::OneCopy),
        ((3, Content::Record), (9, Content::Damaged), StoredState::OneCopy),
        ((3, Content::Record), (2, Content::Version(9)), StoredState::OneCopy),
        ((2, Content::Record), (3, Content::Version(9)), StoredState::Version(9)),
        ((3, Content::Damaged), (3, Content::Version(9)), StoredState::Version(9)),
        ((0, Content::Blank), (0, Content::Blank), StoredState::Nothing),
        ((0, Content::Blank), (0, Content::Unread), StoredState::Unfinished),
        ((0, Content::Blank), (2, Content::Damaged), StoredState::Damaged),
        ((0, Content::Unread), (0, Content::Unread), StoredState::Damaged),
        ((2, Content::Damaged), (2, Content::Damaged), StoredState::Damaged),
    ];
    for (first, second, expected) in rows {
        let (first, second) = (found(first.0, first.1), found(second.0, second.1));
        assert_eq!([state(first, second), state(second, first)], [expected; 2]);
    }
}

/// Flash of four pages, in RAM.
struct Ram([u8; 4 * 2048]);

#[derive(Debug)]
struct Beyond;

impl NorFlashError for Beyond {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::OutOfBounds
    }
}

impl ErrorType for Ram {
    type Error = Beyond;
}

impl ReadNorFlash for Ram {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Beyond> {
        bytes.copy_from_slice(self.0.get(offset as usize..offset as usize + bytes.len()).ok_or(Beyond)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl NorFlash for Ram {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = 2048;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Beyond> {
        self.0.get_mut(from as usize..to as usize).ok_or(Beyond)?.fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Beyond> {
        self.0.get_mut(offset as usize..offset as usize + bytes.len()).ok_or(Beyond)?.copy_from_slice(bytes);
        Ok(())
    }
}

/// Returns a store with this value in both halves, as another firmware has left it.
fn with_stored(version: u8, record: &impl Serialize) -> Settings<Ram> {
    let mut settings = Settings::new(Ram([0xFF; 8192])).unwrap();
    [0, 1].into_iter().for_each(|half| settings.write(half, &value(version, 1, record)).unwrap());
    settings
}

#[test]
fn a_stored_trims_only_record_is_read_and_replaced() {
    let trims = longest().trims;
    let mut settings = with_stored(TRIMS_ONLY_VERSION, &trims);
    assert_eq!(settings.record(), (Record { trims, parameters: Overrides::new() }, StoredState::Stored));
    settings.store(&longest()).unwrap();
    assert_eq!(settings.record(), (longest(), StoredState::Stored));
}

/// Calls `act` with the settings store of a board that was started with these settings, after a
/// calibration.
fn with_store(settings: &mut Settings<Ram>, act: impl FnOnce(&mut SettingsStore, &mut Settings<Ram>)) {
    with_calibrated(longest().trims, settings, act);
}

/// Calls `act` in the same way, after a calibration that has found these trims.
fn with_calibrated(trims: LaneTrims, settings: &mut Settings<Ram>, act: impl FnOnce(&mut SettingsStore, &mut Settings<Ram>)) {
    let config = crate::board::parameters::tests::config();
    let power_up = PowerUp::read(&config, settings);
    let (mut found, mut taken): (Queue<LaneTrims, 2>, Queue<LaneTrims, 2>) = (Queue::new(), Queue::new());
    let (mut found_in, found_out) = found.split();
    let mut settings_store = SettingsStore::new(found_out, taken.split().0, &power_up);
    found_in.enqueue(trims).unwrap();
    act(&mut settings_store, settings);
}

fn state(settings_store: &mut SettingsStore, settings: &mut Settings<Ram>) -> StoredState {
    match settings_store.obey(Verb::Trims(0), true, settings, None) {
        Reply::Settings(report) => report.stored,
        other => panic!("{other:?}"),
    }
}

#[test]
fn records_of_another_version_stay_until_store_or_clear() {
    for verb in [Verb::Store, Verb::Clear] {
        let mut settings = with_stored(VERSION + 1, &longest());
        let before = settings.flash.0;
        with_store(&mut settings, |settings_store, settings| {
            assert_eq!(state(settings_store, settings), StoredState::Version(VERSION + 1));
            // Trims of a calibration act, but are not written.
            settings_store.store_trims(true, settings);
            assert_eq!(settings_store.obey(Verb::Set(5, 2.0), true, settings, None), Reply::Ack);
            assert_eq!(settings_store.obey(Verb::Defaults, true, settings, None), Reply::Ack);
            assert_eq!((state(settings_store, settings), settings.flash.0 == before), (StoredState::Version(VERSION + 1), true));
            assert_eq!(settings_store.obey(verb, true, settings, None), Reply::Ack);
            assert_eq!(state(settings_store, settings), StoredState::Nothing);
        });
        assert_eq!(settings.record(), (Record::default(), StoredState::Nothing), "{verb:?}");
    }
}

#[test]
fn a_calibration_stores_its_trims_and_no_set_parameter() {
    let mut settings = Settings::new(Ram([0xFF; 8192])).unwrap();
    let parameters = Overrides::from_iter([(5, 2.0), (99, 1.0)]);
    settings.store(&Record { trims: LaneTrims::new(), parameters: parameters.clone() }).unwrap();
    with_store(&mut settings, |settings_store, settings| {
        assert_eq!(settings_store.obey(Verb::Set(5, 1.0), true, settings, None), Reply::Ack);
        settings_store.store_trims(false, settings);
        assert_eq!(state(settings_store, settings), StoredState::Due);
        settings_store.store_trims(true, settings);
        assert_eq!(settings.record(), (Record { trims: longest().trims, parameters }, StoredState::Stored));
        assert_eq!(settings_store.obey(Verb::Store, false, settings, None), Reply::Nak(Refusal::Driving));
        assert_eq!(settings_store.obey(Verb::Store, true, settings, None), Reply::Ack);
    });
    // An order to store drops an unknown parameter.
    let expected = Record { trims: longest().trims, parameters: Overrides::from_iter([(5, 1.0)]) };
    assert_eq!(settings.record(), (expected, StoredState::Stored));
}
