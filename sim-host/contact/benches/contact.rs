//! Speed of the contact studies: `cargo bench -p sonoglide-contact`.
//!
//! The gain of the lanes over the scalar loop is measured on the same points in the same run, and printed at the end.

use std::hint::black_box;
use std::time::Instant;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use sonoglide_contact::method::{midpoint, rk4, rk4_events};
use sonoglide_contact::table_4_1::{PERIODS, standard, table_4_1};
use sonoglide_contact::{Law, Problem, closed, coulomb, lanes};

/// kappa of the thesis's contact (table 4.1).
const THESIS: f64 = 0.404_517;

/// Points along the velocity ratio.
const POINTS: u32 = 1024;

fn points(kappa: f64) -> Vec<(f64, f64)> {
    (0..POINTS).map(|i| ((f64::from(i) + 0.5) / f64::from(POINTS), kappa)).collect()
}

fn scalar(points: &[(f64, f64)]) -> Vec<f64> {
    points.iter().map(|&(xi, kappa)| closed::friction_ratio(xi, kappa)).collect()
}

fn scalar_power(points: &[(f64, f64)]) -> Vec<f64> {
    points.iter().map(|&(xi, kappa)| closed::power_ratio(xi, kappa).unwrap_or(f64::NAN)).collect()
}

/// Best of several, ns a point.
fn best_ns(points: &[(f64, f64)], of: fn(&[(f64, f64)]) -> Vec<f64>) -> f64 {
    let run = |_| {
        let began = Instant::now();
        black_box(of(black_box(points)));
        began.elapsed().as_secs_f64() * 1e9 / points.len() as f64
    };
    (0..200).map(run).fold(f64::INFINITY, f64::min)
}

fn closed_form(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("closed form, a point");
    group.throughput(Throughput::Elements(u64::from(POINTS))).sample_size(20);
    for kappa in [THESIS, 1e4] {
        let points = points(kappa);
        group.bench_function(format!("friction, kappa {kappa}"), |bencher| bencher.iter(|| scalar(&points)));
        group.bench_function(format!("friction in lanes, kappa {kappa}"), |bencher| {
            bencher.iter(|| lanes::friction_ratios(&points))
        });
    }
    group.finish();
    println!("kappa      friction: scalar   lanes  gain      power: scalar   lanes  gain   (ns a point, one core)");
    for kappa in [0.01, THESIS, 4.0, 40.0, 1e4] {
        let points = points(kappa);
        let friction = [best_ns(&points, scalar), best_ns(&points, lanes::friction_ratios)];
        let power = [best_ns(&points, scalar_power), best_ns(&points, lanes::power_ratios)];
        println!(
            "{kappa:8.3}   {:16.0} {:7.0} {:5.2}   {:16.0} {:7.0} {:5.2}",
            friction[0],
            friction[1],
            friction[0] / friction[1],
            power[0],
            power[1],
            power[0] / power[1],
        );
    }
}

/// The thesis's oscillator with Coulomb friction, 200 periods.
fn located_events(criterion: &mut Criterion) {
    let problem = Problem { law: Law::Coulomb, ..standard() };
    let mut group = criterion.benchmark_group("Coulomb with located reversals, a period");
    group.throughput(Throughput::Elements(PERIODS as u64)).sample_size(20);
    group.bench_function("table 4.1, 16 steps", |bencher| bencher.iter(|| coulomb::run(&problem, 16, &mut |_| ())));
    group.finish();
}

/// A step of the oscillator with Dahl friction, of the methods with a fixed number of steps a period, and of the midpoint rule on a Stribeck curve.
fn steps(criterion: &mut Criterion) {
    const STEPS: u32 = 1000;
    let problem = table_4_1(0.5, 20.0);
    let mut group = criterion.benchmark_group("1000 steps a period, a step");
    group.throughput(Throughput::Elements(u64::from(20 * STEPS))).sample_size(20);
    group.bench_function("rk4", |bencher| bencher.iter(|| rk4::run_plain(&problem, STEPS, &mut |_| ())));
    group.bench_function("rk4, tabulated force", |bencher| bencher.iter(|| rk4::run_tabulated(&problem, STEPS, &mut |_| ())));
    group.bench_function("rk4 with events", |bencher| bencher.iter(|| rk4_events::run_plain(&problem, STEPS, &mut |_| ())));
    group.bench_function("midpoint", |bencher| bencher.iter(|| midpoint::run(&problem, STEPS, &mut |_| ())));
    group.finish();
}

criterion_group!(benches, closed_form, located_events, steps);
criterion_main!(benches);
