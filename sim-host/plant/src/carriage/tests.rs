use super::*;

const STEP_S: f64 = 2e-6;

fn contact(mu: f64, static_mu: f64) -> scene::Lugre {
    scene::Lugre {
        mu,
        static_mu,
        normal_n: None,
        stiffness_n_per_m: 25e6,
        stribeck_m_per_s: 1e-4,
        sigma1: 0.0,
        sigma2: 0.0,
        sign: None,
    }
}

fn rail() -> scene::Carriage {
    scene::Carriage {
        mass_kg: 20.0,
        normal_n: 200.0,
        force_n: 0.0,
        stiffness_n_per_m: 1e6,
        damping_n_s_per_m: 0.0,
        pull_m_per_s: 1e-4,
        pull_at_s: 0.0,
    }
}

/// Stick-slip in the limit of a slow pull and a stiff contact (Den Hartog 1931). The carriage
/// breaks away at `mu_s N`, jumps by `2 (Fs - Fk) / k`, and jumps again after
/// `2 (Fs - Fk) / (k V)`.
/// Stribeck's velocity is ten times the pull's and a tenth of the slip's. The bristles are damped
/// so that the carriage stops after a slip. They are so stiff that slow sliding is unstable,
/// `|G'| > k Fs / (Kt V)`: a limit that falls with the speed acts `Fs / (Kt V)` late.
#[test]
fn stick_slip_has_its_force_jump_and_period() {
    let (stiffness, pull) = (1e7, 4e-5);
    let stiff = scene::Lugre { stiffness_n_per_m: 2e10, stribeck_m_per_s: 4e-4, sigma1: 4e4, ..contact(0.25, 0.35) };
    let light = scene::Carriage { mass_kg: 2.0, stiffness_n_per_m: stiffness, pull_m_per_s: pull, ..rail() };
    let mut carriage = Carriage::new(&stiff, &light);
    let (mut most_n, mut least_n, mut jumps) = (0.0f64, f64::INFINITY, Vec::new());
    let mut last = 0.0;
    for n in 0..600_000 {
        carriage.slide(0.0, 0.0, 0.0, STEP_S);
        let pull_n = carriage.truth().pull_n;
        most_n = most_n.max(pull_n);
        if carriage.speed_m_per_s() > 2e-3 && last <= 2e-3 {
            jumps.push(f64::from(n) * STEP_S);
        }
        if !jumps.is_empty() {
            least_n = least_n.min(pull_n);
        }
        last = carriage.speed_m_per_s();
    }
    let period_s = (jumps[jumps.len() - 1] - jumps[0]) / (jumps.len() - 1) as f64;
    println!("breaks away at {most_n} N, falls to {least_n} N, every {period_s} s ({} jumps)", jumps.len());
    assert!((most_n / 70.0 - 1.0).abs() < 0.002, "{most_n}");
    // From 70 N past 50 N to 30 N, apart from the distance over which the static friction is lost.
    assert!((30.0..30.5).contains(&least_n), "{least_n}");
    assert!(jumps.len() > 7 && (period_s / (40.0 / (stiffness * pull)) - 1.0).abs() < 0.025, "{period_s}");
}

/// A constant force below `mu_s N` is held. The contact yields by the presliding
/// `(Fs / Kt) ln(1 / (1 - P / Fs))`, or at most twice that since the load is a step, and then
/// stops.
#[test]
fn a_force_below_static_friction_is_held() {
    let damped = scene::Lugre { sigma1: 14e3, ..contact(0.25, 0.35) };
    let loaded = scene::Carriage { force_n: 30.0, stiffness_n_per_m: 0.0, pull_m_per_s: 0.0, ..rail() };
    let mut carriage = Carriage::new(&damped, &loaded);
    for _ in 0..50_000 {
        carriage.slide(0.0, 0.0, 0.0, STEP_S);
    }
    let early_m = carriage.position_m();
    for _ in 0..500_000 {
        carriage.slide(0.0, 0.0, 0.0, STEP_S);
    }
    let presliding_m = 70.0 / 25e6 * -(1.0f64 - 30.0 / 70.0).ln();
    println!("{early_m} m, {} m for {presliding_m} m", carriage.position_m());
    assert!((1.0..2.0).contains(&(carriage.position_m() / presliding_m)), "{}", carriage.position_m());
    assert!((carriage.position_m() - early_m).abs() < 1e-9, "{early_m}, then {}", carriage.position_m());
}

/// Without friction the carriage is an oscillator: tests the period, and the amplitude after a
/// hundred periods.
#[test]
fn without_friction_it_oscillates() {
    let mut carriage = Carriage::new(&contact(0.0, 0.0), &rail());
    let omega = (1e6f64 / 20.0).sqrt();
    let periods = 100.0;
    let steps = (periods * std::f64::consts::TAU / omega / STEP_S).round() as u32;
    let mut farthest = 0.0f64;
    for _ in 0..steps {
        carriage.slide(0.0, 0.0, 0.0, STEP_S);
        let lag_m = carriage.truth().end_m - carriage.position_m();
        farthest = farthest.max(lag_m);
    }
    // y - x = (V / w) sin(w t): zero after whole periods, with the speed of the spring's end.
    assert!((farthest * omega / 1e-4 - 1.0).abs() < 1e-3, "{farthest}");
    assert!(carriage.speed_m_per_s().abs() < 1e-3 * 1e-4, "{}", carriage.speed_m_per_s());
}

/// Under a vibration `Vv cos(w t)`, a constant force P < mu N moves the carriage at the speed at
/// which Coulomb's mean friction equals P: `V = Vv sin(pi P / (2 mu N))`.
#[test]
fn vibration_gives_the_speed_of_coulombs_law() {
    const TAU: f64 = std::f64::consts::TAU;
    let heavy = scene::Carriage { force_n: 25.0, stiffness_n_per_m: 0.0, pull_m_per_s: 0.0, mass_kg: 0.5, ..rail() };
    let stiff = scene::Lugre { stiffness_n_per_m: 2e10, ..contact(0.25, 0.35) };
    let mut carriage = Carriage::new(&stiff, &heavy);
    let (vibration, period, steps) = (0.175, 25e-6, 1000u32);
    let step = period / f64::from(steps);
    let velocity = |phase: f64| vibration * libm::cos(TAU * phase);
    let place = |phase: f64| vibration * period / TAU * libm::sin(TAU * phase);
    for _ in 0..4000 {
        for n in 0..steps {
            let (a, b) = (f64::from(n) / f64::from(steps), f64::from(n + 1) / f64::from(steps));
            carriage.slide(velocity(a), velocity(b), place(b) - place(a), step);
        }
    }
    let expected = vibration * (std::f64::consts::FRAC_PI_2 * 25.0 / 50.0).sin();
    println!("{} m/s for {expected}", carriage.speed_m_per_s());
    assert!((carriage.speed_m_per_s() / expected - 1.0).abs() < 0.002, "{} for {expected}", carriage.speed_m_per_s());
}
