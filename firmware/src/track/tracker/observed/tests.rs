//! Tests from a start to a lock with the exact envelope of a resonance, and of the attempts after a
//! lost lock.

use num_complex::Complex64;

use super::*;

const NOMINAL_HZ: f64 = 40e3;
const BLOCK_S: f64 = 32e-6;
const LM_H: f64 = 0.8e-3;
const WINDOW_HZ: f32 = 1000.0;

/// A block at the edge of the window in which nothing is measured.
const SILENT_AT_EDGE: PlayedBlock =
    PlayedBlock { offset_hz: WINDOW_HZ, volts: 3.0, envelope: Some(1.0), pure: false, on: true, driven: true, rung_up: false };

fn prior(offset_hz: f32, deviation_hz: f32, q: f32) -> Prior {
    let lm_h = (LM_H as f32, 0.05 * LM_H as f32);
    Prior { offset_hz: (offset_hz, deviation_hz), q, lm_h, axis: Phasor::new(1.0, 0.0), noise_a: 5e-4 }
}

fn exp(x: Complex64) -> Complex64 {
    Complex64::new(x.im.cos(), x.im.sin()) * x.re.exp()
}

/// A resonance driven with 3 V at the observer's frequency, with a delay of two blocks.
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

    /// Runs one block. `change` modifies the description of the played block.
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

    /// Returns the number of blocks until the lock, if within `blocks`.
    fn locks(&mut self, blocks: usize) -> Option<usize> {
        (1..=blocks).find(|_| {
            self.tick(true, |_| {});
            self.observed.locked()
        })
    }
}

#[test]
fn it_finds_the_resonance_and_locks_after_eight_good_blocks() {
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
fn contradicting_phases_and_silent_blocks_do_not_count() {
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
    // A lock is kept if one block contradicts it, but convergence is not.
    rig.tick(false, |_| {});
    assert!(rig.observed.locked() && !rig.observed.has_converged());
}

#[test]
fn without_a_sine_the_phase_loop_sets_the_frequency() {
    let mut rig = Rig::new(NOMINAL_HZ, 65.0);
    assert!(rig.locks(60).is_some() && rig.observed.offset_hz().is_some());
    rig.tick(true, |played| played.pure = false);
    assert!(rig.observed.offset_hz().is_none() && !rig.observed.is_confident() && !rig.observed.has_converged());
    rig.tick(true, |_| {});
    assert!(rig.observed.offset_hz().is_some());
}

#[test]
fn only_a_good_estimate_is_followed() {
    // The bound is half a per cent of the nominal frequency: a deviation of 200 Hz.
    let mut rig = Rig::new(NOMINAL_HZ + 400.0, 65.0);
    for _ in 0..12 {
        let before = rig.observed.offset_hz();
        rig.tick(true, |_| {});
        let moved = rig.observed.offset_hz() != before;
        assert_eq!(moved, rig.observed.observer().deviation_hz() < 200.0, "block {}", rig.block);
    }
}

#[test]
fn no_lock_if_too_damped_or_beyond_the_window() {
    // The bound is a tenth of the nominal Q of 65.
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
fn it_times_out_after_128_driven_blocks() {
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
fn a_new_lock_at_the_edge_of_the_window_is_false() {
    let mut rig = Rig::new(NOMINAL_HZ + 2.0 * f64::from(WINDOW_HZ), 65.0);
    rig.observed.followed_hz = WINDOW_HZ;
    (0..EDGE_BLOCKS).for_each(|_| rig.observed.follow(Phasor::default(), Phasor::default(), &SILENT_AT_EDGE, true));
    assert!(!rig.observed.is_astray());
    rig.observed.follow(Phasor::default(), Phasor::default(), &SILENT_AT_EDGE, true);
    assert!(rig.observed.is_astray());
    // A lock within the window is not astray.
    rig.observed.followed_hz = 0.9 * WINDOW_HZ;
    rig.observed.follow(Phasor::default(), Phasor::default(), &SILENT_AT_EDGE, true);
    assert!(!rig.observed.is_astray());
    rig.observed.blocks = 0;
    (0..=EDGE_BLOCKS).for_each(|_| rig.observed.follow(Phasor::default(), Phasor::default(), &SILENT_AT_EDGE, true));
    assert!(!rig.observed.is_astray());
    (rig.observed.followed_hz, rig.observed.blocks) = (WINDOW_HZ, 0);
    (0..=EDGE_BLOCKS).for_each(|_| rig.observed.follow(Phasor::default(), Phasor::default(), &SILENT_AT_EDGE, true));
    assert!(rig.observed.is_astray());
    // A resonance may drift to the edge after a long lock.
    rig.observed.blocks = TIMEOUT_BLOCKS + EDGE_BLOCKS;
    assert!(!rig.observed.is_astray());
    rig.observed.start(&prior(0.0, WINDOW_HZ, 65.0), Retry::Window);
    assert!(!rig.observed.is_astray());
}

#[test]
fn retries_are_nearby_window_self_test_scan() {
    let mut rig = Rig::new(NOMINAL_HZ + 400.0, 65.0);
    assert!(rig.locks(60).is_some() && rig.observed.can_scan());
    // A lock that has lasted is sought nearby; a shorter one is not.
    rig.observed.blocks = LASTED_BLOCKS + 1;
    assert_eq!(rig.observed.retry_lock(true), Some(Retry::Nearby));
    // The prior is 200 Hz around the lost lock; nothing is locked yet.
    let observed = &rig.observed;
    assert!((observed.offset_hz().unwrap() - 400.0).abs() < 20.0 && !observed.locked());
    assert!((observed.observer().deviation_hz() - 200.0 / 2f32.sqrt()).abs() < 1.0, "{}", observed.observer().deviation_hz());
    rig.observed.blocks = LASTED_BLOCKS;
    assert_eq!(rig.observed.retry_lock(true), Some(Retry::Window));
    let observed = &rig.observed;
    assert_eq!((observed.offset_hz(), observed.blocks), (Some(0.0), 0));
    assert!((observed.observer().deviation_hz() - WINDOW_HZ / 2f32.sqrt()).abs() < 1.0, "{}", observed.observer().deviation_hz());
    rig.observed.blocks = LASTED_BLOCKS + 1;
    assert_eq!(rig.observed.retry_lock(false), Some(Retry::Calibrate));
    assert!(rig.observed.can_scan());
    assert_eq!(rig.observed.retry_lock(false), Some(Retry::Scan));
    assert!(!rig.observed.can_scan());
    assert_eq!(rig.observed.retry_lock(false), None);
}

#[test]
fn the_prior_of_the_window_is_kept_for_the_next_attempt() {
    let mut rig = Rig::new(NOMINAL_HZ, 65.0);
    rig.observed.start(&prior(50.0, 20.0, 30.0), Retry::Nearby);
    assert_eq!((rig.observed.prior.q, rig.observed.prior.offset_hz), (65.0, (0.0, WINDOW_HZ)));
    rig.observed.start(&prior(50.0, 20.0, 30.0), Retry::Scan);
    assert_eq!((rig.observed.prior.q, rig.observed.prior.offset_hz), (30.0, (0.0, WINDOW_HZ)));
}

#[test]
fn silence_does_not_move_the_estimate() {
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
fn a_lock_is_handed_over_to_a_scan_once() {
    let mut rig = Rig::new(NOMINAL_HZ, 65.0);
    assert!(rig.observed.can_scan() && rig.observed.hand_over_to_scan());
    assert!(!rig.observed.can_scan() && !rig.observed.hand_over_to_scan());
    // After a reset there is neither a lock nor another scan.
    let mut locked = Rig::new(NOMINAL_HZ, 65.0);
    assert!(locked.locks(60).is_some());
    locked.observed.restart();
    assert!(!locked.observed.locked() && !locked.observed.has_converged() && !locked.observed.can_scan());
}

#[test]
fn a_cold_start_is_nearby_if_the_prior_is_narrow() {
    let begins = |seek: Retry, deviation_hz: f32| {
        let mut observed = Observed::new(NOMINAL_HZ as f32, BLOCK_S as f32, WINDOW_HZ);
        observed.seek = seek;
        observed.start_cold(&prior(50.0, deviation_hz, 65.0));
        (observed.seek, observed.prior.offset_hz, observed.offset_hz())
    };
    // The next attempt uses the whole window.
    let whole = (0.0, WINDOW_HZ);
    assert_eq!(begins(Retry::Scan, 999.0), (Retry::Nearby, whole, Some(50.0)));
    assert_eq!(begins(Retry::Scan, 1000.0), (Retry::Window, whole, Some(50.0)));
    assert_eq!(begins(Retry::Window, 10.0), (Retry::Nearby, whole, Some(50.0)));
    // The second attempt after a lost lock leads to a scan.
    assert_eq!(begins(Retry::Calibrate, 10.0), (Retry::Calibrate, whole, Some(50.0)));
}

#[test]
fn a_measured_quality_factor_is_passed_on() {
    let mut rig = Rig::new(NOMINAL_HZ, 65.0);
    (0..300).for_each(|_| rig.tick(true, |_| {}));
    let before = rig.observed.observer().lm_h();
    rig.observed.take_q((58.5, 0.1));
    assert!((rig.observed.observer().lm_h() / before - 0.9).abs() < 0.01);
}
