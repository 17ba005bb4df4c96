//! Middleware on a byte link: damages written bytes at random, from a seed. Reading is unaffected;
//! to damage both directions, wrap both ends.

use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};

use crate::chance::Chance;

/// Link that damages written bytes.
#[derive(Debug)]
pub struct Noisy<L> {
    /// Link without noise.
    pub inner: L,
    flip: f64,
    drop: f64,
    chance: Chance,
}

impl<L> Noisy<L> {
    /// Creates a link without damage, until [`Noisy::set_noise`].
    pub fn new(inner: L) -> Self {
        Noisy { inner, flip: 0.0, drop: 0.0, chance: Chance::new(0) }
    }

    /// Sets the probabilities of a flipped bit and of a lost byte, and the seed.
    pub fn set_noise(&mut self, seed: u64, flip: f64, drop: f64) {
        (self.flip, self.drop, self.chance) = (flip, drop, Chance::new(seed));
    }
}

impl<L: ErrorType> ErrorType for Noisy<L> {
    type Error = L::Error;
}

impl<L: Read> Read for Noisy<L> {
    fn read(&mut self, into: &mut [u8]) -> Result<usize, L::Error> {
        self.inner.read(into)
    }
}

impl<L: ReadReady> ReadReady for Noisy<L> {
    fn read_ready(&mut self) -> Result<bool, L::Error> {
        self.inner.read_ready()
    }
}

impl<L: Write> Write for Noisy<L> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, L::Error> {
        // One byte at a time, so that a byte refused by the link has not been damaged yet.
        let Some(&byte) = bytes.first() else { return Ok(0) };
        if self.chance.strikes(self.drop) {
            return Ok(1);
        }
        let flipped = if self.chance.strikes(self.flip) { 1 << self.chance.below(8) } else { 0 };
        self.inner.write(&[byte ^ flipped])
    }

    fn flush(&mut self) -> Result<(), L::Error> {
        self.inner.flush()
    }
}

impl<L: WriteReady> WriteReady for Noisy<L> {
    fn write_ready(&mut self) -> Result<bool, L::Error> {
        self.inner.write_ready()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::{Wire, duplex};

    #[test]
    fn noise_has_its_rate_and_is_reproducible() {
        let damaged = |flip, drop| {
            let (board, mut host) = duplex(Wire::default(), Wire::default());
            let mut noisy = Noisy::new(board);
            noisy.set_noise(5, flip, drop);
            noisy.write_all(&[0; 10_000]).unwrap();
            host.take(usize::MAX)
        };
        assert_eq!(damaged(0.0, 0.0), [0; 10_000]);
        let flipped = damaged(0.1, 0.0);
        assert!(flipped.iter().all(|byte| byte.count_ones() <= 1));
        assert!((900..1100).contains(&flipped.iter().filter(|&&byte| byte != 0).count()));
        assert!((8900..9100).contains(&damaged(0.0, 0.1).len()));
        assert_eq!(flipped, damaged(0.1, 0.0));
    }
}
