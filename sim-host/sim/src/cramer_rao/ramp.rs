//! Optimal memory length for a resonance that drifts at a constant rate.
//!
//! ```text
//! lag(T) = r (T - m(T) + latency),   jitter(T) = bound over a window of length T whose first state is unknown
//! ```
//!
//! The least-squares estimate for a constant resonance equals the true resonance at the time m, the
//! centre of the window weighted by its information: `m = (F^-1 F_r)_f`, with `F_r` the information
//! shared with the rate. The current at the beginning of the window is unknown: a short window
//! determines the resonance only from the change of the current within it. An estimate that also
//! fits the slope has no lag but more jitter.

use super::information::Knowledge;
use super::response::{PARAMETERS, Parameter};
use super::{LAST_S, Setting, Start};

/// Optimal memory for a ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compromise {
    /// Length of the estimator's window, s.
    pub memory_s: f64,
    /// Lag of the estimate behind the true resonance, Hz.
    pub lag_hz: f64,
    /// Noise of the estimate, Hz rms.
    pub jitter_hz: f64,
}

impl Compromise {
    /// Returns lag and jitter combined, Hz rms.
    pub fn error_hz(&self) -> f64 {
        self.lag_hz.hypot(self.jitter_hz)
    }
}

/// Returns the same experiment as a window of a continuing drive.
fn continuing(setting: &Setting) -> Setting {
    let mut setting = Setting { start: Start::Settled, ..*setting };
    setting.prior.state = Knowledge::Unknown;
    setting.prior.resonance_hz = Knowledge::Unknown;
    setting
}

/// Returns the window of up to 5 ms with the minimum error on a ramp, for an estimate of a constant
/// resonance that is played `latency_blocks` later. `None` if no window determines the resonance.
pub fn ramp(setting: &Setting, hz_per_s: f64, latency_blocks: f64) -> Option<Compromise> {
    let setting = continuing(setting);
    let prior = setting.prior.of_each();
    let mut weight = [0.0; PARAMETERS];
    weight[Parameter::Resonance as usize] = 1.0;
    let windows = setting.information().take_while(|window| window.0 <= LAST_S).filter_map(|(memory_s, information)| {
        let shared = information.column(Parameter::Rate as usize);
        let information = information.with(&prior);
        let centre_s = information.solve(&shared, &prior)?[Parameter::Resonance as usize];
        let lag_hz = hz_per_s * (memory_s - centre_s + latency_blocks * setting.block_s);
        Some(Compromise { memory_s, lag_hz, jitter_hz: information.deviation(&weight, &prior) })
    });
    windows.min_by(|a, b| a.error_hz().total_cmp(&b.error_hz()))
}

/// Returns the jitter, Hz rms, of an estimate over a window of this length, s, that also fits the
/// slope and is extrapolated over the latency.
pub fn ramp_with_slope(setting: &Setting, memory_s: f64, latency_blocks: f64) -> f64 {
    let setting = continuing(setting);
    let mut prior = setting.prior.of_each();
    prior[Parameter::Rate as usize] = Knowledge::Unknown;
    let half_s = 0.5 / setting.sample_hz;
    let Some((time_s, information)) = setting.information().take_while(|window| window.0 < memory_s + half_s).last() else {
        return f64::INFINITY;
    };
    let mut weight = [0.0; PARAMETERS];
    weight[Parameter::Resonance as usize] = 1.0;
    weight[Parameter::Rate as usize] = time_s + latency_blocks * setting.block_s;
    information.with(&prior).deviation(&weight, &prior)
}
