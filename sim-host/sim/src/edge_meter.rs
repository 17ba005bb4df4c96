//! Both edges of each burst, with a resolution of one sample: the times of the DAC's first and last
//! samples, and the envelope of the true tip velocity after them.
//!
//! The envelope is computed from the plant's own state, `sqrt(v^2 + (w_s x)^2)` with velocity and
//! displacement at the series resonance: the amplitude that corresponds to the energy of the mode.
//! It needs no filter, has no delay, and is correct within a fraction of a period. A drive that
//! does work on the mode raises it in two steps per period, which remain visible.
//!
//! The **first sample** of a burst is the first code other than silence after the gate has opened.
//! Its **end** is the first code, after the gate has closed, that does not continue the wave
//! `c(n) = 2 cos(w) c(n - 1) - c(n - 2)`: silence, a brake, or a ramp down. The burst is **silent**
//! after its last code above the compensation of a burst.

use crate::schedule::first_window;
use scene::{Burst, Driven};

/// Maximum number of recorded bursts: the first that are played in `Run`.
const MAX_BURSTS: usize = 64;
/// Duration recorded after an edge, in time constants of the plant.
const WATCHED_TIME_CONSTANTS: f64 = 8.0;
/// Largest code of a burst's compensation, codes.
const COMPENSATION_CODES: f64 = 32.0;
/// Maximum deviation from the prediction at which a wave continues, codes.
const CONTINUES_CODES: f64 = 4.0;
/// Additional deviation at which a wave continues, relative to its amplitude.
const CONTINUES_REL: f64 = 0.02;

/// Two edges of a burst, as played.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Edges {
    /// Times at which the gate opened and closed, s.
    pub gate_s: (f64, f64),
    /// Beginning of the first sample, s.
    pub first_s: Option<f64>,
    /// Envelope at the end of each sample from the first on, m/s.
    pub rising: Vec<f64>,
    /// Beginning of the first sample that does not continue the wave, s.
    pub end_s: Option<f64>,
    /// Envelope at the end of each sample from the end on, m/s.
    pub falling: Vec<f64>,
    /// Number of samples from the end until the burst is silent.
    pub samples_to_silence: usize,
}

/// Meter of the edges of bursts.
#[derive(Clone, Debug)]
pub struct EdgeMeter {
    burst: Option<Burst>,
    sample_s: f64,
    watched: usize,
    mid: f64,
    /// Burst being recorded.
    now: Option<Edges>,
    /// Recorded bursts.
    pub(crate) done: Vec<Edges>,
    /// Last two codes relative to mid-scale.
    before: [f64; 2],
    largest: f64,
}

impl EdgeMeter {
    /// Creates a meter for the bursts of a scene. `time_constant_s` is the decay time constant of
    /// the plant's vibration.
    pub fn new(scene: &Driven, time_constant_s: f64) -> Self {
        let sample_s = 1.0 / scene.sensors.sample_hz;
        EdgeMeter {
            burst: scene.controller.burst.clone(),
            sample_s,
            watched: (WATCHED_TIME_CONSTANTS * time_constant_s / sample_s) as usize,
            mid: f64::from(1u32 << (scene.sensors.dac_bits - 1)),
            now: None,
            done: Vec::new(),
            before: [0.0; 2],
            largest: 0.0,
        }
    }

    /// Starts a burst whose gate opens in the block of `samples` samples from sample number
    /// `first`, and returns `true` if the block must be passed to [`Self::record_block`]. Only
    /// blocks played while `running` count.
    pub fn begin_block(&mut self, first: u64, samples: u64, running: bool) -> bool {
        let (from_s, to_s) = (first as f64 * self.sample_s, (first + samples) as f64 * self.sample_s);
        if let Some(burst) = self.burst.as_ref().filter(|_| running && self.done.len() < MAX_BURSTS) {
            let next = first_window(burst, from_s - 0.5 * self.sample_s).filter(|window| window.0 < to_s);
            if let Some(gate_s) = next {
                self.done.extend(self.now.take());
                self.now = Some(Edges { gate_s, ..Edges::default() });
            }
        }
        let Some(now) = &self.now else { return false };
        let watches = |edge: &[f64]| edge.len() < self.watched;
        watches(&now.rising) && to_s < now.gate_s.1 || to_s >= now.gate_s.1 - 4.0 * self.sample_s && watches(&now.falling)
    }

    /// Evaluates a block: its codes, the envelope at the end of each sample, and its frequency, Hz.
    pub fn record_block(&mut self, first: u64, codes: &[u16], envelope: impl Iterator<Item = f64>, frequency_hz: f64) {
        let Some(now) = &mut self.now else { return };
        let forward = 2.0 * (std::f64::consts::TAU * frequency_hz * self.sample_s).cos();
        for ((n, &code), envelope) in (first..).zip(codes).zip(envelope) {
            let (begins_s, code) = (n as f64 * self.sample_s, f64::from(code) - self.mid);
            // Times are products, so the time of the gate may differ by rounding.
            let after = |at_s: f64| begins_s > at_s - 0.5 * self.sample_s;
            let begins = code != 0.0 && (self.before[0] == 0.0 || code.abs() > COMPENSATION_CODES);
            if now.first_s.is_none() && after(now.gate_s.0) && begins {
                now.first_s = Some(begins_s);
                self.largest = 0.0;
            }
            let predicted = forward * self.before[0] - self.before[1];
            let breaks = (code - predicted).abs() > CONTINUES_CODES + CONTINUES_REL * self.largest;
            if now.end_s.is_none() && now.first_s.is_some() && after(now.gate_s.1) && breaks {
                now.end_s = Some(begins_s);
            }
            if now.first_s.is_some() && now.end_s.is_none() && now.rising.len() < self.watched {
                now.rising.push(envelope);
            }
            if now.end_s.is_some() && now.falling.len() < self.watched {
                now.falling.push(envelope);
                if code.abs() > COMPENSATION_CODES {
                    now.samples_to_silence = now.falling.len();
                }
            }
            self.largest = self.largest.max(code.abs());
            self.before = [code, self.before[0]];
        }
    }

    /// Returns every recorded burst.
    pub fn finish(mut self) -> Vec<Edges> {
        self.done.extend(self.now.take());
        self.done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OMEGA: f64 = std::f64::consts::TAU * 0.0404;

    /// Returns code `n` of a burst of 5 periods of 300 codes from sample 1010 on, with or without a
    /// brake of two further periods, and 10 samples of compensation.
    fn code(n: usize, brake: bool) -> f64 {
        let wave = |n: usize| (300.0 * (OMEGA * (n as f64 - 1009.5)).sin()).round();
        match n {
            1010..1134 => wave(n),
            1134..1183 if brake => -2.0 * wave(n),
            1183..1193 => -20.0,
            _ => 0.0,
        }
    }

    fn meter() -> EdgeMeter {
        let burst = Burst { on_s: vec![1000e-6], off_s: vec![1120e-6], ..Burst::default() };
        EdgeMeter {
            burst: Some(burst),
            sample_s: 1e-6,
            watched: 200,
            mid: 2048.0,
            now: None,
            done: Vec::new(),
            before: [0.0; 2],
            largest: 0.0,
        }
    }

    #[test]
    fn edges_are_found_to_the_sample() {
        for (brake, samples_to_silence) in [(false, 0), (true, 49)] {
            let mut meter = meter();
            for block in 0..60u64 {
                let first = 32 * block;
                if meter.begin_block(first, 32, true) {
                    let codes: Vec<u16> = (0..32).map(|n| (2048.0 + code(first as usize + n, brake)) as u16).collect();
                    meter.record_block(first, &codes, (0..32).map(|n| (first + n) as f64), 40.4e3);
                }
            }
            let edges = meter.finish();
            assert_eq!(edges.len(), 1);
            let edges = &edges[0];
            let (first, end) = (edges.first_s.unwrap() * 1e6, edges.end_s.unwrap() * 1e6);
            assert!((first - 1010.0).abs() < 0.01 && (end - 1134.0).abs() < 1.01, "{first} {end}");
            assert_eq!((edges.rising[0], edges.falling[0]), (first.round(), end.round()));
            assert!(
                edges.samples_to_silence.abs_diff(samples_to_silence) <= 1,
                "{} samples of braking",
                edges.samples_to_silence
            );
        }
    }
}
