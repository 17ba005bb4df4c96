//! Tests of many runs against each run alone.

use std::sync::Mutex;
use std::sync::atomic::Ordering;

use super::*;
use crate::study::{self, Study};
use scene::load::load;

const RUNS: u32 = 6;

fn cold(sets: &[&str]) -> Loaded {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    load("lock-cold", &[vec![format!("runs={RUNS}")], sets].concat()).unwrap_or_else(|error| panic!("{error}"))
}

fn studied(loaded: &Loaded) -> Study<'_> {
    study::run(loaded, Options::default()).unwrap()
}

fn on_threads(threads: usize) -> (Vec<OneRun>, Metrics) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let loaded = cold(&[]);
    pool.install(|| {
        let study = studied(&loaded);
        (study.monte_carlo().unwrap().runs.clone(), study.metrics.clone())
    })
}

/// Returns the bits of the errors, by which NaN equals itself.
fn bits(run: &OneRun) -> Vec<u32> {
    run.error_hz.iter().map(|hz| hz.to_bits()).collect()
}

#[test]
fn threads_do_not_matter() {
    let ((one, metrics), (two, same)) = (on_threads(1), on_threads(2));
    assert_eq!(metrics, same);
    assert_eq!(one.len(), RUNS as usize);
    for (one, two) in one.iter().zip(&two) {
        assert_eq!((&one.draw, &one.metrics, one.drive_hash, bits(one)), (&two.draw, &two.metrics, two.drive_hash, bits(two)));
    }
}

#[test]
fn single_run_equals_the_run_of_many() {
    let loaded = cold(&[]);
    let study = studied(&loaded);
    let runs = study.monte_carlo().unwrap();
    let many = &runs.runs[4];
    assert_eq!(many.draw.number, 5);
    let draws = Draws::of(&loaded.scene);
    let alone = loaded.cell(&draws.draw(5).sets(&draws.keys)).unwrap();
    let alone = studied(&alone);
    assert_eq!(alone.run().unwrap().record.drive_hash, many.drive_hash.unwrap());
    assert_eq!(alone.metrics, many.metrics);
    // The seed alone would give another run, because the varied values are drawn too.
    let values = many.draw.values.clone();
    assert_ne!(values, runs.runs[3].draw.values);
}

#[test]
fn expectations_use_the_statistics_of_all_runs() {
    let loaded = cold(&[
        "expect.0.metric=runs_completed",
        "expect.0.max=6",
        "expect.0.min=6",
        "expect.3.metric=lock_time_4hz_ms_p95",
        "expect.3.max=0.1",
    ]);
    let study = studied(&loaded);
    let judged = |metric: &str| study.judged.iter().find(|judged| judged.metric == metric).unwrap();
    assert_eq!((judged("runs_completed").value, judged("false_locks").value), (Some(6.0), Some(0.0)));
    let slow = judged("lock_time_4hz_ms_p95");
    assert!(!slow.pass && slow.value.is_some_and(|ms| ms > 0.3));
    // For a single run, the 95th percentile is the value itself.
    let once = cold(&["runs=1"]);
    let once = studied(&once);
    assert!(
        once.monte_carlo().is_none() && once.judged.iter().any(|judged| judged.metric == "lock_time_20hz_ms_p95" && judged.pass)
    );
}

/// Each of two keys is valid at either of its ends, but not both together.
#[test]
fn invalid_run_is_reported() {
    let both = [
        "vary=[]",
        "vary.0.key=controller.tracking.nominal_q",
        "vary.0.from=60",
        "vary.0.to=5000",
        "vary.1.key=controller.tracking.span",
        "vary.1.from=0.02",
        "vary.1.to=0.19",
        "controller.tracking.span=0.02",
        "controller.tracking.nominal_q=60",
    ];
    let loaded = cold(&both);
    let error = study::run(&loaded, Options::default()).unwrap_err();
    let said = format!("{:#}", anyhow::Error::from(error));
    for part in ["of run ", "controller.tracking.nominal_q=", "is not valid", "the scan would need"] {
        assert!(said.contains(part), "`{part}` is missing in\n{said}");
    }
}

#[test]
fn stopped_runs_are_left_out() {
    let (stop, counts) = (AtomicBool::new(false), Mutex::new(Vec::new()));
    let loaded = cold(&[]);
    let progress = &mut |count: f64| {
        counts.lock().unwrap().push(count);
        stop.store(count >= 2.0, Ordering::Relaxed);
    };
    let options = Options { stop: Some(&stop), progress: Some(progress), ..Options::default() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let study = pool.install(|| study::run(&loaded, options)).unwrap();
    assert!(study.interrupted);
    assert_eq!(study.metrics.get("runs_completed"), Some(2.0));
    assert_eq!(*counts.lock().unwrap(), [1.0, 2.0]);
    assert_eq!(study.monte_carlo().unwrap().asked, RUNS);
}

/// Flaws are worse than long times, and a missing lock is worse than a late one.
/// One of 33 values is another one: the end of the interval is uncertain until enough runs
/// distinguish 1 in 33 from the 2.5 % beyond it.
#[test]
fn the_default_number_of_runs_grows_until_the_interval_is_known() {
    let list = format!("contact.dahl.mu={{ samples = [{}0.4] }}", "0.1, ".repeat(32));
    let runs = |sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        let loaded = load("contact-kinematic", &[&[list.clone(), "grid=false".into()], &sets[..]].concat()).unwrap();
        let study = studied(&loaded);
        let runs = study.monte_carlo().unwrap();
        let is_remarked = crate::tables::remarks(&study).iter().any(|remark| remark.contains("standard error"));
        (runs.runs.len(), runs.asked, is_remarked)
    };
    let (count, asked, is_remarked) = runs(&[]);
    assert!((1024..=2048).contains(&count) && asked == count as u32 && !is_remarked, "{count} {asked}");
    assert_eq!(runs(&["runs=256"]), (256, 256, true));
    assert_eq!(runs(&["contact.dahl.mu={ low = 0.1, high = 0.4 }"]), (256, 256, false));
}

#[test]
fn the_worst_run_is_named() {
    let run = |number: u32, metrics: &[(&'static str, f64)]| {
        let mut of = Metrics::default();
        metrics.iter().for_each(|&(name, value)| of.put(name, value));
        let draw = Draw { number, seed: 1, values: Vec::new() };
        OneRun { draw, metrics: of, locked: true, drive_hash: None, error_hz: Vec::new() }
    };
    let lock = load("lock-cold", &[]).unwrap().scene;
    let worst_of = |scene: &Scene, runs: Vec<OneRun>| {
        let all =
            MonteCarlo { keys: vec![], level: Level::Sil, asked: 3, runs, endless: vec![], times_ms: vec![1.0], wall_s: None };
        all.worst(scene).map(|(run, why)| (run.draw.number, why))
    };
    let worst = |runs| worst_of(&lock, runs);
    let is = |number: u32, why: &str| Some((number, why.to_owned()));
    let quick = || run(1, &[("lock_time_20hz_ms", 1.0)]);
    let slow = || run(2, &[("lock_time_20hz_ms", 2.0)]);
    assert_eq!(worst(vec![quick(), slow(), quick()]), is(2, "largest lock time to 20 Hz"));
    assert_eq!(worst(vec![quick(), slow(), run(3, &[])]), is(2, "largest lock time to 20 Hz"));
    assert_eq!(worst(vec![quick(), slow(), run(3, &[("fault_code", 31.0)])]), is(3, "a fault"));
    assert_eq!(worst(vec![run(1, &[("false_locks", 1.0)]), run(2, &[("fault_code", 31.0)])]), is(1, "a false lock"));
    assert_eq!(worst(vec![quick(), quick()]), None);
    let contact = load("contact-kinematic", &[]).unwrap().scene;
    let reduced = |number, percent| run(number, &[("reduction_percent", percent)]);
    let few = vec![reduced(1, 60.0), reduced(2, 50.0), reduced(3, 70.0)];
    assert_eq!(worst_of(&contact, few), is(2, "smallest friction reduction"));
}
