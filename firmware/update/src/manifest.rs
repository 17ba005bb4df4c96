//! The manifest: the first 512 bytes of a slot and of an update file, before the image. All numbers
//! are little-endian.
//!
//! | offset | bytes | content |
//! |---|---|---|
//! | 0 | 8 | `SONOGLID` |
//! | 8 | 2 | format of the manifest: 1 |
//! | 10 | 1 | version of the link's protocol |
//! | 11 | 1 | zero |
//! | 12 | 16 | name of the board, padded with zeros |
//! | 28 | 6 | version of the firmware: major, minor, patch |
//! | 34 | 2 | zero |
//! | 36 | 4 | length of the image, bytes |
//! | 40 | 4 | CRC-32/ISO-HDLC of the image |
//! | 44 | 4 | address for which the image is linked |
//! | 48 | 64 | SHA-512 of the image |
//! | 112 | 64 | Ed25519 signature (RFC 8032) of the bytes 0 to 111; all ones: not signed |
//! | 176 | 4 | CRC-32/ISO-HDLC of the bytes 0 to 175 |
//! | 180 | 332 | ones |
//!
//! It has 512 bytes because the vector table after it must be aligned to its own length, rounded up
//! to a power of two (ARM DDI 0403 B3.2.5).

use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};
use firmware::board::update::UpdateDefect as Defect;

use crate::identity::{Board, Identity, NAME};

/// Size of a manifest in the flash, bytes.
pub const MANIFEST: usize = 512;
/// Number of signed bytes.
pub const SIGNED: usize = 112;
/// Length of a signature, bytes.
pub const SIGNATURE: usize = 64;
const MAGIC: [u8; 8] = *b"SONOGLID";
const FORMAT: u16 = 1;
/// Number of bytes under the checksum of the manifest.
const CHECKED: usize = SIGNED + SIGNATURE;
/// Value of a missing signature: erased flash.
const UNSIGNED: [u8; SIGNATURE] = [0xff; SIGNATURE];

static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// Starts the checksum of an image.
pub(crate) fn checksum() -> Digest<'static, u32, Table<1>> {
    CRC.digest()
}

/// Description of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Manifest {
    /// Board, version, protocol.
    pub identity: Identity,
    /// Length of the image, bytes.
    pub length: u32,
    /// CRC-32 of the image.
    pub checksum: u32,
    /// Address for which the image is linked.
    pub origin: u32,
    /// SHA-512 of the image.
    pub digest: [u8; 64],
    /// Signature of all fields above.
    pub signature: [u8; SIGNATURE],
}

impl Manifest {
    /// Creates the manifest of an image, without a signature.
    pub fn of(identity: Identity, origin: u32, image: &[u8]) -> Self {
        let mut digest = salty::Sha512::new();
        digest.update(image);
        Manifest {
            identity,
            length: image.len() as u32,
            checksum: CRC.checksum(image),
            origin,
            digest: digest.finalize(),
            signature: UNSIGNED,
        }
    }

    /// Signs the manifest with the key of this seed.
    pub fn signed_by(self, seed: &[u8; 32]) -> Self {
        let signature = salty::Keypair::from(seed).sign(&self.signed_bytes()).to_bytes();
        Manifest { signature, ..self }
    }

    /// Returns `true` if the manifest contains a signature.
    pub fn is_signed(&self) -> bool {
        self.signature != UNSIGNED
    }

    /// Returns the bytes that are signed.
    pub fn signed_bytes(&self) -> [u8; SIGNED] {
        let mut bytes = [0; SIGNED];
        bytes[..8].copy_from_slice(&MAGIC);
        bytes[8..10].copy_from_slice(&FORMAT.to_le_bytes());
        bytes[10] = self.identity.protocol;
        bytes[12..12 + NAME].copy_from_slice(&self.identity.board);
        for (to, part) in bytes[28..34].chunks_exact_mut(2).zip(self.identity.version) {
            to.copy_from_slice(&part.to_le_bytes());
        }
        for (to, number) in bytes[36..48].chunks_exact_mut(4).zip([self.length, self.checksum, self.origin]) {
            to.copy_from_slice(&number.to_le_bytes());
        }
        bytes[48..].copy_from_slice(&self.digest);
        bytes
    }

    /// Encodes the manifest as in the flash.
    pub fn encode(&self) -> [u8; MANIFEST] {
        let mut bytes = [0xff; MANIFEST];
        bytes[..SIGNED].copy_from_slice(&self.signed_bytes());
        bytes[SIGNED..CHECKED].copy_from_slice(&self.signature);
        let checksum = CRC.checksum(&bytes[..CHECKED]);
        bytes[CHECKED..CHECKED + 4].copy_from_slice(&checksum.to_le_bytes());
        bytes
    }

    /// Decodes a manifest.
    pub fn decode(bytes: &[u8; MANIFEST]) -> Result<Self, Defect> {
        let number = |at: usize| u32::from_le_bytes(core::array::from_fn(|n| bytes[at + n]));
        let half = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        if bytes[..8] != MAGIC {
            return Err(Defect::NotAnUpdate);
        }
        if number(CHECKED) != CRC.checksum(&bytes[..CHECKED]) {
            return Err(Defect::Damaged);
        }
        if half(8) != FORMAT {
            return Err(Defect::Format(half(8)));
        }
        let board: Board = core::array::from_fn(|n| bytes[12 + n]);
        Ok(Manifest {
            identity: Identity { board, version: [half(28), half(30), half(32)], protocol: bytes[10] },
            length: number(36),
            checksum: number(40),
            origin: number(44),
            digest: core::array::from_fn(|n| bytes[48 + n]),
            signature: core::array::from_fn(|n| bytes[SIGNED + n]),
        })
    }
}
