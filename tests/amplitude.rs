//! The amplitude with the plant behind the converters: how it is held whatever the load is, and how it starts.

use scene::load::load;
use sim::record::{Record, Row};
use sim::run::{Watch, run};

/// The cold start of the flagship stack, with changes.
fn record(changes: &[&str]) -> Record {
    let sets: Vec<String> = ["runs=1", "duration_s=0.2"].iter().chain(changes).map(|&set| set.to_owned()).collect();
    let loaded = load("lock-cold", &sets).unwrap_or_else(|error| panic!("{error}"));
    run(&loaded.scene.driven().unwrap(), Watch::default()).unwrap()
}

/// Mean over the last 5 ms before a time, s.
fn before(record: &Record, end_s: f64, of: impl Fn(&Row) -> f64) -> f64 {
    let rows: Vec<f64> = record.rows.iter().filter(|row| row.time_s < end_s && row.time_s > end_s - 5e-3).map(of).collect();
    rows.iter().sum::<f64>() / rows.len() as f64
}

/// The load makes Q a tenth of what it was, and takes itself off again.
#[test]
fn the_amplitude_is_held_to_a_part_in_a_hundred_over_a_tenfold_load() {
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

/// Along a straight line from the scan's voltage, in 20 ms; Q 65 follows with 0.5 ms.
#[test]
fn a_soft_start_takes_its_time() {
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
