//! The thesis's excitation waveforms (4.4), with choices where it is silent.

use super::case::STEP_S;
use super::picture::{axis, column, figure, line};
use contact::{Shape, Waveform};
use report::Figure;

/// First and last frequency of the chirp, Hz (4.4.1).
pub const CHIRP_HZ: (f64, f64) = (20e3, 200e3);
/// Seed of the random waveform.
const SEED: u64 = 2;

/// Waveform with its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NamedWaveform {
    /// Name in the figures.
    pub name: &'static str,
    /// Shape, with a peak of one.
    pub shape: Shape,
}

/// Hold time of the random waveform's values, which the thesis leaves open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hold {
    /// A tenth of the period of 60 kHz.
    TenthPeriod,
    /// The time step of the thesis's solver.
    SolverStep,
}

impl Hold {
    fn seconds(self) -> f64 {
        match self {
            Hold::TenthPeriod => 0.1 / 60e3,
            Hold::SolverStep => STEP_S,
        }
    }
}

/// Returns sine, square, sawtooth, chirp (ending with the run) and random.
pub fn all(duration_s: f64, hold: Hold) -> [NamedWaveform; 5] {
    let chirp = Shape::Chirp { start_hz: CHIRP_HZ.0, stop_hz: CHIRP_HZ.1, sweep_s: duration_s };
    let random = Shape::Random { hold_s: hold.seconds(), seed: SEED };
    let random_name = match hold {
        Hold::TenthPeriod => "random, held T/10",
        Hold::SolverStep => "random, held a solver step",
    };
    [
        NamedWaveform { name: "sine", shape: Shape::Sine },
        NamedWaveform { name: "square", shape: Shape::Square },
        NamedWaveform { name: "sawtooth", shape: Shape::Sawtooth },
        NamedWaveform { name: "chirp", shape: chirp },
        NamedWaveform { name: random_name, shape: random },
    ]
}

/// Returns the names as labels of numbers.
pub fn labels(waveforms: &[NamedWaveform]) -> Vec<String> {
    waveforms.iter().map(|named| named.name.to_owned()).collect()
}

/// Returns the peak that gives a shape the root mean square of a sine of peak one.
pub fn rms_matched_peak(shape: Shape) -> f64 {
    Waveform::shape_rms(Shape::Sine) / Waveform::shape_rms(shape)
}

/// Draws curves over time as two figures: the periodic waveforms, and the others.
pub fn two_figures(
    id: &str,
    title: &str,
    caption: &str,
    label: &str,
    time: (&str, &[f64]),
    curves: &[(&str, Vec<f64>)],
) -> [Figure; 2] {
    let draw = |id: String, title: String, curves: &[(&str, Vec<f64>)]| {
        let series = curves.iter().map(|(name, y)| line(*name, column("waveform", name), time.1, y.clone())).collect();
        figure(&id, &title, caption.into(), [axis(time.0), axis(label)], series)
    };
    let (periodic, others) = curves.split_at(3);
    let mut first = draw(id.into(), format!("{title}: sine, square, sawtooth"), periodic);
    // Shows a part of the periods, as all could not be distinguished; the data file has all.
    let end = time.1.last().copied().unwrap_or(0.0);
    first.x.range = (time.0.ends_with("[ms]")).then_some((0.0, 0.4 * end));
    [first, draw(format!("{id}-chirp-random"), format!("{title}: chirp, random"), others)]
}
