//! Tests of counters that wrap: the number of the block as reported, and the numbers of orders. And
//! of the start of a tone.

mod guarded;

use super::*;
use crate::board::parameters::PARAMETERS;
use crate::board::parameters::tests::config;
use crate::seam::block::{Gate, Request};
use crate::seam::config::Config;

/// A capacitor in parallel with a series resonance, at the converters of [`config`], one sample at
/// a time.
#[derive(Default)]
struct Resonator {
    drive_v: f64,
    current_a: f64,
    charge_c: f64,
}

impl Resonator {
    const C0_F: f64 = 300e-9;
    const LM_H: f64 = 0.6e-3;
    const CM_F: f64 = 26.4e-9;
    const RM_OHM: f64 = 3.0;
    const SAMPLE_S: f64 = 1e-6;

    fn exchange(&mut self, drive: &DriveBlock) -> SenseBlock {
        let mut sense = SenseBlock::default();
        for &code in &drive.lanes[usize::from(drive.listen)] {
            let before_v = core::mem::replace(&mut self.drive_v, (f64::from(code) - 2048.0) * 0.008);
            let slope = self.drive_v - self.charge_c / Self::CM_F - Self::RM_OHM * self.current_a;
            self.current_a += Self::SAMPLE_S / Self::LM_H * slope;
            self.charge_c += Self::SAMPLE_S * self.current_a;
            let current_a = self.current_a + Self::C0_F * (self.drive_v - before_v) / Self::SAMPLE_S;
            let code = |value: f64| (4096.0 + value).clamp(0.0, 8190.0) as u16;
            sense.v.push(code(self.drive_v / 0.005)).unwrap();
            sense.i.push(code(current_a / 0.001)).unwrap();
        }
        sense
    }
}

/// Returns a configuration with bursts, so that the sample clock matters.
fn in_bursts() -> Config {
    let mut config = config();
    for (name, value) in [("burst.period_s", 0.005), ("burst.duty", 0.5)] {
        let parameter = PARAMETERS.iter().find(|parameter| parameter.name == name).unwrap();
        (parameter.write)(&mut config, value);
    }
    config
}

/// Runs from block `first` and order `order`; returns the codes and reports.
fn run(first: u64, order: u32, blocks: usize) -> std::vec::Vec<(DriveBlock, Telemetry)> {
    let mut controller = Controller::build(&in_bursts()).unwrap();
    controller.chain.block = first;
    let mut queue = [controller.silence(), controller.silence()];
    let mut load = Resonator::default();
    let mut played = std::vec::Vec::new();
    for n in 0..blocks {
        // The attempt number increases in the middle of the run, the order number every 1000
        // blocks.
        let steps = (n / 1000) as u32 + 1;
        let orders = Orders {
            sequence: order.wrapping_add(steps),
            attempt: order.wrapping_add(1 + u32::from(n > blocks / 2)),
            request: if (blocks / 2 - 100..blocks / 2).contains(&n) { Request::Idle } else { Request::Run },
            gate: Gate::Scheduled,
            ..Orders::default()
        };
        let sense = load.exchange(&queue[n % 2]);
        let report = controller.process(&orders, &sense, &mut queue[n % 2]);
        played.push((queue[n % 2].clone(), report));
    }
    played
}

#[test]
fn wrapping_block_and_order_numbers_change_nothing_else() {
    const BLOCKS: usize = 12_000;
    let far = run(0, 0, BLOCKS);
    // Both halves must reach `Run` and play bursts, otherwise the test shows nothing.
    for half in far.chunks(BLOCKS / 2) {
        assert!(half.iter().any(|(_, report)| report.mode == Mode::Run), "{:?}", half.last().map(|(_, report)| report));
        assert!(half.iter().any(|(drive, _)| drive.lanes[0].iter().any(|&code| code.abs_diff(2048) > 300)));
    }
    // Multiples of 64, so that the work of every 64th block is in the same blocks.
    for first in [(1 << 32) - 64, (1 << 32) - 6016, (1 << 33) - 128] {
        let order = u32::MAX - 5;
        let near = run(first, order, BLOCKS);
        for (n, ((drive, report), (far_drive, far_report))) in near.iter().zip(&far).enumerate() {
            assert_eq!(report.block, (first as u32).wrapping_add(far_report.block), "block {n}");
            assert_eq!(report.orders_sequence, order.wrapping_add(far_report.orders_sequence), "block {n}");
            let alike = Telemetry { block: far_report.block, orders_sequence: far_report.orders_sequence, ..*report };
            assert!(drive == far_drive && alike == *far_report, "block {n} from {first}: {report:?}, {far_report:?}");
        }
    }
}

/// In both attempts: a voltage step draws a peak of current into the clamped capacitance, however
/// small the drive is.
#[test]
fn a_scan_begins_at_zero() {
    // The silence before the scan compensates the self-test's volt-seconds by a constant code.
    let is_silent = |drive: &DriveBlock| drive.lanes[0].iter().all(|code| *code == drive.lanes[0][0]);
    let mut began = 0;
    for [(before, _), (drive, report)] in run(0, 0, 12_000).array_windows() {
        if report.mode == Mode::Scan && is_silent(before) && !is_silent(drive) {
            let (first, largest) = (drive.lanes[0][0], drive.lanes[0].iter().map(|code| code.abs_diff(2048)).max());
            assert!(first == 2048 && largest > Some(100), "{:?}", drive.lanes[0]);
            began += 1;
        }
    }
    assert_eq!(began, 2);
}

/// A run that another order ends, at any phase, with any waveform and in every lane, fades within a
/// block, in steps little larger than before. Then there is silence.
#[test]
fn a_run_that_ends_fades_within_a_block() {
    use crate::seam::config::{Edge, ShapeKind, TrackingMode};
    let run = |shape, edge, blocks: usize, next| {
        let mut config = config();
        (config.lanes, config.drive.shape) = (4, shape);
        (config.burst.edge, config.burst.edge_cycles) = (edge, 100.0);
        // A boost needs a lock.
        config.tracking.mode = if edge == Edge::Boost { TrackingMode::PhaseLock } else { TrackingMode::Off };
        let mut controller = Controller::build(&config).unwrap();
        let mut queue = [controller.silence(), controller.silence()];
        let mut load = Resonator::default();
        let mut drives = std::vec::Vec::new();
        let (mut running, mut over) = (0, 0);
        while over < 2 {
            let ends = running == blocks;
            let orders = Orders {
                sequence: 1 + u32::from(ends),
                attempt: 1 + u32::from(ends),
                request: if ends { next } else { Request::Run },
                gate: Gate::On,
                ..Orders::default()
            };
            let slot = drives.len() % 2;
            let sense = load.exchange(&queue[slot]);
            let report = controller.process(&orders, &sense, &mut queue[slot]);
            assert!(report.fault.is_none() && drives.len() < 20_000, "{report:?}");
            drives.push(queue[slot].clone());
            running += usize::from(report.mode == Mode::Run);
            over += usize::from(ends);
        }
        drives
    };
    for (shape, edge) in [
        (ShapeKind::Sine, Edge::Hard),
        (ShapeKind::Sine, Edge::Soft),
        (ShapeKind::Sine, Edge::Boost),
        (ShapeKind::Square, Edge::Hard),
        (ShapeKind::Noise, Edge::Hard),
    ] {
        // Within the ramp of the soft edge, and after it.
        for (blocks, next) in (40..130).step_by(7).zip([Request::Idle, Request::Scan, Request::Calibrate].into_iter().cycle()) {
            let drives = run(shape, edge, blocks, next);
            let [before @ .., fade, silence] = &*drives else { panic!() };
            for lane in 0..4 {
                let codes = |drives: &[DriveBlock]| {
                    drives.iter().flat_map(|drive| drive.lanes[lane].clone()).collect::<std::vec::Vec<_>>()
                };
                let largest = |codes: &[u16]| codes.array_windows().map(|[a, b]| a.abs_diff(*b)).max().unwrap();
                let peak = codes(&before[before.len() - 30..]).iter().map(|code| code.abs_diff(2048)).max().unwrap();
                let steady = largest(&codes(&before[before.len() - 30..]));
                let end = [&before[before.len() - 1], fade, silence].map(DriveBlock::clone);
                assert!(peak > 50 && largest(&codes(&end)) <= steady + peak / 16, "{shape:?} {edge:?} {blocks} {lane}");
                assert!(fade.lanes[lane].iter().any(|&code| code != 2048), "{shape:?} {edge:?} {blocks}");
                assert!(silence.lanes[lane].iter().all(|&code| code == 2048), "{shape:?} {edge:?} {blocks}");
            }
        }
    }
}
