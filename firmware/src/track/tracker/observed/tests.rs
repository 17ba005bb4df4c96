//! From a start to a lock, block by block, with a resonance whose envelope flows exactly; and where a lock is sought that was lost.

use num_complex::Complex64;

use super::*;

const NOMINAL_HZ: f64 = 40e3;
const BLOCK_S: f64 = 32e-6;
const LM_H: f64 = 0.8e-3;
const WINDOW_HZ: f32 = 1000.0;

/// A drive at the edge, of which nothing is seen.
const SILENT_AT_EDGE: PlayedBlock =
    PlayedBlock { offset_hz: WINDOW_HZ, volts: 3.0, envelope: Some(1.0), pure: false, on: true, driven: true, rung_up: false };

fn prior(offset_hz: f32, deviation_hz: f32, q: f32) -> Prior {
    let lm_h = (LM_H as f32, 0.05 * LM_H as f32);
    Prior { offset_hz: (offset_hz, deviation_hz), q, lm_h, axis: Phasor::new(1.0, 0.0), noise_a: 5e-4 }
}

fn exp(x: Complex64) -> Complex64 {
    Complex64::new(x.im.cos(), x.im.sin()) * x.re.exp()
}

/// A resonance that is driven with 3 V where the observer says, two blocks late.
struct Rig {
    observed: Observed,
    resonance_hz: f64,
    q: f64,
    current: Complex64,
    queue: [f64; 2],
    block: usize,
}

impl Rig {
    fn new(resonance_hz: f64, q: f64) -> Self {
        let mut observed = Observed::new(NOMINAL_HZ as f32, BLOCK_S as f32, WINDOW_HZ);
        observed.start(&prior(0.0, WINDOW_HZ, q as f32), Retry::Window);
        Rig { observed, resonance_hz, q, current: Complex64::default(), queue: [0.0; 2], block: 0 }
    }

    /// One block, of which this is said.
    fn tick(&mut self, fits: bool, change: impl FnOnce(&mut PlayedBlock)) {
        let played_hz = self.queue[self.block % 2];
        let w0 = std::f64::consts::TAU * self.resonance_hz;
        let s = -Complex64::new(w0 / (2.0 * self.q), std::f64::consts::TAU * (NOMINAL_HZ + played_hz) - w0);
        let settled = -3.0 / (2.0 * LM_H * s);
        let flows = |seconds: f64| settled + (self.current - settled) * exp(s * seconds);
        let (middle, end) = (flows(0.5 * BLOCK_S), flows(BLOCK_S));
        self.current = end;
        let mut played = PlayedBlock {
            offset_hz: played_hz as f32,
            volts: 3.0,
            envelope: Some(1.0),
            pure: true,
            on: true,
            driven: true,
            rung_up: false,
        };
        change(&mut played);
        self.observed.follow(Phasor::new(middle.re as f32, middle.im as f32), Phasor::new(3.0, 0.0), &played, fits);
        self.queue[self.block % 2] = self.observed.offset_hz().map_or(0.0, f64::from);
        self.block += 1;
    }

    /// Blocks until it is locked, of so many.
    fn locks(&mut self, blocks: usize) -> Option<usize> {
        (1..=blocks).find(|_| {
            self.tick(true, |_| {});
            self.observed.locked()
        })
    }
}

#[test]
fn it_leads_to_the_resonance_and_locks_after_eight_good_blocks() {
    for off in [-700.0, 0.0, 700.0] {
        let mut rig = Rig::new(NOMINAL_HZ + off, 65.0);
        let mut confident = 0;
        while !rig.observed.locked() {
            assert!(!rig.observed.has_converged() && rig.block < 60, "{off}");
            rig.tick(true, |_| {});
            confident = if rig.observed.is_confident() { confident + 1 } else { 0 };
        }
        assert!(confident == 8 && rig.observed.has_converged(), "{off}: {confident}");
        let found = f64::from(rig.observed.offset_hz().unwrap());
        assert!((found - off).abs() < 20.0, "{off}: {found}");
    }
}

#[test]
fn a_phase_that_speaks_against_it_and_blocks_without_drive_do_not_count() {
    let mut rig = Rig::new(NOMINAL_HZ + 300.0, 65.0);
    (0..60).for_each(|_| rig.tick(false, |_| {}));
    assert!(rig.observed.is_confident() && !rig.observed.locked());
    (0..7).for_each(|_| rig.tick(true, |_| {}));
    rig.tick(false, |_| {});
    (0..7).for_each(|_| rig.tick(true, |_| {}));
    (0..50).for_each(|_| rig.tick(true, |played| played.driven = false));
    assert!(!rig.observed.locked());
    rig.tick(true, |_| {});
    assert!(rig.observed.locked());
    // A lock that was found stays, whatever a block says; that it has converged does not.
    rig.tick(false, |_| {});
    assert!(rig.observed.locked() && !rig.observed.has_converged());
}

#[test]
fn a_drive_that_is_no_sine_leaves_the_lead_to_the_phase_loop() {
    let mut rig = Rig::new(NOMINAL_HZ, 65.0);
    assert!(rig.locks(60).is_some() && rig.observed.offset_hz().is_some());
    rig.tick(true, |played| played.pure = false);
    assert!(rig.observed.offset_hz().is_none() && !rig.observed.is_confident() && !rig.observed.has_converged());
    rig.tick(true, |_| {});
    assert!(rig.observed.offset_hz().is_some());
}

#[test]
fn what_is_shown_is_followed_only_where_it_is_worth_it() {
    // Half a per cent of the nominal frequency: 200 Hz of deviation.
    let mut rig = Rig::new(NOMINAL_HZ + 400.0, 65.0);
    for _ in 0..12 {
        let before = rig.observed.offset_hz();
        rig.tick(true, |_| {});
        let moved = rig.observed.offset_hz() != before;
        assert_eq!(moved, rig.observed.observer().deviation_hz() < 200.0, "block {}", rig.block);
    }
}

#[test]
fn a_resonance_that_is_too_damped_or_beyond_the_window_is_no_lock() {
    // A tenth of the nominal Q of 65.
    for (q, locks) in [(8.0, true), (5.0, false)] {
        let mut rig = Rig::new(NOMINAL_HZ, q);
        rig.observed.start(&prior(0.0, WINDOW_HZ, 65.0), Retry::Window);
        assert_eq!(rig.locks(200).is_some(), locks, "Q {q}");
    }
    for (off, locks) in [(980.0, true), (-980.0, true), (1030.0, false), (-1030.0, false)] {
        assert_eq!(Rig::new(NOMINAL_HZ + off, 65.0).locks(200).is_some(), locks, "{off} Hz");
    }
}

#[test]
fn it_has_taken_too_long_after_128_driven_blocks() {
    let mut rig = Rig::new(NOMINAL_HZ, 65.0);
    (0..50).for_each(|_| rig.tick(true, |played| played.driven = false));
    (0..128).for_each(|_| rig.tick(false, |_| {}));
    assert!(!rig.observed.timed_out());
    rig.tick(false, |_| {});
    assert!(rig.observed.timed_out());
    rig.observed.start(&prior(0.0, WINDOW_HZ, 65.0), Retry::Window);
    assert!(!rig.observed.timed_out());
}

#[test]
fn a_new_lock_that_stands_at_the_edge_of_the_window_was_none() {
    let mut rig = Rig::new(NOMINAL_HZ + 2.0 * f64::from(WINDOW_HZ), 65.0);
    rig.observed.shown_hz = WINDOW_HZ;
    (0..AT_EDGE).for_each(|_| rig.observed.follow(Phasor::default(), Phasor::default(), &SILENT_AT_EDGE, true));
    assert!(!rig.observed.is_astray());
    rig.observed.follow(Phasor::default(), Phasor::default(), &SILENT_AT_EDGE, true);
    assert!(rig.observed.is_astray());
    // Within the window nothing stands at its edge.
    rig.observed.shown_hz = 0.9 * WINDOW_HZ;
    rig.observed.follow(Phasor::default(), Phasor::default(), &SILENT_AT_EDGE, true);
    assert!(!rig.observed.is_astray());
    rig.observed.blocks = 0;
    (0..=AT_EDGE).for_each(|_| rig.observed.follow(Phasor::default(), Phasor::default(), &SILENT_AT_EDGE, true));
    assert!(!rig.observed.is_astray());
    (rig.observed.shown_hz, rig.observed.blocks) = (WINDOW_HZ, 0);
    (0..=AT_EDGE).for_each(|_| rig.observed.follow(Phasor::default(), Phasor::default(), &SILENT_AT_EDGE, true));
    assert!(rig.observed.is_astray());
    // One that has lasted is at a resonance that has gone there.
    rig.observed.blocks = TIMEOUT + AT_EDGE;
    assert!(!rig.observed.is_astray());
    rig.observed.start(&prior(0.0, WINDOW_HZ, 65.0), Retry::Window);
    assert!(!rig.observed.is_astray());
}

#[test]
fn a_lost_lock_is_sought_nearby_then_in_the_window_then_from_the_self_test_on_and_then_by_a_scan() {
    let mut rig = Rig::new(NOMINAL_HZ + 400.0, 65.0);
    assert!(rig.locks(60).is_some() && rig.observed.has_a_scan_left());
    // A lock that has lasted is sought where it was, one that has not is not.
    rig.observed.blocks = LASTED + 1;
    assert_eq!(rig.observed.retry_lock(true), Some(Retry::Nearby));
    // It knows where: 200 Hz about it, and nothing is locked yet.
    let observed = &rig.observed;
    assert!((observed.offset_hz().unwrap() - 400.0).abs() < 20.0 && !observed.locked());
    assert!((observed.observer().deviation_hz() - 200.0 / 2f32.sqrt()).abs() < 1.0, "{}", observed.observer().deviation_hz());
    rig.observed.blocks = LASTED;
    assert_eq!(rig.observed.retry_lock(true), Some(Retry::Window));
    let observed = &rig.observed;
    assert_eq!((observed.offset_hz(), observed.blocks), (Some(0.0), 0));
    assert!((observed.observer().deviation_hz() - WINDOW_HZ / 2f32.sqrt()).abs() < 1.0, "{}", observed.observer().deviation_hz());
    rig.observed.blocks = LASTED + 1;
    assert_eq!(rig.observed.retry_lock(false), Some(Retry::Calibrate));
    assert!(rig.observed.has_a_scan_left());
    assert_eq!(rig.observed.retry_lock(false), Some(Retry::Scan));
    assert!(!rig.observed.has_a_scan_left());
    assert_eq!(rig.observed.retry_lock(false), None);
}

#[test]
fn what_was_known_of_the_window_is_kept_for_the_next_time() {
    let mut rig = Rig::new(NOMINAL_HZ, 65.0);
    rig.observed.start(&prior(50.0, 20.0, 30.0), Retry::Nearby);
    assert_eq!((rig.observed.prior.q, rig.observed.prior.offset_hz), (65.0, (0.0, WINDOW_HZ)));
    rig.observed.start(&prior(50.0, 20.0, 30.0), Retry::Scan);
    assert_eq!((rig.observed.prior.q, rig.observed.prior.offset_hz), (30.0, (0.0, WINDOW_HZ)));
}

#[test]
fn silence_moves_nothing_and_is_no_resonance() {
    let mut rig = Rig::new(NOMINAL_HZ + 300.0, 65.0);
    (0..100).for_each(|_| rig.tick(true, |_| {}));
    let before = rig.observed.observer().offset_hz();
    let silent =
        PlayedBlock { offset_hz: before, volts: 3.0, envelope: Some(0.0), pure: true, on: false, driven: false, rung_up: false };
    for _ in 0..100 {
        rig.observed.follow(Phasor::default(), Phasor::default(), &silent, true);
        assert!(!rig.observed.observer().has_opened());
    }
    let moved = rig.observed.observer().offset_hz() - before;
    assert!(moved.abs() < 0.1, "{moved} Hz");
}

#[test]
fn a_scan_is_left_once() {
    let mut rig = Rig::new(NOMINAL_HZ, 65.0);
    assert!(rig.observed.has_a_scan_left() && rig.observed.leave_to_a_scan());
    assert!(!rig.observed.has_a_scan_left() && !rig.observed.leave_to_a_scan());
    // A new attempt has come from none, and what was locked is not.
    let mut locked = Rig::new(NOMINAL_HZ, 65.0);
    assert!(locked.locks(60).is_some());
    locked.observed.restart();
    assert!(!locked.observed.locked() && !locked.observed.has_converged() && !locked.observed.has_a_scan_left());
}

#[test]
fn a_cold_start_is_nearby_or_in_the_window_by_what_is_known() {
    let begins = |seek: Retry, deviation_hz: f32| {
        let mut observed = Observed::new(NOMINAL_HZ as f32, BLOCK_S as f32, WINDOW_HZ);
        observed.seek = seek;
        observed.start_cold(&prior(50.0, deviation_hz, 65.0));
        (observed.seek, observed.prior.offset_hz, observed.offset_hz())
    };
    // Later it is sought in the whole window.
    let whole = (0.0, WINDOW_HZ);
    assert_eq!(begins(Retry::Scan, 999.0), (Retry::Nearby, whole, Some(50.0)));
    assert_eq!(begins(Retry::Scan, 1000.0), (Retry::Window, whole, Some(50.0)));
    assert_eq!(begins(Retry::Window, 10.0), (Retry::Nearby, whole, Some(50.0)));
    // The second time after a lock was lost it leads to a scan.
    assert_eq!(begins(Retry::Calibrate, 10.0), (Retry::Calibrate, whole, Some(50.0)));
}

#[test]
fn a_quality_factor_that_was_measured_is_passed_on() {
    let mut rig = Rig::new(NOMINAL_HZ, 65.0);
    (0..300).for_each(|_| rig.tick(true, |_| {}));
    let before = rig.observed.observer().lm_h();
    rig.observed.take_q((58.5, 0.1));
    assert!((rig.observed.observer().lm_h() / before - 0.9).abs() < 0.01);
}
