//! Cost per point of the maps of a contact study: `cargo bench -p sonoglide-sim --bench maps`.
//!
//! Times are processor times of one thread, so that other load on the machine matters little; two
//! cores halve them. The kinematic map is run in full, a million points. Of the other maps every
//! fiftieth row is run with all its columns, so that neighbours are those of the full map. A
//! thousand points of each map must equal, to the last bit, a separate run from the scene text.

use std::fs;
use std::hint::black_box;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use contact::{solve_many, solve_unwatched};
use scene::load::{Loaded, load};
use scene::numbers::Numbers;
use scene::{Grid, Over, problem};
use sonoglide_sim::study::grid;

/// Number of columns of a map, and of rows of a full map.
const SIDE: u32 = 1000;
/// Number of rows that are run of a sampled map.
const ROWS: u32 = 20;

const STIFFNESS: &str = "contact.dahl.stiffness_n_per_m";
const RATIO: &str = "excitation.velocity_ratio";
const MU: &str = "contact.dahl.mu";

/// Returns the processor time of this thread, s, or the wall time if the system does not report it.
fn cpu_s(began: Instant) -> f64 {
    let text = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let ns: Option<f64> = text.split(' ').next().and_then(|ns| ns.parse().ok());
    ns.map_or_else(|| began.elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}

/// Returns the processor time of `work` per point, us, and its result.
fn micros<T>(points: usize, work: impl FnOnce() -> T) -> (f64, T) {
    let began = Instant::now();
    let before = cpu_s(began);
    let out = black_box(work());
    (1e6 * (cpu_s(began) - before) / points as f64, out)
}

fn map((key, least, most, rows): (&str, f64, f64, u32), set: &[&str]) -> Grid {
    let axis = |key: &str, from: f64, to: f64, points: u32, log| Over {
        key: key.to_owned(),
        values: Vec::new(),
        from: Some(from),
        to: Some(to),
        points: Some(points),
        log,
    };
    Grid {
        title: String::new(),
        metrics: vec!["friction_ratio".to_owned()],
        contours: Vec::new(),
        over: vec![axis(key, least, most, rows, true), axis(RATIO, 0.0012, 1.2, SIDE, false)],
        set: set.iter().map(|&set| set.to_owned()).collect(),
    }
}

fn loaded(scene: &str, sets: &[&str]) -> Loaded {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    load(scene, &sets).unwrap_or_else(|error| panic!("{error}"))
}

/// Measures the time per point of a map and compares a thousand of its points, run alone, bit by
/// bit.
fn measured(name: &str, loaded: &Loaded, grid: &Grid) {
    let points: u32 = grid.over.iter().filter_map(|over| over.points).product();
    let points = points as usize;
    let never = AtomicBool::new(false);
    let (micros, result) = micros(points, || grid::run(loaded, grid, &never).expect("a result").expect("not stopped"));
    let template = loaded.template().expect("a template");
    for sample in 0..1000 {
        // The step is coprime to both sides.
        let place = sample * 7919 % points;
        let axes =
            grid.over.iter().zip(result.design.values(place as u64)).map(|(over, value)| format!("{}={value:?}", over.key));
        let scene = template.scene(&grid.set.iter().cloned().chain(axes).collect::<Vec<_>>()).expect("valid");
        let study = scene.excited().expect("a contact study");
        let problem = problem::problem(&study, problem::law(&study.model).expect("a law")).expect("a problem");
        let numerics = problem::numerics(&study, Some(&["friction_ratio"]));
        let alone = solve_unwatched(&problem, &numerics, &|| ()).expect("an answer").ratios.friction;
        assert_eq!(result.rows.metrics[0][place], Some(alone), "{name}, point {place}");
    }
    println!("{name:44} {micros:8.2} us per point   a million on two cores {:6.1} s", micros / 2.0);
}

/// Measures the parts of a kinematic point, and the speed-up by lanes of a contact with a mass.
fn parts() {
    let kinematic = loaded("contact-kinematic", &[]);
    let template = kinematic.template().expect("a template");
    let sets = |value: f64| [format!("{MU}=0.1"), format!("{RATIO}={value}")];
    let base = template.scene(&sets(0.5)).expect("valid");
    let count = 2000;
    let (text, ()) = micros(count, || {
        (0..count).for_each(|i| drop(black_box(template.scene(&sets(1e-3 + 1e-4 * i as f64)).expect("valid"))));
    });
    let mut numbers = Numbers::of(base, &[MU, RATIO]).expect("numbers");
    let count = 200_000;
    let (set, ()) = micros(count, || {
        for i in 0..count {
            let scene = numbers.set(&[0.1, 1e-3 + 1e-6 * i as f64]).expect("valid");
            let study = scene.excited().expect("a contact study");
            black_box(problem::problem(&study, problem::law(&study.model).expect("a law")).expect("a problem"));
        }
    });
    println!("scene of a point: from its text {text:8.2} us, from its numbers, with its problem, {set:5.2} us");

    let sdof = loaded("contact", &["integrator.tolerance=1e-6", "duration_s=0.00334", "integrator.window_periods=[100, 200]"]);
    let template = sdof.template().expect("a template");
    for stiffness in [5.6e4, 1e6, 1e7] {
        let problem = |i: u32| {
            let sets = [format!("{STIFFNESS}={stiffness}"), format!("{RATIO}={}", 0.4 + 1.2e-3 * f64::from(i))];
            let scene = template.scene(&sets).expect("valid");
            let study = scene.excited().expect("a contact study");
            let problem = problem::problem(&study, problem::law(&study.model).expect("a law")).expect("a problem");
            (problem, problem::numerics(&study, Some(&["friction_ratio"])))
        };
        let (problems, numerics): (Vec<_>, Vec<_>) = (0..256).map(problem).unzip();
        let (batched, many) = micros(problems.len(), || solve_many(&problems, &numerics[0], &|| ()));
        let (alone, one) = micros(problems.len(), || {
            problems.iter().map(|problem| solve_unwatched(problem, &numerics[0], &|| ())).collect::<Vec<_>>()
        });
        assert_eq!(many, one);
        println!(
            "256 neighbours at Kt {stiffness:7.1e} N/m: alone {alone:7.1} us, batched {batched:6.1} us, {:4.1} times",
            alone / batched
        );
    }
}

fn main() {
    // `cargo test --benches` only checks that it compiles.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    pool.install(|| {
        parts();
        let kinematic = loaded("contact-kinematic", &[]);
        measured("kinematic, a million points", &kinematic, &map((MU, 0.01, 1.0, SIDE), &[]));
        let sdof = loaded("contact", &["integrator.tolerance=1e-6"]);
        let window = ["duration_s=0.00334", "integrator.window_periods=[100, 200]"];
        for (name, most) in [("one mass, kappa up to 1, tolerance 1e-6", 1.38e5), ("one mass, Kt from 1e4 to 1e7 N/m, 1e-6", 1e7)]
        {
            measured(name, &sdof, &map((STIFFNESS, 1e4, most, ROWS), &window));
        }
    });
}
