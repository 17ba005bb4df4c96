//! The second experiment (3.2): a seat belt pulled under the horn of a 20 kHz welder, with
//! vibration across it and loads of 270 to 670 N.
//!
//! ```text
//! statements (two numbers and words) --> empirical law and lag --> scene experiment-2 --> Figures 3.7 to 3.12
//!                                   `--> other laws that fit equally well
//! Hertz's contact: its range, and the trends that it reproduces
//! ```
//!
//! The law is a fit, and every check states so. The scene adds a model: the amplitude that the
//! controller holds, and its power.

mod alternatives;
mod claims;
pub(crate) mod compliant;
pub(crate) mod normal;
mod pictures;
mod table_3_2;

use super::StudyResult;
use super::driven::{self, SceneRun};
use contact::SolveError;
use contact::empirical::EmpiricalLaw;
use report::TableBlock;
use sim::instruments::belt::law::{self as belt_law, AMPLITUDES, FULL_M, LAG_S, LOADS_N, SPEED_M_PER_S};

/// Durations of the vibration, s (3.2.3.1).
pub const ON_TIMES_S: [f64; 4] = [0.5, 1.0, 2.0, 2.5];
/// Start of the ON window of the scene, s.
const ON_S: f64 = 2.0;
/// Assumed delay of the scene's horn after its trigger, s.
const DELAY_S: f64 = 0.05;
/// Name of the scene.
const SCENE: &str = "experiment-2";

/// Run of the scene with its parameters.
struct BeltRun {
    load_n: f64,
    amplitude: f64,
    on_time_s: f64,
    ran: SceneRun,
}

/// All runs.
struct Runs(Vec<BeltRun>);

impl Runs {
    fn new() -> Result<Self, SolveError> {
        let loads = AMPLITUDES.iter().flat_map(|&amplitude| LOADS_N.map(|load_n| (load_n, amplitude, 2.0)));
        let shorter = ON_TIMES_S.iter().filter(|&&on_s| on_s != 2.0).map(|&on_s| (LOADS_N[0], AMPLITUDES[1], on_s));
        let cases: Vec<(f64, f64, f64)> = loads.chain(shorter).collect();
        let sets = |&(load_n, amplitude, on_s): &(f64, f64, f64)| {
            vec![
                format!("rig.belt.load_n={load_n}"),
                format!("rig.belt.amplitude_fraction={amplitude}"),
                format!("controller.burst.off_s=[{}]", ON_S + on_s),
            ]
        };
        let runs = driven::each(SCENE, &cases.iter().map(sets).collect::<Vec<_>>())?;
        let case = |((load_n, amplitude, on_time_s), ran)| BeltRun { load_n, amplitude, on_time_s, ran };
        Ok(Runs(cases.into_iter().zip(runs).map(case).collect()))
    }

    fn case(&self, load_n: f64, amplitude: f64, on_time_s: f64) -> Result<&BeltRun, SolveError> {
        let same = |case: &&BeltRun| (case.load_n, case.amplitude, case.on_time_s) == (load_n, amplitude, on_time_s);
        self.0.iter().find(same).ok_or(SolveError::Unsuited { method: "a scene", reason: "no such case".into() })
    }

    /// Returns a metric after 2 s ON.
    fn metric(&self, name: &str, load_n: f64, amplitude: f64) -> Result<f64, SolveError> {
        self.case(load_n, amplitude, 2.0)?.ran.metric(name)
    }

    /// Returns the reductions after 2 s ON over the loads, %.
    fn over_load(&self, amplitude: f64) -> Result<Vec<f64>, SolveError> {
        LOADS_N.iter().map(|&load_n| self.metric("reduction_percent", load_n, amplitude)).collect()
    }

    /// Returns the reductions over the ON times at 270 N and 70 %, %.
    fn over_time(&self) -> Result<Vec<f64>, SolveError> {
        let at = |&on_s: &f64| self.case(LOADS_N[0], AMPLITUDES[1], on_s)?.ran.metric("reduction_percent");
        ON_TIMES_S.iter().map(at).collect()
    }
}

/// Tabulates Table 3.2, the law with its constants and residuals, other laws, Hertz's contact, and
/// a compliant contact.
pub fn tables() -> Vec<TableBlock> {
    let law = EmpiricalLaw::FITTED;
    vec![
        table_3_2::table(),
        belt_law::constants(law, LAG_S),
        belt_law::residuals(law, LAG_S),
        alternatives::table(),
        normal::table(),
        compliant::belt(),
        compliant::speeds(),
    ]
}

fn load_labels() -> Vec<String> {
    LOADS_N.iter().map(|load| format!("{load} N")).collect()
}

fn time_labels() -> Vec<String> {
    ON_TIMES_S.iter().map(|on_s| format!("{on_s} s")).collect()
}

/// Computes Figures 3.7 to 3.12, two figures that explain them, and the claims of 3.2.
pub fn study() -> Result<StudyResult, SolveError> {
    let runs = Runs::new()?;
    Ok(StudyResult { figures: pictures::all(&runs)?, claims: claims::all(&runs)? })
}
