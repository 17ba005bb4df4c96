//! Converters: what the controller can see and do, and no more.
//!
//! A DAC code is held for a sample. An ADC conversion adds an offset and white Gaussian noise (both in LSB, before rounding),
//! rounds and saturates; the conversions of one sample are summed, as a hardware oversampler does.

use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

use scene::{Amplifier, Sensors};

/// DAC of one lane, whose output is held between samples.
#[derive(Clone, Debug)]
pub struct Dac {
    mid_code: f64,
    volt_per_lsb: f64,
}

impl Dac {
    /// The DAC before this amplifier.
    pub fn new(sensors: &Sensors, amplifier: &Amplifier) -> Self {
        let mid_code = f64::from(1u32 << (sensors.dac_bits - 1));
        Dac { mid_code, volt_per_lsb: amplifier.full_scale_v / mid_code }
    }

    /// Code at zero volts.
    pub fn mid_code(&self) -> u16 {
        self.mid_code as u16
    }

    /// Volts at the amplifier's output for one code.
    pub fn volt_per_lsb(&self) -> f64 {
        self.volt_per_lsb
    }

    /// What a code drives, V.
    #[inline]
    pub fn volts(&self, code: u16) -> f64 {
        (f64::from(code) - self.mid_code) * self.volt_per_lsb
    }
}

/// One channel of the ADC, with its noise.
#[derive(Clone, Debug)]
pub struct Adc {
    lsb_per_unit: f64,
    zero: f64,
    noise: f64,
    top: i32,
    random: Xoshiro256PlusPlus,
}

impl Adc {
    /// A channel whose range ends at `full_scale` to each side.
    pub fn new(sensors: &Sensors, full_scale: f64, seed: u64) -> Self {
        let mid = f64::from(1u32 << (sensors.adc_bits - 1));
        Adc {
            lsb_per_unit: mid / full_scale,
            // The half makes truncation round to nearest.
            zero: mid + sensors.offset_lsb + 0.5,
            noise: sensors.noise_lsb,
            top: 2 * mid as i32 - 1,
            random: Xoshiro256PlusPlus::seed_from_u64(seed),
        }
    }

    /// Converts a value to a code.
    #[inline]
    pub fn convert(&mut self, value: f64) -> u16 {
        let normal: f64 = StandardNormal.sample(&mut self.random);
        // Truncation rounds to nearest because of the half in the zero; below zero the code is clamped anyway.
        ((value * self.lsb_per_unit + self.zero + self.noise * normal) as i32).clamp(0, self.top) as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_stated_size_and_mean() {
        let sensors = Sensors { noise_lsb: 2.0, offset_lsb: 7.0, ..Sensors::default() };
        let mut adc = Adc::new(&sensors, 20.0, 3);
        let codes: Vec<f64> = (0..100_000).map(|_| f64::from(adc.convert(1.0)) - 2048.0 - 102.4).collect();
        let mean = codes.iter().sum::<f64>() / codes.len() as f64;
        let variance = codes.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / codes.len() as f64;
        assert!((mean - 7.0).abs() < 0.03, "{mean}");
        // Rounding adds a twelfth of a square LSB.
        assert!((variance - 4.0 - 1.0 / 12.0).abs() < 0.06, "{variance}");
    }

    #[test]
    fn the_range_ends_saturate() {
        let mut adc = Adc::new(&Sensors::default(), 20.0, 1);
        assert_eq!((adc.convert(1e6), adc.convert(-1e6)), (4095, 0));
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
