//! Speed of the simulation: `cargo bench -p sim-host`.
//!
//! Throughput is in samples of simulated time; at 1 Msps, 10 Melem/s is ten simulated seconds a wall second, on one core.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use firmware::block::{Orders, Request, SenseBlock};
use firmware::controller::Controller;
use hal_mock::analog::Analog;
use sim_host::plant::Plant;
use sim_host::run::{Watch, run};
use sim_host::scene::Scene;
use sim_host::scene::load::load;
use sim_host::settings;

fn scene(name: &str, sets: &[&str]) -> Scene {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    load(name, &sets).unwrap_or_else(|error| panic!("{error}")).scene
}

/// The flagship, whole: controller, stack and contact live.
fn experiment_1(criterion: &mut Criterion) {
    let scene = scene("experiment-1", &[]);
    let mut group = criterion.benchmark_group("whole scene");
    group.throughput(Throughput::Elements((scene.duration_s * scene.sensors.sample_hz) as u64)).sample_size(10);
    group
        .bench_function("experiment-1", |bencher| bencher.iter(|| run(&scene, Watch::default()).map(|record| record.drive_hash)));
    group.finish();
}

/// The two halves by themselves, a block at a time.
fn halves(criterion: &mut Criterion) {
    let scene = scene("experiment-1", &[]);
    let config = settings::config(&scene);
    let samples = u64::from(config.block_samples);
    let orders = Orders { sequence: 1, attempt: 1, request: Request::Run, ..Orders::default() };
    let mut group = criterion.benchmark_group("one block");
    group.throughput(Throughput::Elements(samples));

    let mut controller = Controller::build(&config).expect("the flagship's settings");
    let mut plant = Plant::new(&scene);
    let (mut drive, mut sense) = (controller.silence(), SenseBlock::default());
    // Into the scan, where every part of the controller is at work.
    for _ in 0..1000 {
        plant.exchange(&drive, &mut sense);
        controller.process(&orders, &sense, &mut drive);
    }
    let playing = drive.clone();
    group.bench_function("controller", |bencher| bencher.iter(|| controller.process(&orders, &sense, &mut drive)));
    group.bench_function("plant with contact", |bencher| bencher.iter(|| plant.exchange(&playing, &mut sense)));
    let mut stack = Plant::new(&self::scene("lock", &[]));
    group.bench_function("plant, stack alone", |bencher| bencher.iter(|| stack.exchange(&playing, &mut sense)));
    group.finish();
}

criterion_group!(benches, experiment_1, halves);
criterion_main!(benches);
