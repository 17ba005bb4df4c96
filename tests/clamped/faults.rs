//! Defects of a transducer or its wiring: the fault numbers, and the detection times.

use firmware::controller::Controller;
use firmware::seam::block::{DriveBlock, Gate, Orders, Request, SenseBlock};
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use hal_mock::analog::Analog;
use hal_mock::block_clock::BlockClock;
use plant::Plant;
use scene::load::load;
use scene::settings;

use super::power_on::calibrate;
use super::rig::{Case, Rig};

/// Number of random seeds per case.
const SEEDS: u64 = 12;
/// Required detection time of 60 ms in blocks, in which every explanation of the measurement is
/// tried.
const DETECTION_BLOCKS: u64 = 1875;

/// Checks that each seed ends with this fault. Returns the largest number of blocks.
fn ends_with(fault: Fault, case: &Case) -> u64 {
    let ends = (1..=SEEDS).map(|seed| {
        let (found, blocks) = calibrate(&mut Rig::new(case, seed));
        assert_eq!(found.err(), Some(Some(fault)), "seed {seed} of {case:?}");
        blocks
    });
    let blocks = ends.max().unwrap();
    println!("{fault:?}: {:.1} ms", blocks as f64 * 0.032);
    blocks
}

#[test]
fn a_depoled_stack_is_a_shifted_capacitance() {
    for q in [20.0, 65.0, 500.0] {
        let depoled = Case { c0_f: 200e-9, cm_f: 0.2e-9, nominal_c0: 1.5, q, ..Case::default() };
        assert!(ends_with(Fault::CapacitanceShifted, &depoled) < 1400);
        for nominal_c0 in [1.5, 0.7] {
            assert!(ends_with(Fault::CapacitanceShifted, &Case { nominal_c0, q, ..Case::default() }) < DETECTION_BLOCKS);
        }
    }
    for nominal_c0 in [1.25, 0.8] {
        let (found, _) = calibrate(&mut Rig::new(&Case { nominal_c0, ..Case::default() }, 1));
        assert!(found.is_ok(), "{found:?}");
    }
}

/// Q falls to a fifth; a second resonance is 1.5 % lower, with a fifth of the strength.
#[test]
fn a_cracked_stack_is_damaged() {
    for q in [65.0, 200.0, 500.0] {
        let case = Case { q: q / 5.0, nominal_q: 5.0, second: Some((0.2, 0.985)), ..Case::default() };
        assert!(ends_with(Fault::ResonanceDamaged, &case) < DETECTION_BLOCKS);
    }
}

/// A resonance that is too weak to be detected off resonance may still exist.
#[test]
fn a_stack_without_its_resonance_is_left_to_a_scan() {
    for (cm_f, seed) in [20e-13, 20e-15].into_iter().flat_map(|cm_f| (1..=SEEDS).map(move |seed| (cm_f, seed))) {
        let (found, blocks) = calibrate(&mut Rig::new(&Case { cm_f, ..Case::default() }, seed));
        assert!(found == Err(None) && blocks < 2000, "{found:?} after {blocks} blocks");
    }
}

/// Plant whose sense codes are changed by its wiring.
struct Wired<F> {
    plant: Plant,
    wiring: F,
}

impl<F: FnMut(&mut SenseBlock)> Analog for Wired<F> {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        self.plant.exchange(drive, sense);
        (self.wiring)(sense);
    }
}

/// Returns the fault at the end of a run, and the number of blocks from the first driven one.
fn end_of_run(wiring: impl FnMut(&mut SenseBlock)) -> (Option<Fault>, u64) {
    let scene = load("lock", &[]).unwrap_or_else(|error| panic!("{error}")).scene;
    let scene = scene.driven().unwrap();
    let mut controller = Controller::build(&settings::config(&scene)).unwrap();
    let mut clock = BlockClock::new(Wired { plant: Plant::new(&scene), wiring }, &controller.silence());
    let orders = Orders { gate: Gate::On, sequence: 1, attempt: 1, request: Request::Run, ..Orders::default() };
    let mut driven = 0;
    loop {
        let report = clock.tick(|sense, drive| controller.process(&orders, sense, drive));
        driven += u64::from(report.drive.0 > 0.0 || driven > 0);
        if report.fault.is_some() || matches!(report.mode, Mode::Scan | Mode::Run) {
            return (report.fault, driven);
        }
    }
}

#[test]
fn swapped_channels_are_identified() {
    let swapped = end_of_run(|sense| std::mem::swap(&mut sense.v, &mut sense.i));
    // Four blocks, after the latency of two.
    assert_eq!(swapped, (Some(Fault::SenseSwapped), 6), "{swapped:?}");
    let reversed = end_of_run(|sense| sense.i.iter_mut().for_each(|code| *code = 8190 - *code));
    assert_eq!(reversed, (Some(Fault::SenseSwapped), 6), "{reversed:?}");
    assert_eq!(end_of_run(|_| ()).0, None);
}

#[test]
fn a_saturated_channel_is_identified_in_its_block() {
    let mut blocks = 0;
    let saturated = end_of_run(|sense| {
        blocks += 1;
        if blocks > 50 {
            sense.v.iter_mut().take(5).for_each(|code| *code = 8190);
        }
    });
    assert_eq!(saturated.0, Some(Fault::SenseSaturated));
    assert_eq!(blocks, 51);
}
