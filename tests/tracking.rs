//! Scan and lock with the plant at the converters: advantages of the motional phase over the V-I
//! phase.

use firmware::controller::Controller;
use firmware::seam::block::{Amplitude, Gate, Orders, Request};
use firmware::seam::fault::{Fault, Limit};
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use hal_mock::block_clock::BlockClock;
use plant::Plant;
use scene::load::load;
use scene::settings;
use sim::instruments::measure;
use sim::metrics::Metrics;
use sim::record::Record;
use sim::run::{Watch, run};

/// Controller and plant, with orders that a test can change.
struct Rig {
    controller: Controller,
    clock: BlockClock<Plant>,
    orders: Orders,
}

impl Rig {
    fn new(name: &str, changes: &[&str]) -> Self {
        let sets: Vec<String> = changes.iter().map(|&set| set.to_owned()).collect();
        let scene = load(name, &sets).unwrap_or_else(|error| panic!("{error}")).scene;
        let scene = scene.driven().unwrap();
        let controller = Controller::build(&settings::config(&scene)).unwrap();
        let clock = BlockClock::new(Plant::new(&scene), &controller.silence());
        Rig { controller, clock, orders: Orders { gate: Gate::On, ..Orders::default() } }
    }

    fn order(&mut self, request: Request) {
        let Orders { sequence, attempt, .. } = self.orders;
        self.orders = Orders { sequence: sequence + 1, attempt: attempt + 1, request, ..self.orders };
    }

    fn blocks(&mut self, blocks: u32) -> Telemetry {
        (0..blocks).map(|_| self.clock.tick(|sense, drive| self.controller.process(&self.orders, sense, drive))).last().unwrap()
    }

    /// Runs until the mode is reached, or a fault.
    fn until(&mut self, mode: Mode) -> Telemetry {
        (0..100_000)
            .map(|_| self.blocks(1))
            .find(|report| report.mode == mode || report.fault.is_some())
            .expect("the mode or a fault")
    }
}

/// The stack still rings from the previous run: at a Q of 900 for tens of milliseconds, with more
/// current than the self-test expects.
#[test]
fn a_run_can_follow_a_run_immediately() {
    for name in ["transducer-skymen-60w", "transducer-gb-4540-4sh", "transducer-smbltd45f28h", "lock"] {
        for pause in [1, 4, 100] {
            let mut rig = Rig::new(name, &[]);
            rig.order(Request::Run);
            assert_eq!(rig.until(Mode::Run).fault, None, "{name}");
            rig.blocks(2000);
            rig.order(Request::Idle);
            rig.blocks(pause);
            rig.order(Request::Run);
            let again = rig.until(Mode::Run);
            assert_eq!((again.mode, again.fault), (Mode::Run, None), "{name}, after {pause} blocks");
        }
        let mut rig = Rig::new(name, &[]);
        rig.order(Request::Run);
        rig.until(Mode::Run);
        rig.blocks(2000);
        rig.order(Request::Scan);
        assert_eq!(rig.blocks(1).mode, Mode::SelfTest);
        let scanned = rig.until(Mode::Idle);
        assert!(scanned.fault.is_none() && scanned.transducer.is_some(), "{name}: {scanned:?}");
    }
}

/// The drive of a scan without a resonance fades before the fault: an end at once would draw a peak
/// of current into the clamped capacitance.
#[test]
fn a_scan_without_a_resonance_ends_without_a_peak_of_current() {
    // The drive may end at any phase.
    for (n, request) in (0..12).zip([Request::Run, Request::Scan].into_iter().cycle()) {
        let hz = format!("controller.drive.frequency_hz={}", 40_000 + 37 * n);
        let mut rig = Rig::new("lock", &["stack.bvd.series_resonance_hz=60000", "controller.tracking.mode=phase_lock", &hz]);
        rig.order(request);
        let mut peaks = Vec::new();
        let mut block = |rig: &mut Rig| {
            rig.clock.tick(|sense, drive| {
                peaks.push(sense.i.iter().map(|code| code.abs_diff(2048)).max());
                rig.controller.process(&rig.orders, sense, drive)
            })
        };
        let fault = (0..20_000).find_map(|_| block(&mut rig).fault);
        (0..5).for_each(|_| _ = block(&mut rig));
        let (before, end) = peaks.split_at(peaks.len() - 10);
        assert_eq!(fault, Some(Fault::NoResonance));
        assert!(end.iter().max() <= before[before.len() - 100..].iter().max(), "{request:?} {n}: {end:?}");
    }
}

/// An amplitude set point that changes in each block, down to zero and back, is restored: no fault,
/// no silence.
#[test]
fn a_current_may_fade_to_zero_and_back() {
    let courses = [
        ("observer", 500, 2000),
        ("observer", 5000, 2000),
        ("observer", 40, 2000),
        ("observer", 500, 0),
        ("phase_lock", 500, 2000),
    ];
    for (mode, fade, pause) in courses {
        let mut rig = Rig::new("lock", &[&format!("controller.tracking.mode={mode}")]);
        rig.order(Request::Run);
        assert_eq!(rig.until(Mode::Run).fault, None);
        let mut order = |amperes: f32, blocks: u32| {
            rig.orders.amplitude = Some(Amplitude::MotionalCurrent(amperes));
            rig.blocks(blocks)
        };
        order(0.8, 2000);
        for twice in 0..2 {
            (0..fade).for_each(|n| _ = order(0.8 * (1.0 - n as f32 / fade as f32), 1));
            if pause > 0 {
                order(0.0, pause);
            }
            (1..fade).for_each(|n| _ = order(0.8 * n as f32 / fade as f32, 1));
            let back = order(0.8, 1000);
            let amperes = back.motional_current.norm();
            assert_eq!((back.mode, back.fault), (Mode::Run, None), "{mode}, {fade}, {pause}, {twice}");
            assert!((amperes / 0.8 - 1.0).abs() < 0.02, "{mode}, {fade}, {pause}, {twice}: {amperes} A");
        }
    }
}

/// The frequency of the second block of a lock is the first estimate of the observer.
#[test]
fn a_second_run_starts_at_the_known_resonance() {
    let moved = ["disturbance.0.at_s=0.12", "disturbance.0.key=stack.bvd.series_resonance_hz"];
    for (to, same) in [("40520", true), ("40600", true), ("39500", false)] {
        let to = format!("disturbance.0.to={to}");
        let mut rig = Rig::new(
            "lock",
            &["controller.tracking.mode=observer", "stack.bvd.series_resonance_hz=40520", moved[0], moved[1], &to],
        );
        let mut lock = || {
            rig.order(Request::Run);
            assert_eq!(rig.until(Mode::Lock).fault, None, "{to}");
            let begun = rig.blocks(3);
            rig.until(Mode::Run);
            let locked = rig.blocks(1500);
            assert_eq!((locked.mode, locked.fault, locked.locked), (Mode::Run, None, true), "{to}");
            rig.order(Request::Idle);
            rig.blocks(1200);
            (begun.frequency.0, locked.frequency.0)
        };
        let (first, second) = (lock(), lock());
        assert!((first.0 - 40_520.0).abs() > 200.0 && (first.1 - 40_520.0).abs() < 1.0, "{first:?}");
        assert_eq!((second.0 - first.1).abs() < 1.0, same, "{to}: {second:?}");
    }
}

/// At 1 kHz and half a millisecond of ring-up, only a few blocks of each burst can be measured.
#[test]
fn short_bursts_are_tracked() {
    let scene = load(
        "lock",
        &[
            "duration_s=0.8",
            "controller.burst.period_s=1e-3",
            "controller.burst.duty=0.5",
            "disturbance.0.at_s=0.3",
            "disturbance.0.key=stack.bvd.series_resonance_hz",
            "disturbance.0.to=40700",
        ]
        .map(String::from),
    );
    let scene = scene.unwrap_or_else(|error| panic!("{error}")).scene;
    let scene = scene.driven().unwrap();
    let record = run(&scene, Watch::default()).unwrap();
    let last = record.rows.last().unwrap();
    assert_eq!((last.mode, last.fault, last.locked), (Mode::Run, 0, true));
    assert!((last.frequency_hz - 40_700.0).abs() < 5.0, "{} Hz", last.frequency_hz);
}

/// Bursts of four periods contain no information: the frequency is held, and the telemetry reports
/// that it is not tracked.
#[test]
fn bursts_too_short_to_track_are_reported_as_a_limit() {
    let sets = ["duration_s=0.5", "controller.burst.period_s=1e-3", "controller.burst.duty=0.1"].map(String::from);
    let scene = load("lock", &sets).unwrap_or_else(|error| panic!("{error}")).scene;
    let scene = scene.driven().unwrap();
    let record = run(&scene, Watch::default()).unwrap();
    let last = record.rows.last().unwrap();
    assert_eq!((last.mode, last.locked, last.limit), (Mode::Run, false, Limit::NotTracking as u8));
    assert!((last.frequency_hz - 40_520.0).abs() < 2.0, "{} Hz", last.frequency_hz);
}

#[test]
fn long_soft_edges_do_not_disturb_the_lock() {
    let (record, metrics) = lock(&["controller.burst.edge=soft", "controller.burst.edge_cycles=2000"]);
    assert_eq!(record.rows.last().unwrap().fault, 0);
    assert!(metrics.get("frequency_bias_hz").unwrap().abs() < 0.5);
}

/// Runs a lock that stays ON, with changes.
fn lock(changes: &[&str]) -> (Record, Metrics) {
    let stays_on = ["duration_s=0.4", "controller.burst.on_s=[0.0]", "controller.burst.off_s=[9.0]"];
    let sets: Vec<String> = stays_on.iter().chain(changes).map(|&set| set.to_owned()).collect();
    let scene = load("lock", &sets).unwrap_or_else(|error| panic!("{error}")).scene;
    let scene = scene.driven().unwrap();
    let record = run(&scene, Watch::default()).unwrap();
    let metrics = measure(&scene, &record);
    (record, metrics)
}

fn bias_hz(changes: &[&str]) -> Option<f64> {
    lock(changes).1.get("frequency_bias_hz")
}

/// Compares the bias of the V-I loop with that of the circuit: the zero of the total phase nearest
/// to the series resonance.
#[test]
fn v_i_phase_has_the_bias_of_the_circuit() {
    for (q, expected) in [(100, 31.0), (65, 76.0), (40, 228.0)] {
        let bias = bias_hz(&["controller.tracking.mode=zero_phase", &format!("stack.bvd.q={q}")]).unwrap();
        assert!((bias / expected - 1.0).abs() < 0.03, "Q {q}: {bias} Hz");
    }
}

#[test]
fn v_i_phase_reports_no_lock_below_m_of_two() {
    for q in [25, 20] {
        let (record, _) = lock(&["controller.tracking.mode=zero_phase", &format!("stack.bvd.q={q}")]);
        let last = record.rows.last().unwrap();
        assert_eq!((last.mode, last.fault), (Mode::Fault, Fault::NoLock.code()), "Q {q}");
        assert!(record.rows.iter().all(|row| row.mode != Mode::Run), "Q {q}");
    }
}

#[test]
fn motional_phase_locks_at_every_q() {
    // 1 V at Q 400, because 3 V would exceed the current limit. The remaining bias is the noise of
    // the identification: the bounds are four standard deviations over seeds.
    for (q, volts, bound) in [(400, 1, 0.2), (100, 3, 0.15), (65, 3, 0.15), (40, 3, 0.4), (25, 3, 1.1), (20, 3, 1.9)] {
        let nominal_q = format!("controller.tracking.nominal_q={}", f64::from(q) / 1.5);
        let amplitude = format!("controller.drive.amplitude_v={volts}.0");
        let bias = bias_hz(&[&format!("stack.bvd.q={q}"), &nominal_q, &amplitude, "duration_s=1.2"])
            .unwrap_or_else(|| panic!("no lock at Q {q}"));
        assert!(bias.abs() < bound, "Q {q}: {bias} Hz");
    }
}

/// 3 V would drive 3.8 A at the resonance. The scan continues at a lower voltage, and the drive is
/// then reduced to the limit of 3 A.
#[test]
fn a_drive_beyond_the_current_limit_is_reduced_to_it() {
    let (record, _) = lock(&["stack.bvd.q=400"]);
    let last = record.rows.last().unwrap();
    assert_eq!((last.mode, last.fault, last.limit), (Mode::Run, 0, Limit::FoldedBack as u8));
}

#[test]
fn it_finds_the_resonance_anywhere_in_the_window() {
    for hz in [39_200, 39_700, 40_000, 40_300, 40_800] {
        let bias = bias_hz(&[&format!("stack.bvd.series_resonance_hz={hz}")]).unwrap_or_else(|| panic!("no lock at {hz} Hz"));
        assert!(bias.abs() < 0.25, "{hz} Hz: {bias} Hz");
    }
}

#[test]
fn nominal_values_may_be_wrong() {
    for nominal in ["nominal_q=32", "nominal_q=129", "nominal_c0_f=285e-9", "nominal_c0_f=315e-9"] {
        let bias = bias_hz(&[&format!("controller.tracking.{nominal}")]).unwrap_or_else(|| panic!("no lock with {nominal}"));
        assert!(bias.abs() < 0.25, "{nominal}: {bias} Hz");
    }
}

/// Without correction, 100 ns of skew would be 1.4 degrees, which is 8 Hz at Q 65.
#[test]
fn skew_between_the_converters_does_not_move_the_lock() {
    for skew in ["-1e-7", "-2e-8", "2e-8", "1e-7"] {
        let bias = bias_hz(&[&format!("sensors.skew_s={skew}")]).unwrap();
        assert!(bias.abs() < 0.25, "{skew} s: {bias} Hz");
    }
}

#[test]
fn seeds_do_not_matter() {
    for seed in 2..12 {
        let (record, metrics) = lock(&[&format!("seed={seed}"), "duration_s=0.25"]);
        assert_eq!(record.rows.last().unwrap().fault, 0, "seed {seed}");
        let bias = metrics.get("frequency_bias_hz").unwrap();
        assert!(bias.abs() < 0.25, "seed {seed}: {bias} Hz");
    }
}

#[test]
fn a_resonance_outside_the_window_is_a_fault() {
    let (record, _) = lock(&["stack.bvd.series_resonance_hz=44000"]);
    assert_eq!(record.rows.last().unwrap().fault, Fault::NoResonance.code());
}

#[test]
fn a_resonance_that_jumps_away_is_a_loss_of_lock() {
    let jump = ["disturbance.0.at_s=0.25", "disturbance.0.key=stack.bvd.series_resonance_hz", "disturbance.0.to=45000"];
    let (record, _) = lock(&jump);
    let lost = record.rows.iter().find(|row| row.fault != 0).expect("a fault");
    assert_eq!(lost.fault, Fault::LossOfLock.code());
    assert!(lost.time_s < 0.27, "after {} s", lost.time_s - 0.25);
    assert!(record.rows.iter().rev().take(100).all(|row| row.drive_v == 0.0));
}

#[test]
fn velocity_is_held_when_the_load_triples_the_loss() {
    let (record, _) = lock(&[
        "controller.drive.velocity_m_per_s=0.1",
        "controller.drive.scan_v=2.0",
        "controller.tracking.nominal_force_factor_n_per_v=5.566",
        "duration_s=0.5",
        "disturbance.0.at_s=0.3",
        "disturbance.0.key=stack.bvd.q",
        "disturbance.0.to=22",
    ]);
    let last = &record.rows[record.rows.len() - 1000..];
    let velocity = last.iter().map(|row| row.truth.tip_velocity_m_per_s).sum::<f64>() / 1000.0;
    assert!((velocity / 0.1 - 1.0).abs() < 0.005, "{velocity} m/s");
    let volts = |rows: &[sim::record::Row]| rows.last().unwrap().drive_v;
    let before = &record.rows[..(0.299 / 32e-6) as usize];
    assert!(volts(last) / volts(before) > 2.5, "{} V, {} V", volts(before), volts(last));
}

#[test]
fn a_square_drive_locks_on_its_fundamental() {
    let bias = bias_hz(&["controller.drive.shape=square"]).expect("a lock");
    assert!(bias.abs() < 1.0, "{bias} Hz");
}

/// During a sweep about the resonance by half a bandwidth to each side, the controller still
/// estimates the resonance and follows it.
#[test]
fn a_chirp_about_the_resonance_follows_it() {
    let chirp = [
        "duration_s=0.6",
        "controller.burst.on_s=[0.15]",
        "controller.burst.off_s=[0.6]",
        "controller.sweep.around=resonance",
        "controller.sweep.start_hz=-300",
        "controller.sweep.stop_hz=300",
        "controller.sweep.time_s=0.02",
        "controller.sweep.then=updown",
        "disturbance.0.at_s=0.35",
        "disturbance.0.key=stack.bvd.series_resonance_hz",
        "disturbance.0.to=40650",
    ];
    let scene = load("lock", &chirp.map(String::from)).unwrap_or_else(|error| panic!("{error}")).scene;
    let scene = scene.driven().unwrap();
    let record = run(&scene, Watch::default()).unwrap();
    for (from_s, to_s, resonance_hz) in [(0.2, 0.34, 40_520.0), (0.45, 0.6, 40_650.0)] {
        let rows: Vec<_> = record.rows.iter().filter(|row| row.time_s > from_s && row.time_s < to_s).collect();
        let worst = rows.iter().map(|row| (row.resonance_estimate_hz - resonance_hz).abs()).fold(0.0, f64::max);
        let (low, high) =
            rows.iter().fold((f64::MAX, 0.0f64), |(low, high), row| (low.min(row.frequency_hz), high.max(row.frequency_hz)));
        assert!(worst < 15.0, "{worst} Hz off {resonance_hz}");
        assert!((low - resonance_hz + 300.0).abs() < 6.0 && (high - resonance_hz - 300.0).abs() < 6.0, "{low} to {high}");
        assert!(rows.iter().all(|row| row.locked && row.fault == 0));
    }
}
