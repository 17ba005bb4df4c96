//! Check of a stored image against its manifest and the board.

use embedded_storage::nor_flash::ReadNorFlash;
use firmware::board::update::UpdateDefect as Defect;

use crate::identity::Board;
use crate::manifest::{MANIFEST, Manifest, checksum};

/// Number of bytes read at once: a multiple of 128, the block of SHA-512.
const PIECE_BYTES: usize = 256;

/// Requirements on an image that a board can start.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Name of the board.
    pub board: Board,
    /// Address for which the image must be linked.
    pub origin: u32,
    /// Room for the image without its manifest, bytes.
    pub room: u32,
    /// Public key that must verify the signature.
    pub key: [u8; 32],
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

    /// Returns `true` if the manifest was signed by the board's key. Not inlined, so that the stack
    /// used by the curve arithmetic is released.
    #[inline(never)]
    fn has_signed(&self, manifest: &Manifest) -> bool {
        let signature = salty::Signature::from(&manifest.signature);
        salty::PublicKey::try_from(&self.key).is_ok_and(|key| key.verify(&manifest.signed_bytes(), &signature).is_ok())
    }
}
