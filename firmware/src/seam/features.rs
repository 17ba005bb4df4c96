//! Parts of the controller that Cargo features enable: a part that is left out takes no flash.
//!
//! | feature | the parts | without it |
//! |---|---|---|
//! | `waveforms` | square, sawtooth, noise; chirps | a sine, at a frequency that is held or tracked |
//! | `friction` | the friction switch; the decision in a crash | amplitude and gate are the host's |
//!
//! Each such part has a token in it. Of a part that is left out the token has no value, so that there can be none of the part either: to ask for
//! one is [refused](Error::LeftOut), and the compiler leaves out all that would use it.

use crate::seam::error::Error;

/// The token of an enabled part.
#[derive(Clone, Copy, Debug)]
pub struct Enabled;

/// The token of the other waveforms.
#[cfg(feature = "waveforms")]
pub type Waveforms = Enabled;
/// The token of the other waveforms: there is none.
#[cfg(not(feature = "waveforms"))]
pub type Waveforms = core::convert::Infallible;

/// The token of what decides on friction.
#[cfg(feature = "friction")]
pub type Friction = Enabled;
/// The token of what decides on friction: there is none.
#[cfg(not(feature = "friction"))]
pub type Friction = core::convert::Infallible;

/// For a waveform that is no sine, or a chirp.
pub fn waveforms() -> Result<Waveforms, Error> {
    #[cfg(feature = "waveforms")]
    return Ok(Enabled);
    #[cfg(not(feature = "waveforms"))]
    return Err(Error::LeftOut { parameter: "drive.shape or sweep", feature: "waveforms" });
}

/// For a friction switch or a restraint.
pub fn friction() -> Result<Friction, Error> {
    #[cfg(feature = "friction")]
    return Ok(Enabled);
    #[cfg(not(feature = "friction"))]
    return Err(Error::LeftOut { parameter: "friction or restraint", feature: "friction" });
}
