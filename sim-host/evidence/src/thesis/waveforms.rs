//! The thesis's excitation waveforms (4.4), with what it leaves open about them.

use super::case::STEP_S;
use super::picture::{axis, column, figure, line};
use contact::{Shape, Waveform};
use report::Figure;

/// First and last frequency of the chirp, Hz (4.4.1).
pub const CHIRP_HZ: (f64, f64) = (20e3, 200e3);
/// Seed of the random waveform.
const SEED: u64 = 2;

/// A waveform with its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Named {
    /// Name in the figures.
    pub name: &'static str,
    /// Shape, of peak one.
    pub shape: Shape,
}

/// How long the random waveform holds a value; the thesis does not say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hold {
    /// A tenth of the period of 60 kHz.
    TenthPeriod,
    /// The step of the thesis's solver.
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

/// Sine, square, sawtooth, chirp (ending with the run) and random.
pub fn all(duration_s: f64, hold: Hold) -> [Named; 5] {
    let chirp = Shape::Chirp { start_hz: CHIRP_HZ.0, stop_hz: CHIRP_HZ.1, sweep_s: duration_s };
    let random = Shape::Random { hold_s: hold.seconds(), seed: SEED };
    let random_name = match hold {
        Hold::TenthPeriod => "random, held T/10",
        Hold::SolverStep => "random, held a solver step",
    };
    [
        Named { name: "sine", shape: Shape::Sine },
        Named { name: "square", shape: Shape::Square },
        Named { name: "sawtooth", shape: Shape::Sawtooth },
        Named { name: "chirp", shape: chirp },
        Named { name: random_name, shape: random },
    ]
}

/// Names as labels of numbers.
pub fn labels(waveforms: &[Named]) -> Vec<String> {
    waveforms.iter().map(|named| named.name.to_owned()).collect()
}

/// Peak that gives a shape the root mean square of a sine of peak one.
pub fn rms_matched_peak(shape: Shape) -> f64 {
    Waveform::shape_rms(Shape::Sine) / Waveform::shape_rms(shape)
}

/// Curves over time as two figures: the periodic waveforms, and the others.
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
    // More periods than can be distinguished are left to the file of numbers.
    let end = time.1.last().copied().unwrap_or(0.0);
    first.x.range = (time.0.ends_with("[ms]")).then_some((0.0, 0.4 * end));
    [first, draw(format!("{id}-chirp-random"), format!("{title}: chirp, random"), others)]
}
