//! Test bench of the controller: a configuration, and a transducer that answers in sense codes.

use firmware::generate::shape::sine;
use firmware::seam::block::{Amplitude, DriveBlock, SenseBlock};
use firmware::seam::config::{
    Burst, Config, Drive, Edge, FrontEnd, HeatSink, Limits, Link, Phasing, Schedule, Supply, Sweep, Thermometer, Tracking,
    TrackingMode,
};

/// Usual number of samples in a block.
pub const SAMPLES: usize = 32;
/// Code of zero, for all converters.
const MID_CODE: u16 = 2048;

/// Returns the settings of a drive at constant motional current, in bursts with soft edges.
///
/// The converters have 12 bits, at 10 mV and 2 mA per code.
pub fn config(mode: TrackingMode, lanes: u8, samples: usize) -> Config {
    Config {
        sample_hz: 1e6,
        block_samples: samples as u16,
        lanes,
        front_end: FrontEnd {
            volt_per_lsb: 0.01,
            ampere_per_lsb: 0.002,
            sense_mid_code: MID_CODE,
            sense_max_code: 4095,
            drive_volt_per_lsb: 0.01,
            drive_mid_code: MID_CODE,
            drive_max_code: 4095,
            drive_lanes: 4,
            metre_per_count: None,
            force_hz: None,
            newton_per_lsb: None,
        },
        drive: Drive::sine(40e3, Amplitude::MotionalCurrent(0.5), 1.0),
        sweep: Sweep::Hold,
        phasing: Phasing::default(),
        burst: Burst {
            schedule: Schedule::Periodic { period_s: 10e-3, duty: 0.7 },
            edge: Edge::Soft,
            edge_cycles: 8.0,
            ..Burst::default()
        },
        tracking: Tracking { mode, nominal_c0_f: Some(290e-9), ..Tracking::new(50.0) },
        thermometer: Thermometer::default(),
        heat_sink: HeatSink::default(),
        supply: Supply::default(),
        limits: Limits { voltage_v: 12.0, current_a: 3.0, belt_stop_ms: 5.0, ..Limits::default() },
        friction: None,
        restraint: None,
        link: Link::default(),
    }
}

/// Simulated piezo stack in f32, with one complex state per resonance:
///
/// ```text
/// i = sum Re s + C0 dv/dt,    s(n + 1) = p s(n) + g v(n),    p = exp((-pi f / Q + 2 pi j f) T),    g = T / Lm
/// ```
#[derive(Clone)]
pub struct Transducer {
    branches: [Branch; 2],
    last: f32,
}

/// Resonance with its state.
#[derive(Clone, Copy, Default)]
struct Branch {
    turn: u64,
    gain: f32,
    s: (f32, f32),
}

/// Magnitude of `p` for 40 520 Hz and Q 64.6 at 1 Msps: `1 - pi f T / Q`. The second resonance has
/// the same value.
const DECAY: f32 = 1.0 - core::f32::consts::PI * 40_520.0 / 64.6 * 1e-6;
/// Gain `T / Lm` for 0.79 mH: `Rm = 2 pi f Lm / Q = 3.1` ohm.
const AMPERES_PER_VOLT: f32 = 1e-6 / 0.79e-3;
/// Frequency of the second resonance, Hz.
const SECOND_MODE_HZ: f64 = 43_350.0;
/// Gain of the second resonance, relative to the first.
const SECOND_MODE_GAIN: f32 = 0.15;
/// Current per voltage step, `C0 / T` for 300 nF, A/V.
const AMPERES_PER_STEP: f32 = 300e-9 / 1e-6;

/// Returns the angle of `p` as a phase with 2^64 per turn.
const fn turn(hz: f64) -> u64 {
    (hz / 1e6 * 18_446_744_073_709_551_616.0) as u64
}

impl Default for Transducer {
    fn default() -> Self {
        Transducer::new()
    }
}

impl Transducer {
    /// Creates a transducer with one resonance, at rest.
    pub fn new() -> Self {
        let only = Branch { turn: turn(40_520.0), gain: AMPERES_PER_VOLT, ..Branch::default() };
        Transducer { branches: [only, Branch::default()], last: 0.0 }
    }

    /// Creates a transducer with a second resonance, at rest.
    pub fn in_company() -> Self {
        let mut both = Transducer::new();
        both.branches[1] = Branch { turn: turn(SECOND_MODE_HZ), gain: SECOND_MODE_GAIN * AMPERES_PER_VOLT, ..Branch::default() };
        both
    }

    /// Applies a load that moves the resonance by -200 Hz.
    pub fn load(&mut self) {
        self.branches[0].turn = turn(40_320.0);
    }

    /// Drives the transducer with one block of the first lane, and fills the block of sense codes.
    pub fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        let poles = self.branches.map(|branch| sine::rotation(branch.turn) * DECAY);
        sense.v.clone_from(&drive.lanes[0]);
        sense.i.clear();
        for &code in &drive.lanes[0] {
            let volts = (f32::from(code) - f32::from(MID_CODE)) * 0.01;
            let mut amperes = AMPERES_PER_STEP * (volts - self.last);
            for (branch, p) in self.branches.iter_mut().zip(poles) {
                let (re, im) = branch.s;
                amperes += re;
                branch.s = (p.re * re - p.im * im + branch.gain * volts, p.re * im + p.im * re);
            }
            self.last = volts;
            let code = f32::from(MID_CODE) + amperes / 0.002 + 0.5;
            // Cannot fail: there are as many current codes as voltage codes.
            let _ = sense.i.push(code.clamp(0.0, 4095.0) as u16);
        }
    }
}
