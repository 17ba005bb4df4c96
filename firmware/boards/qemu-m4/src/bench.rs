//! What the controller is tried on: a configuration, and a transducer that answers in sense codes.

use firmware::generate::shape::sine;
use firmware::seam::block::{Amplitude, DriveBlock, SenseBlock};
use firmware::seam::config::{
    Burst, Config, Drive, Edge, FrontEnd, HeatSink, Limits, Link, Phasing, Schedule, Supply, Sweep, Thermometer, Tracking,
    TrackingMode,
};

/// Samples in a block, mostly.
pub const SAMPLES: usize = 32;
/// The code of zero, of all converters.
const MID_CODE: u16 = 2048;

/// A drive at constant motional current, tracked like this, in bursts with soft edges; converters of 12 bits, 10 mV and 2 mA a code.
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

/// A stack, in f32 and one complex state a resonance:
///
/// ```text
/// i = sum Re s + C0 dv/dt,    s(n + 1) = p s(n) + g v(n),    p = exp((-pi f / Q + 2 pi j f) T),    g = T / Lm
/// ```
#[derive(Clone)]
pub struct Transducer {
    branches: [Branch; 2],
    last: f32,
}

/// A resonance.
#[derive(Clone, Copy, Default)]
struct Branch {
    turn: u64,
    gain: f32,
    s: (f32, f32),
}

/// Magnitude of `p` of 40 520 Hz and Q 64.6 at 1 Msps, `1 - pi f T / Q`; the second resonance decays as soon.
const DECAY: f32 = 1.0 - core::f32::consts::PI * 40_520.0 / 64.6 * 1e-6;
/// `T / Lm` for 0.79 mH: `Rm = 2 pi f Lm / Q = 3.1` ohm.
const AMPERES_PER_VOLT: f32 = 1e-6 / 0.79e-3;
/// The second resonance, Hz, and its strength relative to the first.
const COMPANY: (f64, f32) = (43_350.0, 0.15);
/// `C0 / T` for 300 nF.
const AMPERES_PER_STEP: f32 = 300e-9 / 1e-6;

/// The angle of `p` as a phase of 2^64 a turn.
const fn turn(hz: f64) -> u64 {
    (hz / 1e6 * 18_446_744_073_709_551_616.0) as u64
}

impl Default for Transducer {
    fn default() -> Self {
        Transducer::new()
    }
}

impl Transducer {
    /// With one resonance, at rest.
    pub fn new() -> Self {
        let only = Branch { turn: turn(40_520.0), gain: AMPERES_PER_VOLT, ..Branch::default() };
        Transducer { branches: [only, Branch::default()], last: 0.0 }
    }

    /// With a second one.
    pub fn in_company() -> Self {
        let mut both = Transducer::new();
        both.branches[1] = Branch { turn: turn(COMPANY.0), gain: COMPANY.1 * AMPERES_PER_VOLT, ..Branch::default() };
        both
    }

    /// From now on under a load that moves the resonance by -200 Hz.
    pub fn load(&mut self) {
        self.branches[0].turn = turn(40_320.0);
    }

    /// Takes one block of the first lane.
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
            // As many as there are voltage codes, which fit.
            let _ = sense.i.push(code.clamp(0.0, 4095.0) as u16);
        }
    }
}
