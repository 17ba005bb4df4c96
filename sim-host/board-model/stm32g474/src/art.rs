//! Flash accelerator: prefetch, instruction cache, data cache. RM0440 3.3.4.
//!
//! With two banks the flash is read in words of 64 bits. The instruction cache has 32 lines of four
//! such words, the data cache eight. The least recently used line is replaced, and its words are
//! filled one by one.

use cortex_m4::Cycle;
use stm32_metapac::flash::regs::Acr;

/// Number of lines of the flash: 512 KiB.
const LINES: usize = 0x8_0000 / 32;
/// Number that marks a missing line of a cache.
const NONE: u8 = u8::MAX;

/// Line of a cache, in a list sorted by the last use.
#[derive(Clone, Copy, Debug)]
struct Line {
    /// Line of the flash.
    of: u16,
    /// One bit for each of the four words.
    valid: u8,
    newer: u8,
    older: u8,
}

/// Cache of `N` lines of 32 bytes.
#[derive(Clone, Debug)]
struct Cache<const N: usize> {
    lines: [Line; N],
    newest: u8,
    oldest: u8,
    /// Line of the cache that contains each line of the flash.
    place: Box<[u8]>,
}

impl<const N: usize> Default for Cache<N> {
    fn default() -> Self {
        // A list of empty lines.
        let lines = std::array::from_fn(|n| Line {
            of: 0,
            valid: 0,
            newer: if n == 0 { NONE } else { n as u8 - 1 },
            older: if n == N - 1 { NONE } else { n as u8 + 1 },
        });
        Cache { lines, newest: 0, oldest: N as u8 - 1, place: vec![NONE; LINES].into() }
    }
}

impl<const N: usize> Cache<N> {
    /// Returns `true` if the cache contains the word; otherwise adds it.
    #[inline]
    fn hit(&mut self, address: u32) -> bool {
        let newest = &self.lines[usize::from(self.newest)];
        if newest.valid >> (address / 8 % 4) & 1 != 0 && usize::from(newest.of) == address as usize / 32 % LINES {
            return true;
        }
        self.look_up(address)
    }

    fn look_up(&mut self, address: u32) -> bool {
        let (of, bit) = (address as usize / 32 % LINES, 1 << (address / 8 % 4));
        let mut at = self.place[of];
        if at == NONE {
            at = self.oldest;
            let line = &mut self.lines[usize::from(at)];
            // An unused line has no words, and its flash line may be in another line.
            if line.valid != 0 {
                self.place[usize::from(line.of)] = NONE;
            }
            (line.of, line.valid) = (of as u16, 0);
            self.place[of] = at;
        }
        self.use_line(at);
        let line = &mut self.lines[usize::from(at)];
        let hit = line.valid & bit != 0;
        line.valid |= bit;
        hit
    }

    /// Marks a line as the most recently used.
    fn use_line(&mut self, at: u8) {
        if at == self.newest {
            return;
        }
        let Line { newer, older, .. } = self.lines[usize::from(at)];
        self.lines[usize::from(newer)].older = older;
        match older {
            NONE => self.oldest = newer,
            older => self.lines[usize::from(older)].newer = newer,
        }
        let line = &mut self.lines[usize::from(at)];
        (line.newer, line.older) = (NONE, self.newest);
        self.lines[usize::from(self.newest)].newer = at;
        self.newest = at;
    }
}

/// Flash accelerator.
#[derive(Clone, Debug)]
pub(crate) struct Art {
    control: Acr,
    code: Cache<32>,
    data: Cache<8>,
    /// Address of the prefetched word, and the cycle from which it is available.
    next: (u32, Cycle),
}

impl Default for Art {
    fn default() -> Self {
        Art { control: Acr(0x0004_0600), code: Cache::default(), data: Cache::default(), next: (u32::MAX, 0) }
    }
}

impl Art {
    /// Applies FLASH_ACR.
    pub fn set(&mut self, control: Acr) {
        if control.icrst() {
            self.code = Cache::default();
        }
        if control.dcrst() {
            self.data = Cache::default();
        }
        self.control = control;
    }

    /// Returns `true` if the data cache is on.
    pub fn caches_data(&self) -> bool {
        self.control.dcen()
    }

    /// Returns the wait states of a fetch of the 8 bytes at `address`.
    #[inline]
    pub fn fetch(&mut self, address: u32, at: Cycle) -> u32 {
        let latency = u32::from(self.control.latency().to_bits());
        if self.control.icen() && self.code.hit(address) {
            return 0;
        }
        let word = address & !7;
        let wait = if self.control.prften() && self.next.0 == word {
            self.next.1.saturating_sub(at).min(u64::from(latency)) as u32
        } else {
            latency
        };
        // The next word is read as soon as the flash is free (3.3.4).
        self.next = (word.wrapping_add(8), at + u64::from(wait) + 1 + u64::from(latency));
        wait
    }

    /// Returns the wait states of a data load.
    #[inline]
    pub fn load(&mut self, address: u32) -> u32 {
        if self.control.dcen() && self.data.hit(address) { 0 } else { u32::from(self.control.latency().to_bits()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn art(prefetch: bool, caches: bool) -> Art {
        let mut control = Acr(4);
        control.set_prften(prefetch);
        control.set_icen(caches);
        control.set_dcen(caches);
        let mut art = Art::default();
        art.set(control);
        art
    }

    #[test]
    fn a_loop_that_fits_waits_once() {
        let mut art = art(false, true);
        let mut round = |at| (0..128).map(|word| art.fetch(0x0800_0000 + 8 * word, at)).sum::<u32>();
        assert_eq!(round(0), 128 * 4);
        assert_eq!(round(10_000), 0);
    }

    #[test]
    fn a_loop_longer_than_the_cache_always_waits() {
        let mut art = art(false, true);
        let mut round = |at| (0..132).map(|word| art.fetch(0x0800_0000 + 8 * word, at)).sum::<u32>();
        round(0);
        assert_eq!(round(10_000), 132 * 4);
    }

    #[test]
    fn the_least_recently_used_line_is_replaced() {
        let mut art = art(false, true);
        let mut waits = |line: u32| art.fetch(0x0800_0000 + 32 * line, 0);
        assert_eq!((0..32).map(&mut waits).sum::<u32>(), 32 * 4);
        assert_eq!([0, 2, 32].map(&mut waits), [0, 0, 4], "32 replaces 1");
        assert_eq!([0, 2, 3, 32, 1, 4].map(&mut waits), [0, 0, 0, 0, 4, 4], "1 replaces 4");
    }

    #[test]
    fn prefetch_reduces_the_wait_by_the_elapsed_time() {
        let mut art = art(true, false);
        assert_eq!(art.fetch(0x0800_0000, 0), 4);
        // After four instructions of 16 bits, one of the five cycles remains.
        assert_eq!(art.fetch(0x0800_0008, 4 + 4), 1);
        assert_eq!(art.fetch(0x0800_0010, 100), 0);
    }

    #[test]
    fn data_have_a_cache_of_256_bytes() {
        let mut art = art(false, true);
        let mut round = |words: u32| (0..words).map(|word| art.load(0x0800_0000 + 8 * word)).sum::<u32>();
        assert_eq!(round(32), 32 * 4);
        assert_eq!(round(32), 0);
    }
}
