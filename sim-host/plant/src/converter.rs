//! Converters: everything that the controller can measure and set.
//!
//! A DAC code is held for a sample. An ADC conversion adds an offset and white Gaussian noise (both
//! in LSB, before rounding), rounds and saturates. The conversions of one sample are summed, as in
//! a hardware oversampler.

use crate::noise::Noise;
use crate::quad::{LANES, Portable, Quad, Registers, Wide};
use scene::{Amplifier, Sensors};

/// DAC of one lane, whose output is held between samples.
#[derive(Clone, Debug)]
pub struct Dac {
    mid_code: f64,
    volt_per_lsb: f64,
}

impl Dac {
    /// Creates the DAC that drives this amplifier.
    pub fn new(sensors: &Sensors, amplifier: &Amplifier) -> Self {
        let mid_code = f64::from(1u32 << (sensors.dac_bits - 1));
        Dac { mid_code, volt_per_lsb: amplifier.full_scale_v / mid_code }
    }

    /// Returns the code at zero volts.
    pub fn mid_code(&self) -> u16 {
        self.mid_code as u16
    }

    /// Returns the volts at the amplifier's output for one code.
    pub fn volt_per_lsb(&self) -> f64 {
        self.volt_per_lsb
    }

    /// Returns the voltage of a code, V.
    #[inline]
    pub fn volts(&self, code: u16) -> f64 {
        (f64::from(code) - self.mid_code) * self.volt_per_lsb
    }
}

/// The two channels of the ADC, voltage and current, with independent noise.
#[derive(Clone, Debug)]
pub struct Adc {
    /// Scales of voltage and current in turn, in the order of the values of two conversions.
    lsb_per_unit: Quad,
    zero: Quad,
    noise_lsb: f64,
    top: f64,
    pub(crate) noise: Noise,
}

impl Adc {
    /// Creates the channels of these sensors.
    pub fn new(sensors: &Sensors, seed: u64) -> Self {
        let mid = f64::from(1u32 << (sensors.adc_bits - 1));
        let (v, i) = (mid / sensors.v_full_scale_v, mid / sensors.i_full_scale_a);
        Adc {
            lsb_per_unit: Quad([v, i, v, i]),
            // The half makes truncation round to nearest.
            zero: Quad::splat(mid + sensors.offset_lsb + 0.5),
            noise_lsb: sensors.noise_lsb,
            top: 2.0 * mid - 1.0,
            noise: Noise::new(seed),
        }
    }

    /// Converts voltage and current to codes.
    pub fn convert(&mut self, [v, i]: [f64; 2]) -> [u16; 2] {
        let scaled = self.scaled(Quad([v, i, 0.0, 0.0]).wide(Portable));
        self.digitize(scaled, 1)
    }

    /// Returns the voltages and currents of two conversions in LSB, before their noise.
    #[inline(always)]
    pub(crate) fn scaled<F: Registers>(&self, values: Wide<F>) -> Wide<F> {
        let four = values.four();
        values * self.lsb_per_unit.wide(four) + self.zero.wide(four)
    }

    /// Returns the sums of the codes of `conversions` conversions, 1 or 2.
    #[inline(always)]
    pub(crate) fn digitize<F: Registers>(&mut self, scaled: Wide<F>, conversions: usize) -> [u16; 2] {
        let four = scaled.four();
        let noisy = scaled + self.noise.quad(conversions).wide(four) * Wide::splat(four, self.noise_lsb);
        let [v, i, later_v, later_i] = codes(noisy, Wide::splat(four, self.top));
        if conversions > 1 { [v + later_v, i + later_i] } else { [v, i] }.map(|code| code as u16)
    }

    /// Returns one channel's factor, its offset, the factor of the noise, and the largest code.
    pub(crate) fn scales(&self, channel: usize) -> [f64; 4] {
        [self.lsb_per_unit[channel], self.zero[channel], self.noise_lsb, self.top]
    }
}

/// Returns codes from zero to the top. Truncation rounds to nearest because of the half in the
/// zero; NaN becomes zero.
#[inline(always)]
pub(crate) fn codes<F: Registers>(noisy: Wide<F>, top: Wide<F>) -> [i32; LANES] {
    noisy.larger(Wide::splat(noisy.four(), 0.0)).smaller(top).truncated()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_stated_size_and_mean() {
        let sensors = Sensors { noise_lsb: 2.0, offset_lsb: 7.0, ..Sensors::default() };
        let mut adc = Adc::new(&sensors, 3);
        let codes: Vec<[f64; 2]> = (0..100_000).map(|_| adc.convert([1.0, 0.2]).map(f64::from)).collect();
        for channel in 0..2 {
            let codes: Vec<f64> = codes.iter().map(|code| code[channel] - 2048.0 - 102.4).collect();
            let mean = codes.iter().sum::<f64>() / codes.len() as f64;
            let variance = codes.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / codes.len() as f64;
            assert!((mean - 7.0).abs() < 0.03, "{mean}");
            // Rounding adds a twelfth of a square LSB.
            assert!((variance - 4.0 - 1.0 / 12.0).abs() < 0.06, "{variance}");
        }
        let both = codes.iter().map(|[v, i]| (v - 2157.4) * (i - 2157.4)).sum::<f64>() / codes.len() as f64;
        assert!(both.abs() < 0.06, "noise of one channel in the other: {both}");
    }

    #[test]
    fn the_range_ends_saturate() {
        let mut adc = Adc::new(&Sensors::default(), 1);
        assert_eq!(adc.convert([1e6, -1e6]), [4095, 0]);
        assert_eq!(adc.convert([-1e300, f64::INFINITY]), [0, 4095]);
    }

    #[test]
    fn the_firmware_and_the_plant_have_the_same_dac() {
        for dac_bits in 6..=16 {
            let sensors = Sensors { dac_bits, ..Sensors::default() };
            let made = scene::settings::front_end(&sensors, &Amplifier::default());
            let dac = Dac::new(&sensors, &Amplifier::default());
            assert_eq!((made.drive_mid_code, made.drive_volt_per_lsb), (dac.mid_code(), dac.volt_per_lsb() as f32));
        }
    }
}
