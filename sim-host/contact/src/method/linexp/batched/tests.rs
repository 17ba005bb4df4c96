//! Batched runs equal single runs, bit for bit.

use std::cell::Cell;
use std::f64::consts::TAU;

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::table_4_1::{DRIVE_HZ, FORCE_N, MASS_KG, table_4_1};
use crate::{Sign, Waveform};

/// Returns every instruction set of this machine.
fn levels() -> Vec<Level> {
    let widest = Level::new();
    let mut levels = vec![widest, Level::baseline()];
    #[cfg(target_arch = "x86_64")]
    levels.extend(widest.as_avx2().map(|simd| simd.level()));
    levels
}

/// Returns all results of a run as bits, so that NaNs are compared, too.
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
            // The sign of zero is not part of the result.
            let hex: Vec<String> = numbers.chain(marks).map(|number| format!("{:x}", (number + 0.0).to_bits())).collect();
            format!("{} {} {}", tally.steps, tally.reversals, hex.join(" "))
        }
    }
}

fn assert_batched_equals_single(problems: &[Problem], settings: &[(u32, u32)]) {
    let problems: Vec<&Problem> = problems.iter().collect();
    for &(steps, order) in settings {
        let alone = problems.iter().map(|problem| bits(&super::super::run(problem, steps, order, Options::Plain, &mut |_| ())));
        let alone: Vec<String> = alone.collect();
        for level in levels() {
            let batched = run_at(level, &problems, steps, order, &|| ());
            for (number, (batched, alone)) in batched.iter().zip(&alone).enumerate() {
                assert_eq!(bits(batched), *alone, "{level:?}, order {order}, {steps} steps: {:?}", problems[number]);
            }
        }
    }
}

/// Returns a random number between two, log-uniformly distributed.
fn between(chance: &mut Xoshiro256PlusPlus, least: f64, most: f64) -> f64 {
    let part = (chance.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    least * (most / least).powf(part)
}

/// Returns a random contact, over about ten decades of stiffness and friction, five of the velocity
/// ratio, three of damping and two of the natural frequency.
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
    // An odd number, so that the last batch is not full.
    let problems: Vec<Problem> = (0..75).map(|_| random(&mut chance, 12.0, Shape::Sine)).collect();
    assert_batched_equals_single(&problems, &[(4, 2), (6, 4), (7, 6), (24, 6)]);
}

#[test]
fn other_waveforms_and_windows_within_a_period_are_the_same() {
    let mut chance = Xoshiro256PlusPlus::seed_from_u64(20);
    for shape in [Shape::Square, Shape::Sawtooth, Shape::Triangle, Shape::Still] {
        let mut problems: Vec<Problem> = (0..9).map(|_| random(&mut chance, 6.0, shape)).collect();
        for problem in &mut problems {
            problem.window_s = (1.3 / DRIVE_HZ, 5.7 / DRIVE_HZ);
        }
        assert_batched_equals_single(&problems, &[(6, 4), (12, 6)]);
    }
}

/// One contact with two reversals per period, batched with one that never reverses, one with rigid
/// bristles, one that is stiff in time, and one that diverges.
#[test]
fn lanes_are_independent() {
    let mut problems = vec![table_4_1(0.5, 40.0); 5];
    problems[1].sliding_m_per_s *= 6.0;
    problems[2].law = Law::Dahl { stiffness_n_per_m: 1e12 };
    problems[3].law = Law::Dahl { stiffness_n_per_m: 5e10 };
    problems[3].coulomb_n = 100.0;
    problems[4].motion = Motion::Sdof { mass_kg: MASS_KG, stiffness_n_per_m: 133e6, damping_n_s_per_m: -1e12 };
    assert_batched_equals_single(&problems, &[(4, 2), (8, 6)]);
    let outcomes = run_batched(&problems.iter().collect::<Vec<_>>(), 8, 6, &|| ());
    let reversals = |number: usize| outcomes[number].as_ref().map_or(0, |tally| tally.reversals);
    assert!(reversals(0) > 70 && reversals(1) == 0 && outcomes[4].is_err(), "{outcomes:?}");
}

/// Problems that cannot be batched, or not with each other, run one by one.
#[test]
fn unequal_problems_run_one_by_one() {
    let mut problems = vec![table_4_1(0.5, 10.0); 6];
    problems[1].duration_s *= 0.5;
    problems[2].load_steps = vec![(1e-4, 0.03)];
    problems[3].motion = Motion::Kinematic;
    problems[4].law = Law::Coulomb;
    problems[5].waveform = Waveform::new(Shape::Random { hold_s: 1e-5, seed: 1 }, FORCE_N, DRIVE_HZ, problems[5].duration_s);
    assert_batched_equals_single(&problems, &[(8, 4)]);
    assert_batched_equals_single(&problems[..1], &[(8, 4)]);
    assert_batched_equals_single(&problems[..2], &[(8, 4), (8, 5)]);
}

#[test]
fn runs_call_pause() {
    let problems = vec![table_4_1(0.5, 2000.0); 8];
    let pauses = Cell::new(0);
    run_batched(&problems.iter().collect::<Vec<_>>(), 16, 2, &|| pauses.set(pauses.get() + 1));
    assert!(pauses.get() >= 3, "{pauses:?}");
}
