use super::*;
use crate::generate::sweep::hold::Hold;
use crate::seam::block::MAX_LANES;
use crate::seam::config::{
    Burst, Direction, Drive, FrontEnd, HeatSink, Limits, Link, Phasing as PhasingConfig, Supply, Sweep, Thermometer, Tracking,
    TrackingMode,
};
use crate::seam::phasor::Phasor;

const VOLTS: f32 = 3.0;
const BLOCK_S: f32 = 32e-6;
const CLAMPED: f32 = 0.05;
const EXPECTED: Expected = Expected { quadrature: 0.25, gain: 1.0, clamped_siemens: CLAMPED };

fn config(lanes: u8) -> Config {
    Config {
        sample_hz: 1e6,
        block_samples: 32,
        lanes,
        front_end: FrontEnd::OF_TESTS,
        drive: Drive::sine(40_000.0, crate::seam::block::Amplitude::Volts(VOLTS), VOLTS),
        sweep: Sweep::Hold,
        phasing: PhasingConfig { direction: Direction::Forward, ..PhasingConfig::default() },
        burst: Burst::default(),
        tracking: Tracking { mode: TrackingMode::Off, nominal_c0_f: Some(200e-9), ..Tracking::new(50.0) },
        thermometer: Thermometer::default(),
        heat_sink: HeatSink::default(),
        supply: Supply::default(),
        limits: Limits { voltage_v: 12.0, ..Limits::default() },
        friction: None,
        restraint: None,
        link: Link::default(),
    }
}

/// Measured values of each lane: relative voltage error, and admittance, S.
#[derive(Clone, Copy)]
struct Motor {
    errors: [Phasor; MAX_LANES],
    siemens: [Phasor; MAX_LANES],
}

const HEALTHY: Motor = Motor { errors: [Phasor::new(1.0, 0.0); 4], siemens: [Phasor::new(0.1, CLAMPED); 4] };

/// Monitor with the latency of a board, and with a multiplexer that outputs nothing while it
/// switches.
struct Bench {
    lanes: Lanes,
    motor: Motor,
    /// Lane and quadrature of the pending blocks.
    coming: std::collections::VecDeque<(u8, f32)>,
    /// Commanded quadrature, turns.
    quadrature: f32,
    shown: (u8, u32),
    /// Blocks without a measurement of lane 0.
    away: u32,
    visits: [u32; MAX_LANES],
}

impl Bench {
    fn new(count: u8, motor: Motor) -> Self {
        let mut lanes = Lanes::build(&config(count), BLOCK_S);
        lanes.begin();
        Bench {
            lanes,
            motor,
            coming: [(0, 0.25); LATENCY_BLOCKS].into(),
            quadrature: 0.25,
            shown: (0, u32::MAX),
            away: 0,
            visits: [0; 4],
        }
    }

    fn block(&mut self, rule: Rule) -> Option<Fault> {
        let (lane, quadrature) = self.coming.pop_front().unwrap();
        self.shown = if lane == self.shown.0 { (lane, self.shown.1.saturating_add(1)) } else { (lane, 1) };
        let n = usize::from(lane);
        let turn = sine::rotation(u64::from(Phasing::offsets(quadrature)[n]) << 32);
        let v = turn * self.motor.errors[n] * VOLTS;
        let mut sensed = Sensed { v, i: v * self.motor.siemens[n] };
        if self.shown.1 < SWITCH_BLOCKS {
            sensed = Sensed { v: Phasor::new(-7.0, 3.0), i: Phasor::new(0.0, 0.0) };
        }
        if self.shown.1 == 1 {
            self.visits[n] += 1;
        }
        let hold = Hold::build(40e3, 1e6).unwrap();
        let played = Played { volts: VOLTS, envelope: 1.0, audible: (lane == 0).then_some(1.0), lane, ..Played::at_rest(&hold) };
        let expected = Expected { quadrature: self.quadrature, ..EXPECTED };
        let before = self.lanes.found();
        self.lanes.update(&played, &mut sensed, rule, &expected);
        let found = self.lanes.found().filter(|_| before.is_none());
        assert!(found.is_none() || self.lanes.are_heard(), "a fault is found in a block of another lane only");
        self.away += u32::from(self.lanes.are_heard());
        let home = self.motor.errors[0] * VOLTS;
        assert!((sensed.v - home).norm_sqr() < 1e-6, "the loops receive lane 0: {sensed:?}");
        self.coming.push_back((self.lanes.ordered(), self.quadrature));
        found
    }

    /// Runs until a fault is found; returns the number of blocks and the fault.
    fn finds(&mut self, rule: Rule, blocks: u32) -> Option<(u32, Fault)> {
        (1..=blocks).find_map(|block| self.block(rule).map(|fault| (block, fault)))
    }
}

fn with(lane: usize, change: impl Fn(&mut Phasor, &mut Phasor)) -> Motor {
    let mut motor = HEALTHY;
    change(&mut motor.errors[lane], &mut motor.siemens[lane]);
    motor
}

#[test]
fn each_round_visits_every_lane_for_ten_blocks() {
    let mut bench = Bench::new(4, HEALTHY);
    // The first round visits all lanes in one go and returns to lane 0 once.
    assert_eq!(bench.finds(Rule::InTurn, 60), None);
    assert_eq!((&bench.visits[1..], bench.away), (&[1; 3][..], 22));
    // 365 ms contain ten rounds of 36 ms and their visits.
    assert_eq!(bench.finds(Rule::InTurn, 11_440), None);
    assert!(bench.visits[1..].iter().all(|&visits| visits == 11), "{:?}", bench.visits);
    assert_eq!(bench.away, 22 + 10 * 30);
    std::println!("{:.2} % of the blocks are of another lane or of the way back", 100.0 * 300.0 / 11_440.0);
    let unwatched = Config { phasing: PhasingConfig { watch: false, ..PhasingConfig::default() }, ..config(4) };
    assert!(!Lanes::build(&unwatched, BLOCK_S).are_several());
    assert_eq!((Bench::new(1, HEALTHY).lanes.are_several(), Bench::new(2, HEALTHY).lanes.are_several()), (false, true));
}

#[test]
fn lane_faults_are_found_within_a_round() {
    let off = |degrees: f32, gain: f32| {
        sine::rotation((f64::from(degrees) / 360.0 * 18_446_744_073_709_551_616.0) as i128 as u64) * gain
    };
    for lane in 1..4 {
        for (error, siemens, expected) in [
            (off(180.0, 1.0), None, Fault::LaneImplausible),
            (off(46.0, 1.0), None, Fault::LaneImplausible),
            (off(-46.0, 1.0), None, Fault::LaneImplausible),
            (off(0.0, 0.7), None, Fault::LaneImplausible),
            (off(0.0, 1.42), None, Fault::LaneImplausible),
            (Phasor::new(0.0, 0.0), None, Fault::LaneImplausible),
            (Phasor::new(f32::NAN, 0.0), None, Fault::LaneImplausible),
            (off(0.0, 1.0), Some(Phasor::new(0.0, 0.0)), Fault::LaneOpen),
            (off(0.0, 1.0), Some(Phasor::new(0.0, 0.24 * CLAMPED)), Fault::LaneOpen),
        ] {
            let mut bench = Bench::new(4, HEALTHY);
            assert_eq!(bench.finds(Rule::InTurn, 500), None);
            bench.motor = with(lane, |e, y| (*e, *y) = (error, siemens.unwrap_or(*y)));
            let found = bench.finds(Rule::InTurn, 1250);
            assert!(found.is_some_and(|(_, fault)| fault == expected), "{lane} {error} {siemens:?}: {found:?}");
        }
        for (error, siemens) in [
            (off(44.0, 1.0), None),
            (off(-44.0, 0.72), None),
            (off(0.0, 1.4), None),
            (off(0.0, 1.0), Some(Phasor::new(0.0, 0.26 * CLAMPED))),
        ] {
            let mut bench = Bench::new(4, with(lane, |e, y| (*e, *y) = (error, siemens.unwrap_or(*y))));
            assert_eq!(bench.finds(Rule::InTurn, 2500), None, "{lane} {error} {siemens:?}");
        }
    }
}

/// The gain of a lane may be the trimmed one, or one if the trim corrects an error.
#[test]
fn a_gain_may_be_that_of_the_trims() {
    for (error, fine) in [(0.5, true), (1.0, true), (0.34, false), (1.43, false)] {
        let lanes = Bench::new(4, HEALTHY).lanes;
        let lanes = Lanes { home: Sensed { v: Phasor::new(VOLTS, 0.0), i: Phasor::new(0.1, 0.0) }, home_volts: VOLTS, ..lanes };
        let v = Phasor::new(0.0, VOLTS * error);
        let played = Played { volts: VOLTS, lane: 1, ..Played::default() };
        let found = lanes.judge(&Sensed { v, i: v * CLAMPED }, &played, &Expected { gain: 0.5, ..EXPECTED });
        assert_eq!(found.is_none(), fine, "{error}");
    }
}

#[test]
fn a_self_test_visits_all_lanes_once_for_each_tone() {
    let mut bench = Bench::new(4, HEALTHY);
    for tone in 1..3 {
        (0..20).for_each(|_| assert_eq!(bench.block(Rule::Rest), None));
        assert_eq!(bench.finds(Rule::Once, 64), None);
        assert_eq!(bench.visits[1..], [tone; 3]);
        assert!(!bench.lanes.are_heard(), "lane 0 is connected for the measurement at the end of the self-test");
    }
    // The fault is reported at the end of the self-test, and no other lane is visited.
    let mut bench = Bench::new(4, with(2, |error, _| *error = -*error));
    (0..20).for_each(|_| assert_eq!(bench.block(Rule::Rest), None));
    assert!(bench.finds(Rule::Once, 40).is_some_and(|(block, fault)| fault == Fault::LaneImplausible && block < 32));
    assert_eq!((bench.finds(Rule::Once, 40), bench.lanes.found(), bench.visits[3]), (None, Some(Fault::LaneImplausible), 0));
}

#[test]
fn a_visit_ends_with_the_burst_and_waits_for_the_next_one() {
    let mut bench = Bench::new(4, HEALTHY);
    for _ in 0..100 {
        (0..20).for_each(|_| assert_eq!(bench.block(Rule::InTurn), None));
        (0..20).for_each(|_| assert_eq!(bench.block(Rule::Rest), None));
    }
    assert_eq!(bench.visits[1..], [0; 3], "no visits in bursts shorter than 32 blocks");
    (0..33).for_each(|_| assert_eq!(bench.block(Rule::InTurn), None));
    assert_ne!(bench.lanes.ordered(), 0);
    (0..10).for_each(|_| assert_eq!(bench.block(Rule::Rest), None));
    assert!(bench.lanes.ordered() == 0 && !bench.lanes.are_heard());
}

#[test]
fn resonance_fault_waits_for_all_lanes_with_a_limit() {
    let mut bench = Bench::new(4, HEALTHY);
    bench.finds(Rule::InTurn, 100);
    let fault = Fault::LossOfLock;
    let waits = |bench: &mut Bench| bench.lanes.judged(false, fault) == Progress::Busy;
    let waited = (0..200).take_while(|_| waits(&mut bench) && bench.block(Rule::InTurn).is_none()).count();
    assert!((18..40).contains(&waited), "{waited}");
    assert_eq!(bench.lanes.judged(false, fault), Progress::Failed(fault), "all lanes have been judged");
    // Between bursts the lanes cannot be judged.
    bench.lanes.doubt(false);
    let waited = (0..200).take_while(|_| waits(&mut bench) && bench.block(Rule::Rest).is_none()).count();
    assert_eq!(waited, usize::from(MAX_POSTPONED_BLOCKS) - 1);
    // Before a run, or with one lane, there is no delay.
    for (locking, lanes) in [(true, 4), (false, 1)] {
        assert_eq!(Bench::new(lanes, HEALTHY).lanes.judged(locking, fault), Progress::Failed(fault));
    }
}

/// A change of direction takes two blocks to take effect; until then the lanes are unchanged.
#[test]
fn change_of_direction_is_not_a_lane_fault() {
    for at in 0..40 {
        let mut bench = Bench::new(4, HEALTHY);
        assert_eq!(bench.finds(Rule::InTurn, 25 + at), None);
        bench.quadrature = -0.25;
        assert_eq!(bench.finds(Rule::InTurn, 60), None, "{at}");
        assert_eq!(bench.visits[1], 1);
    }
}
