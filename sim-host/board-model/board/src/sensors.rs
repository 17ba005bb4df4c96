//! Slow sensors at the pins: belt encoder, force channel, temperature.
//!
//! | sensor | pins | signal |
//! |---|---|---|
//! | encoder | PB2, PC12; complements PC10, PC11 | two channels in quadrature, one count per edge; TIM5 counts the position |
//! | force | PB0 | mid-scale is zero, [`newton_per_lsb`] per code of the sum |
//! | temperature | | temperature of the die |
//!
//! The readings of a plant's sensors at the end of a block hold until the end of the next one.
//! Faults of sensors change them before the pins, as in a simulation without the microcontroller.

use firmware::seam::block::{BeltSense, DriveBlock, SenseBlock, SlowSense};
use hal_mock::analog::Analog;
use hal_mock::fault_injector::FaultInjector;
use nucleo_g474re::config::{FORCE_CONVERSIONS, SILENCE};
use scene::Driven;
use stm32g474::{Drive, Pin};

/// Channel A of the encoder.
const A: Pin = Pin::new('B', 2);
/// Channel B of the encoder.
const B: Pin = Pin::new('C', 12);
/// Complement of channel A.
const NOT_A: Pin = Pin::new('C', 10);
/// Complement of channel B.
const NOT_B: Pin = Pin::new('C', 11);
/// Default temperature of the die, degrees Celsius.
const AMBIENT_C: f64 = 30.0;
/// Default noise of the force channel, N.
const FORCE_NOISE_N: f64 = 5e-3;

/// Returns the force per code of the sum of a block's conversions, N; `None` without a force
/// channel. A code of one conversion equals the noise of the channel.
pub fn newton_per_lsb(scene: &Driven) -> Option<f32> {
    let noise_n = Some(scene.sensors.force_noise_n).filter(|noise_n| *noise_n > 0.0).unwrap_or(FORCE_NOISE_N);
    scene.sensors.force_hz.map(|_| (noise_n / f64::from(FORCE_CONVERSIONS)) as f32)
}

/// Readings of the plant's sensors, as the source of the scene's fault injector.
#[derive(Clone, Debug, Default)]
struct Readings(SlowSense);

impl Analog for Readings {
    fn exchange(&mut self, _: &DriveBlock, sense: &mut SenseBlock) {
        sense.slow = self.0;
    }
}

/// Slow sensors of a scene.
#[derive(Clone, Debug)]
pub(crate) struct Sensors {
    faults: FaultInjector<Readings>,
    has_encoder: bool,
    newton_per_lsb: Option<f64>,
    latest: SlowSense,
    /// Number of force conversions since the last update.
    conversions: u32,
}

impl Sensors {
    /// Creates the sensors of a scene, at rest.
    pub fn new(scene: &Driven) -> Self {
        let block_s = f64::from(scene.controller.block_samples) / scene.sensors.sample_hz;
        let front_end = scene::settings::front_end(scene.sensors, scene.amplifier);
        let mut faults = FaultInjector::new(Readings::default(), &front_end, scene.seed);
        sim::run::faults(scene, block_s).for_each(|fault| faults.schedule(fault));
        Sensors {
            faults,
            has_encoder: scene.sensors.encoder_counts_per_mm.is_some(),
            newton_per_lsb: newton_per_lsb(scene).map(f64::from),
            latest: SlowSense::default(),
            conversions: 0,
        }
    }

    /// Takes the readings of the plant's sensors at the end of a block. During the scene its faults
    /// are applied.
    pub fn update(&mut self, readings: SlowSense, under_way: bool) {
        self.latest = readings;
        self.conversions = 0;
        if under_way {
            self.faults.inner.0 = readings;
            let mut sense = SenseBlock::default();
            self.faults.exchange(&DriveBlock::default(), &mut sense);
            self.latest = sense.slow;
        }
    }

    fn belt(&self) -> BeltSense {
        self.latest.belt.unwrap_or_default()
    }

    /// Returns the position of the encoder, edges.
    pub fn counts(&self) -> i32 {
        self.belt().counts
    }

    /// Returns the temperature of the die, degrees Celsius.
    pub fn celsius(&self) -> f64 {
        self.latest.temperature.map_or(AMBIENT_C, f64::from)
    }

    /// Returns the code of a force conversion. The codes of a block add up to the rounded reading.
    pub fn force_code(&mut self) -> Option<u16> {
        let sum = f64::from(self.latest.force.unwrap_or(0.0)) / self.newton_per_lsb?;
        let conversions = i64::from(FORCE_CONVERSIONS);
        let code = (sum.round() as i64 + i64::from(self.conversions) % conversions).div_euclid(conversions) + i64::from(SILENCE);
        self.conversions += 1;
        Some(code.clamp(0, 4095) as u16)
    }

    /// Adds the levels of the encoder's wires at a port to `drive`. A broken wire is low.
    pub fn levels(&self, port: u8, mut drive: Drive) -> Drive {
        if !self.has_encoder {
            return drive;
        }
        let BeltSense { counts, broken } = self.belt();
        // Order of counts: A, both, B, none.
        let (a, b) = (matches!(counts & 3, 1 | 2), matches!(counts & 3, 2 | 3));
        for (pin, level) in [(A, a && !broken), (NOT_A, !a && !broken), (B, b), (NOT_B, !b)] {
            if pin.port == port {
                drive.driven |= 1 << pin.number;
                drive.high |= u16::from(level) << pin.number;
            }
        }
        drive
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sensors(scene: &str) -> Sensors {
        Sensors::new(&scene::load::load(scene, &[]).unwrap().scene.driven().unwrap())
    }

    #[test]
    fn conversions_of_a_block_add_up_to_the_force() {
        let mut sensors = sensors("belt-stop");
        for force in [0.0, 1.6437, -0.0199, 19.3] {
            sensors.update(SlowSense { force: Some(force), ..SlowSense::default() }, false);
            let sum: u16 = (0..FORCE_CONVERSIONS).map(|_| sensors.force_code().unwrap()).sum();
            let read = nucleo_g474re::config::force_n(sum, newton_per_lsb_of(&sensors));
            assert!((read - force).abs() <= 0.51 * newton_per_lsb_of(&sensors), "{force}: {read}");
        }
    }

    fn newton_per_lsb_of(sensors: &Sensors) -> f32 {
        sensors.newton_per_lsb.unwrap() as f32
    }

    #[test]
    fn each_count_changes_one_wire_and_complements_differ() {
        let mut sensors = sensors("belt-stop");
        let mut levels = |counts, broken| {
            sensors.update(SlowSense { belt: Some(BeltSense { counts, broken }), ..SlowSense::default() }, false);
            let high = |pin: Pin| sensors.levels(pin.port, Drive::default()).high >> pin.number & 1 == 1;
            [A, NOT_A, B, NOT_B].map(high)
        };
        for counts in -5..5 {
            let ([a, not_a, b, not_b], [next_a, _, next_b, _]) = (levels(counts, false), levels(counts + 1, false));
            assert!(a != not_a && b != not_b && (a != next_a) != (b != next_b), "{counts}");
            let [a, not_a, ..] = levels(counts, true);
            assert!(!a && !not_a);
        }
    }
}
