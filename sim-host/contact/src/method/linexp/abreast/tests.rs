//! Runs side by side are the runs that they are alone, bit for bit.

use super::*;
use crate::table_4_1::table_4_1;

#[test]
fn a_map_is_the_same_bit_for_bit() {
    let problems: Vec<Problem> = (0..40)
        .map(|i| {
            let mut problem = table_4_1(0.05 + 0.03 * f64::from(i), 50.0);
            problem.law = Law::Dahl { stiffness_n_per_m: 1e4 * 1e3f64.powf(f64::from(i % 7) / 6.0) };
            problem
        })
        .collect();
    let problems: Vec<&Problem> = problems.iter().collect();
    for (steps, order) in [(4, 2), (6, 4), (12, 6), (32, 6)] {
        let abreast = run_abreast(&problems, steps, order, &|| ());
        for (problem, abreast) in problems.iter().zip(abreast) {
            let alone = super::super::run(problem, steps, order, Options::Plain, &mut |_| ());
            assert_eq!(abreast, alone);
        }
    }
}
