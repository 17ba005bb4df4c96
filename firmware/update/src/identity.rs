//! Identity of an image: a named constant in its ELF file, from which its manifest is made.

/// Length of a board's name, bytes; shorter names are padded with zeros.
pub const NAME: usize = 16;
/// Name of the constant in the ELF file.
pub const SYMBOL: &str = "SONOGLIDE_IDENTITY";
/// Size of the constant, bytes.
pub const SIZE: usize = 24;

/// Name of a board, padded with zeros.
pub type Board = [u8; NAME];

/// Identity of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Board for which the image is built.
    pub board: Board,
    /// Version of the firmware: major, minor, patch.
    pub version: [u16; 3],
    /// Version of the link's protocol.
    pub protocol: u8,
}

/// Returns the name of a board as bytes. A name that is too long is cut.
pub const fn board(name: &str) -> Board {
    let (mut board, bytes, mut n) = ([0; NAME], name.as_bytes(), 0);
    while n < NAME && n < bytes.len() {
        board[n] = bytes[n];
        n += 1;
    }
    board
}

/// Parses a part of a version: its leading digits.
pub const fn number(text: &str) -> u16 {
    let (bytes, mut number, mut n) = (text.as_bytes(), 0, 0);
    while n < bytes.len() && bytes[n].is_ascii_digit() {
        number = number * 10 + (bytes[n] - b'0') as u16;
        n += 1;
    }
    number
}

impl Identity {
    /// Encodes the identity as in the image: board, version, protocol, a zero.
    pub const fn encode(&self) -> [u8; SIZE] {
        let (mut bytes, mut n) = ([0; SIZE], 0);
        while n < NAME {
            bytes[n] = self.board[n];
            n += 1;
        }
        let mut part = 0;
        while part < 3 {
            let [low, high] = self.version[part].to_le_bytes();
            bytes[NAME + 2 * part] = low;
            bytes[NAME + 2 * part + 1] = high;
            part += 1;
        }
        bytes[NAME + 6] = self.protocol;
        bytes
    }

    /// Decodes an identity.
    pub fn decode(bytes: &[u8; SIZE]) -> Self {
        let mut board = [0; NAME];
        board.copy_from_slice(&bytes[..NAME]);
        let version = core::array::from_fn(|n| u16::from_le_bytes([bytes[NAME + 2 * n], bytes[NAME + 2 * n + 1]]));
        Identity { board, version, protocol: bytes[NAME + 6] }
    }
}
