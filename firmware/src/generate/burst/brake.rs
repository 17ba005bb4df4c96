//! The brake: a ringing resonance is stopped by whole periods of drive against it.

/// How a ringing resonance is stopped: by whole half cycles of drive against it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brake {
    /// Half cycles; even, so that their volt-seconds cancel.
    pub(crate) half_cycles: u32,
    /// Amplitude, relative to the drive that is braked.
    pub(crate) level: f32,
}

impl Brake {
    /// The shortest brake for a resonance with a time constant of `periods` periods that has rung up under the drive, with up to `headroom`
    /// times that drive: `level = 1 / (exp(t / tau) - 1)` over `t` stops it in full.
    pub(crate) fn of(periods: f32, headroom: f32) -> Self {
        // Two half cycles are a period: t / tau = half_cycles / (2 periods).
        let shortest = 2.0 * periods * libm::log1pf(1.0 / headroom.max(1e-3));
        let half_cycles = 2 * (libm::ceilf(0.5 * shortest).clamp(1.0, 1e6) as u32);
        Brake { half_cycles, level: 1.0 / libm::expm1f(half_cycles as f32 / (2.0 * periods)) }
    }
}
