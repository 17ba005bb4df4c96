use super::*;
use scene::load::load;

fn sweep<'a>(loaded: &'a Loaded, axes: &[&str], metrics: &[&str]) -> Result<Sweep<'a>, SweepError> {
    let axes = axes.iter().map(|axis| axis.parse()).collect::<Result<Vec<_>, _>>()?;
    Sweep::new(loaded, Design::product(axes)?, &metrics.iter().map(|&name| name.to_owned()).collect::<Vec<_>>())
}

fn loaded(scene: &str, sets: &[&str]) -> Loaded {
    load(scene, &sets.iter().map(|&set| set.to_owned()).collect::<Vec<_>>()).unwrap_or_else(|error| panic!("{error}"))
}

fn all(sweep: &Sweep) -> Rows {
    rows(sweep, 0..sweep.design.count())
}

fn rows(sweep: &Sweep, points: Range<u64>) -> Rows {
    sweep.rows(points, &AtomicBool::new(false), &|| ()).expect("a plan").expect("not stopped")
}

/// A point equals a separate run with its keys set: with a closed form, with steps, and driven.
#[test]
fn point_equals_a_separate_run() {
    for (scene, axis, metrics) in [
        ("contact-kinematic", "excitation.velocity_ratio=0.2:1.4:4", &["friction_ratio", "power_ratio"][..]),
        ("contact-kinematic", "excitation.velocity_ratio=0.2:1.4:4", &["friction_ratio", "reversals", "input_ratio"]),
        ("lock", "stack.bvd.q=60,70", &["lock_time_20hz_ms", "q"]),
    ] {
        let loaded = loaded(scene, &[]);
        let sweep = sweep(&loaded, &[axis], metrics).unwrap_or_else(|error| panic!("{error}"));
        let rows = all(&sweep);
        for point in 0..sweep.design.count() {
            let cell = loaded.cell(&sweep.sets(point)).expect("a scene");
            let study = super::super::run(&cell, Options::default()).expect("a study");
            for (column, name) in rows.metrics.iter().zip(metrics) {
                let (swept, alone) = (column[point as usize], study.metrics.get(name));
                let near = swept.zip(alone).is_none_or(|(swept, alone)| (swept - alone).abs() <= 1e-13 * alone.abs());
                assert!(swept.is_some() == alone.is_some() && near, "{scene}, {point}, {name}: {swept:?}, {alone:?}");
            }
            let hash = study.run().map(|run| format!("{:016x}", run.record.drive_hash));
            assert_eq!(rows.drive_hashes[point as usize], hash, "{scene}");
        }
    }
}

/// The rows do not depend on the division of the points or on the number of threads.
#[test]
fn rows_do_not_depend_on_their_division() {
    let loaded = loaded("contact-kinematic", &[]);
    let sweep =
        sweep(&loaded, &["excitation.velocity_ratio=0.05:0.95:7", "contact.dahl.mu=0.1,0.3"], &["friction_ratio"]).unwrap();
    let whole = all(&sweep);
    for thread in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(thread).build().unwrap();
        let mut parts = Rows::new(2, 1);
        for part in [0..5, 5..6, 6..14] {
            parts.append(pool.install(|| rows(&sweep, part)));
        }
        assert_eq!(parts, whole);
        let rest = parts.split_off(9);
        parts.drop_first(2);
        assert_eq!((&parts.points[..], &rest.metrics[0][..]), (&whole.points[2..9], &whole.metrics[0][9..]));
    }
}

/// An invalid point has a row with its reason, and does not affect the others.
#[test]
fn invalid_point_has_a_row_with_its_reason() {
    let loaded = loaded("contact-kinematic", &[]);
    // The window contains periods that the shorter run does not have.
    let sweep = sweep(&loaded, &["duration_s=0.0005,0.01"], &["friction_ratio"]).unwrap_or_else(|error| panic!("{error}"));
    let rows = all(&sweep);
    assert!(rows.failures[0].as_ref().is_some_and(|why| why.contains("window_periods")), "{:?}", rows.failures);
    assert!(rows.metrics[0][0].is_none() && rows.metrics[0][1].is_some() && rows.failures[1].is_none());
}

/// A scene with several runs has statistics at each point.
#[test]
fn several_runs_have_statistics_at_each_point() {
    let loaded = loaded("lock-cold", &["runs=3"]);
    let metrics = ["lock_time_20hz_ms", "lock_time_20hz_ms_p95", "runs_locked"];
    let sweep = sweep(&loaded, &["controller.drive.amplitude_v=3,4"], &metrics).unwrap_or_else(|error| panic!("{error}"));
    let rows = all(&sweep);
    assert!(rows.metrics[2].iter().all(|locked| *locked == Some(3.0)), "{:?}", rows.failures);
    assert!((0..2).all(|point| rows.metrics[1][point] >= rows.metrics[0][point] && rows.metrics[0][point].is_some()));
}

#[test]
fn errors_are_reported_before_any_run() {
    let loaded = loaded("contact-kinematic", &[]);
    for (axis, metric, why) in [
        ("contact.dahl.mux=0.1,0.2", "friction_ratio", "did you mean `contact.dahl.mu`"),
        ("contact.dahl.mu=0.1,-0.2", "friction_ratio", "must be at least"),
        ("seed=1,2", "friction_ratio", "the same at every point"),
        ("contact.dahl.mu=0.1,0.2", "friction_rato", "did you mean `friction_ratio`"),
        ("contact.dahl.mu=0.1,0.2", "friction_ratio_p95", "the scene runs once"),
        ("title=1,2", "friction_ratio", "is not a number"),
        ("contact.dahl.mu=0.1,0.2", "overlay_rms_n", "requires a scene with [[overlay]]"),
    ] {
        let error = sweep(&loaded, &[axis], &[metric]).expect_err(axis).to_string();
        assert!(error.contains(why), "{axis}, {metric}: {error}");
    }
    let twice = sweep(&loaded, &["contact.dahl.mu=0.1,0.2"], &["friction_ratio", "friction_ratio"]);
    assert!(twice.expect_err("twice").to_string().contains("twice"));
}

/// A number cannot be swept if a profile or a step sets it from the beginning, or if each run draws
/// it.
#[test]
fn key_set_by_the_scene_is_refused() {
    let disturbed =
        |at_s: &str, by: &str| loaded("lock", &[&format!("disturbance.0={{at_s={at_s}, key=\"stack.bvd.q\", {by}}}")]);
    let (course, step) = ("profile={time_s=[0,1], values=[50,50]}", "to=50");
    let drawn = |key: &str| {
        let vary = format!("vary.0={{key=\"{key}\", from=0.1, to=0.2}}");
        loaded("contact-kinematic", &["grid.set=[\"runs=1\"]", "runs=2", &vary])
    };
    let (q, sliding) = ("stack.bvd.q=60,70", "excitation.sliding_m_per_s=0.01,0.02");
    for (loaded, axis, why) in [
        (disturbed("0", course), q, "`stack.bvd.q` follows the measured `disturbance.0.profile`"),
        (disturbed("0", step), q, "has the value of `disturbance.0.to` from the beginning of the run"),
        (drawn("contact.dahl.mu"), "contact.dahl.mu=0.05,0.5", "`contact.dahl.mu` is drawn in each run"),
        // The drawn ratio replaces the speed.
        (drawn("excitation.velocity_ratio"), sliding, "neither the first nor the last point"),
    ] {
        let error = sweep(&loaded, &[axis], &[]).expect_err("nothing to sweep").to_string();
        assert!(error.contains(why), "{error}");
    }
    let begins = "disturbance.0.at_s=0,1e-3";
    for (at_s, by, axes) in
        [("1e-3", course, &[q][..]), ("1e-3", step, &[q]), ("0", course, &[q, begins]), ("0", step, &["disturbance.0.to=60,70"])]
    {
        sweep(&disturbed(at_s, by), axes, &["q"]).unwrap_or_else(|error| panic!("{error}"));
    }
}

/// Returns an overlay with measured friction at two times.
fn measured_at(times_s: &str) -> String {
    format!("overlay.0={{quantity=\"friction_n\", x={times_s}, values=[0.1, 0.15], x_unit=\"s\"}}")
}

/// A measurement is compared with each point as with a separate run: with steps, and over the
/// period of a closed form.
#[test]
fn contact_points_are_compared_with_a_measurement() {
    for (scene, times_s) in [("contact", "[3.31e-3, 3.32e-3]"), ("contact-kinematic", "[2e-6, 9e-6]")] {
        compare_with_a_measurement(&loaded(scene, &[&measured_at(times_s)]));
    }
}

fn compare_with_a_measurement(loaded: &Loaded) {
    let metrics = ["overlay_rms_n", "overlay_max_n", "friction_ratio"];
    let sweep = sweep(loaded, &["contact.dahl.mu=0.2,0.3"], &metrics).unwrap_or_else(|error| panic!("{error}"));
    let rows = all(&sweep);
    for point in 0..2 {
        let cell = loaded.cell(&sweep.sets(point)).expect("a scene");
        let study = super::super::run(&cell, Options::default()).expect("a study");
        for (column, name) in rows.metrics.iter().zip(metrics) {
            let alone = study.metrics.get(name);
            assert!(alone.is_some() && column[point as usize] == alone, "{name}: {column:?}, {alone:?}");
        }
    }
    assert_ne!(rows.metrics[0][0], rows.metrics[0][1]);
}

/// A closed form has one period. A measurement outside it is refused before any run, if no point
/// takes steps.
#[test]
fn measurement_outside_the_closed_form_period_is_refused() {
    let loaded = loaded("contact-kinematic", &[&measured_at("[3.1e-3, 3.2e-3]")]);
    let over = |axis: &str, metric: &str| sweep(&loaded, &[axis], &[metric]).map_err(|error| error.to_string()).map(|_| ());
    let refused = over("contact.dahl.mu=0.2,0.3", "overlay_rms_n").expect_err("one period");
    for part in
        ["no point has `overlay_rms_n`", "its points range from 186 to 192", "ranges from 0 to 1", "integrator.method=linexp"]
    {
        assert!(refused.contains(part), "{part}: {refused}");
    }
    let unit = over("contact.dahl.mu=0.2,0.3", "overlay_rms_hz").expect_err("another unit");
    assert!(unit.contains("no point has `overlay_rms_hz`"), "{unit}");
    assert_eq!(over("contact.dahl.mu=0.2,0.3", "friction_ratio"), Ok(()));
    // The times are within the longer of two periods.
    let loaded = self::loaded("contact-kinematic", &[&measured_at("[11e-6, 12e-6]")]);
    let rows =
        all(&sweep(&loaded, &["excitation.frequency_hz=120000,60000"], &["overlay_rms_n"])
            .unwrap_or_else(|error| panic!("{error}")));
    assert!(rows.metrics[0][0].is_none() && rows.metrics[0][1].is_some(), "{:?} {:?}", rows.metrics, rows.failures);
}

#[test]
fn a_sweep_that_is_stopped_has_no_rows() {
    let loaded = loaded("contact-kinematic", &[]);
    let sweep = sweep(&loaded, &["contact.dahl.mu=0.1,0.2"], &["friction_ratio"]).unwrap();
    assert_eq!(sweep.rows(0..2, &AtomicBool::new(true), &|| ()).unwrap(), None);
}
