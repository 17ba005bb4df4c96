//! Speed of the contact studies: `cargo bench -p sonoglide-contact`.

use std::hint::black_box;
use std::time::Instant;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use sonoglide_contact::method::{midpoint, rk4, rk4_events};
use sonoglide_contact::table_4_1::{PERIODS, standard, table_4_1};
use sonoglide_contact::{Law, Problem, closed, coulomb, linexp};

/// kappa of the thesis's contact (Table 4.1).
const THESIS: f64 = 0.404_517;

/// Number of velocity ratios.
const POINTS: u32 = 1024;

fn points(kappa: f64) -> Vec<(f64, f64)> {
    (0..POINTS).map(|i| ((f64::from(i) + 0.5) / f64::from(POINTS), kappa)).collect()
}

fn scalar(points: &[(f64, f64)]) -> Vec<f64> {
    points.iter().map(|&(xi, kappa)| closed::friction_ratio(xi, kappa)).collect()
}

fn closed_form(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("closed form, a point");
    group.throughput(Throughput::Elements(u64::from(POINTS))).sample_size(20);
    for kappa in [THESIS, 1e4] {
        let points = points(kappa);
        group.bench_function(format!("friction, kappa {kappa}"), |bencher| bencher.iter(|| scalar(&points)));
    }
    group.finish();
}

/// The thesis's oscillator with Coulomb friction, 200 periods.
fn located_events(criterion: &mut Criterion) {
    let problem = Problem { law: Law::Coulomb, ..standard() };
    let mut group = criterion.benchmark_group("Coulomb with located reversals, a period");
    group.throughput(Throughput::Elements(PERIODS as u64)).sample_size(20);
    group.bench_function("table 4.1, 16 steps", |bencher| bencher.iter(|| coulomb::run(&problem, 16, &mut |_| ())));
    group.finish();
}

/// One step of the oscillator with Dahl friction, with the methods of a fixed number of steps per
/// period, and with the midpoint rule.
fn steps(criterion: &mut Criterion) {
    const STEPS: u32 = 1000;
    let problem = table_4_1(0.5, 20.0);
    let mut group = criterion.benchmark_group("1000 steps a period, a step");
    group.throughput(Throughput::Elements(u64::from(20 * STEPS))).sample_size(20);
    group.bench_function("rk4", |bencher| bencher.iter(|| rk4::run_plain(&problem, STEPS, &mut |_| ())));
    group.bench_function("rk4 with events", |bencher| bencher.iter(|| rk4_events::run_plain(&problem, STEPS, &mut |_| ())));
    group.bench_function("midpoint", |bencher| bencher.iter(|| midpoint::run(&problem, STEPS, &mut |_| ())));
    group.finish();
}

/// Contacts with a mass, batched: neighbours in the velocity ratio, and contacts that reverse at
/// different times.
fn batched(criterion: &mut Criterion) {
    const COUNT: u32 = 8;
    let mut group = criterion.benchmark_group("linexp, eight contacts, a period and contact");
    group.throughput(Throughput::Elements(u64::from(COUNT) * PERIODS as u64)).sample_size(20);
    println!("order/steps, Kt N/m         alone  neighbours  gain    far apart  gain   (ns a period and contact, one core)");
    for (order, steps, stiffness_n_per_m) in [(2, 4, 5.6e4), (4, 6, 5.6e4), (6, 12, 1e6), (6, 32, 1e7)] {
        let contacts = |apart: f64| -> Vec<Problem> {
            let contact = |i| table_4_1(0.3 + apart * f64::from(i), PERIODS);
            (0..COUNT).map(contact).map(|problem| Problem { law: Law::Dahl { stiffness_n_per_m }, ..problem }).collect()
        };
        let cost = |problems: &[Problem], lanes: bool| {
            let problems: Vec<&Problem> = problems.iter().collect();
            let alone = |problem: &&Problem| linexp::run(problem, steps, order, linexp::Options::Plain, &mut |_| ());
            let run = |_| {
                let began = Instant::now();
                if lanes {
                    black_box(linexp::run_batched(black_box(&problems), steps, order, &|| ()));
                } else {
                    black_box(problems.iter().map(alone).collect::<Vec<_>>());
                }
                began.elapsed().as_secs_f64() * 1e9 / (f64::from(COUNT) * PERIODS)
            };
            (0..60).map(run).fold(f64::INFINITY, f64::min)
        };
        let (near, far) = (contacts(0.0012), contacts(0.1));
        let (alone, near_ns) = (cost(&near, false), cost(&near, true));
        let (far_alone, far_ns) = (cost(&far, false), cost(&far, true));
        println!(
            "{order}/{steps:<3} {stiffness_n_per_m:9.1e} {alone:16.0} {near_ns:11.0} {:5.2} {far_ns:12.0} {:5.2}",
            alone / near_ns,
            far_alone / far_ns
        );
        let name = format!("order {order}, {steps} steps, Kt {stiffness_n_per_m:.1e} N/m");
        let near: Vec<&Problem> = near.iter().collect();
        group.bench_function(name, |bencher| bencher.iter(|| linexp::run_batched(&near, steps, order, &|| ())));
    }
    group.finish();
}

criterion_group!(benches, closed_form, located_events, steps, batched);
criterion_main!(benches);
