//! Swing of a block of codes: the drive voltage.

use firmware::seam::block::DriveBlock;

use plant::converter::Dac;
use scene::Driven;

/// Peak and mean square of the drive in a block, at the amplifier's output for the held codes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Swing {
    /// Largest voltage to either side, V.
    pub peak_v: f64,
    /// Mean square of the codes, V².
    pub square_v2: f64,
}

/// Meter of blocks of the first lane, which drives the stack.
#[derive(Clone, Debug)]
pub struct SwingMeter(Dac);

impl SwingMeter {
    /// Creates a meter for the DAC of a scene.
    pub fn new(scene: &Driven) -> Self {
        SwingMeter(Dac::new(scene.sensors, scene.amplifier))
    }

    /// Returns the swing of a block.
    pub fn measure(&self, drive: &DriveBlock) -> Swing {
        let codes = drive.lanes.first().map_or(&[][..], |lane| lane.as_slice());
        let silence = self.0.mid_code();
        if codes.iter().all(|&code| code == silence) {
            return Swing::default();
        }
        let (peak_v, sum) = codes.iter().fold((0.0, 0.0), |(peak, sum), &code| {
            let volts = self.0.volts(code);
            // `f64::max` would also handle NaN, which takes longer.
            (if volts.abs() > peak { volts.abs() } else { peak }, sum + volts * volts)
        });
        Swing { peak_v, square_v2: sum / codes.len().max(1) as f64 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::{Amplifier, Sensors};

    #[test]
    fn square_wave_has_equal_peak_and_rms() {
        let meter = SwingMeter(Dac::new(&Sensors::default(), &Amplifier::default()));
        let mut drive = DriveBlock::silent(1, 32, 2048);
        assert_eq!(meter.measure(&drive), Swing::default());
        drive.lanes[0].iter_mut().enumerate().for_each(|(n, code)| *code = if n % 2 == 0 { 2048 + 512 } else { 2048 - 512 });
        let volts = 512.0 * Amplifier::default().full_scale_v / 2048.0;
        assert_eq!(meter.measure(&drive), Swing { peak_v: volts, square_v2: volts * volts });
    }
}
