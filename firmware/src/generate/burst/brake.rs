//! The brake: whole periods of drive against the vibration, which stop it.

/// Brake, which stops a vibration by whole half cycles of drive against it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brake {
    /// Number of half cycles; even, so that their volt-seconds cancel.
    pub(crate) half_cycles: u32,
    /// Amplitude, relative to the drive that is braked.
    pub(crate) level: f32,
}

impl Brake {
    /// Returns the shortest brake after a complete ring-up, for a time constant of `periods`
    /// periods, with up to `headroom` times the drive. `level = 1 / (exp(t / tau) - 1)` over `t`
    /// stops the vibration completely.
    pub(crate) fn of(periods: f32, headroom: f32) -> Self {
        // Two half cycles are a period: t / tau = half_cycles / (2 periods).
        let shortest = 2.0 * periods * libm::log1pf(1.0 / headroom.max(1e-3));
        let half_cycles = 2 * (libm::ceilf(0.5 * shortest).clamp(1.0, 1e6) as u32);
        Brake { half_cycles, level: 1.0 / libm::expm1f(half_cycles as f32 / (2.0 * periods)) }
    }
}
