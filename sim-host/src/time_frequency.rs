//! Time-frequency analysis: where in time a signal holds which frequency.
//!
//! The Fourier transform of a sweep says which frequencies there were, not when (thesis 4.4). The short-time transform
//! ([`stft`]) cuts the signal into windows; the Wigner-Ville distribution ([`wigner_ville`]) needs none, is sharper, and pays with
//! terms between any two components.
