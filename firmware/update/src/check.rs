//! Checks of a stored image against its manifest and against the board.

use embedded_storage::nor_flash::ReadNorFlash;
use firmware::board::update::UpdateDefect as Defect;

use crate::identity::Board;
use crate::manifest::{MANIFEST, Manifest, checksum};

/// Bytes that are read at once: 128 are a block of SHA-512.
const PIECE: usize = 256;

/// What an image must be, to be started on a board.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Name of the board.
    pub board: Board,
    /// Address that the image has to be linked for.
    pub origin: u32,
    /// Room for the image, without its manifest, bytes.
    pub room: u32,
    /// The public key by which it has to be signed.
    pub key: [u8; 32],
}

/// How much of an image is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// Manifest and checksum: whether it is still the image that was checked once.
    Checksum,
    /// Digest and signature, too.
    Signature,
}

impl Target {
    /// Whether the board can start an image with this manifest.
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

    /// The manifest at an offset of a flash, if the board can start its image. What cannot be read is damaged.
    pub fn manifest<F: ReadNorFlash>(&self, flash: &mut F, at: u32) -> Result<Manifest, Defect> {
        let mut bytes = [0; MANIFEST];
        flash.read(at, &mut bytes).map_err(|_| Defect::Damaged)?;
        let manifest = Manifest::decode(&bytes)?;
        self.accepts(&manifest)?;
        Ok(manifest)
    }

    /// The manifest at an offset of a flash, if the image behind it is whole, and its signature right where that is asked for.
    pub fn image<F: ReadNorFlash>(&self, flash: &mut F, at: u32, depth: Depth) -> Result<Manifest, Defect> {
        let manifest = self.manifest(flash, at)?;
        let from = at + MANIFEST as u32;
        let end = from.checked_add(manifest.length).filter(|end| *end as usize <= flash.capacity());
        let end = end.ok_or(Defect::Length(manifest.length))?;
        let (mut sum, mut digest) = (checksum(), salty::Sha512::new());
        let mut piece = [0; PIECE];
        for at in (from..end).step_by(PIECE) {
            let piece = &mut piece[..PIECE.min((end - at) as usize)];
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

    /// Whether the manifest was signed by the board's key. Not inlined: the curve's numbers are not to stand on the stack for longer.
    #[inline(never)]
    fn has_signed(&self, manifest: &Manifest) -> bool {
        let signature = salty::Signature::from(&manifest.signature);
        salty::PublicKey::try_from(&self.key).is_ok_and(|key| key.verify(&manifest.signed_bytes(), &signature).is_ok())
    }
}
