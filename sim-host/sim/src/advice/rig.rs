//! A case made ready to rehearse: bench, follower and prior as the controller would have them after its self-test and its calibration.

use firmware::seam::phasor::Phasor;
use firmware::sense::motional::Motional;
use firmware::track::tracker::Tracker;
use firmware::track::tracker::observer::{Observer, Prior};
use rand_core::SeedableRng;
use rand_distr::{Distribution, Uniform};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::case::{Case, NOMINAL_ERROR};
use super::rehearsal::{Bench, Follower, Rehearsal};
use crate::cramer_rao::noise;
use plant::circuit::Circuit;
use scene::settings;

/// How well the inductance is known by the measurement of the clamped branch, relative: as it is stated, and as it is.
const LM_MEASURED: f64 = 2e-3;
const LM_ERROR: f64 = 7e-4;
/// How well the clamped capacitance is, relative.
const C0_ERROR: f64 = 1e-3;

/// A case made ready to rehearse.
#[derive(Clone, Debug)]
pub struct Rig {
    /// What is around the stack.
    pub bench: Bench,
    /// Equivalent circuit of the stack.
    pub circuit: Circuit,
    /// Length of a block, s.
    pub block_s: f64,
    tracker: Tracker,
    prior: Prior,
}

impl Rig {
    /// The rig of a case; `None` if the firmware refuses its settings.
    pub fn of(case: &Case) -> Option<Self> {
        let driven = case.driven()?;
        let parts = case.parts()?;
        let config = settings::config(&driven);
        let (sensors, controller) = (parts.sensors, parts.controller);
        let (block_s, nominal_hz) = (parts.block_s(), controller.drive.frequency_hz);
        let own = (noise(sensors, sensors.i_full_scale_a), noise(sensors, sensors.v_full_scale_v));
        let bench = Bench {
            nominal_hz,
            volts: parts.volts(),
            source_ohm: parts.amplifier.source_ohm,
            sample_hz: sensors.sample_hz,
            samples: controller.block_samples,
            noise: own,
            c0_error: 0.0,
            skew_s: 0.0,
        };
        // As the self-test measures it, which allows for rounding of the sum once more.
        let per_lsb = [config.front_end.ampere_per_lsb, config.front_end.volt_per_lsb].map(f64::from);
        let of_block =
            |sample: f64, per_lsb: f64| 4.0 / f64::from(controller.block_samples) * (sample.powi(2) + per_lsb.powi(2) / 12.0);
        let y0 = Motional::of_capacitance(parts.circuit.c0_f as f32, nominal_hz as f32).y0;
        let variance = of_block(own.0, per_lsb[0]) + f64::from(y0.norm_sqr()) * of_block(own.1, per_lsb[1]);
        let tracking = &controller.tracking;
        let prior = Prior {
            offset_hz: (0.0, (tracking.span * nominal_hz) as f32),
            q: tracking.nominal_q as f32,
            lm_h: (parts.circuit.lm_h as f32, (LM_MEASURED * parts.circuit.lm_h) as f32),
            axis: Phasor::new(1.0, 0.0),
            noise_a: variance.sqrt() as f32,
        };
        let tracker = Tracker::build(&config, block_s as f32).ok()?;
        Some(Rig { bench, circuit: parts.circuit, block_s, tracker, prior })
    }

    /// Rms noise of a block's motional current, A.
    pub fn noise_a(&self) -> f64 {
        self.prior.noise_a.into()
    }

    /// Blocks in a time.
    pub fn blocks(&self, time_s: f64) -> usize {
        (time_s / self.block_s).ceil() as usize
    }

    /// A cold start of the tracker on the stack itself, with the true values as nominal ones.
    pub fn start(&self, bench: Bench, random: Option<Xoshiro256PlusPlus>) -> Rehearsal {
        self.begin(bench, Follower::Tracker(Box::new(self.tracker.clone())), &self.prior, 0.0, random)
    }

    /// A cold start of the observer by itself, without its second integrator.
    pub fn start_without_rate(&self) -> Rehearsal {
        let observer = Observer::new(self.bench.nominal_hz as f32, self.block_s as f32);
        self.begin(self.bench, Follower::WithoutRate(Box::new(observer)), &self.prior, 0.0, None)
    }

    /// A cold start with noise, of a stack beside the nominal one, with nominal values that are off once more: draw `number`.
    pub fn draw(&self, number: u64) -> (Rehearsal, Circuit) {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(number);
        let mut side = || Uniform::new(-1.0, 1.0).map_or(0.0, |uniform| uniform.sample(&mut random));
        let [hz, q, lm, phase, c0] = [side(), side(), side(), side(), side()];
        // At the same coupling.
        let hz = self.circuit.series_resonance_hz() * (1.0 + NOMINAL_ERROR.resonance * hz);
        let lm_h = 1.0 / ((std::f64::consts::TAU * hz).powi(2) * self.circuit.cm_f);
        let circuit = Circuit { lm_h, ..self.circuit }.with_q(self.circuit.q());
        let prior = Prior {
            q: (f64::from(self.prior.q) * NOMINAL_ERROR.q.powf(q)) as f32,
            lm_h: ((lm_h * (1.0 + LM_ERROR * lm)) as f32, (LM_MEASURED * lm_h) as f32),
            ..self.prior
        };
        let follower = Follower::Tracker(Box::new(self.tracker.clone()));
        let bench = Bench { c0_error: C0_ERROR * c0, ..self.bench };
        (self.begin(bench, follower, &prior, 0.5 + 0.5 * phase, Some(random)), circuit)
    }

    fn begin(
        &self,
        bench: Bench,
        follower: Follower,
        prior: &Prior,
        phase: f64,
        random: Option<Xoshiro256PlusPlus>,
    ) -> Rehearsal {
        let mut rehearsal = Rehearsal::new(bench, follower, self.circuit.c0_f, phase, random);
        rehearsal.observe(prior);
        rehearsal
    }
}
