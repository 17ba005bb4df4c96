//! Double-precision model of a transducer with up to three branches, for tests; exact, and
//! independent of the code under test.

use crate::seam::block::{DriveBlock, SenseBlock};
use crate::seam::config::FrontEnd;

/// Gaussian noise of variance one (G. E. P. Box and M. E. Muller 1958), from a multiplicative
/// generator.
pub(crate) struct Noise(u64);

impl Noise {
    pub(crate) fn new(seed: u64) -> Self {
        Noise(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(0xD134_2543_DE82_EF95).wrapping_add(0x2545_F491_4F6C_DD1D);
        ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    pub(crate) fn normal(&mut self) -> f64 {
        libm::sqrt(-2.0 * libm::log(self.uniform())) * libm::cos(core::f64::consts::TAU * self.uniform())
    }
}

pub(crate) fn front_end() -> FrontEnd {
    FrontEnd {
        volt_per_lsb: 20.0 / 2048.0,
        ampere_per_lsb: 4.0 / 2048.0,
        sense_mid_code: 2048,
        sense_max_code: 4095,
        drive_volt_per_lsb: 20.0 / 2048.0,
        drive_mid_code: 2048,
        drive_max_code: 4095,
        drive_lanes: 4,
        metre_per_count: None,
        force_hz: None,
        newton_per_lsb: None,
    }
}

/// Motional branch: series resonance frequency, Hz, quality factor, and motional inductance, H.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Branch {
    pub(crate) hz: f64,
    pub q: f64,
    pub lm_h: f64,
}

impl Branch {
    pub(crate) fn cm_f(&self) -> f64 {
        let omega = core::f64::consts::TAU * self.hz;
        1.0 / (omega * omega * self.lm_h)
    }

    pub(crate) fn rm_ohm(&self) -> f64 {
        core::f64::consts::TAU * self.hz * self.lm_h / self.q
    }
}

/// Driven circuit, sampled at 1 Msps: one-pole amplifier, source resistance, capacitance and
/// branches.
pub(crate) struct Bench {
    pub(crate) noise_lsb: f64,
    noise: Noise,
    /// State: amplifier output, voltage, and two values per branch.
    x: [f64; STATES],
    flow: [[f64; STATES + 1]; STATES],
    source_ohm: f64,
    front_end: FrontEnd,
}

const STATES: usize = 8;
/// Averages per sample, so that the steps of the drive leave no images.
const OVERSAMPLE: usize = 8;

impl Bench {
    /// Creates a model with up to three branches, and a front end whose current range fits them.
    pub(crate) fn new(branches: &[Branch], c0_f: f64, seed: u64, front_end: FrontEnd) -> Self {
        let (corner, source_ohm) = (core::f64::consts::TAU * 200e3, 0.3);
        let mut a = [[0.0; STATES + 1]; STATES + 1];
        (a[0][0], a[0][STATES]) = (-corner, corner);
        (a[1][0], a[1][1]) = (1.0 / (source_ohm * c0_f), -1.0 / (source_ohm * c0_f));
        for (n, branch) in branches.iter().enumerate() {
            let (i, vc) = (2 + 2 * n, 3 + 2 * n);
            a[1][i] = -1.0 / c0_f;
            (a[i][1], a[i][i], a[i][vc]) = (1.0 / branch.lm_h, -branch.rm_ohm() / branch.lm_h, -1.0 / branch.lm_h);
            a[vc][i] = 1.0 / branch.cm_f();
        }
        let exact = exponential(&a, 1e-6 / OVERSAMPLE as f64);
        let mut flow = [[0.0; STATES + 1]; STATES];
        flow.copy_from_slice(&exact[..STATES]);
        Bench { noise_lsb: 1.0, noise: Noise::new(seed), x: [0.0; STATES], flow, source_ohm, front_end }
    }

    /// Plays a block and samples it.
    pub(crate) fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        sense.v.clear();
        sense.i.clear();
        for &code in &drive.lanes[0] {
            let volts = (f64::from(code) - 2048.0) * f64::from(self.front_end.drive_volt_per_lsb);
            let (mut v, mut i) = (0.0, 0.0);
            for _ in 0..OVERSAMPLE {
                v += self.x[1] / OVERSAMPLE as f64;
                i += (self.x[0] - self.x[1]) / self.source_ohm / OVERSAMPLE as f64;
                let x = self.x;
                for (n, row) in self.flow.iter().enumerate() {
                    self.x[n] = row[..STATES].iter().zip(&x).map(|(a, x)| a * x).sum::<f64>() + row[STATES] * volts;
                }
            }
            let mut adc = |x: f64| libm::round(2048.0 + x + self.noise_lsb * self.noise.normal()).clamp(0.0, 4095.0) as u16;
            sense.v.push(adc(v / f64::from(self.front_end.volt_per_lsb))).unwrap();
            sense.i.push(adc(i / f64::from(self.front_end.ampere_per_lsb))).unwrap();
        }
    }
}

/// Computes `exp(A t)` by scaling and squaring with a series of eighteen terms.
fn exponential(a: &[[f64; STATES + 1]; STATES + 1], t: f64) -> [[f64; STATES + 1]; STATES + 1] {
    const N: usize = STATES + 1;
    let product = |x: &[[f64; N]; N], y: &[[f64; N]; N]| {
        let mut z = [[0.0; N]; N];
        for (r, row) in z.iter_mut().enumerate() {
            for (c, cell) in row.iter_mut().enumerate() {
                *cell = (0..N).map(|k| x[r][k] * y[k][c]).sum();
            }
        }
        z
    };
    let halvings = 12;
    let small = a.map(|row| row.map(|x| x * t / f64::from(1 << halvings)));
    let one: [[f64; N]; N] = core::array::from_fn(|r| core::array::from_fn(|c| f64::from(r == c)));
    let (mut sum, mut term) = (one, one);
    for n in 1..18 {
        term = product(&term, &small).map(|row| row.map(|x| x / f64::from(n)));
        for (row, more) in sum.iter_mut().zip(&term) {
            row.iter_mut().zip(more).for_each(|(x, y)| *x += y);
        }
    }
    (0..halvings).fold(sum, |x, _| product(&x, &x))
}
