//! The session of the host: frames of any other are not obeyed.

use crate::board::link::NO_SESSION;

/// The present session, if there is one.
#[derive(Clone, Debug, Default)]
pub(super) struct HostSession {
    /// Its number; [`NO_SESSION`] before the first.
    number: u32,
    /// The number that the host has drawn for it.
    nonce: u32,
    /// Sessions since the start.
    count: u32,
    /// A frame of it was received.
    used: bool,
}

impl HostSession {
    /// Number of the present session.
    pub(super) fn number(&self) -> u32 {
        self.number
    }

    /// Begins a session for the host that has drawn this number, so many blocks after the start, and returns its number.
    ///
    /// A copy of the same request, whose answer was lost, gives the same session. Once a frame of the session was received there is no such copy any more,
    /// as the host has had its answer: what comes then is a conversation that is repeated, and nothing of it may act.
    pub(super) fn begin(&mut self, nonce: u32, block: u32) -> u32 {
        if self.number == NO_SESSION || self.nonce != nonce || self.used {
            self.count = self.count.wrapping_add(1);
            // A host that always draws the same number is given another session each time all the same.
            let number = mixed(mixed(mixed(nonce) ^ self.count) ^ block);
            *self = HostSession { number: number.max(NO_SESSION + 1), nonce, count: self.count, used: false };
        }
        self.number
    }

    /// Whether a frame with this number is of the present session.
    pub(super) fn admits(&mut self, number: u32) -> bool {
        let admitted = number != NO_SESSION && number == self.number;
        self.used |= admitted;
        admitted
    }
}

/// Mixes 32 bits so that each of them depends on all: one to one, by multiplications and shifts ("lowbias32" by Chris Wellons).
fn mixed(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn before_the_first_session_nothing_is_admitted() {
        let mut session = HostSession::default();
        assert!([NO_SESSION, 1, u32::MAX].iter().all(|&number| !session.admits(number)));
        let number = session.begin(0, 0);
        assert!(number != NO_SESSION && session.admits(number) && !session.admits(NO_SESSION));
    }

    #[test]
    fn a_copy_gives_the_same_session_until_a_frame_of_it_has_come() {
        let mut session = HostSession::default();
        let number = session.begin(7, 100);
        assert_eq!(session.begin(7, 101), number);
        // A frame of another session says nothing of this one's host.
        assert!(!session.admits(number ^ 1));
        assert_eq!(session.begin(7, 102), number);
        assert!(session.admits(number));
        let next = session.begin(7, 102);
        assert!(next != number && !session.admits(number) && session.admits(next));
    }

    #[test]
    fn sessions_differ_by_nonce_block_and_count() {
        let mut numbers = BTreeSet::new();
        let mut count = 0;
        for nonce in [0, 1, 2, 0x8000_0000, u32::MAX] {
            for block in [0, 1, 2, 31_250, u32::MAX] {
                let mut session = HostSession::default();
                for _ in 0..40 {
                    let number = session.begin(nonce, block);
                    assert!(session.admits(number) && number != NO_SESSION);
                    numbers.insert(number);
                    count += 1;
                }
            }
        }
        assert_eq!(numbers.len(), count);
    }

    #[test]
    fn each_bit_depends_on_each() {
        for bit in 0..32 {
            let flips: u32 = (0..1000).map(|n: u32| (mixed(n) ^ mixed(n ^ (1 << bit))).count_ones()).sum();
            assert!((15_000..17_000).contains(&flips), "bit {bit}: {flips}");
        }
    }
}
