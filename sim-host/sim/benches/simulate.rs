//! Speed of the simulation: `cargo bench -p sonoglide-sim`.
//!
//! Throughput is in samples of simulated time on one core. At 1 Msps, 10 Melem/s is ten simulated
//! seconds per second of wall time.

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use firmware::controller::Controller;
use firmware::seam::block::{DriveBlock, Gate, Orders, Request, SenseBlock};
use firmware::seam::mode::Mode;
use firmware::seam::units::Hertz;
use hal_mock::analog::Analog;
use hal_mock::block_clock::BlockClock;
use plant::Plant;
use scene::Scene;
use scene::load::load;
use scene::settings;
use sonoglide_sim::run::{Watch, run};
use sonoglide_sim::study::{self, Options};

fn scene(name: &str, sets: &[&str]) -> Scene {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    load(name, &sets).unwrap_or_else(|error| panic!("{error}")).scene
}

/// Runs the complete experiment-1: controller, stack and contact.
fn experiment_1(criterion: &mut Criterion) {
    let scene = scene("experiment-1", &[]);
    let scene = scene.driven().expect("a driven scene");
    let mut group = criterion.benchmark_group("whole scene");
    group.throughput(Throughput::Elements((scene.duration_s * scene.sensors.sample_hz) as u64)).sample_size(10);
    group
        .bench_function("experiment-1", |bencher| bencher.iter(|| run(&scene, Watch::default()).map(|record| record.drive_hash)));
    group.finish();
}

/// Runs cold starts on one thread: one alone, and several batched as in a Monte Carlo, with their
/// scenes and metrics.
fn cold_starts(criterion: &mut Criterion) {
    const RUNS: u32 = 16;
    let sets = [format!("runs={RUNS}")];
    let loaded = load("lock-cold", &sets).unwrap_or_else(|error| panic!("{error}"));
    let scene = loaded.scene.driven().expect("a driven scene");
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let samples = (scene.duration_s * scene.sensors.sample_hz) as u64;
    let mut group = criterion.benchmark_group("cold starts");
    group.throughput(Throughput::Elements(samples)).sample_size(10);
    group.bench_function("alone", |bencher| bencher.iter(|| run(&scene, Watch::default()).map(|record| record.drive_hash)));
    group.throughput(Throughput::Elements(u64::from(RUNS) * samples));
    group.bench_function("side by side", |bencher| {
        bencher.iter(|| one_thread.install(|| study::run(&loaded, Options::default()).map(|study| study.rest.metrics)));
    });
    group.finish();
}

/// Runs a complete crash with one coefficient for the wrap, and with the coefficient as a function
/// of the position along it; each run builds the table of its ring.
fn crashes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("crash");
    group.sample_size(20);
    for (name, sets) in [("dring-crash", &[][..]), ("dring-wrap", &[]), ("dring-wrap", &["rig.dring.ring_normal_part=fitted"])] {
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        let loaded = load(name, &sets).unwrap_or_else(|error| panic!("{error}"));
        let name = [name, if sets.is_empty() { "" } else { " fitted" }].concat();
        group.bench_function(name, |bencher| {
            bencher.iter(|| study::run(&loaded, Options::default()).map(|study| study.rest.metrics));
        });
    }
    group.finish();
}

/// Number of blocks replayed per iteration.
const BLOCKS: usize = 500;

/// Controller, plant, and the signals between them over [`BLOCKS`] blocks with the drive ON and
/// tracked.
struct Recorded {
    controller: Controller,
    plant: Plant,
    sensed: Vec<SenseBlock>,
    played: Vec<DriveBlock>,
}

const ORDERS: Orders = Orders {
    sequence: 1,
    attempt: 1,
    request: Request::Run,
    gate: Gate::On,
    amplitude: None,
    detune: Hertz(0.0),
    quadrature: None,
    friction: None,
    torso_kg: None,
    emergency_stop: false,
    host_lost: false,
    clear_fault: false,
};

fn recorded(scene: &Scene) -> Recorded {
    let scene = &scene.driven().expect("a driven scene");
    let mut controller = Controller::build(&settings::config(scene)).expect("a built-in scene's settings");
    let mut clock = BlockClock::new(Plant::new(scene), &controller.silence());
    let drive_into = |controller: &mut Controller, clock: &mut BlockClock<Plant>| {
        clock.tick(|sense, drive| (controller.process(&ORDERS, sense, drive).mode, sense.clone(), drive.clone()))
    };
    while drive_into(&mut controller, &mut clock).0 != Mode::Run {}
    for _ in 0..1000 {
        drive_into(&mut controller, &mut clock);
    }
    let (start, plant) = (controller.clone(), clock.analog.clone());
    let (sensed, played) =
        (0..BLOCKS).map(|_| drive_into(&mut controller, &mut clock)).map(|(_, sense, drive)| (sense, drive)).unzip();
    Recorded { controller: start, plant, sensed, played }
}

/// Replays the controller and the plant separately.
fn halves(criterion: &mut Criterion) {
    let with_contact = recorded(&scene("experiment-1", &[]));
    let alone = recorded(&scene("lock", &[]));
    let mut group = criterion.benchmark_group("replayed");
    let samples = BLOCKS * with_contact.sensed[0].v.len();
    group.throughput(Throughput::Elements(samples as u64));
    group.bench_function("controller", |bencher| {
        let mut drive = with_contact.controller.silence();
        bencher.iter_batched_ref(
            || with_contact.controller.clone(),
            |controller| with_contact.sensed.iter().map(|sense| controller.process(&ORDERS, sense, &mut drive).block).last(),
            BatchSize::SmallInput,
        );
    });
    for (name, recorded) in [("plant with contact", &with_contact), ("plant, stack alone", &alone)] {
        group.bench_function(name, |bencher| {
            let mut sense = SenseBlock::default();
            bencher.iter_batched_ref(
                || recorded.plant.clone(),
                |plant| recorded.played.iter().for_each(|drive| plant.exchange(drive, &mut sense)),
                BatchSize::SmallInput,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, experiment_1, cold_starts, crashes, halves);
criterion_main!(benches);
