//! Time-frequency analysis: where in time a signal holds which frequency.
//!
//! The Fourier transform of a sweep says which frequencies there were, not when (thesis 4.4). The short-time transform
//! ([`stft()`]) cuts the signal into windows; the Wigner-Ville distribution ([`wigner_ville()`]) needs none, is sharper, and pays with
//! terms between any two components. Wavelets ([`wavelet()`]) have as many cycles at each frequency.

mod analytic;
mod map;
mod stft;
mod wavelet;
mod wigner_ville;

pub use analytic::analytic;
pub use map::Map;
pub use stft::{stft, window_for};
pub use wavelet::{Morlet, Scalogram, ratios, wavelet};
pub use wigner_ville::{Smoothing, wigner_ville};
