//! One sweep of a run, sample by sample.

use crate::plant::circuit::Circuit;
use crate::record::{Record, Window};
use crate::scene::{Around, ChirpKind, Driven, Sweep, Then};
use crate::schedule::first_window;

/// Title of the window that holds a sweep.
pub const TITLE: &str = "sweep";
/// After the edge of a burst, the stack rings up; a sweep that comes again is taken later, s.
const SETTLE_S: f64 = 0.02;

/// A sweep as it was played, and what the plant made of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Swept {
    /// What it is called; empty for the scene's own run.
    pub name: String,
    /// The samples, from the sweep's beginning on.
    pub window: Window,
    /// Duration of a sample, s.
    pub sample_s: f64,
    /// Frequency at its beginning, Hz.
    pub start_hz: f64,
    /// Frequency at its end, Hz.
    pub stop_hz: f64,
    /// How long it takes, s.
    pub time_s: f64,
    /// Whether the frequency grows by equal factors in equal times, rather than by equal steps.
    pub exponential: bool,
    /// The stack's series resonance, Hz.
    pub resonance_hz: f64,
    /// The stack's time constant, s.
    pub time_constant_s: f64,
    /// Whether there is friction.
    pub rubs: bool,
}

/// The sweep of a scene whose frequencies are known beforehand.
fn sweep<'a>(scene: &Driven<'a>) -> Option<&'a Sweep> {
    scene.controller.sweep.as_ref().filter(|sweep| sweep.around == Around::Zero)
}

/// The window that holds the first whole sweep under drive, or of one that comes only once, that one.
pub fn window(scene: &Driven) -> Option<Window> {
    let sweep = sweep(scene)?;
    let on_s = scene.controller.burst.as_ref().and_then(|burst| first_window(burst, 0.0)).map_or(0.0, |(on, _)| on);
    let from_s = if sweep.then == Then::Hold { 0.0 } else { on_s + SETTLE_S };
    let to_s = from_s + sweep.time_s;
    Some(Window { title: TITLE.into(), from_s, to_s, trigger_hz: Some(sweep.start_hz), ..Window::default() })
}

impl Swept {
    /// What a run has recorded of its sweep, if it has one and came to it.
    pub fn of(name: &str, scene: &Driven, record: &Record) -> Option<Self> {
        let sweep = sweep(scene)?;
        let window = record.windows.iter().find(|window| window.title == TITLE && !window.samples.is_empty())?;
        let circuit = Circuit::of(&scene.stack.bvd);
        Some(Swept {
            name: name.to_owned(),
            window: window.clone(),
            sample_s: record.sample_s,
            start_hz: sweep.start_hz,
            stop_hz: sweep.stop_hz,
            time_s: window.samples.len() as f64 * record.sample_s,
            exponential: sweep.kind == ChirpKind::Exponential,
            resonance_hz: circuit.series_resonance_hz(),
            time_constant_s: circuit.time_constant_s(),
            rubs: scene.sliding.is_some(),
        })
    }

    /// Its frequency so long after its beginning, Hz.
    pub fn frequency_hz(&self, after_s: f64) -> f64 {
        let share = after_s / self.time_s;
        if self.exponential {
            self.start_hz * (self.stop_hz / self.start_hz).powf(share)
        } else {
            self.start_hz + share * (self.stop_hz - self.start_hz)
        }
    }

    /// When the sweep passes a frequency, s from its beginning; nothing if it does not.
    pub fn passes_s(&self, hz: f64) -> Option<f64> {
        let share = if self.exponential {
            (hz / self.start_hz).ln() / (self.stop_hz / self.start_hz).ln()
        } else {
            (hz - self.start_hz) / (self.stop_hz - self.start_hz)
        };
        (0.0..=1.0).contains(&share).then_some(share * self.time_s)
    }

    /// How fast the frequency moves where it is slowest, Hz/s: at the lower end, of an exponential sweep.
    pub fn slowest_hz_per_s(&self) -> f64 {
        let factor = (self.stop_hz / self.start_hz).ln();
        let slope = if self.exponential { self.start_hz.min(self.stop_hz) * factor } else { self.stop_hz - self.start_hz };
        (slope / self.time_s).abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep(exponential: bool) -> Swept {
        Swept {
            name: String::new(),
            window: Window::default(),
            sample_s: 1e-6,
            start_hz: 20e3,
            stop_hz: 200e3,
            time_s: 0.01,
            exponential,
            resonance_hz: 40e3,
            time_constant_s: 5e-4,
            rubs: true,
        }
    }

    #[test]
    fn it_passes_each_frequency_once() {
        let near = |found: Option<f64>, expected: f64| assert!((found.unwrap() - expected).abs() < 1e-12, "{found:?} {expected}");
        near(sweep(false).passes_s(40e3), 0.01 / 9.0);
        near(sweep(true).passes_s(40e3), 0.01 * 2f64.log10());
        let down = Swept { start_hz: 200e3, stop_hz: 20e3, ..sweep(false) };
        near(down.passes_s(40e3), 0.08 / 9.0);
        assert!((sweep(true).frequency_hz(sweep(true).passes_s(123e3).unwrap()) - 123e3).abs() < 1e-6);
        assert_eq!((down.passes_s(19e3), down.passes_s(201e3)), (None, None));
    }

    #[test]
    fn its_slope_is_that_of_its_frequency() {
        assert!((sweep(false).slowest_hz_per_s() - 1.8e7).abs() < 1e-3);
        let (swept, dt) = (sweep(true), 1e-8);
        let early = swept.start_hz * 10f64.powf(dt / swept.time_s) - swept.start_hz;
        assert!((swept.slowest_hz_per_s() / (early / dt) - 1.0).abs() < 1e-5);
    }
}
