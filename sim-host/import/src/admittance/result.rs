//! Result of an import: the circuit with standard deviations, derived values and warnings.

use nalgebra::DMatrix;
use serde::Serialize;
use serde_json::{Value as Json, json};

use super::circuit::{BRANCH_PARAMETERS, Branch, CLAMPED_PARAMETERS, Equivalent};
use super::coordinate::{Coordinate, Topology};
use super::fit::Fit;
use super::measured::Measured;
use crate::error::ImportError;

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
    /// `true` for the working mode, which has the largest motional capacitance.
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
    /// Factor by which the correlation that remains after whitening has increased the standard
    /// deviations.
    pub inflation: f64,
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
    pub(super) fn from_fit(name: &str, measured: Measured, fit: Fit) -> Result<Self, ImportError> {
        let equivalent = Equivalent::from_parameters(&fit.parameters, fit.farad);
        if equivalent.c0_f.is_nan() || equivalent.c0_f <= 0.0 {
            let what =
                format!("the fit gives a clamped capacitance of {:.3e} F; check topology, units and fixture", equivalent.c0_f);
            return Err(ImportError::NotATransducer(what));
        }
        let capacitance = |branch: &Branch| branch.cm_f();
        let by_capacitance = |(_, a): &(usize, &Branch), (_, b): &(usize, &Branch)| capacitance(a).total_cmp(&capacitance(b));
        let working = equivalent.branches.iter().enumerate().max_by(by_capacitance).map_or(0, |(at, _)| at);
        let of = |at: usize| propagated(&fit.parameters, &fit.covariance, |parameters| derived(parameters, fit.farad, at));
        let (values, correlations) = of(working);
        let [series_resonance_hz, parallel_resonance_hz, q, rm_ohm, lm_h, cm_f, c0_f, coupling, loss_tangent] = values;
        let circuit = Circuit { series_resonance_hz, parallel_resonance_hz, q, rm_ohm, lm_h, cm_f, c0_f, coupling, loss_tangent };
        let mode = |at: usize| {
            let [series_resonance_hz, _, q, rm_ohm, lm_h, cm_f, ..] = of(at).0;
            Mode { series_resonance_hz, q, rm_ohm, lm_h, cm_f, working: at == working }
        };
        let mut modes: Vec<Mode> = (0..(fit.parameters.len() - CLAMPED_PARAMETERS) / BRANCH_PARAMETERS).map(mode).collect();
        modes.sort_by(|a, b| a.series_resonance_hz.value.total_cmp(&b.series_resonance_hz.value));
        let warnings = warnings(&measured, &circuit, &fit);
        let Fit { residuals, noise, correlation, inflation, .. } = fit;
        let name = name.to_owned();
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
            warnings,
        })
    }

    /// Returns the result for programs. `scene` is the path of the written scene.
    pub fn json(&self, scene: Option<&str>) -> Json {
        json!({
            "circuit": self.circuit, "correlation": { "names": Circuit::NAMES, "matrix": self.correlations }, "modes": self.modes, "scene": scene, "points": self.measured.hz.len(),
            "from_hz": self.measured.hz.first(), "to_hz": self.measured.hz.last(), "noise": self.noise,
            "residual_correlation": self.correlation, "sd_inflation": self.inflation, "remarks": self.measured.remarks,
            "warnings": self.warnings,
        })
    }
}

/// Returns the warnings for the reader.
fn warnings(measured: &Measured, circuit: &Circuit, fit: &Fit) -> Vec<String> {
    /// Variance of the residuals, relative to noise, above which they show an effect that the
    /// circuit does not contain.
    const MAX_MISFIT: f64 = 4.0;
    const MIN_BANDWIDTH_POINTS: usize = 5;
    const MAX_SD_REL: f64 = 0.2;
    let mut warnings = Vec::new();
    if fit.misfit > MAX_MISFIT {
        warnings.push(format!(
            "the circuit does not describe the data to their noise: the variance of the residuals is {:.0} times that of their \
             noise from point to point; see the figure of the residuals. Usual causes are a further resonance, a drift during \
             the sweep, an uncorrected fixture, or too high a drive",
            fit.misfit
        ));
    }
    if fit.correlation > 0.0 {
        warnings.push(format!(
            "residuals of neighbouring points are correlated ({:.2}); the standard deviations are increased accordingly",
            fit.correlation
        ));
    }
    let (hz, q) = (circuit.series_resonance_hz.value, circuit.q.value);
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
        warnings.push(format!(
            "the resonance is within a bandwidth of the end of the sweep; sweep from {:.0} to {:.0} Hz",
            hz - 5.0 * band,
            hz + 5.0 * band
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
