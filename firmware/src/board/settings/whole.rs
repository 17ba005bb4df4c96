//! Check that the value read from a half is the last one that was written to it.
//!
//! A map that cannot read its latest value returns the one before. The latest one is still there,
//! after the last byte of the returned value, or in a page whose marks show it as empty. Therefore
//! the flash itself is examined. After a complete write of `sequential-storage`
//!
//! * one page is open: its first word is marked, its last one is not, and the value, padded with
//!   zeros to whole words, is the last data in it;
//! * every other page is closed (both words marked), or blank.

use core::ops::Range;

use embedded_storage::nor_flash::NorFlash;

/// Length of the longest word, bytes.
pub(super) const MAX_WORD_BYTES: usize = 32;
/// Value of an erased byte.
const BLANK_BYTE: u8 = 0xFF;
/// Number of zero bits that make a mark: half of a byte, more than a damaged blank byte has.
const MARK_BITS: u32 = 4;

/// State of a page.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Page {
    Blank,
    Open,
    Closed,
    Wrong,
}

/// Returns `true` if the last data in the pages is this value of this key.
pub(super) fn ends_with<F: NorFlash>(flash: &mut F, pages: Range<u32>, key: u8, value: &[u8]) -> bool {
    let mut open = None;
    for page in each::<F>(pages) {
        match state(flash, &page) {
            Page::Blank | Page::Closed => {}
            Page::Open if open.is_none() => open = Some(page),
            Page::Open | Page::Wrong => return false,
        }
    }
    open.is_some_and(|page| is_last(flash, page, key, value))
}

/// Returns `true` if nothing was ever written to the pages.
pub(super) fn is_blank<F: NorFlash>(flash: &mut F, pages: Range<u32>) -> bool {
    each::<F>(pages).all(|page| state(flash, &page) == Page::Blank)
}

/// Returns the number of bytes that are written at once.
pub(super) const fn word<F: NorFlash>() -> u32 {
    if F::WRITE_SIZE > F::READ_SIZE { F::WRITE_SIZE as u32 } else { F::READ_SIZE as u32 }
}

fn each<F: NorFlash>(pages: Range<u32>) -> impl Iterator<Item = Range<u32>> {
    pages.step_by(F::ERASE_SIZE).map(|from| from..from + F::ERASE_SIZE as u32)
}

/// Returns `true` if there is a mark at this offset, or `None` if it cannot be read.
pub(super) fn is_marked<F: NorFlash>(flash: &mut F, at: u32) -> Option<bool> {
    let mut bytes = [0; MAX_WORD_BYTES];
    let bytes = &mut bytes[..F::READ_SIZE];
    flash.read(at, bytes).ok().map(|()| bytes.iter().map(|byte| byte.count_zeros()).sum::<u32>() >= MARK_BITS)
}

fn state<F: NorFlash>(flash: &mut F, page: &Range<u32>) -> Page {
    match (is_marked(flash, page.start), is_marked(flash, page.end - F::READ_SIZE as u32)) {
        (Some(true), Some(false)) => Page::Open,
        (Some(true), Some(true)) => Page::Closed,
        (Some(false), Some(false)) if last_written(flash, page.clone()).is_none() => Page::Blank,
        _ => Page::Wrong,
    }
}

/// Returns the end of the last word that is not blank, or cannot be read.
fn last_written<F: NorFlash>(flash: &mut F, range: Range<u32>) -> Option<u32> {
    let word = word::<F>();
    let mut bytes = [0; MAX_WORD_BYTES];
    let bytes = &mut bytes[..word as usize];
    let mut is_written = |at: u32| flash.read(at, bytes).is_err() || bytes.iter().any(|&byte| byte != BLANK_BYTE);
    range.step_by(word as usize).rev().find(|&at| is_written(at)).map(|at| at + word)
}

/// Returns `true` if this value is the last data in an open page.
fn is_last<F: NorFlash>(flash: &mut F, page: Range<u32>, key: u8, value: &[u8]) -> bool {
    let word = word::<F>();
    let data = page.start + word..page.end - word;
    let length = (1 + value.len() as u32).next_multiple_of(word);
    let Some(from) = last_written(flash, data.clone()).and_then(|end| end.checked_sub(length)).filter(|from| data.contains(from))
    else {
        return false;
    };
    let mut expected = core::iter::once(key).chain(value.iter().copied()).chain(core::iter::repeat(0));
    let mut bytes = [0; MAX_WORD_BYTES];
    let bytes = &mut bytes[..word as usize];
    (from..from + length)
        .step_by(word as usize)
        .all(|at| flash.read(at, bytes).is_ok() && bytes.iter().all(|&byte| expected.next() == Some(byte)))
}
