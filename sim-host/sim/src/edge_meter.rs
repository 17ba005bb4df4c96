//! Both edges of each burst, to the sample: when the DAC's first and last samples play, and the envelope of the true tip velocity from there on.
//!
//! The envelope is that of the plant's own state, `sqrt(v^2 + (w_s x)^2)` of velocity and displacement at the series resonance: the amplitude that
//! the energy of the mode holds. It needs no filter, is late by nothing, and is right within a fraction of a period; a drive that works on it makes
//! it rise in two steps a period, of which it shows the steps.
//!
//! The **first sample** of a burst is the first code that is not silence, after the gate has opened. Its **end** is the first code, after the gate
//! has closed, that does not go on with the wave `c(n) = 2 cos(w) c(n - 1) - c(n - 2)`: silence, a brake, or a ramp down. It is **silent** after its
//! last code above what a burst pays back.

use crate::schedule::first_window;
use scene::{Burst, Driven};

/// Most bursts that are recorded: the first that are played while running.
const MOST: usize = 64;
/// Time constants of the plant that are recorded after an edge.
const WATCHED: f64 = 8.0;
/// The most codes that a burst pays back in a sample.
const PAID_BACK: f64 = 32.0;
/// A wave goes on as long as it is within so many codes of its prediction, and within this part of its amplitude.
const GOES_ON: (f64, f64) = (4.0, 0.02);

/// The two edges of a burst as they were played.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Edges {
    /// When the gate opened and closed, s.
    pub gate_s: (f64, f64),
    /// The beginning of the first sample, s.
    pub first_s: Option<f64>,
    /// The envelope at the end of each sample from the first on, m/s.
    pub rising: Vec<f64>,
    /// The beginning of the first sample that does not go on with the wave, s.
    pub end_s: Option<f64>,
    /// The envelope at the end of each sample from that on, m/s.
    pub falling: Vec<f64>,
    /// How many of these were played until it fell silent.
    pub loud: usize,
}

/// Watches the edges of bursts.
#[derive(Clone, Debug)]
pub struct EdgeMeter {
    burst: Option<Burst>,
    sample_s: f64,
    watched: usize,
    mid: f64,
    /// The burst that is being watched, and those that were.
    now: Option<Edges>,
    pub(crate) done: Vec<Edges>,
    /// The last two codes about the middle, and the largest of late.
    before: [f64; 2],
    largest: f64,
}

impl EdgeMeter {
    /// A meter for the bursts of a scene whose plant has this time constant of vibration, s.
    pub fn new(scene: &Driven, time_constant_s: f64) -> Self {
        let sample_s = 1.0 / scene.sensors.sample_hz;
        EdgeMeter {
            burst: scene.controller.burst.clone(),
            sample_s,
            watched: (WATCHED * time_constant_s / sample_s) as usize,
            mid: f64::from(1u32 << (scene.sensors.dac_bits - 1)),
            now: None,
            done: Vec::new(),
            before: [0.0; 2],
            largest: 0.0,
        }
    }

    /// Whether the block of `samples` samples that begins with sample number `first` is to be looked at, sample by sample. Only what is played while
    /// `running` counts.
    pub fn records(&mut self, first: u64, samples: u64, running: bool) -> bool {
        let (from_s, to_s) = (first as f64 * self.sample_s, (first + samples) as f64 * self.sample_s);
        if let Some(burst) = self.burst.as_ref().filter(|_| running && self.done.len() < MOST) {
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

    /// Takes a block: its codes, the envelope at the end of each sample, and its frequency, Hz.
    pub fn take(&mut self, first: u64, codes: &[u16], envelope: impl Iterator<Item = f64>, frequency_hz: f64) {
        let Some(now) = &mut self.now else { return };
        let forward = 2.0 * (std::f64::consts::TAU * frequency_hz * self.sample_s).cos();
        for ((n, &code), envelope) in (first..).zip(codes).zip(envelope) {
            let (begins_s, code) = (n as f64 * self.sample_s, f64::from(code) - self.mid);
            // A time is a product, and that of the gate may be another.
            let after = |at_s: f64| begins_s > at_s - 0.5 * self.sample_s;
            let begins = code != 0.0 && (self.before[0] == 0.0 || code.abs() > PAID_BACK);
            if now.first_s.is_none() && after(now.gate_s.0) && begins {
                now.first_s = Some(begins_s);
                self.largest = 0.0;
            }
            let predicted = forward * self.before[0] - self.before[1];
            let breaks = (code - predicted).abs() > GOES_ON.0 + GOES_ON.1 * self.largest;
            if now.end_s.is_none() && now.first_s.is_some() && after(now.gate_s.1) && breaks {
                now.end_s = Some(begins_s);
            }
            if now.first_s.is_some() && now.end_s.is_none() && now.rising.len() < self.watched {
                now.rising.push(envelope);
            }
            if now.end_s.is_some() && now.falling.len() < self.watched {
                now.falling.push(envelope);
                if code.abs() > PAID_BACK {
                    now.loud = now.falling.len();
                }
            }
            self.largest = self.largest.max(code.abs());
            self.before = [code, self.before[0]];
        }
    }

    /// Every burst that was watched.
    pub fn finish(mut self) -> Vec<Edges> {
        self.done.extend(self.now.take());
        self.done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OMEGA: f64 = std::f64::consts::TAU * 0.0404;

    /// A burst of 5 periods of 300 codes from sample 1010 on, with or without a brake of two more, and 10 samples paid back.
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
        for (brake, loud) in [(false, 0), (true, 49)] {
            let mut meter = meter();
            for block in 0..60u64 {
                let first = 32 * block;
                if meter.records(first, 32, true) {
                    let codes: Vec<u16> = (0..32).map(|n| (2048.0 + code(first as usize + n, brake)) as u16).collect();
                    meter.take(first, &codes, (0..32).map(|n| (first + n) as f64), 40.4e3);
                }
            }
            let edges = meter.finish();
            assert_eq!(edges.len(), 1);
            let edges = &edges[0];
            let (first, end) = (edges.first_s.unwrap() * 1e6, edges.end_s.unwrap() * 1e6);
            assert!((first - 1010.0).abs() < 0.01 && (end - 1134.0).abs() < 1.01, "{first} {end}");
            assert_eq!((edges.rising[0], edges.falling[0]), (first.round(), end.round()));
            assert!(edges.loud.abs_diff(loud) <= 1, "{} samples of brake", edges.loud);
        }
    }
}
