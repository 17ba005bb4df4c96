//! Test rig: a stage of the firmware, the plant, and two effects that the plant lacks. These are a
//! lossy dielectric and a second resonance, both added to the sense codes.

use std::f64::consts::TAU;

use firmware::generate::nco::{Nco, Stretch};
use firmware::generate::shape::sine;
use firmware::generate::sweep::hold::Hold;
use firmware::seam::block::{DriveBlock, LATENCY_BLOCKS, SenseBlock};
use firmware::seam::config::Config;
use firmware::seam::phasor::Phasor;
use firmware::sense::convert::Convert;
use firmware::sense::demod::{Sensed, demodulate};
use hal_mock::analog::Analog;
use hal_mock::block_clock::BlockClock;
use num_complex::Complex64;
use plant::Plant;
use plant::circuit::Circuit;
use scene::load::load;
use scene::settings;

use super::truth::Truth;

/// Number of samples in a block.
const BLOCK: usize = 32;

pub fn wide(x: Phasor) -> Complex64 {
    Complex64::new(x.re.into(), x.im.into())
}

/// Transducer, and its nominal values in the firmware.
#[derive(Clone, Debug)]
pub struct Case {
    pub nominal_hz: f64,
    pub q: f64,
    pub c0_f: f64,
    pub cm_f: f64,
    pub resonance: f64,
    pub nominal_q: f64,
    pub nominal_c0: f64,
    pub skew_s: f64,
    pub loss: f64,
    /// Strength and frequency of a second resonance, relative to the first.
    pub second: Option<(f64, f64)>,
    pub noise_lsb: f64,
    /// Disturbances, in the format of a scene.
    pub changes: Vec<String>,
}

impl Default for Case {
    /// Returns the 40 kHz stack of Q 65 with exact nominal values.
    fn default() -> Self {
        Case {
            nominal_hz: 40e3,
            q: 65.0,
            c0_f: 300e-9,
            cm_f: 20e-9,
            resonance: 1.0,
            nominal_q: 1.0,
            nominal_c0: 1.0,
            skew_s: 0.0,
            loss: 0.0,
            second: None,
            noise_lsb: 1.0,
            changes: Vec::new(),
        }
    }
}

impl Case {
    /// Draws nominal values within their bounds: the resonance within 2 %, Q within a factor of 2,
    /// C0 within 5 %. They are distributed evenly, by multiples of the golden ratio.
    pub fn with_nominal_values(&self, seed: u64) -> Self {
        let draw = |ratio: f64| 2.0 * (seed as f64 * ratio).fract() - 1.0;
        let (hz, q, c0) = (draw(0.618_033_988_75), draw(0.754_877_666_25), draw(0.569_840_290_99));
        Case { resonance: 1.0 + 0.02 * hz, nominal_q: self.nominal_q * q.exp2(), nominal_c0: 1.0 + 0.05 * c0, ..self.clone() }
    }
}

/// Additional motional branch, driven by the sensed voltage.
#[derive(Default)]
struct Branch {
    flow: [[f64; 2]; 2],
    drive: [f64; 2],
    state: [f64; 2],
    last: f64,
}

impl Branch {
    /// Computes the flow of the branch over a sample with constant voltage: Taylor series of the
    /// exponential, in short steps.
    fn new([r, l, c]: [f64; 3], sample_s: f64) -> Self {
        const STEPS: usize = 64;
        let step = sample_s / STEPS as f64;
        let advance = |start: [f64; 2], volts: f64| {
            (0..STEPS).fold(start, |state, _| {
                let mut term = state;
                let mut sum = state;
                for order in 1..6 {
                    let forced = if order == 1 { volts } else { 0.0 };
                    term = [(forced - r * term[0] - term[1]) / l, term[0] / c].map(|x| x * step / f64::from(order));
                    sum = [sum[0] + term[0], sum[1] + term[1]];
                }
                sum
            })
        };
        let (i, q, drive) = (advance([1.0, 0.0], 0.0), advance([0.0, 1.0], 0.0), advance([0.0, 0.0], 1.0));
        Branch { flow: [[i[0], q[0]], [i[1], q[1]]], drive, ..Branch::default() }
    }

    fn current(&mut self, volts: f64) -> f64 {
        let mean = 0.5 * (volts + std::mem::replace(&mut self.last, volts));
        let [i, q] = self.state;
        let row = |n: usize| self.flow[n][0] * i + self.flow[n][1] * q + self.drive[n] * mean;
        self.state = [row(0), row(1)];
        self.state[0]
    }
}

/// The plant with the additional effects.
pub struct Bench {
    pub plant: Plant,
    conductance: f64,
    second: Option<Branch>,
    volt_per_lsb: f64,
    ampere_per_lsb: f64,
    mid_code: f64,
}

impl Analog for Bench {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        self.plant.exchange(drive, sense);
        if self.conductance == 0.0 && self.second.is_none() {
            return;
        }
        for (v, i) in sense.v.iter().zip(&mut sense.i) {
            let volts = (f64::from(*v) - self.mid_code) * self.volt_per_lsb;
            let more = self.conductance * volts + self.second.as_mut().map_or(0.0, |branch| branch.current(volts));
            *i = (f64::from(*i) + more / self.ampere_per_lsb).round() as u16;
        }
    }
}

/// Phasors measured in a block, and the tone played in it.
#[derive(Clone, Copy, Default)]
pub struct Exchange {
    pub sensed: Sensed,
    pub relative: f32,
    pub offset_hz: f32,
}

pub struct Rig {
    pub clock: BlockClock<Bench>,
    pub config: Config,
    pub truth: Truth,
    convert: Convert,
    hold: Hold,
    nco: Nco,
    played: [(Stretch, Exchange); LATENCY_BLOCKS],
}

impl Rig {
    pub fn new(case: &Case, seed: u64) -> Self {
        let hz = case.nominal_hz * case.resonance;
        // A small stack draws a small current.
        let range = if case.c0_f < 100e-9 { 0.2 } else { 4.0 };
        let mut sets = vec![
            format!("seed={seed}"),
            "duration_s=10.0".into(),
            format!("controller.drive.frequency_hz={:?}", case.nominal_hz),
            format!("controller.tracking.nominal_q={:?}", case.q * case.nominal_q),
            format!("controller.tracking.nominal_c0_f={:e}", case.c0_f * case.nominal_c0),
            "controller.tracking.span=0.02".into(),
            format!("stack.bvd.c0_f={:e}", case.c0_f),
            format!("stack.bvd.series_resonance_hz={hz:?}"),
            format!("stack.bvd.q={:?}", case.q),
            format!("stack.bvd.coupling={:?}", (case.cm_f / (case.c0_f + case.cm_f)).sqrt()),
            format!("sensors.skew_s={:e}", case.skew_s),
            format!("sensors.noise_lsb={:?}", case.noise_lsb),
            format!("sensors.i_full_scale_a={range:?}"),
        ];
        sets.extend(case.changes.iter().cloned());
        let scene = load("lock", &sets).unwrap_or_else(|error| panic!("{error}")).scene;
        let scene = scene.driven().unwrap();
        let config = settings::config(&scene);
        let plant = Plant::new(&scene);
        let circuit: Circuit = plant.circuit();
        let second = case.second.map(|(strength, place)| {
            let (omega, cm_f) = (TAU * hz * place, circuit.cm_f * strength);
            let lm_h = 1.0 / (omega * omega * cm_f);
            [omega * lm_h / case.q, lm_h, cm_f]
        });
        let (sensors, front_end) = (scene.sensors, &config.front_end);
        let truth = Truth { circuit, second, loss: case.loss, amplifier: scene.amplifier.clone(), sensors: sensors.clone() };
        let bench = Bench {
            plant,
            conductance: 0.0,
            second: second.map(|second| Branch::new(second, 1.0 / sensors.sample_hz)),
            volt_per_lsb: front_end.volt_per_lsb.into(),
            ampere_per_lsb: front_end.ampere_per_lsb.into(),
            mid_code: front_end.sense_mid_code.into(),
        };
        // The self-test removes this offset.
        let mut convert = Convert::build(front_end).unwrap();
        let offset = (sensors.offset_lsb * f64::from(sensors.oversample)) as f32;
        convert.v.shift_zero(offset);
        convert.i.shift_zero(offset);
        let hold = Hold::build(case.nominal_hz as f32, sensors.sample_hz as f32).unwrap();
        let silence = DriveBlock::silent(1, BLOCK, front_end.drive_mid_code);
        let tone = Stretch { word: hold.word(), ..Stretch::default() };
        let played = [(tone, Exchange { relative: 1.0, ..Exchange::default() }); LATENCY_BLOCKS];
        Rig { clock: BlockClock::new(bench, &silence), config, truth, convert, hold, nco: Nco::default(), played }
    }

    /// Runs one block: passes its phasors to `wants`, and plays the returned offset from the
    /// nominal frequency, Hz, and voltage, V.
    pub fn block(&mut self, mut wants: impl FnMut(&Exchange) -> (f32, f32)) -> Exchange {
        let slot = (self.clock.blocks() % LATENCY_BLOCKS as u64) as usize;
        let (tone, mut exchange) = self.played[slot];
        let hz = f64::from(self.hold.nominal_hz() + exchange.offset_hz);
        self.clock.analog.conductance = self.truth.loss * TAU * hz * self.truth.circuit.c0_f;
        let (front_end, nominal_hz) = (&self.config.front_end, self.hold.nominal_hz());
        let (convert, hold, nco, played) = (&self.convert, &mut self.hold, &mut self.nco, &mut self.played[slot]);
        self.clock.tick(|sense, drive| {
            exchange.sensed = demodulate(convert, sense, &tone).0;
            let (offset_hz, volts) = wants(&exchange);
            hold.retune(offset_hz);
            let stretch = nco.advance((hold.word(), 0), BLOCK);
            *played = (stretch, Exchange { relative: 1.0 + offset_hz / nominal_hz, offset_hz, ..Exchange::default() });
            for (n, code) in drive.lanes[0].iter_mut().enumerate() {
                let volts = sine::rotation(stretch.phase_at(n)).im * volts;
                *code = (f32::from(front_end.drive_mid_code) + volts / front_end.drive_volt_per_lsb + 0.5) as u16;
            }
        });
        exchange
    }
}
