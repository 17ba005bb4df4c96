//! Record of one sweep of a run, sample by sample.

use crate::record::{Record, Trigger, Window};
use crate::schedule::first_window;
use plant::circuit_of;
use scene::{Around, ChirpKind, Driven, Then};

/// Title of the window that contains a sweep.
pub const TITLE: &str = "sweep";
/// Time after the edge of a burst, s, after which a repeated sweep is recorded; the ring-up has
/// then ended.
const SETTLE_S: f64 = 0.02;

/// Frequency law of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepLaw {
    /// Frequency at the beginning, Hz.
    pub start_hz: f64,
    /// Frequency at the end, Hz.
    pub stop_hz: f64,
    /// Duration, s.
    pub time_s: f64,
    /// `true` if the frequency changes by equal factors in equal times; otherwise by equal steps.
    pub exponential: bool,
}

impl SweepLaw {
    /// Returns the frequency at a time after the beginning, Hz.
    pub fn frequency_hz(&self, after_s: f64) -> f64 {
        let share = after_s / self.time_s;
        if self.exponential {
            self.start_hz * (self.stop_hz / self.start_hz).powf(share)
        } else {
            self.start_hz + share * (self.stop_hz - self.start_hz)
        }
    }

    /// Returns the time at which the sweep passes a frequency, s from its beginning; `None` if it
    /// does not.
    pub fn passes_s(&self, hz: f64) -> Option<f64> {
        let share = if self.exponential {
            (hz / self.start_hz).ln() / (self.stop_hz / self.start_hz).ln()
        } else {
            (hz - self.start_hz) / (self.stop_hz - self.start_hz)
        };
        (0.0..=1.0).contains(&share).then_some(share * self.time_s)
    }

    /// Returns the minimum rate of the frequency, Hz/s; for an exponential sweep, that at its lower
    /// end.
    pub fn slowest_hz_per_s(&self) -> f64 {
        let factor = (self.stop_hz / self.start_hz).ln();
        let slope = if self.exponential { self.start_hz.min(self.stop_hz) * factor } else { self.stop_hz - self.start_hz };
        (slope / self.time_s).abs()
    }
}

/// A sweep as played, with the plant's response.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepRecord {
    /// Name of the case; empty for the scene's own run.
    pub name: String,
    /// Samples from the beginning of the sweep on.
    pub window: Window,
    /// Duration of a sample, s.
    pub sample_s: f64,
    /// Frequency law.
    pub law: SweepLaw,
    /// Series resonance of the stack, Hz.
    pub resonance_hz: f64,
    /// Time constant of the stack, s.
    pub time_constant_s: f64,
    /// `true` if the scene has friction.
    pub rubs: bool,
}

/// Returns the sweep of a scene with fixed frequencies, rounded to whole blocks, and the action
/// after it.
fn law(scene: &Driven) -> Option<(SweepLaw, Then)> {
    let sweep = scene.controller.sweep.as_ref().filter(|sweep| sweep.around == Around::Zero)?;
    let time_s = (sweep.time_s / block_s(scene)).round().max(1.0) * block_s(scene);
    let exponential = sweep.kind == ChirpKind::Exponential;
    Some((SweepLaw { start_hz: sweep.start_hz, stop_hz: sweep.stop_hz, time_s, exponential }, sweep.then))
}

fn block_s(scene: &Driven) -> f64 {
    f64::from(scene.controller.block_samples) / scene.sensors.sample_hz
}

/// Returns the window of the first complete sweep under drive, or of the only sweep.
pub fn window(scene: &Driven) -> Option<Window> {
    let (law, then) = law(scene)?;
    let on_s = scene.controller.burst.as_ref().and_then(|burst| first_window(burst, 0.0)).map_or(0.0, |(on, _)| on);
    let from_s = if then == Then::Hold { 0.0 } else { on_s + SETTLE_S };
    let [first_hz, second_hz] = [0.5, 1.5].map(|blocks| law.frequency_hz(blocks * block_s(scene)));
    let trigger = Some(Trigger { first_hz, second_hz, before_hz: 0.0 });
    Some(Window { title: TITLE.into(), from_s, to_s: from_s + law.time_s, trigger, ..Window::default() })
}

impl SweepRecord {
    /// Returns the recorded sweep of a run, if it has one and reached it.
    pub fn from_record(name: &str, scene: &Driven, record: &Record) -> Option<Self> {
        let (law, _) = law(scene)?;
        let window = record.windows.iter().find(|window| window.title == TITLE && !window.samples.is_empty())?;
        let circuit = circuit_of(scene);
        Some(SweepRecord {
            name: name.to_owned(),
            window: window.clone(),
            sample_s: record.sample_s,
            law,
            resonance_hz: circuit.series_resonance_hz(),
            time_constant_s: circuit.time_constant_s(),
            rubs: scene.sliding().is_some(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(exponential: bool) -> SweepLaw {
        SweepLaw { start_hz: 20e3, stop_hz: 200e3, time_s: 0.01, exponential }
    }

    #[test]
    fn sweep_passes_each_frequency_once() {
        let near = |found: Option<f64>, expected: f64| assert!((found.unwrap() - expected).abs() < 1e-12, "{found:?} {expected}");
        near(law(false).passes_s(40e3), 0.01 / 9.0);
        near(law(true).passes_s(40e3), 0.01 * 2f64.log10());
        let down = SweepLaw { start_hz: 200e3, stop_hz: 20e3, ..law(false) };
        near(down.passes_s(40e3), 0.08 / 9.0);
        assert!((law(true).frequency_hz(law(true).passes_s(123e3).unwrap()) - 123e3).abs() < 1e-6);
        assert_eq!((down.passes_s(19e3), down.passes_s(201e3)), (None, None));
    }

    #[test]
    fn slowest_rate_is_the_frequency_derivative() {
        assert!((law(false).slowest_hz_per_s() - 1.8e7).abs() < 1e-3);
        let dt = 1e-8;
        let slope = (law(true).frequency_hz(dt) - law(true).frequency_hz(0.0)) / dt;
        assert!((law(true).slowest_hz_per_s() / slope - 1.0).abs() < 1e-5);
    }
}
