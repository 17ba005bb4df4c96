//! The first experiment (3.1): a transducer that slides on a rail, tangential vibration at 40 kHz,
//! loads of 0 to 10 N.
//!
//! ```text
//! Table 3.1 --> stack (set A3, from measured values) --> scenes experiment-1, experiment-1-fast --> Figures 3.4, 3.5
//! ```
//!
//! All numbers come from runs of the scenes (controller on the host, contact coupled to the stack).
//! Fitted parameters occur only in the scene `experiment-1-fitted`, and in checks that state so.

mod claims;
pub(super) mod table_3_1;

pub(crate) use claims::reductions;
pub use table_3_1::table;

use super::StudyResult;
use super::driven::{self, SceneRun};
use super::picture::{axis, dashed, figure, line};
use contact::SolveError;
use plant::dahl::Dahl;
use plant::load_cell::LoadCell;
use report::{Figure, Span};

/// Loads on the lever, N (3.1.4).
pub const LOADS_N: [f64; 5] = [0.0, 1.0, 2.0, 5.0, 10.0];
/// Cases: scene, sliding speed, m/s, ON window, s, and number of the thesis's figure.
const CASES: [(&str, f64, (f64, f64), &str); 2] =
    [("experiment-1", 0.038, (3.0, 5.0), "4"), ("experiment-1-fast", 0.068, (1.5, 2.5), "5")];
/// Contact stiffness of both scenes, N/m, from Table 4.1.
const KT_N_PER_M: f64 = 0.056e6;
/// Coefficient of friction of both scenes: aluminium on aluminium.
const MU: f64 = 0.3;
/// Weight of the transducer, N.
const SELF_WEIGHT_N: f64 = 0.48;
/// Bandwidth of the recorder, Hz (3.1.3).
const CELL_HZ: f64 = 80.0;

/// Runs at one sliding speed.
struct SpeedRuns {
    scene: &'static str,
    sliding_m_per_s: f64,
    on_s: (f64, f64),
    number: &'static str,
    /// Runs, one for each load.
    ran: Vec<SceneRun>,
}

impl SpeedRuns {
    fn reductions(&self) -> Result<Vec<f64>, SolveError> {
        self.ran.iter().map(|ran| ran.metric("reduction_percent")).collect()
    }
}

fn loads() -> Vec<Vec<String>> {
    LOADS_N.iter().map(|load| vec![format!("rig.slider.load_n={load}")]).collect()
}

fn labels() -> Vec<String> {
    LOADS_N.iter().map(|load| format!("{load} N")).collect()
}

/// Computes Figures 3.4 and 3.5 and the claims of 3.1.
pub fn study() -> Result<StudyResult, SolveError> {
    let speed = |(scene, sliding_m_per_s, on_s, number)| {
        Ok(SpeedRuns { scene, sliding_m_per_s, on_s, number, ran: driven::each(scene, &loads())? })
    };
    let speeds = CASES.into_iter().map(speed).collect::<Result<Vec<_>, SolveError>>()?;
    let figures = speeds.iter().flat_map(|speed| [off(speed), on(speed)]).collect();
    Ok(StudyResult { figures, claims: claims::judge(&speeds)? })
}

fn off(speed: &SpeedRuns) -> Figure {
    // The pull begins at once, and the cell follows it: a sliding contact reaches Fc after some
    // Dahl lengths, a tenth of a millisecond.
    let step_s = 1e-3;
    let time_s: Vec<f64> = (1..=500).map(|step| f64::from(step) * step_s).collect();
    let curve = |load: f64| {
        let mut contact = Dahl::new(KT_N_PER_M, MU * (load + SELF_WEIGHT_N));
        let mut cell = LoadCell::new(CELL_HZ, step_s);
        let slip = speed.sliding_m_per_s;
        time_s.iter().map(|_| -cell.measure(contact.slip(slip, slip, slip * step_s, step_s))).collect::<Vec<_>>()
    };
    let series = LOADS_N.iter().map(|&load| line(format!("{load} N"), format!("friction_{load}_n"), &time_s, curve(load)));
    let caption = format!(
        "Model, nothing fitted. Friction over time at {} m/s without vibration; negative is compression of the load cell \
         (80 Hz), as in the thesis. Contact of Table 4.1, mu 0.3 (assumed), the load plus 0.48 N of own weight. Dahl's \
         friction has no static peak above its kinetic value: the overshoot is due to the cell's filter. The thesis calls \
         its first compression static friction.",
        speed.sliding_m_per_s
    );
    let title = format!("Figure 3.{}(a): friction at {} m/s, OFF", speed.number, speed.sliding_m_per_s);
    let axes = [axis("time [s]"), axis("friction [N]")];
    figure(&format!("fig-3-0{}a", speed.number), &title, caption, axes, series.collect())
}

fn on(speed: &SpeedRuns) -> Figure {
    let negative = |values: &[f64]| values.iter().map(|value| -value).collect::<Vec<_>>();
    let series = LOADS_N
        .iter()
        .zip(&speed.ran)
        .map(|(load, ran)| line(format!("{load} N"), format!("load_cell_{load}_n"), &ran.time_s, negative(&ran.cell_n)));
    let mut series: Vec<_> = series.collect();
    if let Some(ran) = speed.ran.last() {
        series.push(dashed("10 N, true mean", "friction_true_10_n", &ran.time_s, negative(&ran.friction_n)));
    }
    let caption = format!(
        "Model, nothing fitted: the scene {} with the controller on the host and friction coupled to the stack, at each \
         load. The load cell (80 Hz) shows the mean; negative is compression. In the first tenth of a second self-test, \
         calibration and lock also drive the stack.",
        speed.scene
    );
    let (from, to) = speed.on_s;
    let title = format!("Figure 3.{}(b): friction at {} m/s, ON from {from} to {to} s", speed.number, speed.sliding_m_per_s);
    let axes = [axis("time [s]"), axis("friction [N]")];
    Figure {
        shaded: vec![Span { from, to, label: "ON".into() }],
        ..figure(&format!("fig-3-0{}b", speed.number), &title, caption, axes, series)
    }
}
