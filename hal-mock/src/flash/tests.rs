use super::*;

const PAGE: u32 = PAGE_BYTES as u32;

fn read<const N: usize>(flash: &mut Flash, offset: u32) -> [u8; N] {
    let mut bytes = [0; N];
    flash.read(offset, &mut bytes).unwrap();
    bytes
}

#[test]
fn words_are_read_back_and_an_erase_affects_one_page() {
    let mut flash = Flash::new(3, 1);
    flash.write(PAGE - 8, &[0x11; 16]).unwrap();
    assert_eq!(read::<18>(&mut flash, PAGE - 9)[..2], [0xFF, 0x11]);
    flash.erase(PAGE, 2 * PAGE).unwrap();
    assert_eq!((read(&mut flash, PAGE - 8), read(&mut flash, PAGE)), ([0x11; 8], [0xFF; 8]));
    assert_eq!(([0, 1, 2].map(|page| flash.erases(page)), flash.words_written(), flash.operations()), ([0, 1, 0], 2, 3));
}

#[test]
fn a_word_is_written_only_once_after_an_erase() {
    let mut flash = Flash::new(1, 1);
    for value in [[0xFF; 8], [0x5A; 8]] {
        flash.erase(0, PAGE).unwrap();
        flash.write(8, &value).unwrap();
        assert_eq!(flash.write(8, &value), Err(FlashError::NotErased));
        assert_eq!(flash.write(8, &[0; 8]), Err(FlashError::NotErased));
        assert_eq!(read(&mut flash, 8), value);
    }
    // Writing several words stops at the first that is not erased; the later ones keep their
    // values.
    assert_eq!(flash.write(0, &[0x33; 24]), Err(FlashError::NotErased));
    assert_eq!((read(&mut flash, 0), read(&mut flash, 8), read(&mut flash, 16)), ([0x33; 8], [0x5A; 8], [0xFF; 8]));
}

#[test]
fn addresses_are_checked_and_a_refused_call_changes_nothing() {
    let mut flash = Flash::new(2, 1);
    assert_eq!(flash.write(4, &[0; 8]), Err(FlashError::NotAligned));
    assert_eq!(flash.write(0, &[0; 7]), Err(FlashError::NotAligned));
    assert_eq!(flash.write(2 * PAGE - 8, &[0; 16]), Err(FlashError::OutOfBounds));
    assert_eq!(flash.erase(8, PAGE), Err(FlashError::NotAligned));
    assert_eq!(flash.erase(PAGE, 0), Err(FlashError::OutOfBounds));
    assert_eq!(flash.erase(0, 3 * PAGE), Err(FlashError::OutOfBounds));
    assert_eq!(flash.read(2 * PAGE, &mut [0]), Err(FlashError::OutOfBounds));
    assert!(flash.operations() == 0 && flash.bytes().iter().all(|&byte| byte == ERASED));
    assert_eq!((flash.capacity(), FlashError::NotAligned.kind()), (2 * PAGE_BYTES, NorFlashErrorKind::NotAligned));
}

#[test]
fn a_cut_write_changes_part_of_one_word() {
    let mut torn_words = 0;
    for seed in 0..32 {
        let mut flash = Flash::new(1, seed);
        flash.cut_power_after(2);
        assert_eq!(flash.write(0, &[0x0F; 32]), Err(FlashError::PowerCut));
        assert!(flash.is_off());
        assert_eq!(flash.read(0, &mut [0]), Err(FlashError::PowerCut));
        assert_eq!((flash.write(64, &[0; 8]), flash.erase(0, PAGE)), (Err(FlashError::PowerCut), Err(FlashError::PowerCut)));
        flash.restore_power();
        let [whole, torn, after]: [[u8; 8]; 3] = [0, 16, 24].map(|offset| read(&mut flash, offset));
        assert_eq!((whole, read(&mut flash, 8), after), ([0x0F; 8], [0x0F; 8], [0xFF; 8]));
        // Bits that were not to be cleared stay set.
        assert!(torn.iter().all(|byte| byte & 0x0F == 0x0F), "{torn:x?}");
        torn_words += u32::from(torn != [0x0F; 8] && torn != [0xFF; 8]);
        assert_eq!(flash.write(16, &[0x0F; 8]), Err(FlashError::NotErased));
        flash.write(24, &[0x0F; 8]).unwrap();
    }
    assert!(torn_words > 28, "{torn_words}");
}

#[test]
fn a_cut_erase_leaves_a_page_that_must_be_erased_again() {
    let mut flash = Flash::new(3, 9);
    flash.write(0, &[0x00; 3 * PAGE_BYTES]).unwrap();
    flash.cut_power_after(1);
    assert_eq!(flash.erase(0, 3 * PAGE), Err(FlashError::PowerCut));
    flash.restore_power();
    let ones: Vec<u32> = flash.bytes().chunks(PAGE_BYTES).map(|page| page.iter().map(|byte| byte.count_ones()).sum()).collect();
    assert!(ones[0] == 8 * PAGE && (2 * PAGE..6 * PAGE).contains(&ones[1]) && ones[2] == 0, "{ones:?}");
    assert_eq!(flash.write(PAGE, &[0; 8]), Err(FlashError::NotErased));
    flash.write(0, &[0x12; 8]).unwrap();
    flash.erase(PAGE, 2 * PAGE).unwrap();
    flash.write(PAGE, &[0x12; 8]).unwrap();
}

#[test]
fn a_cancelled_cut_has_no_effect_and_cuts_are_reproducible() {
    let torn = |seed, back: bool| {
        let mut flash = Flash::new(1, seed);
        flash.cut_power_after(0);
        if back {
            flash.restore_power();
        }
        let written = flash.write(0, &[0; 8]);
        (written, flash.bytes()[..8].to_vec())
    };
    assert_eq!(torn(3, true), (Ok(()), vec![0; 8]));
    assert_eq!(torn(3, false), torn(3, false));
    assert_ne!(torn(3, false), torn(4, false));
}

#[test]
fn agrees_with_a_plain_model_under_any_power_cut() {
    let mut chance = Chance::new(2024);
    for seed in 0..200 {
        let mut flash = Flash::new(2, seed);
        let mut model: Vec<Option<[u8; 8]>> = vec![None; 2 * WORDS_PER_PAGE];
        flash.cut_power_after(chance.below(60));
        for _ in 0..60 {
            let (page, word) = (chance.below(2) as usize, chance.below(2 * WORDS_PER_PAGE as u64) as usize);
            let before = flash.bytes().to_vec();
            let (done, range) = if chance.strikes(0.05) {
                (flash.erase(page as u32 * PAGE, (page as u32 + 1) * PAGE), page * PAGE_BYTES..(page + 1) * PAGE_BYTES)
            } else {
                let value = [(); 8].map(|()| chance.byte());
                let done = flash.write((word * 8) as u32, &value);
                assert_eq!(done == Err(FlashError::NotErased), model[word].is_some() && !flash.is_off());
                if done.is_ok() {
                    model[word] = Some(value);
                }
                (done, word * 8..word * 8 + 8)
            };
            if done.is_ok() && range.len() == PAGE_BYTES {
                model[page * WORDS_PER_PAGE..(page + 1) * WORDS_PER_PAGE].fill(None);
            }
            // The operation changed nothing outside its range.
            assert_eq!(
                (&before[..range.start], &before[range.end..]),
                (&flash.bytes()[..range.start], &flash.bytes()[range.end..])
            );
            if done == Err(FlashError::PowerCut) {
                break;
            }
            let expected = model.iter().flat_map(|word| word.unwrap_or([ERASED; 8]));
            assert!(expected.eq(flash.bytes().iter().copied()));
        }
    }
}

#[test]
fn flipped_bits_are_read_and_an_erase_sets_them() {
    let mut flash = Flash::new(1, 1);
    flash.turn_bits(3, 0x81);
    flash.turn_bits(usize::MAX, 1);
    assert_eq!(read(&mut flash, 2), [0xFF, 0x7E, 0xFF]);
    flash.erase(0, PAGE).unwrap();
    assert_eq!(read(&mut flash, 3), [0xFF]);
}

#[test]
fn a_flash_can_be_restored_from_its_bytes() {
    let mut first = Flash::new(2, 1);
    first.write(PAGE, &[0x11; 8]).unwrap();
    let mut second = Flash::holding(first.bytes().to_vec(), 1);
    assert_eq!(second.bytes(), first.bytes());
    assert_eq!(second.write(PAGE, &[0; 8]), Err(FlashError::NotErased));
    second.write(PAGE + 8, &[0; 8]).unwrap();
}
