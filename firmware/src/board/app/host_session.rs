//! The session of the host: frames of any other are not obeyed.

use crate::board::link::NO_SESSION;

/// Present session, if any.
#[derive(Clone, Debug, Default)]
pub(super) struct HostSession {
    /// Number of the session; [`NO_SESSION`] before the first.
    number: u32,
    /// Number that the host has drawn for the session.
    nonce: u32,
    /// Number of sessions since the start.
    count: u32,
    /// `true` if a frame of the session was received.
    used: bool,
}

impl HostSession {
    /// Returns the number of the present session.
    pub(super) fn number(&self) -> u32 {
        self.number
    }

    /// Begins a session for the host that has drawn `nonce`, at this block, and returns its number.
    ///
    /// A host that repeats its request because the answer was lost gets the same session. After a
    /// frame of the session the host must have had its answer. The same request then belongs to a
    /// replayed conversation and begins another session, so that none of its frames is obeyed.
    pub(super) fn begin(&mut self, nonce: u32, block: u32) -> u32 {
        if self.number == NO_SESSION || self.nonce != nonce || self.used {
            self.count = self.count.wrapping_add(1);
            // A host that always draws the same number still gets another session each time.
            let number = mixed(mixed(mixed(nonce) ^ self.count) ^ block);
            *self = HostSession { number: number.max(NO_SESSION + 1), nonce, count: self.count, used: false };
        }
        self.number
    }

    /// Returns `true` if `number` identifies the present session. If so, marks the session as used.
    pub(super) fn admit(&mut self, number: u32) -> bool {
        let admitted = number != NO_SESSION && number == self.number;
        self.used |= admitted;
        admitted
    }
}

/// Mixes 32 bits one to one, so that each depends on all ("lowbias32" by Chris Wellons).
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
        assert!([NO_SESSION, 1, u32::MAX].iter().all(|&number| !session.admit(number)));
        let number = session.begin(0, 0);
        assert!(number != NO_SESSION && session.admit(number) && !session.admit(NO_SESSION));
    }

    #[test]
    fn a_repeated_request_gets_the_same_session_until_it_is_used() {
        let mut session = HostSession::default();
        let number = session.begin(7, 100);
        assert_eq!(session.begin(7, 101), number);
        // A frame of another session does not show that this host has had its answer.
        assert!(!session.admit(number ^ 1));
        assert_eq!(session.begin(7, 102), number);
        assert!(session.admit(number));
        let next = session.begin(7, 102);
        assert!(next != number && !session.admit(number) && session.admit(next));
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
                    assert!(session.admit(number) && number != NO_SESSION);
                    numbers.insert(number);
                    count += 1;
                }
            }
        }
        assert_eq!(numbers.len(), count);
    }

    #[test]
    fn each_bit_depends_on_all_bits() {
        for bit in 0..32 {
            let flips: u32 = (0..1000).map(|n: u32| (mixed(n) ^ mixed(n ^ (1 << bit))).count_ones()).sum();
            assert!((15_000..17_000).contains(&flips), "bit {bit}: {flips}");
        }
    }
}
