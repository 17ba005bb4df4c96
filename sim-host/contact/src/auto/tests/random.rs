//! Random contacts over wide ranges of their parameters, log-uniform, against a far finer run of another method.

use rand_core::{Rng as _, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::rk4_events;
use crate::table_4_1::{DRIVE_HZ, FORCE_N, MASS_KG};

/// A generator of contacts.
struct Contacts(Xoshiro256PlusPlus);

impl Contacts {
    fn from(&mut self, least: f64, most: f64) -> f64 {
        let part = (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        least * (most / least).powf(part)
    }

    /// Contact spring over m w^2, friction over force, velocity ratio, natural over drive frequency, damping ratio or none.
    fn next(&mut self, periods: f64, lugre: bool) -> Problem {
        let mut problem = table_4_1(0.5, periods);
        let inertia = MASS_KG * (std::f64::consts::TAU * DRIVE_HZ).powi(2);
        let kt = inertia * self.from(1e-6, 10.0);
        let (friction, ratio) = (self.from(1e-6, 0.5), self.from(1e-3, 3.0));
        let stiffness_n_per_m = inertia * self.from(0.05, 5.0).powi(2);
        let damping = self.from(1e-8, 0.3);
        let damping = if damping < 1e-4 { 0.0 } else { damping };
        let damping_n_s_per_m = 2.0 * damping * (MASS_KG * stiffness_n_per_m).sqrt();
        problem.motion = Motion::Sdof { mass_kg: MASS_KG, stiffness_n_per_m, damping_n_s_per_m };
        let vibration = problem.vibration_m_per_s();
        let (stribeck, sigma1) = (self.from(1e-2, 3.0), self.from(1e-5, 10.0));
        problem.law = if lugre {
            Law::Lugre {
                stiffness_n_per_m: kt,
                static_ratio: self.from(1.0, 2.0),
                stribeck_m_per_s: stribeck * vibration,
                sigma1: if sigma1 < 1e-3 { 0.0 } else { sigma1 * (inertia * MASS_KG).sqrt() },
                sigma2: 0.0,
            }
        } else {
            Law::Dahl { stiffness_n_per_m: kt }
        };
        (problem.coulomb_n, problem.sliding_m_per_s) = (friction * FORCE_N, ratio * vibration);
        problem
    }
}

/// Every contact within the tolerance or flagged, at most one in a hundred flagged, none estimated low by more than ten and at most one
/// in a hundred by more than three. Beside round-off of the reference nothing is said.
fn keeps_its_word(contacts: &[(Problem, f64)], tolerances: &[f64], round_off: f64) {
    for &tolerance in tolerances {
        let (mut flagged, mut low) = (0, 0);
        for (problem, truth) in contacts {
            let numerics = Numerics { tolerance, energies: false, ..Numerics::default() };
            let solution = solve_unwatched(problem, &numerics, &|| ()).unwrap();
            let error = (solution.ratios.friction - truth).abs() - round_off;
            assert!(error <= tolerance || !solution.tolerance_met, "{tolerance:e}: off by {error:e}, {solution:?}, {problem:?}");
            let estimate = solution.error_estimate.unwrap();
            assert!(error <= 10.0 * estimate, "{tolerance:e}: off by {error:e}, {solution:?}, {problem:?}");
            flagged += usize::from(!solution.tolerance_met);
            low += usize::from(error > 3.0 * estimate);
        }
        println!("{tolerance:e}: {flagged} flagged, {low} low of {}", contacts.len());
        assert!(flagged <= contacts.len().div_ceil(100) && low <= contacts.len().div_ceil(100));
    }
}

#[test]
fn random_dahl_contacts_meet_their_tolerance_or_say_so() {
    let mut generator = Contacts(Xoshiro256PlusPlus::seed_from_u64(1));
    let mut contacts = Vec::new();
    for number in 0..120 {
        let problem = generator.next(if number % 4 == 0 { 300.0 } else { 60.0 }, false);
        let truth = if problem.kappa() < 30.0 {
            taylor::run(&problem, 32, 24, &mut |_| ()).unwrap()
        } else {
            linexp::run(&problem, 1000, 4, linexp::Options::Plain, &mut |_| ()).unwrap()
        };
        contacts.push((problem.clone(), Ratios::of(&problem, &truth).friction));
    }
    keeps_its_word(&contacts, &[1e-3, 1e-5, 1e-7, 1e-8], 1e-10);
}

#[test]
fn random_lugre_contacts_meet_their_tolerance_or_say_so() {
    let mut generator = Contacts(Xoshiro256PlusPlus::seed_from_u64(2));
    let mut contacts = Vec::new();
    while contacts.len() < 20 {
        let problem = generator.next(20.0, true);
        let by = |steps| rk4_events::run_plain(&problem, steps, &mut |_| ()).map(|tally| Ratios::of(&problem, &tally).friction);
        if stable_steps(&problem) > 1000.0 {
            continue;
        }
        let (truth, half) = (by(12_000).unwrap(), by(6_000).unwrap());
        assert!((truth - half).abs() < 1e-8, "{problem:?}");
        contacts.push((problem, truth));
    }
    keeps_its_word(&contacts, &[1e-4, 1e-6], 1e-8);
}
