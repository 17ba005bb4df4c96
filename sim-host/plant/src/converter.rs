//! Converters: what the controller can see and do, and no more.
//!
//! A DAC code is held for a sample. An ADC conversion adds an offset and white Gaussian noise (both in LSB, before rounding),
//! rounds and saturates; the conversions of one sample are summed, as a hardware oversampler does.

use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use wide::f64x2;

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

/// The two channels of the ADC, voltage and current, side by side; each with a noise of its own.
#[derive(Clone, Debug)]
pub struct Adc {
    lsb_per_unit: f64x2,
    zero: f64x2,
    noise: f64x2,
    top: i32,
    random: [Xoshiro256PlusPlus; 2],
    /// Normal numbers drawn ahead, and how many of them are left.
    drawn: [f64x2; DRAWN],
    left: usize,
}

/// Normal numbers that are drawn at a time: what the generators work with stays in registers.
const DRAWN: usize = 64;

impl Adc {
    /// The channels of these sensors.
    pub fn new(sensors: &Sensors, seed: u64) -> Self {
        let mid = f64::from(1u32 << (sensors.adc_bits - 1));
        Adc {
            lsb_per_unit: f64x2::new([mid / sensors.v_full_scale_v, mid / sensors.i_full_scale_a]),
            // The half makes truncation round to nearest.
            zero: f64x2::splat(mid + sensors.offset_lsb + 0.5),
            noise: f64x2::splat(sensors.noise_lsb),
            top: 2 * mid as i32 - 1,
            // Two streams that never meet, whatever the seed: the halves of a 64-bit space apart.
            random: [seed, seed ^ (1 << 63)].map(Xoshiro256PlusPlus::seed_from_u64),
            drawn: [f64x2::splat(0.0); DRAWN],
            left: 0,
        }
    }

    /// Converts voltage and current to codes.
    #[inline]
    pub fn convert(&mut self, values: impl Into<f64x2>) -> [u16; 2] {
        if self.left == 0 {
            self.draw();
        }
        self.left -= 1;
        let normal = self.drawn[self.left % DRAWN];
        // Truncation rounds to nearest because of the half in the zero; below zero the code is clamped anyway.
        let codes = values.into() * self.lsb_per_unit + self.zero + self.noise * normal;
        codes.to_array().map(|code| (code as i32).clamp(0, self.top) as u16)
    }

    /// Draws normal numbers, of which the first is taken first.
    #[inline(never)]
    fn draw(&mut self) {
        let [mut v, mut i] = self.random.clone();
        for both in self.drawn.iter_mut().rev() {
            *both = f64x2::new([StandardNormal.sample(&mut v), StandardNormal.sample(&mut i)]);
        }
        self.random = [v, i];
        self.left = DRAWN;
    }
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
