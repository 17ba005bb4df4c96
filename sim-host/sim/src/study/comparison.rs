//! A comparison: cases at equal peak, rms, power or reduction.

use std::sync::atomic::AtomicBool;

use firmware::seam::fault::Fault;
use rayon::prelude::*;

use super::StudyError;
use super::matching::{Match, Target, find};
use super::plan::{Cell, Made, Plan};
use crate::instruments::sweep::record::SweepRecord;
use crate::metrics::Metrics;
use scene::load::Loaded;
use scene::resolved::resolved_json;
use scene::schema::Schema;
use scene::{Case, Comparison, Equal, Scene};

/// Results of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparisonResult {
    /// Comparison as defined in the scene.
    pub comparison: Comparison,
    /// Cases for each matched quantity.
    pub matches: Vec<Matched>,
    /// Sweeps of the cases with pictures, at the last match.
    pub sweeps: Vec<SweepRecord>,
}

/// Cases at equal peak, rms, power or reduction.
#[derive(Clone, Debug, PartialEq)]
pub struct Matched {
    /// Quantity that is equal in all cases.
    pub equal: Equal,
    /// Metric of the first case that the others are matched to.
    pub target: Option<f64>,
    /// Cases, in the order of the scene.
    pub cases: Vec<CaseResult>,
}

/// A case at equal peak, rms, power or reduction.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseResult {
    /// Name of the case.
    pub name: String,
    /// Amplitude of the case, in the unit of the amplitude key.
    pub amplitude: f64,
    /// Metrics of the case at that amplitude.
    pub metrics: Metrics,
    /// Result of the matching.
    pub standing: Standing,
}

/// Result of matching a case to the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Standing {
    /// The case is matched, up to a relative deviation.
    Equal {
        /// Metric over the first case's, minus one.
        off: f64,
    },
    /// A match would require more than the largest allowed amplitude; amplitude and metrics are
    /// those of the largest.
    Beyond {
        /// Amplitude required for a match.
        needs: f64,
    },
    /// The case cannot be matched, because one of its runs lacks the metric. The amplitude of the
    /// result is the one at which the metric is missing.
    Unmeasured {
        /// Fault that ended the run, if that is the reason.
        fault: Option<Fault>,
    },
}

impl ComparisonResult {
    /// Returns a case by its name.
    pub fn case(&self, name: &str, equal: Equal) -> Option<&CaseResult> {
        self.matches.iter().find(|matched| matched.equal == equal)?.cases.iter().find(|case| case.name == name)
    }
}

impl CaseResult {
    /// Returns a metric, if the case matches the first.
    pub fn metric(&self, name: &str) -> Option<f64> {
        matches!(self.standing, Standing::Equal { .. }).then(|| self.metrics.find(name)).flatten()
    }
}

/// Data that all cases share.
struct CaseRunner<'a> {
    plan: Plan<'a>,
    comparison: &'a Comparison,
}

/// Runs every case of a comparison, in parallel; `None` if it is stopped.
pub(super) fn run(loaded: &Loaded, comparison: &Comparison, stop: &AtomicBool) -> Result<Option<ComparisonResult>, StudyError> {
    let runner = CaseRunner { plan: Plan::new(loaded, stop)?, comparison };
    let cases: Vec<&Case> = comparison.case.iter().collect();
    let peaks = runner.plan.run(cases, |case| runner.cell(case, None), |case, made| runner.peak(case, made))?;
    let Some(peaks) = peaks.into_iter().collect::<Option<Vec<CaseResult>>>() else { return Ok(None) };
    let Some(first) = peaks.first() else { return Ok(None) };
    let pairs: Vec<(Equal, usize)> =
        comparison.matched.iter().flat_map(|&equal| (0..peaks.len()).map(move |case| (equal, case))).collect();
    let matched = |&(equal, case): &(Equal, usize)| runner.matched(equal, &comparison.case[case], &peaks[case], first);
    let cases = pairs.par_iter().map(matched).collect::<Result<Vec<_>, StudyError>>()?;
    let last = &cases[cases.len().saturating_sub(peaks.len())..];
    let drawn: Vec<_> = comparison.case.iter().zip(last).filter(|(case, _)| case.picture).collect();
    let played = |&(case, result): &(&Case, &CaseResult)| runner.cell(case, Some(result.amplitude));
    let sweeps = runner.plan.run(drawn, played, |(case, _), made| made.sweep(&case.name))?;
    if runner.plan.is_stopped() {
        return Ok(None);
    }
    let matches = comparison.matched.iter().zip(cases.chunks(peaks.len())).map(|(&equal, cases)| Matched {
        equal,
        target: goal(first, equal),
        cases: cases.to_vec(),
    });
    let (matches, sweeps) = (matches.collect(), sweeps.into_iter().flatten().flatten().collect());
    Ok(Some(ComparisonResult { comparison: comparison.clone(), matches, sweeps }))
}

impl CaseRunner<'_> {
    /// Returns the cell of a case at an amplitude, or at the scene's own.
    fn cell(&self, case: &Case, amplitude: Option<f64>) -> Cell {
        let scaled = amplitude.map(|amplitude| format!("{}={amplitude}", self.comparison.amplitude_key));
        let label = scaled.iter().fold(format!("`{}`", case.name), |label, scaled| format!("{label}, {scaled}"));
        Cell { label, sets: self.comparison.set.iter().chain(&case.set).chain(&scaled).cloned().collect() }
    }

    /// Runs a case at the scene's amplitude.
    fn peak(&self, case: &Case, made: &Made) -> Result<CaseResult, StudyError> {
        let amplitude = number(&made.scene, &self.comparison.amplitude_key).ok_or(StudyError::Incomplete)?;
        let metrics = made.metrics()?;
        let standing = fault(&metrics).map_or(Standing::Equal { off: 0.0 }, |fault| Standing::Unmeasured { fault: Some(fault) });
        Ok(CaseResult { name: case.name.clone(), amplitude, metrics, standing })
    }

    /// Scales a case until it matches the first.
    fn matched(&self, equal: Equal, case: &Case, peak: &CaseResult, first: &CaseResult) -> Result<CaseResult, StudyError> {
        let Some(metric) = equal.metric() else { return Ok(peak.clone()) };
        let unmeasured = |amplitude: f64, metrics: &Metrics| CaseResult {
            name: case.name.clone(),
            amplitude,
            metrics: metrics.clone(),
            standing: Standing::Unmeasured { fault: fault(metrics) },
        };
        let Some(goal) = goal(first, equal) else { return Ok(unmeasured(peak.amplitude, &peak.metrics)) };
        let made = self.plan.make(self.cell(case, None))?;
        let target =
            Target { metric: goal, exponent: equal.exponent(), allowed: allowed(&made.scene, &self.comparison.amplitude_key) };
        let mut runs = vec![(peak.amplitude, peak.metrics.clone())];
        let found = find(peak.metrics.get(metric), peak.amplitude, target, |amplitude| {
            let metrics = self.plan.make(self.cell(case, Some(amplitude)))?.metrics()?;
            let measured = metrics.get(metric);
            runs.push((amplitude, metrics));
            Ok::<_, StudyError>(measured)
        })?;
        let (point, standing) = match found {
            Match::At(point) => (point, Standing::Equal { off: point.metric / goal - 1.0 }),
            Match::Beyond { needs, reached } => (reached, Standing::Beyond { needs }),
            Match::Unmeasured => {
                let last = runs.pop().unwrap_or_else(|| (peak.amplitude, peak.metrics.clone()));
                return Ok(unmeasured(last.0, &last.1));
            }
        };
        let (amplitude, metrics) =
            runs.into_iter().find(|(amplitude, _)| *amplitude == point.amplitude).ok_or(StudyError::Incomplete)?;
        Ok(CaseResult { name: case.name.clone(), amplitude, metrics, standing })
    }
}

/// Returns the metric of the first case that the others are matched to, unless it is a reduction
/// within rounding errors.
fn goal(first: &CaseResult, equal: Equal) -> Option<f64> {
    const LEAST_PERCENT: f64 = 1e-6;
    first.metrics.get(equal.metric()?).filter(|&value| equal != Equal::Reduction || value > LEAST_PERCENT)
}

/// Returns the fault that ended a run.
fn fault(metrics: &Metrics) -> Option<Fault> {
    metrics.get("fault_code").and_then(|code| Fault::try_from(code as u8).ok())
}

/// Returns a number of a scene.
fn number(scene: &Scene, key: &str) -> Option<f64> {
    resolved_json(scene).pointer(&format!("/{}", key.replace('.', "/")))?.as_f64()
}

/// Returns the smallest and the largest allowed amplitude of a scene, from the range of its key and
/// the limits of the drive.
fn allowed(scene: &Scene, key: &str) -> (f64, f64) {
    let (least, most) = Schema::root().at(key).map_or((None, None), Schema::range);
    let drive = scene.driven().map_or(f64::INFINITY, |scene| {
        let largest_trim = scene.controller.phasing.gain_trim.iter().copied().fold(1.0, f64::max);
        scene.controller.limits.voltage_v.min(scene.amplifier.full_scale_v) / largest_trim
    });
    (least.unwrap_or(0.0), most.unwrap_or(f64::MAX).min(drive))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study;
    use scene::load::load_text;

    /// Scene of a stack without contact: at resonance, with a square wave, far off resonance, and
    /// far off resonance with a low current limit.
    const SCENE: &str = r#"
        title = "Stack"
        duration_s = 0.05
        [controller.drive]
        frequency_hz = 40e3
        amplitude_v = 1.0
        [controller.tracking]
        mode = "off"
        nominal_q = 50
        nominal_c0_f = 300e-9
        [stack.bvd]
        c0_f = 300e-9
        cm_f = 20e-9
        lm_h = 0.7916e-3
        rm_ohm = 3.08
        force_factor_n_per_v = 5.566
        [comparison]
        title = "Tones"
        metrics = ["drive_rms_v", "drive_power_w"]
        amplitude_key = "controller.drive.amplitude_v"
        match = ["peak", "rms", "power"]
        [[comparison.case]]
        name = "sine"
        [[comparison.case]]
        name = "square"
        set = ["controller.drive.shape=square"]
        [[comparison.case]]
        name = "off"
        set = ["controller.drive.frequency_hz=60e3"]
        [[comparison.case]]
        name = "weak"
        set = ["controller.drive.frequency_hz=60e3", "controller.limits.current_a=1"]
    "#;

    #[test]
    fn cases_are_matched_or_have_a_reason() {
        let loaded = load_text("a.toml", SCENE, &[]).unwrap_or_else(|error| panic!("{error}"));
        let study = study::run(&loaded, study::Options::default()).unwrap();
        let result = study.rest.comparison.unwrap();
        let case = |name: &str, equal| result.case(name, equal).unwrap();
        let power = |name: &str| case(name, Equal::Peak).metric("drive_power_w").unwrap();
        let equal =
            |case: &CaseResult| matches!(case.standing, Standing::Equal { off } if off.abs() <= super::super::matching::CLOSE);
        assert!(["sine", "square", "off", "weak"].iter().all(|name| case(name, Equal::Peak).amplitude == 1.0));

        // The rms of codes is proportional to the peak, up to rounding of codes.
        let (sine, square) = (case("sine", Equal::Rms), case("square", Equal::Rms));
        let ratio = case("sine", Equal::Peak).metrics.get("drive_rms_v").unwrap()
            / case("square", Equal::Peak).metrics.get("drive_rms_v").unwrap();
        assert!(equal(sine) && equal(square) && (square.amplitude / ratio - 1.0).abs() < 2e-3, "{square:?}");

        // Without a contact the plant is linear: power is proportional to the square of the
        // amplitude.
        assert!(equal(case("square", Equal::Power)));
        let Standing::Beyond { needs } = case("off", Equal::Power).standing else { panic!("{:?}", case("off", Equal::Power)) };
        assert!((needs / (power("sine") / power("off")).sqrt() - 1.0).abs() < 0.01, "{needs}");
        assert_eq!(case("off", Equal::Power).amplitude, 15.466);
        assert_eq!(case("off", Equal::Power).metric("drive_power_w"), None);
        assert_eq!(case("weak", Equal::Power).standing, Standing::Unmeasured { fault: Some(Fault::OverCurrent) });
    }
}
