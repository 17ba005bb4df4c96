//! Settings in flash, with power cuts at any time and any contents of the flash.

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use firmware::board::parameters::Overrides;
use firmware::board::settings::{NotStored, Record, Settings};
use firmware::board::stored_state::StoredState;
use firmware::seam::config::{LaneTrims, Trim, TrimPoint};
use firmware::seam::error::Error;
use hal_mock::chance::Chance;
use hal_mock::flash::{Damage, Flash, PAGE_BYTES, WORD_BYTES};

/// Returns trims that are identified by a number.
fn trims(number: u16) -> LaneTrims {
    let lane = |lane: usize| Trim { phase_turns: 1e-5 * f32::from(number) + 0.01 * lane as f32, gain: 0.9 };
    (0..5).map(|point| TrimPoint { hz: 39e3 + 500.0 * point as f32, lanes: std::array::from_fn(lane) }).collect()
}

/// Returns trims and parameters that are identified by the same number, so that a mixture of old
/// and new ones is detected.
fn record(number: u16) -> Record {
    let parameters: Overrides = (1..=9).map(|key| (key, f32::from(key) + f32::from(number))).collect();
    Record { trims: trims(number), parameters }
}

fn read(flash: &Flash) -> (Record, StoredState) {
    Settings::new(flash.clone()).unwrap().record()
}

#[test]
fn an_empty_flash_is_read_without_a_write() {
    let flash = Flash::new(4, 1);
    let mut settings = Settings::new(flash).unwrap();
    assert_eq!(settings.record(), (Record::default(), StoredState::Nothing));
    assert_eq!(settings.clear(), Ok(()));
    assert_eq!(settings.release().operations(), 0);
}

/// Stores many records in this number of pages, and reads each back. Returns the number of page
/// erases.
fn wear(pages: usize, record: impl Fn(u16) -> Record) -> u32 {
    let mut settings = Settings::new(Flash::new(pages, 1)).unwrap();
    for number in 0..200 {
        settings.store(&record(number)).unwrap();
        assert_eq!(settings.record(), (record(number), StoredState::Stored), "{pages} {number}");
    }
    settings.clear().unwrap();
    assert_eq!(settings.record(), (Record::default(), StoredState::Nothing));
    assert_eq!(settings.stores(), 201);
    let flash = settings.release();
    let wear: Vec<u32> = (0..pages).map(|page| flash.erases(page)).collect();
    println!("{pages} pages, 201 writes: erased {wear:?} times");
    assert!(wear.iter().max().unwrap() - wear.iter().min().unwrap() <= 1, "{wear:?}");
    wear.iter().sum()
}

#[test]
fn the_latest_record_survives_any_number_of_erases() {
    for pages in [4, 6, 10] {
        // Two copies of each record: ten lane trims fit into a page, or eight of them with nine
        // parameters. All pages wear equally.
        let alone = wear(pages, |number| Record { trims: trims(number), ..Record::default() });
        assert!(alone <= 2 * 201 / 9, "{alone}");
        let whole = wear(pages, record);
        assert!(whole <= 2 * 201 / 7, "{whole}");
    }
}

#[test]
fn storing_the_same_record_again_writes_nothing() {
    let mut settings = Settings::new(Flash::new(4, 1)).unwrap();
    settings.store(&record(1)).unwrap();
    let mut flash = settings.release();
    let operations = flash.operations();
    for _ in 0..100 {
        let mut settings = Settings::new(flash).unwrap();
        settings.store(&record(1)).unwrap();
        flash = settings.release();
    }
    assert_eq!(flash.operations(), operations);
}

/// Returns a flash after this number of writes.
fn filled(writes: u16, seed: u64) -> Flash {
    let mut settings = Settings::new(Flash::new(4, seed)).unwrap();
    (0..writes).for_each(|number| settings.store(&record(number)).unwrap());
    settings.release()
}

#[test]
fn a_power_cut_leaves_the_old_or_the_new_record_whole() {
    let mut cuts = 0;
    // Every state of the pages: empty, the first of a page, its last, and the change to the next
    // page, with and without an erase.
    for writes in (0..4).chain(12..20).chain(28..40).chain(60..72) {
        for seed in 0..4 {
            let flash = filled(writes, seed);
            let (old, _) = read(&flash);
            for operations in 0.. {
                let mut cut = flash.clone();
                cut.cut_power_after(operations);
                let mut settings = Settings::new(cut).unwrap();
                let stored = settings.store(&record(1000));
                let mut cut = settings.release();
                if stored.is_ok() {
                    break;
                }
                assert_eq!((stored, cut.is_off()), (Err(NotStored), true));
                cuts += 1;
                cut.restore_power();
                let mut settings = Settings::new(cut).unwrap();
                let (now, state) = settings.record();
                let whole = match state {
                    // If the cut has left a differing copy, the state reports it.
                    StoredState::Stored | StoredState::OneCopy => now == old || now == record(1000),
                    // Before the first write there was no record to lose.
                    StoredState::Nothing | StoredState::Unfinished => writes == 0 && now.is_empty(),
                    _ => false,
                };
                assert!(whole, "{writes} writes, cut after {operations}: {state:?}");
                settings.store(&record(1001)).unwrap();
                assert_eq!(
                    read(&settings.release()),
                    (record(1001), StoredState::Stored),
                    "{writes} writes, cut after {operations}"
                );
            }
        }
    }
    println!("{cuts} cuts");
    assert!(cuts > 3000, "{cuts}");
}

#[test]
fn repeated_power_cuts_lose_no_record() {
    for seed in 0..12 {
        let mut chance = Chance::new(seed);
        let mut flash = filled(7, seed);
        let mut last = record(6);
        for number in 100..500 {
            // The cut often occurs before a value is complete, and sometimes afterwards.
            flash.cut_power_after(chance.below(40));
            let mut settings = Settings::new(flash).unwrap();
            let stored = settings.store(&record(number));
            flash = settings.release();
            flash.restore_power();
            let (now, state) = read(&flash);
            assert!(matches!(state, StoredState::Stored | StoredState::OneCopy), "{seed} {number}: {state:?}");
            assert!(now == record(number) || (now == last && stored.is_err()), "{seed} {number}");
            last = now;
        }
    }
}

#[test]
fn any_content_of_the_flash_is_read_safely_and_can_be_replaced() {
    for seed in 0..400 {
        let mut chance = Chance::new(seed);
        let mut flash = if seed % 2 == 0 { Flash::new(4, seed) } else { filled(seed as u16 % 83, seed) };
        if seed % 2 == 0 {
            let bytes: Vec<u8> = (0..flash.capacity()).map(|_| if seed % 4 == 0 { chance.byte() } else { 0 }).collect();
            flash.write(0, &bytes).unwrap();
        } else {
            // A page that another program has used.
            let page = chance.below(4) as usize;
            flash.erase((page * PAGE_BYTES) as u32, ((page + 1) * PAGE_BYTES) as u32).unwrap();
            let bytes: Vec<u8> = (0..PAGE_BYTES).map(|_| chance.byte()).collect();
            flash.write((page * PAGE_BYTES) as u32, &bytes).unwrap();
        }
        let mut settings = Settings::new(flash).unwrap();
        let (found, state) = settings.record();
        assert!(found.is_empty() || matches!(state, StoredState::Stored | StoredState::OneCopy), "{seed}: {state:?}");
        settings.store(&record(9)).unwrap();
        assert_eq!(read(&settings.release()), (record(9), StoredState::Stored), "{seed}");
    }
}

/// Returns random damage of a word.
fn damage(chance: &mut Chance) -> Damage {
    match chance.below(6) {
        0 | 1 => Damage::Unreadable,
        2 => Damage::Flips([0xFF; 8]),
        3 => Damage::Flips(std::array::from_fn(|_| chance.byte())),
        _ => {
            let bit = chance.below(64);
            Damage::Flips((1_u64 << bit).to_le_bytes())
        }
    }
}

#[test]
fn one_damaged_word_anywhere_leaves_the_last_record() {
    let (mut chance, mut named) = (Chance::new(1), 0);
    let mut words = 0;
    // A partly filled page, a full page and the first words of the next one; the larger counts also
    // close earlier pages.
    for (pages, writes) in [(4, 1), (4, 2), (4, 5), (4, 8), (4, 9), (6, 17), (8, 27)] {
        let mut settings = Settings::new(Flash::new(pages, 1)).unwrap();
        (0..writes).for_each(|number| settings.store(&record(number)).unwrap());
        let flash = settings.release();
        for word in 0..flash.capacity() / WORD_BYTES {
            let mut damaged = flash.clone();
            let damage = damage(&mut chance);
            damaged.damage(word, damage);
            let operations = damaged.operations();
            let mut settings = Settings::new(damaged).unwrap();
            let (found, state) = settings.record();
            let last = record(writes - 1);
            assert!(
                found == last && matches!(state, StoredState::Stored | StoredState::OneCopy),
                "{writes} {word} {damage:?}: {state:?}"
            );
            named += u32::from(state == StoredState::OneCopy);
            words += 1;
            let mut damaged = settings.release();
            assert_eq!(damaged.operations(), operations, "reading must not write");
            // After storing again, both copies are complete.
            if word % 7 == 0 {
                let mut settings = Settings::new(damaged).unwrap();
                settings.store(&last).unwrap();
                assert_eq!(settings.record(), (last, StoredState::Stored), "{writes} {word} {damage:?}");
                damaged = settings.release();
                damaged.damage(word, Damage::Unreadable);
                assert_eq!(read(&damaged).0, record(writes - 1));
            }
        }
    }
    println!("{words} words, of which {named} were noticed");
    assert!(named > 300 && named < words);
}

#[test]
fn no_older_record_acts_after_any_damage() {
    let (mut chance, mut undecided, mut kept) = (Chance::new(2), 0, 0);
    for round in 0..6000 {
        let writes = 1 + chance.below(30) as u16;
        let mut flash = filled(writes, round);
        let used: Vec<usize> = flash
            .bytes()
            .chunks(WORD_BYTES)
            .enumerate()
            .filter(|(_, word)| word.iter().any(|&byte| byte != 0xFF))
            .map(|(word, _)| word)
            .collect();
        // Mostly in used words, and at least two, so that both copies may be damaged.
        for _ in 0..2 + chance.below(3) {
            let word =
                if chance.below(4) > 0 { used[chance.below(used.len() as u64) as usize] } else { chance.below(4 * 256) as usize };
            flash.damage(word, damage(&mut chance));
        }
        let (found, state) = read(&flash);
        match state {
            StoredState::Stored | StoredState::OneCopy => {
                kept += 1;
                assert_eq!(found, record(writes - 1), "{round}: {state:?}");
            }
            _ => {
                undecided += 1;
                assert!(found.is_empty() && state.hides_limits(), "{round}: {state:?}");
            }
        }
        let mut settings = Settings::new(flash).unwrap();
        settings.store(&record(1000)).unwrap();
        assert_eq!(settings.record(), (record(1000), StoredState::Stored), "{round}");
    }
    println!("{kept} kept, {undecided} undecided");
    assert!(kept > 500 && undecided > 200, "{kept} {undecided}");
}

#[test]
fn the_newer_of_two_copies_is_used_and_reported() {
    let mut flash = filled(3, 1);
    flash.cut_power_after(0);
    let mut settings = Settings::new(flash).unwrap();
    assert_eq!(settings.store(&record(9)), Err(NotStored));
    let mut flash = settings.release();
    flash.restore_power();
    assert_eq!(read(&flash), (record(2), StoredState::OneCopy));
    // Two writes replace both copies of the old record; a cut between them leaves one copy of the
    // new one.
    let whole = filled(3, 1);
    let mut stored = Settings::new(whole.clone()).unwrap();
    stored.store(&record(9)).unwrap();
    let operations = stored.release().operations() - whole.operations();
    let mut cut = whole;
    cut.cut_power_after(operations / 2);
    let mut settings = Settings::new(cut).unwrap();
    assert_eq!(settings.store(&record(9)), Err(NotStored));
    let mut flash = settings.release();
    flash.restore_power();
    assert_eq!(read(&flash), (record(9), StoredState::OneCopy));
}

#[test]
fn impossible_trims_are_damage_and_a_small_flash_is_refused() {
    let wrong = [
        LaneTrims::from_iter([TrimPoint { hz: 40e3, lanes: [Trim { phase_turns: f32::NAN, gain: 1.0 }; 4] }]),
        LaneTrims::from_iter([TrimPoint { hz: 40e3, lanes: [Trim { phase_turns: 0.0, gain: 3.0 }; 4] }]),
        LaneTrims::from_iter([TrimPoint { hz: 41e3, ..Default::default() }, TrimPoint { hz: 40e3, ..Default::default() }]),
    ];
    for trims in wrong {
        let mut settings = Settings::new(Flash::new(4, 1)).unwrap();
        // A record is read back before it counts as stored.
        let record = Record { trims: trims.clone(), ..record(1) };
        assert!(settings.store(&record).is_err(), "{trims:?}");
        assert_eq!(settings.record(), (Record::default(), StoredState::Damaged), "{trims:?}");
    }
    let refused = Settings::new(Flash::new(3, 1)).err();
    assert!(matches!(refused, Some(Error::OutOfRange { parameter: "settings.flash_bytes", value: 4096.0, min: 8192.0, .. })));
}
