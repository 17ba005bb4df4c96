//! The flash accelerator: prefetch, instruction cache, data cache. RM0440 3.3.4.
//!
//! With two banks the flash is read in words of 64 bits. The instruction cache has 32 lines of four such words, the data cache eight; the line that was
//! not used for longest is replaced, and its words are filled one by one.

use cortex_m4::Cycle;
use stm32_metapac::flash::regs::Acr;

/// A cache of `N` lines of 32 bytes.
#[derive(Clone, Debug)]
struct Cache<const N: usize> {
    /// Address / 32 plus one.
    tags: [u32; N],
    /// A bit for each of the four words.
    valid: [u8; N],
    used: [u64; N],
    clock: u64,
    last: usize,
}

impl<const N: usize> Default for Cache<N> {
    fn default() -> Self {
        Cache { tags: [0; N], valid: [0; N], used: [0; N], clock: 0, last: 0 }
    }
}

impl<const N: usize> Cache<N> {
    /// Whether the word is there; if not, it is from now on.
    fn hit(&mut self, address: u32) -> bool {
        let (tag, bit) = (address / 32 + 1, 1 << (address / 8 % 4));
        self.clock += 1;
        let line = if self.tags[self.last] == tag {
            self.last
        } else if let Some(line) = self.tags.iter().position(|at| *at == tag) {
            line
        } else {
            let oldest = (0..N).min_by_key(|line| self.used[*line]).unwrap_or(0);
            (self.tags[oldest], self.valid[oldest]) = (tag, 0);
            oldest
        };
        self.last = line;
        self.used[line] = self.clock;
        let hit = self.valid[line] & bit != 0;
        self.valid[line] |= bit;
        hit
    }
}

/// The accelerator.
#[derive(Clone, Debug)]
pub(crate) struct Art {
    control: Acr,
    code: Cache<32>,
    data: Cache<8>,
    /// The word that was prefetched, and when it is there.
    next: (u32, Cycle),
}

impl Default for Art {
    fn default() -> Self {
        Art { control: Acr(0x0004_0600), code: Cache::default(), data: Cache::default(), next: (u32::MAX, 0) }
    }
}

impl Art {
    /// Takes over FLASH_ACR.
    pub fn set(&mut self, control: Acr) {
        if control.icrst() {
            self.code = Cache::default();
        }
        if control.dcrst() {
            self.data = Cache::default();
        }
        self.control = control;
    }

    /// Whether the data cache is on.
    pub fn caches_data(&self) -> bool {
        self.control.dcen()
    }

    /// Wait states of a fetch of the 8 bytes at `address`.
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

    /// Wait states of a load of data.
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
    fn a_loop_that_is_too_long_waits_always() {
        let mut art = art(false, true);
        let mut round = |at| (0..132).map(|word| art.fetch(0x0800_0000 + 8 * word, at)).sum::<u32>();
        round(0);
        assert_eq!(round(10_000), 132 * 4);
    }

    #[test]
    fn prefetch_hides_what_time_has_passed() {
        let mut art = art(true, false);
        assert_eq!(art.fetch(0x0800_0000, 0), 4);
        // Four instructions of 16 bits after the word was there, one of the five cycles remains.
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
