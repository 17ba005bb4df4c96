//! Overhead of a sweep over its solves: `cargo bench -p sonoglide-sim --bench sweeps`.
//!
//! ```text
//! solves   only the problems or runs of the points, created and solved in batches as in the sweep
//! rows     with scenes, metrics and, for several runs, statistics: the result of `Sweep::rows`
//! whole    with the parts, tables, figures and page: the work of `sim-host sweep`
//! ```
//!
//! Times are processor times of one thread, each the minimum of several rounds.

use std::fs;
use std::hint::black_box;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use contact::solve_many;
use scene::load::{Loaded, load};
use scene::problem;
use sonoglide_sim::output::Presentation;
use sonoglide_sim::output::sweep::{Shard, SweepFolder, join};
use sonoglide_sim::run::{LANES, run_batch};
use sonoglide_sim::study::monte_carlo::draw::Draws;
use sonoglide_sim::study::sweep::Sweep;
use sonoglide_sim::study::sweep::design::Design;

/// Number of rounds, of which the minimum counts.
const ROUNDS: u32 = 3;
/// Number of contacts in a batch.
const BATCH: usize = 512;

/// Returns the processor time of this thread, s, or the wall time if the system does not report it.
fn cpu_s(began: Instant) -> f64 {
    let text = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let ns: Option<f64> = text.split(' ').next().and_then(|ns| ns.parse().ok());
    ns.map_or_else(|| began.elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}

fn timed<T>(work: impl FnOnce() -> T) -> f64 {
    let began = Instant::now();
    let before = cpu_s(began);
    black_box(work());
    cpu_s(began) - before
}

/// Computes the rows of all points.
fn rows(sweep: &Sweep) {
    black_box(sweep.rows(0..sweep.design.count(), &AtomicBool::new(false), &|| ()).expect("rows").expect("not stopped"));
}

/// Runs a complete sweep in its own folder.
fn whole(sweep: &Sweep) {
    let dir = std::env::temp_dir().join(format!("sonoglide-sweeps-{}", std::process::id()));
    let folder = SweepFolder::open(&dir, sweep, Shard::WHOLE, &[]).expect("a folder");
    assert!(folder.run(sweep, &AtomicBool::new(false), &|| ()).expect("all points"));
    join(std::slice::from_ref(&dir), &dir, &Presentation::default()).expect("a result");
    fs::remove_dir_all(&dir).expect("removed");
}

/// Creates and solves the problems of all points of a map.
fn solve_contacts(sweep: &Sweep, metrics: &[&str]) {
    let template = sweep.loaded.template().expect("a template");
    let scene = template.scene(&sweep.sets(0)).expect("valid");
    let mut numbers = scene::numbers::Numbers::of(scene, &sweep.design.keys()).expect("numbers");
    let points: Vec<u64> = (0..sweep.design.count()).collect();
    for group in points.chunks(BATCH) {
        let mut numerics = None;
        let mut problem = |point: &u64| {
            let scene = numbers.set(&sweep.design.values(*point)).expect("valid");
            let study = scene.excited().expect("a contact study");
            numerics.get_or_insert_with(|| problem::numerics(&study, Some(metrics)));
            problem::problem(&study, problem::law(&study.model).expect("a law")).expect("a problem")
        };
        let problems: Vec<_> = group.iter().map(&mut problem).collect();
        black_box(solve_many(&problems, &numerics.expect("a group"), &|| ()));
    }
}

/// Runs all points of a Monte Carlo in batches, without their metrics.
fn run_draws(sweep: &Sweep) {
    for point in 0..sweep.design.count() {
        let changed = sweep.loaded.changed(&sweep.sets(point)).expect("valid");
        let (draws, template) = (Draws::of(&changed.scene), changed.template().expect("a template"));
        let scene = |number| template.scene(&draws.draw(number).sets(&draws.keys)).expect("valid");
        let scenes: Vec<_> = (1..=changed.scene.runs).map(scene).collect();
        for group in scenes.chunks(LANES) {
            let driven: Vec<_> = group.iter().filter_map(|scene| scene.driven()).collect();
            black_box(run_batch(&driven, None));
        }
    }
}

fn measured(name: &str, sweep: &Sweep, solves: impl Fn()) {
    let mut least = [f64::INFINITY; 3];
    for _ in 0..ROUNDS {
        for (least, time) in least.iter_mut().zip([timed(&solves), timed(|| rows(sweep)), timed(|| whole(sweep))]) {
            *least = least.min(time);
        }
    }
    let [solves, rows, whole] = least;
    let over = |part: f64| 100.0 * (part / solves - 1.0);
    println!(
        "{name:40} {:6} points   solves {solves:6.2} s   rows {rows:6.2} s ({:+.1} %)   whole {whole:6.2} s ({:+.1} %)",
        sweep.design.count(),
        over(rows),
        over(whole)
    );
}

fn loaded(scene: &str, sets: &[&str]) -> Loaded {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    load(scene, &sets).unwrap_or_else(|error| panic!("{error}"))
}

fn sweep<'a>(loaded: &'a Loaded, axes: &[&str], metrics: &[&str]) -> Sweep<'a> {
    let axes = axes.iter().map(|axis| axis.parse().unwrap_or_else(|error| panic!("{error}"))).collect();
    let names: Vec<String> = metrics.iter().map(|&metric| metric.to_owned()).collect();
    Sweep::new(loaded, Design::product(axes).expect("a design"), &names).unwrap_or_else(|error| panic!("{error}"))
}

fn main() {
    // `cargo test --benches` only checks that it compiles.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    pool.install(|| {
        let mass = loaded("contact", &["integrator.tolerance=1e-6"]);
        let axes = ["contact.dahl.stiffness_n_per_m=1e4:1e7:50:log", "excitation.velocity_ratio=0.05:0.95:200"];
        let map = sweep(&mass, &axes, &["friction_ratio"]);
        measured("a map of a mass", &map, || solve_contacts(&map, &["friction_ratio"]));
        let cold = loaded("lock-cold", &["runs=40"]);
        let draws = sweep(&cold, &["controller.drive.amplitude_v=2:4:5"], &["lock_time_20hz_ms", "lock_time_20hz_ms_p95"]);
        measured("five Monte Carlos of 40 cold starts", &draws, || run_draws(&draws));
    });
}
