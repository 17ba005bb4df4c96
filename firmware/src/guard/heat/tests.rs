use super::*;
use crate::board::parameters::tests::config;

const BLOCK_S: f32 = 32e-6;

/// Returns a watch with a limit of 80 °C, a stack with two thermometers, and these changes.
fn heat(change: impl FnOnce(&mut Config)) -> Heat {
    let mut config = config();
    config.limits.temperature_c = 80.0;
    (config.thermometer.hz_per_k, config.thermometer.c0_per_k) = (-10.0, 4e-3);
    change(&mut config);
    Heat::build(&config, BLOCK_S)
}

fn estimates(resonance_hz: f32, susceptance: f32) -> Thermometers {
    Thermometers { resonance_hz, susceptance }
}

/// Inspects blocks without a sensor of the board.
fn inspect_often(heat: &mut Heat, blocks: u32, watts: f32) {
    for _ in 0..blocks {
        heat.inspect_temperature(None, watts);
    }
}

#[test]
fn the_drive_falls_to_a_tenth_and_ends_above_the_limit() {
    let mut heat = heat(|_| {});
    for (celsius, factor, fault) in [(25.0, 1.0, false), (60.0, 1.0, false), (70.0, 0.55, false), (79.99, 0.1, false)] {
        assert_eq!(heat.inspect_temperature(Some(celsius), 0.0).is_some(), fault);
        assert!((heat.factor() - factor).abs() < 1e-3, "{celsius}: {}", heat.factor());
    }
    assert_eq!(heat.inspect_temperature(Some(80.0), 0.0), None);
    assert_eq!(heat.inspect_temperature(Some(80.001), 0.0), Some(Fault::OverTemperature));
    assert_eq!(heat.inspect_temperature(Some(f32::NAN), 0.0), Some(Fault::OverTemperature));
    assert_eq!(heat.inspect_temperature(Some(25.0), 0.0), None);
}

#[test]
fn the_hotter_of_board_and_stack_counts() {
    let mut heat = heat(|_| {});
    heat.inspect_temperature(Some(30.0), 0.0);
    heat.update_temperature(&estimates(-50.0, 0.075));
    assert_eq!(heat.stack.celsius(), 30.0);
    // A resonance 400 Hz lower indicates 40 K, a capacitance 20 % higher 50 K.
    heat.update_temperature(&estimates(-450.0, 0.075));
    assert!((heat.stack.celsius() - 70.0).abs() < 1e-3, "{}", heat.stack.celsius());
    heat.update_temperature(&estimates(-450.0, 0.075 * 1.2));
    assert!((heat.stack.celsius() - 80.0).abs() < 1e-2, "{}", heat.stack.celsius());
    heat.update_temperature(&estimates(-560.0, 0.075));
    assert_eq!(heat.inspect_temperature(Some(30.0), 0.0), Some(Fault::OverTemperature));
}

#[test]
fn a_sensor_at_the_stack_overrides_all_estimates() {
    let mut heat = heat(|config| config.thermometer.at_stack = true);
    heat.update_temperature(&estimates(0.0, 0.075));
    heat.update_temperature(&estimates(-600.0, 0.075));
    assert_eq!(heat.inspect_temperature(Some(60.0), 1e3), None);
    assert_eq!(heat.factor(), 1.0);
    assert_eq!(heat.inspect_temperature(Some(81.0), 0.0), Some(Fault::OverTemperature));
}

/// A load that raises the resonance by 40 K within a block is added to all later readings, and
/// taken back when it ends. Without a load, readings are not changed.
#[test]
fn a_load_is_told_from_cooling() {
    let mut heat = heat(|_| {});
    let mut read = |hz: f32| {
        inspect_often(&mut heat, 64, 1.0);
        heat.update_temperature(&estimates(hz, 0.075));
        heat.stack.celsius()
    };
    // Heating by 30 K in 0.6 s.
    for n in 0..300 {
        read(-(n as f32));
    }
    for _ in 0..20 {
        assert!((54.0..55.5).contains(&read(-300.0)));
        let loaded = read(100.0);
        assert!((45.0..57.0).contains(&loaded), "{loaded}");
    }
    let (freed, cool) = (read(-300.0), (0..3000).map(|n| read(-300.0 + 0.1 * n as f32)).last().unwrap());
    assert!((54.0..57.0).contains(&freed) && (24.0..27.0).contains(&cool), "{freed} {cool}");
}

/// With constant power the bound follows the closed form for the largest resistance and the
/// smallest heat capacity, and cools with the largest.
#[test]
fn the_bound_follows_the_closed_form() {
    let mut heat = heat(|config| {
        let thermometer = &mut config.thermometer;
        (thermometer.resistance_k_per_w, thermometer.heat_capacity_j_per_k) = (Some(20.0), Some(0.05));
        (thermometer.start_c, thermometer.tolerance) = (Some(25.0), 0.3);
    });
    let mut after = |seconds: f32, watts: f32| {
        inspect_often(&mut heat, (seconds / BLOCK_S) as u32, watts);
        heat.stack.celsius()
    };
    let heated = after(1.0, 1.0);
    let expected = 25.0 + 26.0 * (1.0 - libm::expf(-1.0 / (26.0 * 0.035)));
    assert!((heated - expected).abs() < 0.1, "{heated} {expected}");
    let settled = after(10.0, 1.0);
    assert!((settled - 51.0).abs() < 0.1, "{settled}");
    let cooled = after(1.0, 0.0);
    let expected = 25.0 + 26.0 * libm::expf(-1.0 / (26.0 * 0.065));
    assert!((cooled - expected).abs() < 0.1, "{cooled} {expected}");
}

#[test]
fn an_unknown_start_is_assumed_warm() {
    let mut heat = heat(|config| {
        (config.thermometer.resistance_k_per_w, config.thermometer.heat_capacity_j_per_k) = (Some(20.0), Some(0.05));
    });
    assert_eq!(heat.inspect_temperature(None, 0.0), None);
    assert_eq!(heat.factor(), MIN_FACTOR);
    // No reference is taken while the stack may be cooling.
    heat.update_temperature(&estimates(0.0, 0.075));
    inspect_often(&mut heat, (10.0 / BLOCK_S) as u32, 0.0);
    heat.update_temperature(&estimates(400.0, 0.075));
    assert!(heat.factor() == 1.0 && heat.stack.celsius() < 26.0, "{}", heat.stack.celsius());
}

#[test]
fn the_mean_power_is_held_at_its_limit() {
    let mut heat = heat(|config| config.limits.power_w = Some(2.0));
    // 8 W at full amplitude are reduced to 2 W at half the amplitude.
    for _ in 0..10_000 {
        let factor = heat.factor();
        heat.limit_power(8.0 * factor * factor);
    }
    assert!((heat.factor() - 0.5).abs() < 1e-3, "{}", heat.factor());
    // The smaller factor acts, and the factor recovers when the power falls.
    heat.inspect_temperature(Some(79.0), 0.0);
    assert!((heat.factor() - 0.145).abs() < 1e-3, "{}", heat.factor());
    heat.inspect_temperature(Some(25.0), 0.0);
    (0..10_000).for_each(|_| heat.limit_power(0.5));
    assert_eq!(heat.factor(), 1.0);
}

#[test]
fn a_nan_power_counts_as_over_the_limit() {
    let mut heat = heat(|config| config.limits.power_w = Some(2.0));
    (0..1000).for_each(|_| heat.limit_power(f32::NAN));
    assert_eq!(heat.factor(), MIN_FACTOR);
    (0..10_000).for_each(|_| heat.limit_power(1.0));
    assert_eq!(heat.factor(), 1.0);
}

#[test]
fn the_power_is_averaged_over_1_ms_and_reduced_over_32_ms() {
    let mut heat = heat(|config| config.limits.power_w = Some(2.0));
    // Three times the limit for 8 ms: the factor falls by 2 (8 - 1) / 32, 1 ms being the delay of
    // the mean, and a little less while the mean settles.
    (0..250).for_each(|_| heat.limit_power(6.0));
    assert!((heat.factor() - 0.585).abs() < 0.01, "{}", heat.factor());
}

/// Random numbers of the property test.
struct Random(u64);

impl Random {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }

    fn one_in(&mut self, count: f64) -> bool {
        self.within(0.0, count) < 1.0
    }
}

/// Simulates a random stack in closed loop with the watch, and returns its highest temperature over
/// the limit before a fault, K, and the mean of the power over the last third relative to the
/// largest power that it can take for ever, both with a closed-form step of double precision.
///
/// The resonance is shifted by steps, ramps, modes and noise; the true values lie anywhere within
/// the tolerance; the surroundings are measured, or below the configured temperature.
fn overshoot_and_use(seed: u64, tolerance: f64, disturbed: bool) -> (f64, f64) {
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    for _ in 0..8 {
        random.within(0.0, 1.0);
    }
    let off = |random: &mut Random| if disturbed { random.within(1.0 - tolerance, 1.0 + tolerance) } else { 1.0 };
    let (nominal_r, nominal_c) = (random.within(1.0, 50.0), libm::exp(random.within(-5.0, 0.0)));
    let (r, c) = (nominal_r * off(&mut random), nominal_c * off(&mut random));
    let block_s = 0.002 * nominal_r * nominal_c;
    let (highest_c, limit_c) = (random.within(-20.0, 45.0), random.within(55.0, 120.0));
    let measured = random.one_in(2.0);
    let mut surroundings_c = if measured || !disturbed { highest_c } else { random.within(highest_c - 40.0, highest_c) };
    // Half of the stacks begin warm, as assumed, or anywhere below.
    let start_c = if disturbed { random.within(surroundings_c, limit_c) } else { surroundings_c };
    let told_c = (!disturbed || random.one_in(2.0)).then_some(start_c as f32);
    let hz_per_k = random.within(5.0, 30.0) * if random.one_in(2.0) { -1.0 } else { 1.0 };
    let c0_per_k = if random.one_in(2.0) { 0.0 } else { 4e-3 };
    let mut heat = {
        let mut config = config();
        let thermometer = &mut config.thermometer;
        (thermometer.hz_per_k, thermometer.c0_per_k) = (hz_per_k as f32, c0_per_k as f32);
        (thermometer.resistance_k_per_w, thermometer.heat_capacity_j_per_k) = (Some(nominal_r as f32), Some(nominal_c as f32));
        (thermometer.tolerance, thermometer.start_c, thermometer.ambient_c) = (tolerance as f32, told_c, highest_c as f32);
        config.limits.temperature_c = limit_c as f32;
        Heat::build(&config, block_s as f32)
    };
    let most_w = (limit_c - surroundings_c) / r;
    let mut asked_w = most_w * random.within(0.5, 20.0);
    let (mut kelvin_c, mut over_k, mut used_w) = (start_c, f64::NEG_INFINITY, 0.0);
    let (mut load_hz, mut ramp_hz) = (0.0, 0.0);
    let (blocks, remains) = (6000, libm::exp(-block_s / (r * c)));
    for n in 0..blocks {
        if disturbed && random.one_in(300.0) {
            load_hz += random.within(-1500.0, 1500.0);
            ramp_hz = if random.one_in(2.0) { random.within(-3.0, 3.0) } else { 0.0 };
            asked_w = if random.one_in(4.0) { 0.0 } else { most_w * random.within(0.2, 20.0) };
            surroundings_c = if measured { highest_c + random.within(-10.0, 10.0) } else { surroundings_c };
        }
        load_hz += ramp_hz;
        let factor = f64::from(heat.factor());
        let watts = asked_w * factor * factor;
        let end_c = surroundings_c + r * watts;
        kelvin_c = end_c + (kelvin_c - end_c) * remains;
        used_w += if n >= 2 * blocks / 3 { watts } else { 0.0 };
        let board_c = measured.then_some(surroundings_c as f32);
        if heat.inspect_temperature(board_c, watts as f32).is_some() {
            break;
        }
        over_k = over_k.max(kelvin_c - limit_c);
        let hz = hz_per_k * (kelvin_c - 25.0) + load_hz + if disturbed { random.within(-2.0, 2.0) } else { 0.0 };
        heat.update_temperature(&estimates(hz as f32, (0.075 * (1.0 + c0_per_k * (kelvin_c - 25.0))) as f32));
    }
    (over_k, used_w / (blocks / 3) as f64 / most_w)
}

#[test]
fn no_combination_of_loads_exceeds_the_limit() {
    let excesses = (0..10_000).map(|seed| (overshoot_and_use(seed, 0.3, true).0, seed));
    let (worst_k, seed) = excesses.max_by(|one, other| one.0.total_cmp(&other.0)).unwrap();
    std::println!("highest excess {worst_k:.2} K, seed {seed}");
    assert!(worst_k < 0.0, "{worst_k} K, seed {seed}");
}

/// The loss by the tolerance is that of the power at the same demand with exact values.
#[test]
fn the_bound_costs_a_tenth_of_the_power_if_measured_and_a_quarter_if_not() {
    for (tolerance, most) in [(0.1, 0.10), (0.3, 0.24)] {
        let used = |seed, tolerance| overshoot_and_use(seed, tolerance, false).1;
        let worst = (0..300).map(|seed| 1.0 - used(seed, tolerance) / used(seed, 0.0)).fold(0.0, f64::max);
        std::println!("tolerance {tolerance}: at most {:.1} % less power", 100.0 * worst);
        assert!(worst <= most, "{tolerance}: {worst}");
    }
}
