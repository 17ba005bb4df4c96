//! The generator xoshiro256++ with an accessible state, so that several can be advanced in a batch.

use std::convert::Infallible;

use rand_core::{Rng, SeedableRng, TryRng};
use rand_xoshiro::SplitMix64;

/// State of a xoshiro256++ generator. The one in `rand_xoshiro` is private.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Generator(pub(super) [u64; 4]);

impl Generator {
    /// Creates a generator seeded by splitmix64 (Steele, Lea and Flood 2014), as in that library.
    pub(super) fn from_seed(seed: u64) -> Self {
        let mut words = SplitMix64::seed_from_u64(seed);
        Generator(std::array::from_fn(|_| words.next_u64()))
    }

    /// Returns the next 64 bits, and the state after them.
    #[inline(always)]
    pub(super) fn step([s0, s1, s2, s3]: [u64; 4]) -> (u64, [u64; 4]) {
        let bits = s0.wrapping_add(s3).rotate_left(23).wrapping_add(s0);
        let (s2, s3) = (s2 ^ s0, s3 ^ s1);
        (bits, [s0 ^ s3, s1 ^ s2, s2 ^ (s1 << 17), s3.rotate_left(45)])
    }
}

impl TryRng for Generator {
    type Error = Infallible;

    #[inline]
    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        self.try_next_u64().map(|bits| (bits >> 32) as u32)
    }

    #[inline]
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        let (bits, state) = Self::step(self.0);
        self.0 = state;
        Ok(bits)
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        for bytes in bytes.chunks_mut(8) {
            let word = self.try_next_u64()?.to_le_bytes();
            bytes.copy_from_slice(&word[..bytes.len()]);
        }
        Ok(())
    }
}

/// A generator whose next 64 bits have been drawn already.
pub(super) struct Resumed<'a> {
    /// The drawn bits, until they are used.
    pub(super) bits: Option<u64>,
    /// The generator after these bits.
    pub(super) rest: &'a mut Generator,
}

impl TryRng for Resumed<'_> {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        self.try_next_u64().map(|bits| (bits >> 32) as u32)
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        self.bits.take().map_or_else(|| self.rest.try_next_u64(), Ok)
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        self.rest.try_fill_bytes(bytes)
    }
}

/// Given bits, followed only by ones.
pub(super) struct Scripted(pub(super) Option<u64>);

impl TryRng for Scripted {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        self.try_next_u64().map(|bits| (bits >> 32) as u32)
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(self.0.take().unwrap_or(u64::MAX))
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        bytes.fill(u8::MAX);
        Ok(())
    }
}
