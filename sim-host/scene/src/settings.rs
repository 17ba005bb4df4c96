//! Conversion of a scene's `[controller]` to the firmware's configuration.
//!
//! Scale factors come from the scene's converters, as from the settings store of a calibrated
//! board. Everything else is the user's prior knowledge, not the true values of the plant.

use firmware::seam::block::{Amplitude, Target};
use firmware::seam::config::{self, Config, FrontEnd, LaneTrims, Link, Schedule};

use crate as scene;

/// Returns the firmware's configuration for a scene that has passed its rules.
pub fn config(scene: &scene::Driven) -> Config {
    let controller = scene.controller;
    let tracking = &controller.tracking;
    Config {
        sample_hz: scene.sensors.sample_hz as f32,
        block_samples: controller.block_samples,
        lanes: controller.drive.lanes,
        front_end: front_end(scene.sensors, scene.amplifier),
        drive: drive(scene),
        sweep: controller.sweep.as_ref().map_or(config::Sweep::Hold, |sweep| config::Sweep::Chirp(sweep.settings())),
        phasing: phasing(scene),
        burst: controller.burst.as_ref().map_or_else(config::Burst::default, |burst| {
            let schedule = schedule(burst, scene.trigger_delay_s());
            burst.with(schedule)
        }),
        tracking: tracking.settings(),
        thermometer: controller.thermometer.settings(),
        heat_sink: config::HeatSink::default(),
        supply: config::Supply::default(),
        limits: controller.limits.settings(),
        friction: controller.friction.as_ref().map(|friction| friction.with(target(friction), force_factor(tracking) as f32)),
        restraint: controller.restraint.as_ref().map(scene::Restraint::settings),
        link: Link::default(),
    }
}

/// Returns the phasing. If lane 0 drives a stack, the other lanes have nothing to watch.
fn phasing(scene: &scene::Driven) -> config::Phasing {
    let phasing = scene.controller.phasing.with(LaneTrims::new());
    config::Phasing { watch: phasing.watch && scene.stator().is_some(), ..phasing }
}

/// Returns the scale factors of the converters.
pub fn front_end(sensors: &scene::Sensors, amplifier: &scene::Amplifier) -> FrontEnd {
    let conversions = u32::from(sensors.oversample);
    let (sense_half, drive_half) = (1u32 << (sensors.adc_bits - 1), 1u32 << (sensors.dac_bits - 1));
    let sense = |full_scale: f64| (full_scale / f64::from(sense_half) / f64::from(conversions)) as f32;
    FrontEnd {
        volt_per_lsb: sense(sensors.v_full_scale_v),
        ampere_per_lsb: sense(sensors.i_full_scale_a),
        sense_mid_code: code(sense_half * conversions),
        sense_max_code: code((2 * sense_half - 1) * conversions),
        drive_volt_per_lsb: (amplifier.full_scale_v / f64::from(drive_half)) as f32,
        drive_mid_code: code(drive_half),
        drive_max_code: code(2 * drive_half - 1),
        drive_lanes: amplifier.lanes,
        metre_per_count: sensors.encoder_counts_per_mm.map(|counts| (1e-3 / counts) as f32),
        force_hz: sensors.force_hz.map(|hz| hz as f32),
        // The plant gives its readings in newtons.
        newton_per_lsb: None,
    }
}

/// Converts a code to the firmware's type. It fits: the rules check the sense codes, and a DAC has
/// at most 16 bits.
fn code(code: u32) -> u16 {
    u16::try_from(code).unwrap_or(u16::MAX)
}

/// Returns the drive settings. Without its own voltage, a scan uses that of the drive.
fn drive(scene: &scene::Driven) -> config::Drive {
    let drive = &scene.controller.drive;
    let scan_v = drive.scan_v.or(drive.amplitude_v).unwrap_or(1.0);
    let (low_hz, high_hz) = (0.75 * drive.frequency_hz, 1.25 * drive.frequency_hz);
    let noise_band_hz = (drive.noise_low_hz.unwrap_or(low_hz) as f32, drive.noise_high_hz.unwrap_or(high_hz) as f32);
    drive.with(amplitude(scene), scan_v as f32, noise_band_hz, scene.seed)
}

/// Returns the set point. A velocity is controlled through the motional current, which is force
/// factor times velocity.
fn amplitude(scene: &scene::Driven) -> Amplitude {
    let controller = scene.controller;
    match scene.ordered_velocity_m_per_s() {
        Some(velocity) => Amplitude::MotionalCurrent((velocity * force_factor(&controller.tracking)) as f32),
        None => Amplitude::Volts(controller.drive.amplitude_v.unwrap_or(0.0) as f32),
    }
}

fn force_factor(tracking: &scene::Tracking) -> f64 {
    tracking.nominal_force_factor_n_per_v.unwrap_or(1.0)
}

/// Returns the times at which the drive is ON, each `later_s` seconds after its burst window.
fn schedule(burst: &scene::Burst, later_s: f64) -> Schedule {
    match (burst.period_s, burst.duty) {
        (Some(period_s), Some(duty)) => Schedule::Periodic { period_s, duty },
        _ => Schedule::Windows(burst.on_s.iter().zip(&burst.off_s).map(|(on, off)| (on + later_s, off + later_s)).collect()),
    }
}

fn target(friction: &scene::Friction) -> Target {
    match (friction.target_ratio, friction.target_force_n) {
        (None, Some(newtons)) => Target::Force(newtons as f32),
        (ratio, _) => Target::Ratio(ratio.unwrap_or(1.0) as f32),
    }
}
#[cfg(test)]
mod tests {
    use super::*;

    fn front_end_of_bits(adc_bits: u8, dac_bits: u8, oversample: u8) -> FrontEnd {
        let sensors = scene::Sensors { adc_bits, dac_bits, oversample, ..scene::Sensors::default() };
        front_end(&sensors, &scene::Amplifier::default())
    }

    #[test]
    fn codes_of_every_width_are_exact() {
        for (bits, oversample) in (6..=16).flat_map(|bits| (1..=4).map(move |oversample| (bits, oversample))) {
            let (max, mid) = (((1u32 << bits) - 1) * u32::from(oversample), (1u32 << (bits - 1)) * u32::from(oversample));
            let made = front_end_of_bits(bits, bits, oversample);
            assert_eq!(u32::from(made.drive_max_code), (1 << bits) - 1);
            if max <= 65535 {
                assert_eq!((u32::from(made.sense_max_code), u32::from(made.sense_mid_code)), (max, mid), "{bits} x {oversample}");
            }
        }
    }
}
