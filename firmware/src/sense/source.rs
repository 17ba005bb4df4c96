//! The source as the stack's terminals see it: `V = g u - z I_m`, for a drive of `u`.
//!
//! `g` is what amplifier, hold and delay make of the drive, loaded by the clamped capacitance; `z` is the source's impedance, so loaded. Both are
//! fitted by least squares to all blocks that are driven throughout: in a ring-up the current changes under a constant drive. Where none has been
//! measured for long, `z` is what it was.
//!
//! The source damps the vibration: in the frame of the drive `I_m' = -alpha I_m + beta V` becomes `I_m' = -(alpha + beta z) I_m + beta g u`.

use crate::seam::phasor::Phasor;

/// The largest resistance of a source that is reckoned with before it has been seen, ohm.
pub(crate) const LARGEST_OHM: f32 = 0.5;
/// Blocks after which earlier measurements count for half.
const MEMORY: u32 = 1024;
/// Part of the current that must have changed by itself for an impedance to be known.
const CHANGED: f32 = 1e-3;

/// The source.
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
    /// Takes a block that was played throughout with a drive of `volts`.
    pub(crate) fn update(&mut self, volts: f32, v: Phasor, motional_current: Phasor) {
        self.drive += volts * volts;
        self.drive_current += motional_current * volts;
        self.current += motional_current.norm_sqr();
        self.drive_voltage += v * volts;
        self.voltage_current += v * motional_current.conj();
        self.blocks += 1;
        if self.blocks >= MEMORY {
            self.blocks /= 2;
            (self.drive, self.current) = (0.5 * self.drive, 0.5 * self.current);
            self.drive_current *= 0.5;
            self.drive_voltage *= 0.5;
            self.voltage_current *= 0.5;
        }
    }

    /// `g` and `z`, ohm, if there was any drive.
    pub(crate) fn seen(&mut self) -> Option<(Phasor, Phasor)> {
        if self.drive <= 0.0 {
            return None;
        }
        let part = 1.0 / self.drive;
        let by_itself = self.current - part * self.drive_current.norm_sqr();
        if by_itself > CHANGED * self.current {
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
    fn a_ring_up_tells_the_source() {
        let (g, z) = (Phasor::new(-0.4, -0.9), Phasor::new(0.3, -0.02));
        let update = |source: &mut Source, u: f32, i: Phasor| source.update(u, g * u - z * i, i);
        let mut source = Source::default();
        assert!(source.seen().is_none());
        for n in 0..20 {
            update(&mut source, 3.0, Phasor::new(-0.3, -0.8) * (1.0 - libm::expf(-0.1 * n as f32)));
        }
        let near = |(got_g, got_z): (Phasor, Phasor)| (got_g - g).norm_sqr() < 1e-8 && (got_z - z).norm_sqr() < 1e-8;
        // Measured: 6e-7 of either.
        assert!(near(source.seen().unwrap()), "{:?}", source.seen());
        // A steady drive adds no information, and removes none.
        for _ in 0..20_000 {
            update(&mut source, 3.0, Phasor::new(-0.3, -0.8));
        }
        let (got_g, got_z) = source.seen().unwrap();
        assert!((got_g - g).norm_sqr() < 1e-6 && (got_z - z).norm_sqr() < 1e-6, "{got_g} {got_z}");
    }
}
