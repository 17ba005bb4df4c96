//! Amplitude control with the plant at the converters: the amplitude under load changes, and its
//! start.

use scene::load::load;
use sim::record::{Record, Row};
use sim::run::{Watch, run};

/// Runs the cold start of the flagship stack with changes.
fn record(changes: &[&str]) -> Record {
    let sets: Vec<String> = ["runs=1", "duration_s=0.2"].iter().chain(changes).map(|&set| set.to_owned()).collect();
    let loaded = load("lock-cold", &sets).unwrap_or_else(|error| panic!("{error}"));
    run(&loaded.scene.driven().unwrap(), Watch::default()).unwrap()
}

/// Returns the mean over the last 5 ms before a time, s.
fn before(record: &Record, end_s: f64, of: impl Fn(&Row) -> f64) -> f64 {
    let rows: Vec<f64> = record.rows.iter().filter(|row| row.time_s < end_s && row.time_s > end_s - 5e-3).map(of).collect();
    rows.iter().sum::<f64>() / rows.len() as f64
}

/// The load reduces Q to a tenth and is removed again.
#[test]
fn the_amplitude_is_held_to_1_percent_over_a_tenfold_load() {
    let record = record(&[
        "stack.bvd.q=200",
        "controller.tracking.nominal_q=200",
        "controller.tracking.nominal_force_factor_n_per_v=5.566",
        "controller.drive.velocity_m_per_s=0.1",
        "controller.drive.scan_v=0.3",
        "duration_s=0.6",
        "disturbance.0.at_s=0.2",
        "disturbance.0.key=stack.bvd.q",
        "disturbance.0.to=20",
        "disturbance.1.at_s=0.4",
        "disturbance.1.key=stack.bvd.q",
        "disturbance.1.to=200",
    ]);
    for (begin_s, end_s) in [(0.05, 0.2), (0.2, 0.4), (0.4, 0.6)] {
        let velocity = before(&record, end_s, |row| row.truth.tip_velocity_m_per_s);
        let off =
            |row: &&Row| row.time_s > begin_s && row.time_s < end_s && (row.truth.tip_velocity_m_per_s / 0.1 - 1.0).abs() > 0.015;
        let last_off_s = record.rows.iter().rfind(off).map_or(begin_s, |row| row.time_s);
        println!("{velocity} m/s before {end_s} s; within 1.5 % {} ms after the change", 1e3 * (last_off_s - begin_s));
        assert!((velocity / 0.1 - 1.0).abs() < 0.01, "{velocity} m/s before {end_s} s");
        assert!(begin_s < 0.2 || last_off_s - begin_s < 0.03, "{last_off_s} s");
    }
}

/// The drive rises linearly from the scan voltage in 20 ms. A stack of Q 65 follows with a time
/// constant of 0.5 ms.
#[test]
fn a_soft_start_is_linear_in_time() {
    let changes = ["controller.drive.amplitude_v=6", "controller.drive.scan_v=1", "controller.drive.soft_start_s=0.02"];
    let record = record(&changes);
    let first = record.rows.iter().find(|row| row.drive_v > 1.0 && row.locked).unwrap().time_s;
    let at = |after_s: f64| record.rows.iter().find(|row| row.time_s > first + after_s).unwrap();
    let end = before(&record, 0.2, |row| row.truth.tip_velocity_m_per_s);
    for (after_s, volts) in [(0.005, 2.25), (0.01, 3.5), (0.015, 4.75), (0.021, 6.0)] {
        let row = at(after_s);
        println!("{after_s} s: {} V, {} m/s of {end}", row.drive_v, row.truth.tip_velocity_m_per_s);
        assert!((row.drive_v - volts).abs() < 0.15, "{} V after {after_s} s", row.drive_v);
        assert!((row.truth.tip_velocity_m_per_s / end - volts / 6.0).abs() < 0.05, "{after_s} s");
    }
    assert!(record.rows.iter().all(|row| row.fault == 0));
}

/// Returns the current at the amplifier, A peak: that of the resonance, in phase with the voltage,
/// and that of the parallel 300 nF.
fn amperes(row: &Row) -> f64 {
    row.motional_current_a.hypot(std::f64::consts::TAU * 40e3 * 300e-9 * row.drive_v)
}

/// At 6 V the resonance alone would draw a third more current than the limit.
#[test]
fn an_order_above_the_current_limit_is_folded_back() {
    for (q, limit_a) in [(65.0, 1.45), (120.0, 2.2), (200.0, 3.0)] {
        let sets = [format!("stack.bvd.q={q}"), format!("controller.limits.current_a={limit_a}")];
        let sets: Vec<&str> = sets.iter().map(String::as_str).chain(["controller.drive.amplitude_v=6"]).collect();
        let record = record(&sets);
        let (most, end) = (record.rows.iter().map(amperes).fold(0.0, f64::max), before(&record, 0.2, amperes));
        let (fault, limit) = record.rows.last().map(|row| (row.fault, row.limit)).unwrap();
        println!("Q {q}: at most {most:.3} A of {limit_a}, {end:.3} A at the end, fault {fault}, limit {limit}");
        assert_eq!((fault, limit), (0, 108), "Q {q}");
        assert!(most < limit_a && (end / limit_a / 0.95 - 1.0).abs() < 0.02, "Q {q}: {most} A, {end} A");
    }
}

/// A sudden removal of the load reduces the resistance to a third or to a tenth. Blocks of 100
/// samples are too slow for the latter.
#[test]
fn removing_the_load_folds_back_before_a_trip() {
    for (q, samples) in [(65.0, 32), (200.0, 32), (65.0, 100)] {
        let (to, block) = (format!("disturbance.0.to={q}"), format!("controller.block_samples={samples}"));
        let record = record(&[
            "stack.bvd.q=20",
            "controller.tracking.nominal_q=20",
            "controller.drive.amplitude_v=12",
            "controller.limits.current_a=3",
            "disturbance.0.at_s=0.1",
            "disturbance.0.key=stack.bvd.q",
            &to,
            &block,
        ]);
        let (most, end) = (record.rows.iter().map(amperes).fold(0.0, f64::max), before(&record, 0.2, amperes));
        println!("Q 20 to {q}: {:.3} A before, at most {most:.3} A, {end:.3} A at the end", before(&record, 0.1, amperes));
        assert!(record.rows.iter().all(|row| row.fault == 0), "Q {q}");
        assert!(most < 3.0 && (end / 2.85 - 1.0).abs() < 0.02, "Q {q}: {most} A, {end} A");
    }
}

/// Each burst begins with the load estimate of the previous one.
#[test]
fn bursts_are_folded_back_too() {
    for edge in ["hard", "boost"] {
        let edge = format!("controller.burst.edge={edge}");
        let record = record(&[
            "controller.drive.amplitude_v=12",
            "controller.limits.current_a=3",
            "controller.burst.period_s=0.01",
            "controller.burst.duty=0.5",
            &edge,
        ]);
        let most = record.rows.iter().map(amperes).fold(0.0, f64::max);
        let folded = record.rows.iter().filter(|row| row.limit == 108).count();
        println!("{edge}: at most {most:.3} A, folded back in {folded} blocks of {}", record.rows.len());
        assert!(record.rows.iter().all(|row| row.fault == 0) && most < 3.0 && folded > 1000, "{edge}: {most} A");
    }
}
