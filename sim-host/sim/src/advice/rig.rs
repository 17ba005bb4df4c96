//! A case prepared for rehearsals: bench, tracker and prior as in the controller after its
//! self-test and its calibration.

use firmware::seam::phasor::Phasor;
use firmware::sense::motional::Motional;
use firmware::track::tracker::Tracker;
use firmware::track::tracker::observer::{Observer, Prior};
use rand_core::SeedableRng;
use rand_distr::{Distribution, Uniform};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::case::{Case, NOMINAL_ERROR};
use super::rehearsal::{Follower, Rehearsal, RehearsalBench};
use crate::cramer_rao::noise;
use plant::circuit::Circuit;
use scene::settings;

/// Standard deviation of the inductance stated by the measurement of the clamped branch, relative.
const LM_SD_REL: f64 = 2e-3;
/// Actual error of the inductance after this measurement, relative.
const LM_ERROR_REL: f64 = 7e-4;
/// Actual error of the clamped capacitance, relative.
const C0_ERROR_REL: f64 = 1e-3;

/// Case prepared for rehearsals.
#[derive(Clone, Debug)]
pub struct RehearsalRig {
    /// Surroundings of the stack.
    pub bench: RehearsalBench,
    /// Equivalent circuit of the stack.
    pub circuit: Circuit,
    /// Length of a block, s.
    pub block_s: f64,
    tracker: Tracker,
    prior: Prior,
}

impl RehearsalRig {
    /// Prepares a case; `None` if the firmware refuses its settings.
    pub fn from_case(case: &Case) -> Option<Self> {
        let driven = case.driven()?;
        let parts = case.parts()?;
        let config = settings::config(&driven);
        let (sensors, controller) = (parts.sensors, parts.controller);
        let (block_s, nominal_hz) = (parts.block_s(), controller.drive.frequency_hz);
        let own = (noise(sensors, sensors.i_full_scale_a), noise(sensors, sensors.v_full_scale_v));
        let bench = RehearsalBench {
            nominal_hz,
            volts: parts.volts(),
            source_ohm: parts.amplifier.source_ohm,
            sample_hz: sensors.sample_hz,
            samples: controller.block_samples,
            noise: own,
            c0_error: 0.0,
            skew_s: 0.0,
        };
        // As in the self-test, which adds the rounding of the sum once more.
        let per_lsb = [config.front_end.ampere_per_lsb, config.front_end.volt_per_lsb].map(f64::from);
        let of_block =
            |sample: f64, per_lsb: f64| 4.0 / f64::from(controller.block_samples) * (sample.powi(2) + per_lsb.powi(2) / 12.0);
        let y0 = Motional::of_capacitance(parts.circuit.c0_f as f32, nominal_hz as f32).y0;
        let variance = of_block(own.0, per_lsb[0]) + f64::from(y0.norm_sqr()) * of_block(own.1, per_lsb[1]);
        let tracking = &controller.tracking;
        let prior = Prior {
            offset_hz: (0.0, (tracking.span * nominal_hz) as f32),
            q: tracking.nominal_q as f32,
            lm_h: (parts.circuit.lm_h as f32, (LM_SD_REL * parts.circuit.lm_h) as f32),
            axis: Phasor::new(1.0, 0.0),
            noise_a: variance.sqrt() as f32,
        };
        let tracker = Tracker::build(&config, block_s as f32).ok()?;
        Some(RehearsalRig { bench, circuit: parts.circuit, block_s, tracker, prior })
    }

    /// Returns the rms noise of a block's motional current, A.
    pub fn noise_a(&self) -> f64 {
        self.prior.noise_a.into()
    }

    /// Returns the number of blocks in a time, rounded up.
    pub fn blocks(&self, time_s: f64) -> usize {
        (time_s / self.block_s).ceil() as usize
    }

    /// Starts the tracker cold on the stack itself, with the true values as nominal ones.
    pub fn start(&self, bench: RehearsalBench, random: Option<Xoshiro256PlusPlus>) -> Rehearsal {
        self.begin(bench, Follower::Tracker(Box::new(self.tracker.clone())), &self.prior, 0.0, random)
    }

    /// Starts the observer alone, cold, without its second integrator.
    pub fn start_without_rate(&self) -> Rehearsal {
        let observer = Observer::new(self.bench.nominal_hz as f32, self.block_s as f32, self.prior.offset_hz.1);
        self.begin(self.bench, Follower::WithoutRate(Box::new(observer)), &self.prior, 0.0, None)
    }

    /// Starts draw `number` cold, with noise: the stack deviates from the nominal one, and the
    /// nominal values have errors in addition.
    pub fn draw(&self, number: u64) -> (Rehearsal, Circuit) {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(number);
        let mut side = || Uniform::new(-1.0, 1.0).map_or(0.0, |uniform| uniform.sample(&mut random));
        let [hz, q, lm, phase, c0] = [side(), side(), side(), side(), side()];
        // The coupling remains the same.
        let hz = self.circuit.series_resonance_hz() * (1.0 + NOMINAL_ERROR.resonance * hz);
        let lm_h = 1.0 / ((std::f64::consts::TAU * hz).powi(2) * self.circuit.cm_f);
        let circuit = Circuit { lm_h, ..self.circuit }.with_q(self.circuit.q());
        let prior = Prior {
            q: (f64::from(self.prior.q) * NOMINAL_ERROR.q.powf(q)) as f32,
            lm_h: ((lm_h * (1.0 + LM_ERROR_REL * lm)) as f32, (LM_SD_REL * lm_h) as f32),
            ..self.prior
        };
        let follower = Follower::Tracker(Box::new(self.tracker.clone()));
        let bench = RehearsalBench { c0_error: C0_ERROR_REL * c0, ..self.bench };
        (self.begin(bench, follower, &prior, 0.5 + 0.5 * phase, Some(random)), circuit)
    }

    fn begin(
        &self,
        bench: RehearsalBench,
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
