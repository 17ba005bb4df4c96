//! Received bytes, to be shown if they are not frames of the link.

/// Maximum number of stored bytes.
const MAX_STORED_BYTES: usize = 256;

/// First received bytes and their total number.
#[derive(Clone, Debug, Default)]
pub struct RawFrame {
    first: Vec<u8>,
    count: usize,
    /// Bytes since the last zero.
    frame: Vec<u8>,
}

impl RawFrame {
    /// Takes a byte. At the zero that ends a frame, returns the protocol version, which is the
    /// first byte of the decoded frame.
    ///
    /// COBS encodes a leading zero as a one; otherwise the version follows the first code byte.
    pub fn take(&mut self, byte: u8) -> Option<u8> {
        self.count += 1;
        if self.first.len() < MAX_STORED_BYTES {
            self.first.push(byte);
        }
        if byte != 0 {
            if self.frame.len() < MAX_STORED_BYTES {
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

    /// Returns the number of received bytes.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Returns the first bytes as readable text.
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
    fn the_version_of_any_frame_is_found() {
        let mut raw = RawFrame::default();
        let frame = encode(300, 0, Command::Identify(7)).unwrap();
        let versions: Vec<u8> = frame.iter().filter_map(|&byte| raw.take(byte)).collect();
        assert_eq!(versions, [VERSION]);
        // Version 0 is encoded as a one.
        assert_eq!([1, 5, 7, 0].iter().filter_map(|&byte| raw.take(byte)).collect::<Vec<u8>>(), [0]);
        assert_eq!([0, 0].iter().filter_map(|&byte| raw.take(byte)).count(), 0);
    }

    #[test]
    fn the_output_of_another_device_is_shown() {
        let mut raw = RawFrame::default();
        assert!(b"ok\r\n\xff login: please say who you are".iter().all(|&byte| raw.take(byte).is_none()));
        assert_eq!((raw.count(), raw.shown()), (35, r#""ok\r\n\xff login: please say …""#.into()));
    }
}
