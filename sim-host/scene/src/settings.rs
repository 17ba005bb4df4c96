//! A scene's `[controller]` as the firmware's configuration. Scale factors come from the scene's converters, as they would from
//! the settings store of a calibrated board; everything else is what the user knows beforehand, not the plant's truth.

use firmware::block::Amplitude;
use firmware::block::Target;
use firmware::config::{
    Around, Burst, Chirp, ChirpKind, Config, Direction, Drive, Edge, Friction, FrictionLaw, FrontEnd, LaneTrims, Limits, Link,
    Phasing, Restraint, Schedule, ShapeKind, Sweep, Then, Thermometer, Tracking, TrackingMode,
};

use crate as scene;

/// The firmware's configuration for a scene that has passed its rules.
pub fn config(scene: &scene::Driven) -> Config {
    let controller = scene.controller;
    let drive = &controller.drive;
    Config {
        sample_hz: scene.sensors.sample_hz as f32,
        block_samples: controller.block_samples,
        lanes: drive.lanes,
        front_end: front_end(scene.sensors, scene.amplifier),
        drive: Drive {
            frequency_hz: drive.frequency_hz as f32,
            amplitude: amplitude(scene),
            scan_volts: drive.scan_v.or(drive.amplitude_v).unwrap_or(1.0) as f32,
            shape: match drive.shape {
                scene::Shape::Sine => ShapeKind::Sine,
                scene::Shape::Square => ShapeKind::Square,
                scene::Shape::Sawtooth => ShapeKind::Sawtooth,
                scene::Shape::Noise => ShapeKind::Noise,
            },
            noise_band_hz: (
                drive.noise_low_hz.unwrap_or(0.75 * drive.frequency_hz) as f32,
                drive.noise_high_hz.unwrap_or(1.25 * drive.frequency_hz) as f32,
            ),
            dither: drive.dither,
            seed: scene.seed,
        },
        sweep: sweep(controller.sweep.as_ref()),
        phasing: Phasing {
            direction: match controller.phasing.direction {
                scene::Direction::Forward => Direction::Forward,
                scene::Direction::Reverse => Direction::Reverse,
            },
            phase_trim_turns: controller.phasing.phase_trim_turns.iter().map(|&x| x as f32).collect(),
            gain_trim: controller.phasing.gain_trim.iter().map(|&x| x as f32).collect(),
            calibration: LaneTrims::new(),
        },
        burst: burst(controller.burst.as_ref(), scene.trigger_delay_s()),
        tracking: tracking(&controller.tracking),
        thermometer: Thermometer {
            hz_per_k: controller.thermometer.hz_per_k as f32,
            c0_per_k: controller.thermometer.c0_per_k as f32,
            ambient_c: controller.thermometer.ambient_c as f32,
        },
        limits: limits(&controller.limits),
        friction: controller.friction.as_ref().map(|told| friction(told, &controller.tracking)),
        restraint: controller.restraint.as_ref().map(restraint),
        link: Link::default(),
    }
}

fn friction(told: &scene::Friction, tracking: &scene::Tracking) -> Friction {
    let target = match (told.target_ratio, told.target_force_n) {
        (None, Some(newtons)) => Target::Force(newtons as f32),
        (ratio, _) => Target::Ratio(ratio.unwrap_or(1.0) as f32),
    };
    Friction {
        target,
        law: match told.law {
            scene::FrictionLaw::Dahl => FrictionLaw::Dahl,
            scene::FrictionLaw::Coulomb => FrictionLaw::Coulomb,
        },
        prefer_bursts: told.prefer == scene::Prefer::Bursts,
        force_factor_n_per_v: tracking.nominal_force_factor_n_per_v.unwrap_or(1.0) as f32,
        speed_m_per_s: told.speed_m_per_s as f32,
        dahl_length_m: told.dahl_length_m as f32,
        average_s: told.average_s as f32,
    }
}

fn restraint(restraint: &scene::Restraint) -> Restraint {
    Restraint {
        sensed_n: restraint.sensed_n as f32,
        confirm_ms: restraint.confirm_ms as f32,
        latest_ms: restraint.latest_ms as f32,
        latest_n: restraint.latest_n as f32,
        light_below_kg: restraint.light_below_kg as f32,
        least_kg: restraint.least_kg as f32,
        most_kg: restraint.most_kg as f32,
    }
}

fn limits(limits: &scene::Limits) -> Limits {
    let single = |limit: Option<f64>| limit.map(|limit| limit as f32);
    Limits {
        voltage_v: limits.voltage_v as f32,
        current_a: limits.current_a as f32,
        power_w: single(limits.power_w),
        temperature_c: limits.temperature_c as f32,
        belt_stop_ms: limits.belt_stop_ms as f32,
        energy_j_per_m: single(limits.energy_j_per_m),
        on_time_s: single(limits.on_time_s),
    }
}

/// The converters' scale factors.
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
    }
}

/// A code as the firmware has it. It fits: the rules see to the sense codes, and a DAC has 16 bits at most.
fn code(code: u32) -> u16 {
    u16::try_from(code).unwrap_or(u16::MAX)
}

fn amplitude(scene: &scene::Driven) -> Amplitude {
    let (drive, tracking) = (&scene.controller.drive, &scene.controller.tracking);
    match (scene.ordered_velocity_m_per_s(), drive.amplitude_v) {
        (Some(velocity), _) => {
            Amplitude::MotionalCurrent((velocity * tracking.nominal_force_factor_n_per_v.unwrap_or(1.0)) as f32)
        }
        (None, volts) => Amplitude::Volts(volts.unwrap_or(0.0) as f32),
    }
}

fn sweep(sweep: Option<&scene::Sweep>) -> Sweep {
    let Some(sweep) = sweep else { return Sweep::Hold };
    Sweep::Chirp(Chirp {
        kind: match sweep.kind {
            scene::ChirpKind::Linear => ChirpKind::Linear,
            scene::ChirpKind::Exponential => ChirpKind::Exponential,
        },
        start_hz: sweep.start_hz as f32,
        stop_hz: sweep.stop_hz as f32,
        time_s: sweep.time_s,
        then: match sweep.then {
            scene::Then::Hold => Then::Hold,
            scene::Then::Repeat => Then::Repeat,
            scene::Then::Updown => Then::UpDown,
        },
        around: match sweep.around {
            scene::Around::Zero => Around::Zero,
            scene::Around::Resonance => Around::Resonance,
        },
    })
}

/// The burst, `later_s` seconds later than it says.
fn burst(burst: Option<&scene::Burst>, later_s: f64) -> Burst {
    let Some(burst) = burst else { return Burst { schedule: Schedule::Continuous, edge: Edge::Hard, brake: false } };
    let schedule = match (burst.period_s, burst.duty) {
        (Some(period_s), Some(duty)) => Schedule::Periodic { period_s, duty },
        _ => Schedule::Windows(burst.on_s.iter().zip(&burst.off_s).map(|(on, off)| (on + later_s, off + later_s)).collect()),
    };
    let edge = match burst.edge {
        scene::Edge::Hard => Edge::Hard,
        scene::Edge::Soft => Edge::Soft { cycles: burst.edge_cycles as f32 },
        scene::Edge::Boost => Edge::Boost,
    };
    Burst { schedule, edge, brake: burst.brake }
}

fn tracking(tracking: &scene::Tracking) -> Tracking {
    Tracking {
        mode: match tracking.mode {
            scene::TrackingMode::Observer => TrackingMode::Observer,
            scene::TrackingMode::PhaseLock => TrackingMode::PhaseLock,
            scene::TrackingMode::ZeroPhase => TrackingMode::ZeroPhase,
            scene::TrackingMode::Off => TrackingMode::Off,
        },
        span: tracking.span as f32,
        bandwidth_hz: tracking.bandwidth_hz as f32,
        nominal_q: tracking.nominal_q as f32,
        nominal_lm_h: tracking.nominal_lm_h.map(|henry| henry as f32),
        nominal_c0_f: tracking.nominal_c0_f as f32,
        c0_drift_per_s: tracking.c0_drift_per_s as f32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_bits(adc_bits: u8, dac_bits: u8, oversample: u8) -> FrontEnd {
        let sensors = scene::Sensors { adc_bits, dac_bits, oversample, ..scene::Sensors::default() };
        front_end(&sensors, &scene::Amplifier::default())
    }

    #[test]
    fn codes_of_every_width_are_exact() {
        for (bits, oversample) in (6..=16).flat_map(|bits| (1..=4).map(move |oversample| (bits, oversample))) {
            let (max, mid) = (((1u32 << bits) - 1) * u32::from(oversample), (1u32 << (bits - 1)) * u32::from(oversample));
            let made = of_bits(bits, bits, oversample);
            assert_eq!(u32::from(made.drive_max_code), (1 << bits) - 1);
            if max <= 65535 {
                assert_eq!((u32::from(made.sense_max_code), u32::from(made.sense_mid_code)), (max, mid), "{bits} x {oversample}");
            }
        }
    }
}
