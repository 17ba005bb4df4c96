//! Time-frequency analysis: the frequency content of a signal over time.
//!
//! The Fourier transform of a sweep shows its frequencies, but not their times (thesis 4.4). The
//! short-time transform ([`stft()`]) divides the signal into windows. The Wigner-Ville distribution
//! ([`wigner_ville()`]) needs no windows and is sharper, but has cross terms between any two
//! components. Wavelets ([`wavelet()`]) have the same number of cycles at each frequency.

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
