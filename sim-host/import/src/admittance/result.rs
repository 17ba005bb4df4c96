//! Result of an import: the circuit with standard deviations, derived values and warnings.

use nalgebra::DMatrix;
use serde::Serialize;
use serde_json::{Value as Json, json};

use super::circuit::{BRANCH_PARAMETERS, CLAMPED_PARAMETERS, Equivalent};
use super::coordinate::{Coordinate, Topology};
use super::fit::Fit;
use super::measured::Measured;
use super::options::ModeChoice;
use super::passivity;
use super::scene_file::{MAX_FURTHER_MODES, SCENE_HZ};
use crate::error::ImportError;
use report::{rounded, significant};

/// Largest variance of the residuals, relative to their noise from point to point, for a scene.
const MAX_SCENE_MISFIT: f64 = 40.0;

/// Chosen working mode; `None` chooses the strongest.
type Choice = Option<ModeChoice>;

/// Value with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Value {
    /// Value.
    pub value: f64,
    /// Standard deviation of the value, in the same unit.
    pub sd: f64,
}

/// Equivalent circuit of the working mode.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Circuit {
    /// Series resonance, Hz.
    pub series_resonance_hz: Value,
    /// Parallel resonance, Hz, of this mode with the clamped capacitance alone.
    pub parallel_resonance_hz: Value,
    /// Quality factor at the series resonance.
    pub q: Value,
    /// Motional resistance, ohm.
    pub rm_ohm: Value,
    /// Motional inductance, H.
    pub lm_h: Value,
    /// Motional capacitance, F.
    pub cm_f: Value,
    /// Clamped capacitance, F.
    pub c0_f: Value,
    /// Effective coupling.
    pub coupling: Value,
    /// Dielectric loss tangent of the clamped capacitance.
    pub loss_tangent: Value,
}

impl Circuit {
    /// Names of the values, in their order.
    pub const NAMES: [&str; 9] =
        ["series_resonance_hz", "parallel_resonance_hz", "q", "rm_ohm", "lm_h", "cm_f", "c0_f", "coupling", "loss_tangent"];

    /// Returns the values, in the order of the names.
    pub(super) fn values(&self) -> [Value; 9] {
        let c = self;
        [c.series_resonance_hz, c.parallel_resonance_hz, c.q, c.rm_ohm, c.lm_h, c.cm_f, c.c0_f, c.coupling, c.loss_tangent]
    }
}

/// Resonance of the sweep.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Mode {
    /// Series resonance, Hz.
    pub series_resonance_hz: Value,
    /// Quality factor at the series resonance.
    pub q: Value,
    /// Motional resistance, ohm.
    pub rm_ohm: Value,
    /// Motional inductance, H.
    pub lm_h: Value,
    /// Motional capacitance, F.
    pub cm_f: Value,
    /// Figure of merit `Q Cm / C0`.
    pub merit: f64,
    /// `true` for the working mode: the chosen one, or the one with the largest figure of merit.
    pub working: bool,
}

/// Measured admittance with its circuit.
#[derive(Clone, Debug, PartialEq)]
pub struct Admittance {
    /// Name of the transducer, from its file.
    pub name: String,
    /// Measured sweep.
    pub measured: Measured,
    /// Circuit of the working mode.
    pub circuit: Circuit,
    /// Correlations of the values of the circuit, in the order of [`Circuit::NAMES`].
    pub correlations: Vec<Vec<f64>>,
    /// All resonances of the fit, by frequency.
    pub modes: Vec<Mode>,
    /// Fitted circuit with all resonances.
    pub equivalent: Equivalent,
    /// Residuals of the fit in units of the noise.
    pub residuals: Vec<num_complex::Complex64>,
    /// Root mean square of the noise, of real and imaginary part in the coordinate of the
    /// instrument.
    pub noise: [f64; 2],
    /// Correlation of neighbouring residuals; zero if it is not significant.
    pub correlation: f64,
    /// Factor by which the correlation that remains after whitening, or the misfit, has increased
    /// the standard deviations.
    pub inflation: f64,
    /// Variance of the residuals relative to that of their noise from point to point.
    pub misfit: f64,
    /// Warnings for the reader, one sentence each.
    pub warnings: Vec<String>,
}

/// Returns the values of a branch and of the clamped branch, in the order of [`Circuit`].
pub(super) fn derived(parameters: &[f64], farad: f64, at: usize) -> [f64; 9] {
    let circuit = Equivalent::from_parameters(parameters, farad);
    let branch = circuit.branches[at];
    let c0 = circuit.c0_f;
    [
        branch.hz,
        branch.parallel_hz(c0),
        branch.q,
        branch.rm_ohm(),
        branch.lm_h(),
        branch.cm_f(),
        c0,
        branch.coupling(c0),
        circuit.loss_tangent,
    ]
}

/// Propagates the covariance of the parameters to values, standard deviations and correlations of
/// functions of them, by numerical derivatives.
pub(super) fn propagated<const N: usize>(
    parameters: &[f64],
    covariance: &DMatrix<f64>,
    of: impl Fn(&[f64]) -> [f64; N],
) -> ([Value; N], [[f64; N]; N]) {
    /// Step of a numerical derivative, standard deviations.
    const SLOPE_STEP_SIGMAS: f64 = 1e-3;
    let n = parameters.len();
    let slopes: Vec<[f64; N]> = (0..n)
        .map(|at| {
            let step = (SLOPE_STEP_SIGMAS * covariance[(at, at)].sqrt()).max(1e-9 * parameters[at].abs()).max(1e-12);
            let moved = |by: f64| {
                let mut moved = parameters.to_vec();
                moved[at] += by;
                of(&moved)
            };
            let (up, down) = (moved(step), moved(-step));
            std::array::from_fn(|k| (up[k] - down[k]) / (2.0 * step))
        })
        .collect();
    let values = of(parameters);
    let common = |k: usize, l: usize| -> f64 {
        let terms = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        terms.map(|(i, j)| slopes[i][k] * covariance[(i, j)] * slopes[j][l]).sum()
    };
    let sd: [f64; N] = std::array::from_fn(|k| common(k, k).max(0.0).sqrt());
    // A value without a deviation is correlated only with itself.
    let correlation = |k: usize, l: usize| match sd[k] * sd[l] {
        _ if k == l => 1.0,
        product if product > 0.0 => (common(k, l) / product).clamp(-1.0, 1.0),
        _ => 0.0,
    };
    let correlations = std::array::from_fn(|k| std::array::from_fn(|l| correlation(k, l)));
    (std::array::from_fn(|k| Value { value: values[k], sd: sd[k] }), correlations)
}

impl Admittance {
    /// Creates the result from a fit.
    pub(super) fn from_fit(name: String, measured: Measured, fit: Fit, choice: Choice) -> Result<Self, ImportError> {
        let equivalent = Equivalent::from_parameters(&fit.parameters, fit.farad);
        if equivalent.c0_f.is_nan() || equivalent.c0_f <= 0.0 {
            let what = format!("the fit gives a clamped capacitance of {:.3e} F. {}", equivalent.c0_f, passivity::INDUCTIVE);
            return Err(ImportError::NotATransducer(what));
        }
        let working = working(&equivalent, choice)?;
        let of = |at: usize| propagated(&fit.parameters, &fit.covariance, |parameters| derived(parameters, fit.farad, at));
        let (values, correlations) = of(working);
        let [series_resonance_hz, parallel_resonance_hz, q, rm_ohm, lm_h, cm_f, c0_f, coupling, loss_tangent] = values;
        let circuit = Circuit { series_resonance_hz, parallel_resonance_hz, q, rm_ohm, lm_h, cm_f, c0_f, coupling, loss_tangent };
        let mode = |at: usize| {
            let [series_resonance_hz, _, q, rm_ohm, lm_h, cm_f, ..] = of(at).0;
            let merit = equivalent.branches[at].merit(equivalent.c0_f);
            Mode { series_resonance_hz, q, rm_ohm, lm_h, cm_f, merit, working: at == working }
        };
        let mut modes: Vec<Mode> = (0..(fit.parameters.len() - CLAMPED_PARAMETERS) / BRANCH_PARAMETERS).map(mode).collect();
        modes.sort_by(|a, b| a.series_resonance_hz.value.total_cmp(&b.series_resonance_hz.value));
        passivity::check_circuit(&circuit)?;
        let mut warnings = warnings(&measured, &circuit, &fit);
        warnings.extend(near(&modes));
        if modes.len() > 1 + MAX_FURTHER_MODES {
            warnings.push(format!("the scene has only the {MAX_FURTHER_MODES} strongest of the further modes"));
        }
        let Fit { residuals, noise, correlation, inflation, misfit, .. } = fit;
        let correlations = correlations.iter().map(|row| row.to_vec()).collect();
        Ok(Admittance {
            name,
            measured,
            circuit,
            correlations,
            modes,
            equivalent,
            residuals,
            noise,
            correlation,
            inflation,
            misfit,
            warnings,
        })
    }

    /// Returns `true` if the circuit does not describe the data, so that its values cannot be used.
    pub fn is_doubtful(&self) -> bool {
        self.misfit > MAX_SCENE_MISFIT
    }

    /// Returns the result for programs. `scene` is the path of the written scene.
    pub fn json(&self, scene: Option<&str>) -> Json {
        json!({
            "circuit": self.circuit, "correlation": { "names": Circuit::NAMES, "matrix": self.correlations }, "modes": self.modes, "scene": scene, "points": self.measured.hz.len(),
            "from_hz": self.measured.hz.first(), "to_hz": self.measured.hz.last(), "noise": self.noise,
            "residual_correlation": self.correlation, "sd_inflation": self.inflation, "misfit": self.misfit,
            "remarks": self.measured.remarks, "warnings": self.warnings,
        })
    }
}

/// Returns the index of the working mode.
fn working(circuit: &Equivalent, choice: Choice) -> Result<usize, ImportError> {
    /// Largest distance of a chosen frequency from its mode, relative.
    const MAX_CHOICE_REL: f64 = 0.05;
    let branches = &circuit.branches;
    let mut by_hz: Vec<usize> = (0..branches.len()).collect();
    by_hz.sort_by(|a, b| branches[*a].hz.total_cmp(&branches[*b].hz));
    let merit = |at: &usize| branches[*at].merit(circuit.c0_f);
    let found = match choice {
        None => by_hz.iter().max_by(|a, b| merit(a).total_cmp(&merit(b))),
        Some(ModeChoice::Number(number)) => by_hz.get(number - 1),
        Some(ModeChoice::Near(hz)) => {
            let far = |at: &usize| (branches[*at].hz / hz - 1.0).abs();
            by_hz.iter().min_by(|a, b| far(a).total_cmp(&far(b))).filter(|at| far(at) < MAX_CHOICE_REL)
        }
    };
    found.copied().ok_or_else(|| {
        let list = by_hz.iter().enumerate().map(|(at, mode)| format!("{} at {} Hz", at + 1, rounded(branches[*mode].hz, 6)));
        ImportError::NoSuchMode(list.collect::<Vec<_>>().join(", "))
    })
}

/// Returns a warning if further modes are near the working one.
fn near(modes: &[Mode]) -> Option<String> {
    /// Largest relative distance of a near mode.
    const NEAR_REL: f64 = 0.06;
    /// Smallest figure of merit of a near mode, relative to the working one.
    const MIN_MERIT_REL: f64 = 0.02;
    let working = modes.iter().find(|mode| mode.working)?;
    let hz = |mode: &Mode| mode.series_resonance_hz.value;
    let is_near = |mode: &&Mode| {
        !mode.working && mode.merit > MIN_MERIT_REL * working.merit && (hz(mode) / hz(working) - 1.0).abs() < NEAR_REL
    };
    let list: Vec<String> = modes
        .iter()
        .filter(is_near)
        .map(|mode| format!("{:.0} Hz (Rm {} ohm)", hz(mode), rounded(mode.rm_ohm.value, 3)))
        .collect();
    (!list.is_empty()).then(|| {
        let (hz, list) = (hz(working), list.join(", "));
        format!("the working mode is at {hz:.0} Hz; further modes are near, at {list}; `--mode N` or `--mode HZ` chooses one")
    })
}

/// Returns the warnings for the reader.
fn warnings(measured: &Measured, circuit: &Circuit, fit: &Fit) -> Vec<String> {
    /// Variance of the residuals, relative to noise, above which they show an effect that the
    /// circuit does not contain.
    const MAX_MISFIT: f64 = 4.0;
    const MIN_BANDWIDTH_POINTS: usize = 5;
    const MAX_SD_REL: f64 = 0.2;
    /// Largest half-width of a sweep, relative to the resonance.
    const MAX_SWEEP_REL: f64 = 0.3;
    let mut warnings = Vec::new();
    if fit.misfit > MAX_MISFIT {
        warnings.push(format!(
            "the circuit does not describe the data to their noise: the variance of the residuals is {:.0} times that of their \
             noise from point to point, and the standard deviations are multiplied by {:.1}; see the figure of the residuals. \
             Usual causes are a further resonance, a drift during the sweep, an uncorrected fixture, or too high a drive{}",
            fit.misfit,
            fit.inflation,
            if fit.misfit > MAX_SCENE_MISFIT { ". No scene is written without `--force`" } else { "" }
        ));
    }
    if fit.correlation > 0.0 {
        warnings.push(format!(
            "residuals of neighbouring points are correlated ({:.2}); the standard deviations are increased accordingly",
            fit.correlation
        ));
    }
    let (hz, q) = (circuit.series_resonance_hz.value, circuit.q.value);
    if !SCENE_HZ.contains(&hz) {
        warnings.push(format!(
            "no scene is written: the resonance at {} kHz is outside the range that a scene can have, {} Hz to {} kHz",
            significant(rounded(1e-3 * hz, 5)),
            SCENE_HZ.start(),
            1e-3 * SCENE_HZ.end()
        ));
    }
    let band = hz / q;
    let inside = measured.hz.iter().filter(|point| (*point - hz).abs() < 0.5 * band).count();
    if inside < MIN_BANDWIDTH_POINTS {
        warnings.push(format!(
            "only {inside} points are within the bandwidth of {band:.1} Hz around the resonance; sweep a narrower range, or more \
             points"
        ));
    }
    let ends = [measured.hz.first(), measured.hz.last()];
    if ends.into_iter().flatten().any(|end| (end - hz).abs() < band) {
        let half = (5.0 * band).min(MAX_SWEEP_REL * hz);
        warnings.push(format!(
            "the resonance is within a bandwidth of the end of the sweep; sweep from {:.0} to {:.0} Hz",
            hz - half,
            hz + half
        ));
    }
    let uncertain: Vec<&str> = [("Q", circuit.q), ("Rm", circuit.rm_ohm), ("C0", circuit.c0_f), ("coupling", circuit.coupling)]
        .into_iter()
        .filter(|(_, value)| value.sd > MAX_SD_REL * value.value.abs())
        .map(|(name, _)| name)
        .collect();
    if !uncertain.is_empty() {
        let hint = match measured.coordinate {
            Coordinate::Scattering(Topology::OnePort, ohm)
                if circuit.rm_ohm.value > 20.0 * ohm || circuit.rm_ohm.value < 0.05 * ohm =>
            {
                "; one port is insensitive to an impedance so far from its own: measure through two ports (series-through for a \
                 high impedance, shunt-through for a low one)"
            }
            _ => "",
        };
        warnings.push(format!("the data hardly determine {}{hint}", uncertain.join(", ")));
    }
    if circuit.loss_tangent.value < -3.0 * circuit.loss_tangent.sd {
        warnings.push(
            "the loss tangent is negative, due to an error of the angle: correct the fixture, or calibrate again".to_owned(),
        );
    }
    warnings
}
