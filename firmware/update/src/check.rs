//! Check of a stored image against its manifest and the board.

use embedded_storage::nor_flash::ReadNorFlash;
use firmware::board::update::UpdateDefect as Defect;

use crate::identity::Board;
use crate::manifest::{MANIFEST, Manifest, checksum};

/// Number of bytes read at once: a multiple of 128, the block of SHA-512.
const PIECE_BYTES: usize = 256;
/// Order of the base point of Ed25519, little-endian (RFC 8032 5.1):
/// 2^252 + 27742317777372353535851937790883648493.
pub(crate) const GROUP_ORDER: [u8; 32] = [
    0xed, 0xd3, 0xf5, 0x5c, 0x1a, 0x63, 0x12, 0x58, 0xd6, 0x9c, 0xf7, 0xa2, 0xde, 0xf9, 0xde, 0x14, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0x10,
];

/// Requirements on an image that a board can start.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Name of the board.
    pub board: Board,
    /// Address for which the image must be linked.
    pub origin: u32,
    /// Room for the image without its manifest, bytes.
    pub room: u32,
    /// Public keys, one of which must verify the signature.
    pub keys: &'static [[u8; 32]],
}

/// Extent of the check of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// Manifest and checksum: detects a change of an image that was fully checked before.
    Checksum,
    /// Manifest, checksum, digest and signature.
    Signature,
}

impl Target {
    /// Checks that the board can start an image with this manifest.
    pub fn accepts(&self, manifest: &Manifest) -> Result<(), Defect> {
        if manifest.identity.board != self.board {
            return Err(Defect::OtherBoard);
        }
        if manifest.origin != self.origin {
            return Err(Defect::OtherOrigin(manifest.origin));
        }
        if manifest.length == 0 || manifest.length > self.room {
            return Err(Defect::Length(manifest.length));
        }
        if !manifest.is_signed() { Err(Defect::Unsigned) } else { Ok(()) }
    }

    /// Returns the manifest at an offset of a flash, if the board can start its image. An
    /// unreadable manifest counts as damaged.
    pub fn manifest<F: ReadNorFlash>(&self, flash: &mut F, at: u32) -> Result<Manifest, Defect> {
        let mut bytes = [0; MANIFEST];
        flash.read(at, &mut bytes).map_err(|_| Defect::Damaged)?;
        let manifest = Manifest::decode(&bytes)?;
        self.accepts(&manifest)?;
        Ok(manifest)
    }

    /// Returns the manifest at an offset of a flash, if the image after it is complete. With
    /// [`Depth::Signature`] the signature must also be valid.
    pub fn image<F: ReadNorFlash>(&self, flash: &mut F, at: u32, depth: Depth) -> Result<Manifest, Defect> {
        let manifest = self.manifest(flash, at)?;
        let from = at + MANIFEST as u32;
        let end = from.checked_add(manifest.length).filter(|end| *end as usize <= flash.capacity());
        let end = end.ok_or(Defect::Length(manifest.length))?;
        let (mut sum, mut digest) = (checksum(), salty::Sha512::new());
        let mut piece = [0; PIECE_BYTES];
        for at in (from..end).step_by(PIECE_BYTES) {
            let piece = &mut piece[..PIECE_BYTES.min((end - at) as usize)];
            flash.read(at, piece).map_err(|_| Defect::Damaged)?;
            sum.update(piece);
            if depth == Depth::Signature {
                digest.update(piece);
            }
        }
        if sum.finalize() != manifest.checksum {
            return Err(Defect::Damaged);
        }
        if depth == Depth::Signature && !(digest.finalize() == manifest.digest && self.has_signed(&manifest)) {
            return Err(Defect::WrongSignature);
        }
        Ok(manifest)
    }

    /// Returns `true` if the manifest was signed by a key of the board. Not inlined, so that the
    /// stack used by the curve arithmetic is released.
    #[inline(never)]
    fn has_signed(&self, manifest: &Manifest) -> bool {
        let signature = salty::Signature::from(&manifest.signature);
        // `salty` compares encodings of R, but also accepts S + L (RFC 8032 5.1.7), another
        // signature of the same image.
        let canonical = signature.s.0.iter().rev().lt(GROUP_ORDER.iter().rev());
        let verifies = |key: salty::PublicKey| key.verify(&manifest.signed_bytes(), &signature).is_ok();
        canonical && self.keys.iter().any(|key| salty::PublicKey::try_from(key).is_ok_and(verifies))
    }
}
