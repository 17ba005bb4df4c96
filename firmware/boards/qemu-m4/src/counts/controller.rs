//! The controller as a whole, a block at a time, on a capacitor: its drive looped back, with no resonance to follow.

use core::hint::black_box;

use firmware::block::{Amplitude, DriveBlock, Orders, Request, SenseBlock};
use firmware::config::{Burst, Config, Drive, Edge, FrontEnd, Limits, Phasing, Schedule, ShapeKind, Tracking, TrackingMode};
use firmware::controller::Controller;
use firmware::supervisor::Mode;
use firmware::telemetry::Telemetry;

use crate::counter::Counter;
use crate::image::line;

const SAMPLES: usize = 32;
const REPETITIONS: u32 = 500;
/// Self-test and its wait end before this.
const POWER_UP_BLOCKS: u32 = 10_000;

/// A capacitor of 200 nF at 40.4 kHz: converters of 12 bits, 10 mV and 2 mA a code.
pub fn config() -> Config {
    Config {
        sample_hz: 1e6,
        block_samples: SAMPLES as u16,
        lanes: 1,
        front_end: FrontEnd {
            volt_per_lsb: 0.01,
            ampere_per_lsb: 0.002,
            sense_mid_code: 2048,
            sense_max_code: 4095,
            drive_volt_per_lsb: 0.01,
            drive_mid_code: 2048,
            drive_max_code: 4095,
        },
        drive: Drive { frequency_hz: 40_400.0, amplitude: Amplitude::Volts(3.0), scan_volts: 1.0, shape: ShapeKind::Sine },
        phasing: Phasing::default(),
        burst: Burst { schedule: Schedule::Continuous, edge: Edge::Hard },
        tracking: Tracking { mode: TrackingMode::Off, span: 0.05, bandwidth_hz: 100.0, nominal_q: 50.0, nominal_c0_f: 200e-9 },
        limits: Limits { voltage_v: 12.0, current_a: 3.0, belt_moving_m_per_s: 0.01, belt_stop_ms: 5.0 },
    }
}

/// A block of 3 V and what the capacitor takes.
pub fn sense() -> SenseBlock {
    let mut load = Load { last: 2048 };
    let mut drive = DriveBlock::default();
    let wave = |n: usize| (2048.0 + 300.0 * firmware::shape::sine::rotation((n as u64) << 59).im) as u16;
    let _ = drive.lanes.push((0..SAMPLES).map(wave).collect());
    let mut sense = SenseBlock::default();
    load.exchange(&drive, &mut sense);
    sense
}

/// The capacitor.
#[derive(Clone)]
struct Load {
    last: u16,
}

impl Load {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        // 200 nF, 10 mV a code and 1 us a sample: 2 mA, one current code.
        let lane = &drive.lanes[0];
        sense.v.clone_from(lane);
        sense.i.clear();
        for &code in lane {
            let _ = sense.i.push(2048u16.wrapping_add(code).wrapping_sub(self.last).min(4095));
            self.last = code;
        }
    }
}

pub fn count(counter: &Counter) {
    for lanes in [1, 4] {
        for (name, edge, schedule) in [
            ("continuous", Edge::Hard, Schedule::Continuous),
            ("in edges", Edge::Soft { cycles: 1e4 }, Schedule::Periodic { period_s: 1.0, duty: 0.5 }),
        ] {
            let config = Config { lanes, burst: Burst { schedule, edge }, ..config() };
            let mut bench = Bench::running(&config);
            let mut alone = bench.clone();
            let mut label = heapless::String::<40>::new();
            let _ = core::fmt::write(&mut label, format_args!("process {lanes} {name}"));
            let both = counter.count(REPETITIONS, || {
                black_box(bench.turn());
            });
            line(&label, SAMPLES, REPETITIONS, both);
            let mut label = heapless::String::<40>::new();
            let _ = core::fmt::write(&mut label, format_args!("load {lanes} {name}"));
            let load = counter.count(REPETITIONS, || {
                alone.listen();
            });
            line(&label, SAMPLES, REPETITIONS, load);
        }
    }
}

/// A controller on its load.
#[derive(Clone)]
struct Bench {
    controller: Controller,
    orders: Orders,
    load: Load,
    sense: SenseBlock,
    playing: [DriveBlock; 2],
    block: usize,
}

impl Bench {
    /// Powers up until it runs.
    fn running(config: &Config) -> Self {
        let controller = Controller::build(config).expect("a valid configuration");
        let silence = controller.silence();
        let mut bench = Bench {
            controller,
            orders: Orders { sequence: 1, request: Request::Run, attempt: 1, ..Orders::default() },
            load: Load { last: 2048 },
            sense: SenseBlock::default(),
            playing: [silence.clone(), silence],
            block: 0,
        };
        for _ in 0..POWER_UP_BLOCKS {
            let report = bench.turn();
            assert!(report.mode != Mode::Fault, "{:?}", report.fault);
            if report.mode == Mode::Run {
                return bench;
            }
        }
        panic!("the controller does not come to run")
    }

    #[inline(never)]
    fn listen(&mut self) {
        self.block += 1;
        self.load.exchange(&self.playing[self.block % 2], &mut self.sense);
    }

    #[inline(never)]
    fn turn(&mut self) -> Telemetry {
        self.listen();
        self.controller.process(&self.orders, &self.sense, &mut self.playing[self.block % 2])
    }
}
