//! Runs side by side are the runs that they are alone, bit for bit.

use std::cell::Cell;
use std::f64::consts::TAU;

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::table_4_1::{DRIVE_HZ, FORCE_N, MASS_KG, table_4_1};
use crate::{Sign, Waveform};

/// Every instruction set that this machine has.
fn levels() -> Vec<Level> {
    let widest = Level::new();
    let mut levels = vec![widest, Level::baseline()];
    #[cfg(target_arch = "x86_64")]
    levels.extend(widest.as_avx2().map(|simd| simd.level()));
    levels
}

/// All that a run has added up, as bits: also what is no number is to be the same.
fn bits(outcome: &Outcome) -> String {
    match outcome {
        Err(error) => error.to_string(),
        Ok(tally) => {
            let totals = &tally.totals;
            let states = [tally.first, tally.last].map(|state| [state.time_s, state.x_m, state.v_m_per_s, state.force_n]);
            let peaks = [tally.peak_velocity_m_per_s, tally.peak_displacement_m, tally.peak_force_ratio];
            let sums = [totals.friction_n_s, totals.friction_work_j, tally.time_s, tally.coulomb_n];
            let numbers = states.concat().into_iter().chain(peaks).chain(sums);
            let marks = tally.marks.get().iter().flat_map(|mark| [mark.0, mark.1]);
            // The sign of zero is none of the result.
            let hex: Vec<String> = numbers.chain(marks).map(|number| format!("{:x}", (number + 0.0).to_bits())).collect();
            format!("{} {} {}", tally.steps, tally.reversals, hex.join(" "))
        }
    }
}

fn assert_the_same(problems: &[Problem], settings: &[(u32, u32)]) {
    let problems: Vec<&Problem> = problems.iter().collect();
    for &(steps, order) in settings {
        let alone = problems.iter().map(|problem| bits(&super::super::run(problem, steps, order, Options::Plain, &mut |_| ())));
        let alone: Vec<String> = alone.collect();
        for level in levels() {
            let abreast = run_at(level, &problems, steps, order, &|| ());
            for (number, (abreast, alone)) in abreast.iter().zip(&alone).enumerate() {
                assert_eq!(bits(abreast), *alone, "{level:?}, order {order}, {steps} steps: {:?}", problems[number]);
            }
        }
    }
}

/// A number between two, evenly over its decades.
fn between(chance: &mut Xoshiro256PlusPlus, least: f64, most: f64) -> f64 {
    let part = (chance.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    least * (most / least).powf(part)
}

/// Contacts over ten decades of spring, friction and velocity ratio, three of damping and two of the natural frequency.
fn random(chance: &mut Xoshiro256PlusPlus, periods: f64, shape: Shape) -> Problem {
    let mut problem = table_4_1(0.0, periods);
    let inertia = MASS_KG * (TAU * DRIVE_HZ).powi(2);
    let stiffness_n_per_m = inertia * between(chance, 0.01, 3.0).powi(2);
    let damping_n_s_per_m = between(chance, 1e-4, 0.1) * 2.0 * (MASS_KG * stiffness_n_per_m).sqrt();
    problem.motion = Motion::Sdof { mass_kg: MASS_KG, stiffness_n_per_m, damping_n_s_per_m };
    problem.law = Law::Dahl { stiffness_n_per_m: inertia * between(chance, 1e-7, 1e2) };
    problem.coulomb_n = FORCE_N * between(chance, 1e-9, 0.5);
    problem.sliding_m_per_s = between(chance, 1e-4, 10.0) * problem.vibration_m_per_s();
    if chance.next_u64() & 3 == 0 {
        problem.sign = Sign::Literal;
    }
    if chance.next_u64() & 3 == 0 {
        problem.sliding_m_per_s *= -1.0;
    }
    problem.waveform = Waveform::new(shape, FORCE_N, DRIVE_HZ, problem.duration_s);
    problem
}

#[test]
fn random_contacts_are_the_same_bit_for_bit() {
    let mut chance = Xoshiro256PlusPlus::seed_from_u64(19);
    // An odd count: the last lanes are those of too few.
    let problems: Vec<Problem> = (0..75).map(|_| random(&mut chance, 12.0, Shape::Sine)).collect();
    assert_the_same(&problems, &[(4, 2), (6, 4), (7, 6), (24, 6)]);
}

#[test]
fn other_waveforms_and_windows_within_a_period_are_the_same() {
    let mut chance = Xoshiro256PlusPlus::seed_from_u64(20);
    for shape in [Shape::Square, Shape::Sawtooth, Shape::Triangle, Shape::Still] {
        let mut problems: Vec<Problem> = (0..9).map(|_| random(&mut chance, 6.0, shape)).collect();
        for problem in &mut problems {
            problem.window_s = (1.3 / DRIVE_HZ, 5.7 / DRIVE_HZ);
        }
        assert_the_same(&problems, &[(6, 4), (12, 6)]);
    }
}

/// Beside one with two reversals a period: one that never reverses, one of rigid bristles, one that is stiff in time, one that runs away.
#[test]
fn each_lane_lives_its_own_life() {
    let mut problems = vec![table_4_1(0.5, 40.0); 5];
    problems[1].sliding_m_per_s *= 6.0;
    problems[2].law = Law::Dahl { stiffness_n_per_m: 1e12 };
    problems[3].law = Law::Dahl { stiffness_n_per_m: 5e10 };
    problems[3].coulomb_n = 100.0;
    problems[4].motion = Motion::Sdof { mass_kg: MASS_KG, stiffness_n_per_m: 133e6, damping_n_s_per_m: -1e12 };
    assert_the_same(&problems, &[(4, 2), (8, 6)]);
    let outcomes = run_abreast(&problems.iter().collect::<Vec<_>>(), 8, 6, &|| ());
    let reversals = |number: usize| outcomes[number].as_ref().map_or(0, |tally| tally.reversals);
    assert!(reversals(0) > 70 && reversals(1) == 0 && outcomes[4].is_err(), "{outcomes:?}");
}

/// What lanes cannot do, or not side by side, is run one by one.
#[test]
fn what_is_not_alike_is_run_one_by_one() {
    let mut problems = vec![table_4_1(0.5, 10.0); 6];
    problems[1].duration_s *= 0.5;
    problems[2].load_steps = vec![(1e-4, 0.03)];
    problems[3].motion = Motion::Kinematic;
    problems[4].law = Law::Coulomb;
    problems[5].waveform = Waveform::new(Shape::Random { hold_s: 1e-5, seed: 1 }, FORCE_N, DRIVE_HZ, problems[5].duration_s);
    assert_the_same(&problems, &[(8, 4)]);
    assert_the_same(&problems[..1], &[(8, 4)]);
    assert_the_same(&problems[..2], &[(8, 4), (8, 5)]);
}

#[test]
fn it_pauses_on_the_way() {
    let problems = vec![table_4_1(0.5, 2000.0); 8];
    let pauses = Cell::new(0);
    run_abreast(&problems.iter().collect::<Vec<_>>(), 16, 2, &|| pauses.set(pauses.get() + 1));
    assert!(pauses.get() >= 3, "{pauses:?}");
}
