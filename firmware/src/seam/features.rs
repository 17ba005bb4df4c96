//! Parts of the controller that Cargo features enable; a part without its feature takes no flash.
//!
//! | feature | parts | without it |
//! |---|---|---|
//! | `waveforms` | square, sawtooth, noise; chirps | a sine, at a frequency that is held or tracked |
//! | `friction` | the friction switch; the decision in a crash | the host sets amplitude and gate |
//!
//! Each such part contains a token. Without the feature the type of the token has no value, so that
//! the part cannot be constructed: a configuration with it is [refused](Error::LeftOut), and the
//! compiler removes the code that would use it.

use crate::seam::error::Error;

/// Token of an enabled part.
#[derive(Clone, Copy, Debug)]
pub struct Enabled;

/// Token of the waveforms other than a sine, and of chirps.
#[cfg(feature = "waveforms")]
pub type Waveforms = Enabled;
/// Token of the waveforms other than a sine, and of chirps: not in this image.
#[cfg(not(feature = "waveforms"))]
pub type Waveforms = core::convert::Infallible;

/// Token of friction switch and restraint.
#[cfg(feature = "friction")]
pub type Friction = Enabled;
/// Token of friction switch and restraint: not in this image.
#[cfg(not(feature = "friction"))]
pub type Friction = core::convert::Infallible;

/// Returns the token for a waveform other than a sine, or a chirp.
pub fn waveforms() -> Result<Waveforms, Error> {
    #[cfg(feature = "waveforms")]
    return Ok(Enabled);
    #[cfg(not(feature = "waveforms"))]
    return Err(Error::LeftOut { parameter: "drive.shape or sweep", feature: "waveforms" });
}

/// Returns the token for a friction switch or a restraint.
pub fn friction() -> Result<Friction, Error> {
    #[cfg(feature = "friction")]
    return Ok(Enabled);
    #[cfg(not(feature = "friction"))]
    return Err(Error::LeftOut { parameter: "friction or restraint", feature: "friction" });
}
