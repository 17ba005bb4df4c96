//! Source as seen from the terminals of the stack: `V = g u - z I_m`, for a drive of `u`.
//!
//! `g` is the gain of amplifier, hold and delay, loaded by the clamped capacitance; `z` is the
//! impedance of the source with that load. Both are fitted by least squares to all blocks driven
//! throughout: during a ring-up the current changes at constant drive. Without new information, `z`
//! keeps its last value.
//!
//! The source damps the vibration: in the frame of the drive `I_m' = -alpha I_m + beta V` becomes
//! `I_m' = -(alpha + beta z) I_m + beta g u`.

use crate::seam::phasor::Phasor;

/// Maximum source resistance that is assumed before it is measured, ohm.
pub(crate) const LARGEST_OHM: f32 = 0.5;
/// Number of blocks after which earlier measurements are weighted by one half.
const MEMORY_BLOCKS: u32 = 1024;
/// Minimum part of the squared current that must be independent of the drive to determine the
/// impedance.
const MIN_INDEPENDENT_PART: f32 = 1e-3;

/// Least-squares estimator of the source.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Source {
    drive: f32,
    drive_current: Phasor,
    current: f32,
    drive_voltage: Phasor,
    voltage_current: Phasor,
    blocks: u32,
    impedance: Phasor,
}

impl Source {
    /// Adds a block that was driven throughout with `volts`.
    pub(crate) fn update(&mut self, volts: f32, v: Phasor, motional_current: Phasor) {
        self.drive += volts * volts;
        self.drive_current += motional_current * volts;
        self.current += motional_current.norm_sqr();
        self.drive_voltage += v * volts;
        self.voltage_current += v * motional_current.conj();
        self.blocks += 1;
        if self.blocks >= MEMORY_BLOCKS {
            self.blocks /= 2;
            (self.drive, self.current) = (0.5 * self.drive, 0.5 * self.current);
            self.drive_current *= 0.5;
            self.drive_voltage *= 0.5;
            self.voltage_current *= 0.5;
        }
    }

    /// Returns `g` and `z`, ohm; `None` before any drive.
    pub(crate) fn seen(&mut self) -> Option<(Phasor, Phasor)> {
        if self.drive <= 0.0 {
            return None;
        }
        let part = 1.0 / self.drive;
        let by_itself = self.current - part * self.drive_current.norm_sqr();
        if by_itself > MIN_INDEPENDENT_PART * self.current {
            let correlation = self.drive_voltage * self.drive_current.conj() * part - self.voltage_current;
            self.impedance = correlation / by_itself;
        }
        Some(((self.drive_voltage + self.impedance * self.drive_current) * part, self.impedance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ring_up_determines_the_source() {
        let (g, z) = (Phasor::new(-0.4, -0.9), Phasor::new(0.3, -0.02));
        let update = |source: &mut Source, u: f32, i: Phasor| source.update(u, g * u - z * i, i);
        let mut source = Source::default();
        assert!(source.seen().is_none());
        for n in 0..20 {
            update(&mut source, 3.0, Phasor::new(-0.3, -0.8) * (1.0 - libm::expf(-0.1 * n as f32)));
        }
        let near = |(got_g, got_z): (Phasor, Phasor)| (got_g - g).norm_sqr() < 1e-8 && (got_z - z).norm_sqr() < 1e-8;
        // Measured error of gain and impedance: 6e-7.
        assert!(near(source.seen().unwrap()), "{:?}", source.seen());
        // A steady drive adds no information, and removes none.
        for _ in 0..20_000 {
            update(&mut source, 3.0, Phasor::new(-0.3, -0.8));
        }
        let (got_g, got_z) = source.seen().unwrap();
        assert!((got_g - g).norm_sqr() < 1e-6 && (got_z - z).norm_sqr() < 1e-6, "{got_g} {got_z}");
    }
}
