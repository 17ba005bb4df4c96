//! The bytes received, to be shown if they turn out to be no frame of the link.

/// Most bytes that are stored.
const MOST: usize = 256;

/// The first bytes received since the last frame, and their number.
#[derive(Clone, Debug, Default)]
pub struct RawFrame {
    first: Vec<u8>,
    count: usize,
    /// Since the last zero.
    frame: Vec<u8>,
}

impl RawFrame {
    /// Takes a byte. At the zero that closes a frame, gives the first of what the frame says: its protocol version.
    ///
    /// COBS puts a one before a zero, and anything else before the first byte itself.
    pub fn take(&mut self, byte: u8) -> Option<u8> {
        self.count += 1;
        if self.first.len() < MOST {
            self.first.push(byte);
        }
        if byte != 0 {
            if self.frame.len() < MOST {
                self.frame.push(byte);
            }
            return None;
        }
        let version = match self.frame.as_slice() {
            [1, ..] => Some(0),
            [_, version, ..] => Some(*version),
            _ => None,
        };
        self.frame.clear();
        version
    }

    /// Bytes that have come.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The first of them, readable.
    pub fn shown(&self) -> String {
        let first = &self.first[..self.first.len().min(24)];
        let rest = if self.count > first.len() { "…" } else { "" };
        format!("\"{}{rest}\"", first.escape_ascii())
    }

    /// Discards the bytes received so far.
    pub fn clear(&mut self) {
        *self = RawFrame::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use firmware::board::command::Command;
    use firmware::board::link::{VERSION, encode};

    #[test]
    fn a_frame_tells_its_version_whatever_it_says() {
        let mut raw = RawFrame::default();
        let frame = encode(300, 0, Command::Identify(7)).unwrap();
        let versions: Vec<u8> = frame.iter().filter_map(|&byte| raw.take(byte)).collect();
        assert_eq!(versions, [VERSION]);
        // A version of nothing is stuffed as a one.
        assert_eq!([1, 5, 7, 0].iter().filter_map(|&byte| raw.take(byte)).collect::<Vec<u8>>(), [0]);
        assert_eq!([0, 0].iter().filter_map(|&byte| raw.take(byte)).count(), 0);
    }

    #[test]
    fn what_a_stranger_says_is_shown() {
        let mut raw = RawFrame::default();
        assert!(b"ok\r\n\xff login: please say who you are".iter().all(|&byte| raw.take(byte).is_none()));
        assert_eq!((raw.count(), raw.shown()), (35, r#""ok\r\n\xff login: please say …""#.into()));
    }
}
