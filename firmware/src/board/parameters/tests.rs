//! Tests of the parameters: keys, ranges, and reading back written values.

mod needs;

use super::*;
use crate::controller::Controller;
use crate::seam::block::Amplitude;
use crate::seam::config::{
    Around, Burst, Chirp, ChirpKind, Choice, Direction, Drive, Edge, Friction, FrictionLaw, FrontEnd, HeatSink, Limits, Link,
    MAX_WINDOWS, Optional, Phasing, Prefer, Range, Restraint, Schedule, ShapeKind, Supply, Sweep, Then, Thermometer, Tracking,
    TrackingMode,
};
use crate::seam::error::Error;

/// Returns a configuration of one lane that builds.
pub(crate) fn config() -> Config {
    Config {
        sample_hz: 1e6,
        block_samples: 32,
        lanes: 1,
        front_end: FrontEnd {
            volt_per_lsb: 0.005,
            ampere_per_lsb: 0.001,
            sense_mid_code: 4096,
            sense_max_code: 8190,
            drive_volt_per_lsb: 0.008,
            drive_mid_code: 2048,
            drive_max_code: 4095,
            drive_lanes: 4,
            metre_per_count: None,
            force_hz: None,
            newton_per_lsb: None,
        },
        drive: Drive::sine(40e3, Amplitude::Volts(3.0), 1.0),
        sweep: Sweep::Hold,
        phasing: Phasing::default(),
        burst: Burst::default(),
        tracking: Tracking {
            mode: TrackingMode::PhaseLock,
            span: 0.05,
            bandwidth_hz: 100.0,
            nominal_c0_f: Some(300e-9),
            ..Tracking::new(50.0)
        },
        thermometer: Thermometer::default(),
        heat_sink: HeatSink::default(),
        supply: Supply::default(),
        limits: Limits::default(),
        friction: None,
        restraint: None,
        link: Link::default(),
    }
}

/// Returns a configuration that builds, and in which a parameter acts.
fn config_of(parameter: &Parameter) -> Config {
    let mut config = config();
    match parameter.name {
        // A duty needs a period.
        "burst.duty" => config.burst.schedule = Schedule::Periodic { period_s: 0.01, duty: 0.5 },
        name if name.starts_with("burst.o") => config.burst.schedule = windows(),
        name if name.starts_with("friction.") => {
            config.drive.amplitude = Amplitude::MotionalCurrent(0.5);
            config.friction = (name != "friction.enabled").then_some(Friction::DEFAULT);
        }
        "restraint.enabled" => {}
        name if name.starts_with("restraint.") => config.restraint = Some(Restraint::DEFAULT),
        "sweep.around" => config.sweep = Sweep::Chirp(Chirp { start_hz: -300.0, stop_hz: 300.0, time_s: 0.02, ..Chirp::DEFAULT }),
        name if name.starts_with("sweep.") => {
            config.tracking.mode = TrackingMode::Off;
            config.sweep = Sweep::Chirp(Chirp { start_hz: 35e3, stop_hz: 45e3, time_s: 0.02, ..Chirp::DEFAULT });
        }
        "thermometer.resistance_k_per_w" => config.thermometer.heat_capacity_j_per_k = Some(0.05),
        name if name.starts_with("drive.noise") => {
            config.tracking.mode = TrackingMode::Off;
            config.drive.shape = ShapeKind::Noise;
        }
        _ => {}
    }
    config
}

/// Returns a value that differs from the built-in one and builds.
fn another(parameter: &Parameter, built_in: f32) -> f32 {
    match parameter.name {
        "limits.power_w" | "limits.on_time_s" => 7.0,
        "drive.amplitude_v" | "lanes" => 2.0,
        "front_end.metre_per_count" => 1e-5,
        "front_end.newton_per_lsb" => 1e-3,
        "front_end.force_hz" => 500.0,
        "heat_sink.ohm_at_25_c" => 10e3,
        "supply.divider" => 11.0,
        "thermometer.resistance_k_per_w" | "thermometer.heat_capacity_j_per_k" | "thermometer.start_c" => 30.0,
        "supply.min_v" => 18.0,
        "friction.target_force_n" => 5.0,
        "sweep.start_hz" => 34e3,
        "sweep.stop_hz" => 46e3,
        "sweep.time_s" => 0.01,
        "drive.motional_current_a" => 0.25,
        "burst.period_s" => 0.01,
        "burst.duty" => 0.25,
        "link.patience_s" => 2.5,
        "tracking.nominal_lm_h" => 0.8e-3,
        "tracking.c0_drift_per_s" | "thermometer.hz_per_k" | "thermometer.c0_per_k" => 0.01,
        // Window n is from 0.1 s to 0.15 s, plus n times 0.1 s.
        name if name.starts_with("burst.o") => built_in + 0.01,
        _ if matches!(parameter.range, Range::Choice(_)) => 1.0 - built_in,
        _ => 0.95 * built_in,
    }
}

/// Returns the largest number of windows.
fn windows() -> Schedule {
    Schedule::Windows((0..MAX_WINDOWS).map(|n| (0.1 + 0.1 * n as f64, 0.15 + 0.1 * n as f64)).collect())
}

#[test]
fn keys_and_names_are_unique_and_zero_is_not_a_key() {
    for (place, parameter) in PARAMETERS.iter().enumerate() {
        assert_eq!(place_of(parameter.key), Ok(place), "{}", parameter.name);
        assert!(parameter.key != 0 && PARAMETERS[..place].iter().all(|other| other.name != parameter.name), "{}", parameter.name);
    }
    assert!(PARAMETERS.len() <= MAX_PARAMETERS);
    assert_eq!([0, 32, 65, 199, 255].map(place_of), [Err(Refusal::NoSuchKey); 5]);
}

#[test]
fn a_key_never_changes_its_meaning() {
    let known = [(1, "front_end.volt_per_lsb"), (9, "limits.current_a"), (16, "tracking.nominal_c0_f"), (21, "link.patience_s")];
    for (key, name) in known {
        assert_eq!(PARAMETERS[place_of(key).unwrap()].name, name);
    }
}

#[test]
fn a_written_parameter_reads_back_builds_and_changes_no_other() {
    let built_in = values_of(&config());
    for (place, parameter) in PARAMETERS.iter().enumerate() {
        // A limit of energy needs a belt.
        if parameter.name == "limits.energy_j_per_m" {
            continue;
        }
        let mut config = config_of(parameter);
        let before = values_of(&config);
        let value = another(parameter, before[place]);
        assert_eq!(parameter.check(value, built_in[place]), Ok(()), "{}", parameter.name);
        (parameter.write)(&mut config, value);
        let values = values_of(&config);
        assert_eq!(values[place], value, "{}", parameter.name);
        assert!(Controller::build(&config).is_ok(), "{}", parameter.name);
        let moved = |other: &usize| values[*other] != before[*other] && *other != place;
        let others: std::vec::Vec<&str> = (0..PARAMETERS.len()).filter(moved).map(|other| PARAMETERS[other].name).collect();
        // Only one kind of amplitude, and one of friction target, can be set.
        let expected: &[&str] = match parameter.name {
            "drive.motional_current_a" => &["drive.amplitude_v"],
            "friction.target_force_n" => &["friction.target_ratio"],
            _ => &[],
        };
        assert_eq!(others, expected, "{}", parameter.name);
    }
}

#[test]
fn the_build_names_the_parameter_out_of_range() {
    let built_in = values_of(&config());
    for (place, parameter) in PARAMETERS.iter().enumerate() {
        let (Range::Within(least, most) | Range::Scale(least, most) | Range::UpToCeiling(least, most)) = parameter.range else {
            continue;
        };
        for value in [least - 1.0, 2.0 * most, f32::NAN] {
            let mut config = config_of(parameter);
            (parameter.write)(&mut config, value);
            if (parameter.read)(&config) == built_in[place] {
                continue;
            }
            let refused = Controller::check(&config).err();
            // For an element of a list, the error names the list.
            let asked: std::string::String = parameter.name.replace(|at: char| at.is_ascii_digit(), "").replace("__s", "_s");
            let asked = if parameter.name.starts_with("burst.o") { &*asked } else { parameter.name };
            let named = matches!(refused, Some(Error::OutOfRange { parameter: name, .. }) if name == asked);
            assert!(named || (parameter.read)(&config) == f32::INFINITY, "{} = {value}: {refused:?}", parameter.name);
        }
    }
}

#[test]
fn a_limit_is_never_raised() {
    let built_in = values_of(&config());
    let with = |name: &str, value: f32| {
        let place = PARAMETERS.iter().position(|parameter| parameter.name == name).expect("a parameter");
        PARAMETERS[place].check(value, built_in[place])
    };
    let mut limits = 0;
    for (parameter, built_in) in PARAMETERS.iter().zip(built_in).filter(|(parameter, _)| parameter.name.starts_with("limits.")) {
        limits += 1;
        let least = parameter.range.of(built_in).0;
        assert_eq!([least, built_in].map(|value| parameter.check(value, built_in)), [Ok(()); 2], "{}", parameter.name);
        let wrong = [least - 1e-6, -1.0, f32::NEG_INFINITY].map(|value| parameter.check(value, built_in));
        assert_eq!(wrong, [Err(Refusal::OutOfRange); 3], "{}", parameter.name);
        if built_in.is_finite() {
            let more = [built_in * 1.001, f32::INFINITY].map(|value| parameter.check(value, built_in));
            assert_eq!(more, [Err(Refusal::OutOfRange); 2], "{}", parameter.name);
        }
    }
    assert_eq!(limits, 7);
    assert_eq!([1e-9, 0.5, 1e3].map(|value| with("front_end.volt_per_lsb", value)), [Ok(()); 3]);
    assert_eq!([0.0, -1.0, 2e3].map(|value| with("front_end.volt_per_lsb", value)), [Err(Refusal::OutOfRange); 3]);
    assert_eq!([0.0, 1.0, 2.0].map(|value| with("burst.edge", value)), [Ok(()); 3]);
    assert_eq!([-1.0, 0.5, 3.0, f32::INFINITY].map(|value| with("burst.edge", value)), [Err(Refusal::OutOfRange); 4]);
    assert_eq!([0.0, 1.0, 3600.0].map(|value| with("link.patience_s", value)), [Ok(()); 3]);
    assert_eq!([-1.0, 3601.0, f32::INFINITY].map(|value| with("link.patience_s", value)), [Err(Refusal::OutOfRange); 3]);
    assert!(
        PARAMETERS
            .iter()
            .zip(built_in)
            .all(|(parameter, built_in)| parameter.check(f32::NAN, built_in) == Err(Refusal::NotPlausible))
    );
}

#[test]
fn a_limit_rises_with_its_scale_factors_but_not_in_codes() {
    let built_in = values_of(&config());
    let place = |key| place_of(key).unwrap();
    // An amplifier with a hundred times the gain, and a shunt with twice the resistance.
    let scales = [(3, 0.8), (2, 0.5e-3)];
    for (limit, ceiling) in [(8, 1546.6), (9, 1.5), (11, built_in[place(11)])] {
        let set = |value| overridden(&scales.into_iter().chain([(limit, value)]).collect(), &built_in);
        let with = |value| {
            let (values, all) = set(value);
            (values[place(limit)], all)
        };
        let near = |value: f32, expected: f32| (value / expected - 1.0).abs() < 1e-6;
        assert_eq!(with(0.9 * ceiling), (0.9 * ceiling, true));
        let (held, all) = with(1.1 * ceiling);
        assert!(near(held, ceiling) && !all, "{limit}: {held}");
        // The order in which they were stored does not matter.
        let (values, all) = overridden(&[(limit, 0.9 * ceiling)].into_iter().chain(scales).collect(), &built_in);
        assert_eq!((values[place(limit)], all), (0.9 * ceiling, true));
        // A limit that was not stored falls with its ceiling, but does not rise.
        let mut config = config();
        apply(&mut config, &overridden(&scales.into_iter().collect(), &built_in).0, &built_in, |_| true);
        let acts = (PARAMETERS[place(limit)].read)(&config);
        assert!(near(acts, ceiling.min(built_in[place(limit)])), "{limit}: {acts}");
        // Without its scale factors a limit is held to the built-in value.
        let mut config = self::config();
        apply(&mut config, &set(0.9 * ceiling).0, &built_in, |acting| acting == place(limit));
        let acts = (PARAMETERS[place(limit)].read)(&config);
        assert_eq!(acts, (0.9 * ceiling).min(built_in[place(limit)]), "{limit}");
    }
}

#[test]
fn choices_match_their_places() {
    fn agree<T: Choice>() {
        assert_eq!(T::ALL.len(), T::NAMES.len());
        assert!(T::ALL.iter().all(|choice| T::at(choice.place()) == *choice));
    }
    agree::<bool>();
    agree::<Edge>();
    agree::<TrackingMode>();
    agree::<ShapeKind>();
    agree::<Direction>();
    agree::<ChirpKind>();
    agree::<Then>();
    agree::<Around>();
    agree::<FrictionLaw>();
    agree::<Prefer>();
}

#[test]
fn windows_are_set_end_by_end() {
    let mut config = config();
    let mut set = |key, value| {
        (PARAMETERS[place_of(key).unwrap()].write)(&mut config, value);
        config.burst.schedule.clone()
    };
    assert_eq!(set(40, 0.0), Schedule::Continuous);
    assert_eq!(set(43, 2.0), Schedule::Windows([(0.0, 0.0), (0.0, 2.0)].into_iter().collect()));
    set(42, 1.5);
    set(41, 0.5);
    assert_eq!(set(40, 0.25), Schedule::Windows([(0.25, 0.5), (1.5, 2.0)].into_iter().collect()));
    set(43, 0.0);
    assert_eq!(set(42, 0.0), Schedule::Windows([(0.25, 0.5)].into_iter().collect()));
    set(40, 0.0);
    assert_eq!(set(41, 0.0), Schedule::Continuous);
}

#[test]
fn only_differing_and_valid_values_are_kept() {
    let built_in = values_of(&config());
    assert!(overrides(&built_in, &built_in).is_empty());
    let mut values = built_in;
    (values[7], values[20]) = (2.0, 1.5);
    let stored = overrides(&values, &built_in);
    assert_eq!(stored, [(8, 2.0), (21, 1.5)]);
    assert_eq!(overridden(&stored, &built_in), (values, true));
    for wrong in [(8, 1000.0), (21, f32::NAN), (21, f32::INFINITY), (0, 1.0), (199, 1.0)] {
        let mut stored = stored.clone();
        stored.retain(|(key, _)| *key != wrong.0);
        let expected = overridden(&stored, &built_in).0;
        stored.push(wrong).unwrap();
        assert_eq!(overridden(&stored, &built_in), (expected, false), "{wrong:?}");
    }
    // An invalid limit becomes the nearest valid value; of two entries the lower one acts.
    for (wrong, limit) in
        [(f32::NAN, 1e-3), (-1.0, 1e-3), (f32::NEG_INFINITY, 1e-3), (0.0, 1e-3), (1000.0, 15.466), (f32::INFINITY, 15.466)]
    {
        let (values, all) = overridden(&Overrides::from_iter([(8, wrong)]), &built_in);
        assert_eq!((values[7], all), (limit, false), "{wrong}");
    }
    assert_eq!(overridden(&Overrides::from_iter([(8, 2.0), (8, 3.0)]), &built_in).0[7], 2.0);
    assert_eq!(overridden(&Overrides::from_iter([(10, f32::INFINITY)]), &built_in), (built_in, true));
    assert_eq!(
        overridden(&Overrides::from_iter([(10, 2e5)]), &built_in),
        (
            {
                let mut values = built_in;
                values[9] = 1e5;
                values
            },
            false
        )
    );
    let mut config = config();
    apply(&mut config, &values, &built_in, |_| true);
    assert_eq!((config.limits.voltage_v, config.link.patience_s), (2.0, 1.5));
    assert_eq!(config.burst.schedule, Schedule::Continuous);
}

/// Returns the built-in values with some of them replaced.
fn with(set: &[(u8, f32)]) -> Values {
    let mut values = values_of(&config());
    for &(key, value) in set {
        values[place_of(key).unwrap()] = value;
    }
    values
}

#[test]
fn a_parameter_without_its_need_is_refused() {
    let built_in = values_of(&config());
    let check = |(key, value): (u8, f32), set: &[(u8, f32)]| check_need(place_of(key).unwrap(), value, &with(set), &built_in);
    // A parameter, and the one that it needs.
    let needs = [
        ((13, 1.0), (56, 1e-5)),
        ((14, 100.0), (56, 1e-5)),
        ((83, 1.0), (56, 1e-5)),
        ((20, 0.5), (19, 0.01)),
        ((58, 500.0), (57, 1e-3)),
        ((60, 3000.0), (59, 10e3)),
        ((61, 5e3), (59, 10e3)),
        ((69, 1.0), (68, 0.01)),
        ((73, 1.0), (68, 0.01)),
        ((75, 0.5), (74, 1.0)),
        ((82, 0.1), (74, 1.0)),
        ((96, 2e-3), (74, 1.0)),
        ((97, 0.8), (74, 1.0)),
        ((84, 500.0), (83, 1.0)),
        ((90, 50.0), (83, 1.0)),
    ];
    for (parameter, need) in needs {
        assert_eq!(need_of(parameter.0), Some(need.0));
        assert_eq!(check(parameter, &[]), Err(Refusal::NotConfigured), "{parameter:?}");
        assert_eq!(check(parameter, &[need]), Ok(()), "{parameter:?}");
    }
    assert_eq!((need_of(8), check((8, 2.0), &[]), check((62, 4.0), &[]), check((64, 1.0), &[])), (None, Ok(()), Ok(()), Ok(())));
}

#[test]
fn the_belts_scale_stays_while_something_needs_it() {
    let built_in = values_of(&config());
    let none = |set: &[(u8, f32)]| check_need(place_of(56).unwrap(), f32::INFINITY, &with(set), &built_in);
    assert_eq!(none(&[(56, 1e-5)]), Ok(()));
    for user in [(14, 100.0), (83, 1.0)] {
        assert_eq!(none(&[(56, 1e-5), user]), Err(Refusal::NotConfigured), "{user:?}");
        // Removing the parameter needs nothing.
        let gone = if user.0 == 14 { f32::INFINITY } else { 0.0 };
        assert_eq!(check_need(place_of(user.0).unwrap(), gone, &with(&[user]), &built_in), Ok(()));
    }
}

#[test]
fn the_belt_stop_limit_rises_only_at_a_d_ring() {
    let built_in = values_of(&config());
    let place = place_of(13).unwrap();
    let acts = |stored: &[(u8, f32)]| {
        let (values, all) = overridden(&stored.iter().copied().collect(), &built_in);
        let mut config = config();
        apply(&mut config, &values, &built_in, |_| true);
        (config.limits.belt_stop_ms, all)
    };
    let default = built_in[place];
    assert_eq!(acts(&[(13, 1000.0), (56, 1e-5), (83, 1.0)]), (1000.0, true));
    assert_eq!(acts(&[(13, 1000.0), (56, 1e-5)]), (default, false));
    assert_eq!(acts(&[(56, 1e-5), (83, 1.0)]), (default, true), "it rises only if it is set");
    assert_eq!(acts(&[(13, 2000.0), (83, 1.0)]), (1000.0, false));
}
