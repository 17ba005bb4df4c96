//! Two copies in flash: after any interruption or damage, the last stored record is read, or none.

use super::*;

const BYTES: usize = 4 * 2048;

/// Flash whose bits only fall until they are erased.
#[derive(Clone)]
struct Nor {
    bytes: std::vec::Vec<u8>,
    /// Number of words and pages that can be written or erased before power fails.
    left: usize,
    /// Number of words written so far.
    written: usize,
    /// Number of pages erased so far.
    erased: usize,
    /// Number of the next words that lose a bit as they are written.
    weak: usize,
}

impl Nor {
    fn blank() -> Self {
        Nor::with_pages(4)
    }

    fn with_pages(count: usize) -> Self {
        Nor { bytes: std::vec![0xFF; count * 2048], left: usize::MAX, written: 0, erased: 0, weak: 0 }
    }

    fn spend(&mut self) -> Result<(), Beyond> {
        self.left = self.left.checked_sub(1).ok_or(Beyond)?;
        Ok(())
    }
}

impl ErrorType for Nor {
    type Error = Beyond;
}

impl ReadNorFlash for Nor {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Beyond> {
        bytes.copy_from_slice(self.bytes.get(offset as usize..offset as usize + bytes.len()).ok_or(Beyond)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Nor {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = 2048;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Beyond> {
        self.spend()?;
        self.erased += (to - from) as usize / 2048;
        self.bytes.get_mut(from as usize..to as usize).ok_or(Beyond)?.fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Beyond> {
        for (at, word) in (offset as usize..).step_by(8).zip(bytes.chunks(8)) {
            self.spend()?;
            self.written += 1;
            let place = self.bytes.get_mut(at..at + word.len()).ok_or(Beyond)?;
            place.iter_mut().zip(word).for_each(|(byte, new)| *byte &= new);
            if self.weak > 0 {
                self.weak -= 1;
                place[0] &= 0x7F;
                place[1] ^= 0x11;
            }
        }
        Ok(())
    }
}

/// Returns a record that differs from that of every other number.
fn record(n: u32) -> Record {
    let parameters = (0..40 + n as u8 % 20).map(|key| (key + 100, n as f32 + f32::from(key) / 64.0)).collect();
    Record { trims: longest().trims, parameters }
}

/// Returns a flash in which this number of records have been stored, one after the other.
fn stored(count: u32) -> Nor {
    let mut settings = Settings::new(Nor::blank()).unwrap();
    (1..=count).for_each(|n| settings.store(&record(n)).unwrap());
    settings.release()
}

fn read_back(flash: &Nor) -> (Record, StoredState) {
    Settings::new(flash.clone()).unwrap().record()
}

#[test]
fn each_store_counts_and_the_same_record_is_not_written_again() {
    let mut settings = Settings::new(Nor::blank()).unwrap();
    assert_eq!((settings.stores(), settings.record()), (0, (Record::default(), StoredState::Nothing)));
    // There is nothing to clear.
    settings.clear().unwrap();
    assert_eq!(settings.flash.written, 0);
    // The pages are used in turn: some are closed, and some are erased again.
    for n in 1..=40 {
        settings.store(&record(n)).unwrap();
        assert_eq!((settings.stores(), settings.record()), (n, (record(n), StoredState::Stored)));
        let written = settings.flash.written;
        settings.store(&record(n)).unwrap();
        assert_eq!(settings.flash.written, written, "{n}");
    }
    settings.clear().unwrap();
    assert_eq!((settings.stores(), settings.record()), (41, (Record::default(), StoredState::Nothing)));
}

#[test]
fn one_record_is_intact_whenever_power_fails() {
    for count in 1..=6 {
        let begun = stored(count);
        let (mut cut, mut seen) = (0, [0; 3]);
        loop {
            let mut settings = Settings::new(Nor { left: cut, ..begun.clone() }).unwrap();
            let done = settings.store(&record(99));
            let flash = Nor { left: usize::MAX, ..settings.release() };
            let (found, state) = read_back(&flash);
            let place = [record(count), record(99)].iter().position(|one| *one == found);
            assert!(place.is_some() && matches!(state, StoredState::Stored | StoredState::OneCopy), "{count} {cut}: {state:?}");
            seen[if state == StoredState::OneCopy { 2 } else { place.unwrap() }] += 1;
            // The next store writes both halves again.
            let mut next = Settings::new(flash).unwrap();
            next.store(&record(100)).unwrap();
            assert_eq!(next.record(), (record(100), StoredState::Stored), "{count} {cut}");
            assert!(next.stores() > count);
            if done.is_ok() {
                break;
            }
            cut += 1;
        }
        assert!(seen.iter().all(|times| *times > 0), "{seen:?}");
    }
}

#[test]
fn larger_halves_use_closed_pages() {
    // Four pages in each half, and four records in each page.
    let mut settings = Settings::new(Nor::with_pages(8)).unwrap();
    for n in 1..=40 {
        settings.store(&record(n)).unwrap();
        assert_eq!((settings.stores(), settings.record()), (n, (record(n), StoredState::Stored)));
        // A damaged mark of a closed page costs one copy, and the next store writes it again.
        if n % 7 == 0 {
            let whole = settings.flash.clone();
            let ends = (0..4).flat_map(|page| [2048 * page, 2048 * page + 2040]);
            let marks = ends.filter(|&at| whole.bytes[at] != 0xFF);
            for at in marks.collect::<std::vec::Vec<_>>() {
                let mut flash = whole.clone();
                flash.bytes[at..at + 8].fill(0xFF);
                let mut damaged = Settings::new(flash).unwrap();
                assert_eq!(damaged.record(), (record(n), StoredState::OneCopy), "{n} {at}");
                damaged.store(&record(88)).unwrap();
                assert_eq!(damaged.record(), (record(88), StoredState::Stored), "{n} {at}");
            }
        }
    }
    // Pages are erased only in turn: a page takes three records at least.
    let erased = settings.flash.erased;
    assert!((10..=28).contains(&erased), "{erased}");
}

#[test]
fn a_first_store_that_is_cut_off_leaves_nothing_or_one_copy() {
    let mut seen = std::vec::Vec::new();
    for cut in 0.. {
        let mut settings = Settings::new(Nor { left: cut, ..Nor::blank() }).unwrap();
        let done = settings.store(&record(1)).is_ok();
        let (found, state) = read_back(&settings.release());
        let empty = matches!(state, StoredState::Nothing | StoredState::Unfinished);
        assert!(found == if empty { Record::default() } else { record(1) }, "{cut}: {state:?}");
        if !seen.contains(&state) {
            seen.push(state);
        }
        if done {
            break;
        }
    }
    assert_eq!(seen, [StoredState::Nothing, StoredState::Unfinished, StoredState::OneCopy, StoredState::Stored]);
}

#[test]
fn a_damaged_word_leaves_the_other_copy() {
    for count in [1, 2, 5] {
        let whole = stored(count);
        let mut one_copy = 0;
        for at in (0..BYTES).step_by(3) {
            let mut flash = whole.clone();
            flash.bytes[at] ^= 0x5A;
            let (found, state) = read_back(&flash);
            assert!(found == record(count), "{count} {at}: {state:?}");
            one_copy += usize::from(state == StoredState::OneCopy);
        }
        assert!(one_copy > 100, "{one_copy}");
    }
}

#[test]
fn damage_to_both_copies_never_brings_back_an_older_record() {
    for count in [2, 5] {
        let whole = stored(count);
        let mut damaged = 0;
        for at in (0..BYTES / 2).step_by(3) {
            let mut flash = whole.clone();
            flash.bytes[at] ^= 0x5A;
            flash.bytes[BYTES / 2 + at] ^= 0x5A;
            let (found, state) = read_back(&flash);
            if state == StoredState::Damaged {
                damaged += 1;
                assert_eq!(found, Record::default());
                // A store writes both copies again, with a number above all earlier ones.
                if damaged % 16 == 0 {
                    let mut settings = Settings::new(flash).unwrap();
                    settings.store(&record(77)).unwrap();
                    assert_eq!(settings.record(), (record(77), StoredState::Stored), "{count} {at}");
                }
            } else {
                assert!(found == record(count), "{count} {at}: {state:?}");
            }
        }
        assert!(damaged > 50, "{damaged}");
    }
}

#[test]
fn data_other_than_a_record_is_not_blank() {
    let state = |places: &[usize]| {
        let mut flash = Nor::blank();
        places.iter().for_each(|&at| flash.bytes[at] = 0xE7);
        read_back(&flash)
    };
    for at in [8, 1000, 2039, 3000] {
        assert_eq!(state(&[at]), (Record::default(), StoredState::Unfinished), "{at}");
        assert_eq!(state(&[BYTES / 2 + at]), (Record::default(), StoredState::Unfinished), "{at}");
        assert_eq!(state(&[at, BYTES / 2 + at]), (Record::default(), StoredState::Damaged), "{at}");
    }
}

#[test]
fn a_word_that_fails_to_write_is_erased_and_written_again() {
    for count in 0..5 {
        for weak in [1, 2, 5, 40] {
            let mut settings = Settings::new(Nor { weak, ..stored(count) }).unwrap();
            settings.store(&record(50)).unwrap();
            assert_eq!(settings.record(), (record(50), StoredState::Stored), "{count} {weak}");
        }
        // A flash that never takes the data reports an error, and so does one that does nothing.
        let mut settings = Settings::new(Nor { weak: usize::MAX, ..stored(count) }).unwrap();
        assert_eq!(settings.store(&record(50)), Err(NotStored));
        let mut settings = Settings::new(Nor { left: 0, ..stored(count) }).unwrap();
        assert_eq!((settings.store(&record(50)), settings.clear().is_ok()), (Err(NotStored), count == 0));
    }
}

#[test]
fn the_next_number_is_above_those_of_all_valid_writes() {
    let next = |first: (u32, Content), second: (u32, Content)| {
        let found = [first, second].map(|(number, content)| HalfValue { number, content, is_expected: false });
        Halves { newest: found[1].is_newer_than(&found[0]).into(), found, is_marked: false }.next_number()
    };
    let rows = [
        ((0, Content::Blank), (0, Content::Blank), 1),
        ((3, Content::Record), (3, Content::Record), 4),
        ((3, Content::Record), (9, Content::Damaged), 4),
        ((8, Content::Damaged), (4, Content::Version(9)), 5),
        ((9, Content::Damaged), (7, Content::Damaged), 10),
        ((u32::MAX, Content::Damaged), (0, Content::Unread), 1),
        ((u32::MAX, Content::Record), (u32::MAX, Content::Record), 0),
    ];
    for (first, second, expected) in rows {
        assert_eq!([next(first, second), next(second, first)], [expected; 2], "{first:?} {second:?}");
    }
}

#[test]
fn erased_settings_differ_from_those_of_a_new_board() {
    let new = Nor::with_pages(5);
    // A first store that is cut off leaves no marker without a record.
    let cut = (0..).map_while(|left| {
        let mut settings = Settings::new(Nor { left, ..new.clone() }).unwrap();
        settings.store(&record(1)).is_err().then(|| settings.record().1)
    });
    assert!(cut.clone().count() > 50 && cut.into_iter().all(|state| state != StoredState::Damaged));
    let mut settings = Settings::new(new).unwrap();
    assert_eq!((settings.clear(), settings.record().1, settings.flash.written), (Ok(()), StoredState::Nothing, 0));
    settings.store(&record(1)).unwrap();
    let whole = settings.release();
    let erased = |pages: Range<usize>| {
        let mut flash = whole.clone();
        flash.bytes[pages.start * 2048..pages.end * 2048].fill(0xFF);
        flash
    };
    assert_eq!([1..3, 3..5].map(|half| read_back(&erased(half))), [(); 2].map(|()| (record(1), StoredState::OneCopy)));
    let mut unreadable = erased(1..3);
    unreadable.bytes[3 * 2048 + 8..].fill(0xE7);
    for flash in [erased(1..5), unreadable] {
        let mut settings = Settings::new(flash).unwrap();
        assert_eq!(settings.record(), (Record::default(), StoredState::Damaged));
        settings.clear().unwrap();
        assert_eq!(settings.record(), (Record::default(), StoredState::Nothing));
    }
    // Earlier firmware wrote no marker, and an update erases it: the board writes it in silence.
    let mut settings = Settings::new(erased(0..1)).unwrap();
    let power_up = PowerUp::read(&crate::board::parameters::tests::config(), &mut settings);
    let (mut found, mut taken): (Queue<LaneTrims, 2>, Queue<LaneTrims, 2>) = (Queue::new(), Queue::new());
    let mut store = SettingsStore::new(found.split().1, taken.split().0, &power_up);
    for (silent, expected) in [(false, erased(0..1)), (true, whole.clone())] {
        store.store_trims(silent, &mut settings);
        assert!(settings.flash.bytes == expected.bytes, "{silent}");
    }
}
