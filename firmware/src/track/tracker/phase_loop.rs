//! A phase-locked PI loop, normalised by Q.
//!
//! Near the resonance the phase answers a detuning with `phi = -2 pi tau df / (1 + tau s)`,
//! `tau = Q / (pi f)`. A PI with its zero at `1 / tau`, `Kp = B` Hz/rad and `Ki = B / tau`, cancels
//! that pole and leaves a first-order loop of bandwidth `B` at any Q. The delay of three blocks of
//! 32 us costs 0.1 rad of phase margin at B = 200 Hz.

use crate::seam::compare::within;
use crate::seam::config::Tracking;
use crate::seam::error::Error;
use crate::seam::phasor::{Phasor, argument};
use crate::seam::units::Turns;

/// State of the loop.
#[derive(Clone, Debug)]
pub(crate) struct PhaseLoop {
    window_hz: f32,
    bandwidth_hz: f32,
    block_s: f32,
    /// `block_s / tau`: change of the integral in one block, relative to the proportional part.
    integral_gain: f32,
    integral_hz: f32,
    /// Last output, as an offset from the nominal frequency, Hz.
    offset_hz: f32,
}

impl PhaseLoop {
    /// Builds a loop around `frequency_hz`, updated every `block_s` seconds.
    pub(crate) fn build(tracking: &Tracking, frequency_hz: f32, block_s: f32) -> Result<Self, Error> {
        Tracking::BANDWIDTH_HZ.check_within(tracking.bandwidth_hz.into(), 0.0, 0.02 / f64::from(block_s))?;
        Ok(PhaseLoop {
            window_hz: tracking.span * frequency_hz,
            bandwidth_hz: tracking.bandwidth_hz,
            block_s,
            integral_gain: 0.0,
            integral_hz: 0.0,
            offset_hz: 0.0,
        })
    }

    /// Starts at a known resonance: its offset from the nominal frequency, Hz, and its time
    /// constant, s.
    pub(crate) fn seed(&mut self, offset_hz: f32, time_constant_s: f32) {
        self.integral_hz = offset_hz;
        self.offset_hz = offset_hz;
        self.integral_gain = self.block_s / time_constant_s;
    }

    /// Updates the loop with one block's phase error, and returns the phase.
    pub(crate) fn update(&mut self, error: Phasor) -> Turns {
        let phase = argument(error);
        let proportional = self.bandwidth_hz * core::f32::consts::TAU * phase.0;
        // The integral is clamped to the window: sufficient anti-windup for a first-order loop.
        self.integral_hz = within(self.integral_hz + self.integral_gain * proportional, -self.window_hz, self.window_hz);
        self.offset_hz = within(self.integral_hz + proportional, -self.window_hz, self.window_hz);
        phase
    }

    /// Sets the time constant of the resonance, s.
    pub(crate) fn set_time_constant(&mut self, time_constant_s: f32) {
        self.integral_gain = self.block_s / time_constant_s;
    }

    /// Follows the observer's frequency, so that the loop can take over at any time, and returns
    /// the phase of one block.
    pub(crate) fn accompany(&mut self, error: Phasor, offset_hz: f32) -> Turns {
        self.integral_hz = within(offset_hz, -self.window_hz, self.window_hz);
        self.offset_hz = self.integral_hz;
        argument(error)
    }

    /// Drops the proportional part: the integral is the frequency to hold without a measured phase.
    pub(crate) fn hold(&mut self) {
        self.offset_hz = self.integral_hz;
    }

    /// Returns the largest offset, Hz.
    pub(crate) fn window_hz(&self) -> f32 {
        self.window_hz
    }

    /// Returns the frequency to drive, as an offset from the nominal one, Hz.
    pub(crate) fn offset_hz(&self) -> f32 {
        self.offset_hz
    }

    /// Returns the smoothed frequency estimate, as an offset from the nominal one, Hz.
    pub(crate) fn estimate_hz(&self) -> f32 {
        self.integral_hz
    }

    /// Returns `true` if the window limits the loop.
    pub(crate) fn limited(&self) -> bool {
        self.offset_hz.abs() >= self.window_hz
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seam::config::TrackingMode;

    const BLOCK_S: f32 = 32e-6;

    /// Closes the loop on the linear phase response of a resonance `detuning` away, with two blocks
    /// of delay. Returns the number of blocks until it stays within `tolerance_hz`.
    fn settle(q: f32, assumed_q: f32, detuning: f32, tolerance_hz: f32) -> usize {
        let tracking = Tracking {
            mode: TrackingMode::PhaseLock,
            span: 0.025,
            bandwidth_hz: 200.0,
            nominal_c0_f: Some(300e-9),
            ..Tracking::new(q)
        };
        let mut pll = PhaseLoop::build(&tracking, 40e3, BLOCK_S).unwrap();
        let tau = q / (core::f32::consts::PI * 40e3);
        pll.seed(0.0, assumed_q / (core::f32::consts::PI * 40e3));
        let (mut phase, mut played, mut last_out) = (0.0_f32, [0.0_f32; 2], 0);
        for n in 0..2000 {
            let error = played[0] - detuning;
            if error.abs() > tolerance_hz {
                last_out = n;
            }
            phase += BLOCK_S / tau * (-core::f32::consts::TAU * tau * error - phase);
            pll.update(Phasor::new(libm::cosf(phase), libm::sinf(phase)));
            played = [played[1], pll.offset_hz()];
        }
        last_out
    }

    #[test]
    fn bandwidth_does_not_depend_on_q() {
        // First order at 200 Hz: 100 Hz to 4 Hz takes ln(25) / (2 pi 200) s = 80 blocks.
        for q in [20.0, 65.0, 200.0] {
            let blocks = settle(q, q, 100.0, 4.0);
            assert!((50..110).contains(&blocks), "Q {q}: {blocks} blocks");
        }
    }

    #[test]
    fn a_q_wrong_by_two_still_locks() {
        assert!(settle(65.0, 130.0, 100.0, 4.0) < 400);
        assert!(settle(65.0, 32.0, 100.0, 4.0) < 400);
    }

    #[test]
    fn the_window_bounds_the_loop() {
        assert_eq!(settle(65.0, 65.0, 1500.0, 400.0), 1999);
    }
}
