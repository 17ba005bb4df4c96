//! Simulated bank of four different amplifiers with a multiplexer, for tests of the calibration.

use std::collections::VecDeque;

use firmware::seam::block::{DriveBlock, SenseBlock};
use hal_mock::analog::Analog;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::{BLOCK, CODES_PER_VOLT, MID_CODE};

/// Amplifier with a gain and one pole, whose delay and gain error grow with the frequency.
#[derive(Clone, Copy)]
pub struct Amplifier {
    /// Gain for slow signals.
    pub gain: f64,
    /// Frequency of the pole, Hz.
    pub pole: f64,
    volts: f64,
}

/// Lanes as measured in the thesis: 5 to 10 degrees apart, with gain errors of several per cent.
pub const THESIS: [Amplifier; 4] = [amplifier(1.0, 2e6), amplifier(1.05, 200e3), amplifier(0.98, 130e3), amplifier(1.08, 300e3)];

const fn amplifier(gain: f64, pole: f64) -> Amplifier {
    Amplifier { gain, pole, volts: 0.0 }
}

impl Amplifier {
    /// Advances by one sample and returns the output, V.
    fn play(&mut self, volts: f64) -> f64 {
        self.volts += (1.0 - (-std::f64::consts::TAU * self.pole * 1e-6).exp()) * (self.gain * volts - self.volts);
        self.volts
    }
}

/// Four amplifiers, each with a capacitor, whose sense channels a multiplexer connects to one of
/// them. Sense codes have noise.
pub struct Bank {
    noise: f64,
    chance: Xoshiro256PlusPlus,
    /// Lane that the multiplexer fails to connect.
    pub disconnected: Option<usize>,
    /// Recent outputs of each amplifier, V.
    pub outputs: [VecDeque<f64>; 4],
    /// `true` if the latest block was not silent.
    pub is_driven: bool,
    pub amplifiers: [Amplifier; 4],
}

impl Bank {
    pub fn new(amplifiers: [Amplifier; 4], noise: f64) -> Self {
        let chance = Xoshiro256PlusPlus::seed_from_u64(11);
        Bank { amplifiers, noise, chance, disconnected: None, outputs: Default::default(), is_driven: false }
    }

    fn code(&mut self, codes: f64) -> u16 {
        // The sum of twelve uniform numbers is approximately Gaussian.
        let bell: f64 = (0..12).map(|_| f64::from(self.chance.next_u32()) / 4_294_967_296.0).sum::<f64>() - 6.0;
        (f64::from(MID_CODE) + codes + self.noise * bell).round().clamp(0.0, 4095.0) as u16
    }
}

impl Analog for Bank {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        let (samples, listen) = (drive.lanes[0].len(), usize::from(drive.listen));
        sense.v.clear();
        sense.i.clear();
        self.is_driven = drive.lanes.iter().flatten().any(|&code| code != MID_CODE);
        for n in 0..samples {
            let before = self.amplifiers[listen].volts;
            for (lane, codes) in drive.lanes.iter().enumerate() {
                let volts = self.amplifiers[lane].play((f64::from(codes[n]) - f64::from(MID_CODE)) / CODES_PER_VOLT);
                self.outputs[lane].push_back(volts);
                let surplus = self.outputs[lane].len().saturating_sub(600 * BLOCK);
                self.outputs[lane].drain(..surplus);
            }
            let (volts, connected) = (self.amplifiers[listen].volts, self.disconnected != Some(listen));
            // 200 nF, 2 mA per code.
            let codes = if connected { (volts * CODES_PER_VOLT, (volts - before) * 100.0) } else { (0.0, 0.0) };
            let codes = (self.code(codes.0), self.code(codes.1));
            sense.v.push(codes.0).unwrap();
            sense.i.push(codes.1).unwrap();
        }
    }
}

/// Returns the least-squares amplitude and phase (turns) of a tone.
pub fn tone_of(volts: &VecDeque<f64>, hz: f64) -> (f64, f64) {
    let (mut cc, mut ss, mut cs, mut c, mut s) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (n, volts) in volts.iter().enumerate() {
        let (sin, cos) = (std::f64::consts::TAU * hz * 1e-6 * n as f64).sin_cos();
        (cc, ss, cs, c, s) = (cc + cos * cos, ss + sin * sin, cs + sin * cos, c + cos * volts, s + sin * volts);
    }
    let determinant = cc * ss - cs * cs;
    let (cos, sin) = ((c * ss - s * cs) / determinant, (s * cc - c * cs) / determinant);
    (sin.hypot(cos), cos.atan2(sin) / std::f64::consts::TAU)
}
