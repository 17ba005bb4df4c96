//! Measured and fitted friction ratio of each condition.

use super::fit::Fit;
use super::measurement::Measurement;
use super::model::Point;
use report::{rounded, significant};

/// Condition with vibration.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Condition {
    /// Sliding speed, m/s.
    pub speed_m_per_s: f64,
    /// Normal force, N.
    pub normal_n: Option<f64>,
    /// Strength of the vibration in its unit.
    pub level: Option<f64>,
    /// Words of the text columns.
    pub label: String,
    /// Number of measurements with vibration.
    pub on: usize,
    /// Number of measurements without vibration at the same speed and load; 0 if the ratio is that
    /// to the fitted friction.
    pub off: usize,
    /// Measured friction ratio.
    pub measured: f64,
    /// Standard deviation of the measured ratio, from the noise and the scatter.
    pub sd: f64,
    /// Fitted friction ratio.
    pub fitted: f64,
    /// Weighted sum of squares of the ON measurements about their mean.
    #[serde(skip)]
    within: f64,
}

/// Largest difference of two values of the same condition, relative.
const SAME_REL: f64 = 0.05;
/// Ratio of the squares of misfit and scatter above which a warning names the misfit.
const MAX_MISFIT: f64 = 4.0;

impl Condition {
    /// Returns measured minus fitted ratio, standard deviations.
    pub fn residual(&self) -> f64 {
        (self.measured - self.fitted) / self.sd
    }
}

fn is_same(a: Option<f64>, b: Option<f64>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() <= SAME_REL * a.abs().max(b.abs()),
        (a, b) => a == b,
    }
}

/// Groups the measurements with vibration in conditions, by strength of the vibration, load and
/// speed.
pub(super) fn conditions(measurements: &[Measurement], fit: &Fit) -> Vec<Condition> {
    let level = |m: &Measurement| m.level.or(m.tip_m_per_s);
    let is_place = |a: &Measurement, b: &Measurement| {
        is_same(Some(a.speed_m_per_s), Some(b.speed_m_per_s)) && is_same(a.normal_n, b.normal_n) && a.label == b.label
    };
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (at, m) in measurements.iter().enumerate().filter(|(_, m)| m.on) {
        let known = groups.iter_mut().find(|group| {
            let first = &measurements[group[0]];
            is_place(first, m) && is_same(level(first), level(m))
        });
        match known {
            Some(group) => group.push(at),
            None => groups.push(vec![at]),
        }
    }
    // Weighted mean and its variance.
    let mean = |rows: &[usize]| {
        let weight: f64 = rows.iter().map(|at| 1.0 / fit.variances[*at]).sum();
        (rows.iter().map(|at| measurements[*at].mu / fit.variances[*at]).sum::<f64>() / weight, 1.0 / weight)
    };
    let slice = &fit.slices[fit.chosen];
    let of = fit.model.parameters(&slice.fitted, slice.ln_compliance);
    let one = |group: &Vec<usize>| {
        let first = &measurements[group[0]];
        let off: Vec<usize> =
            (0..measurements.len()).filter(|at| !measurements[*at].on && is_place(&measurements[*at], first)).collect();
        let average = |value: &dyn Fn(&Measurement) -> Option<f64>| {
            group.iter().map(|at| value(&measurements[*at])).sum::<Option<f64>>().map(|sum| sum / group.len() as f64)
        };
        let speed_m_per_s = average(&|m| Some(m.speed_m_per_s)).unwrap_or(first.speed_m_per_s);
        let normal_n = average(&|m| m.normal_n);
        let point = Point { speed_m_per_s, normal_n: normal_n.unwrap_or(1.0), ..Point::new(first) };
        let (on_mu, on_variance) = mean(group);
        let (off_mu, off_variance) = match off.is_empty() {
            true => (fit.model.mu(&of, &Point { drive: None, ..point }), 0.0),
            false => mean(&off),
        };
        let measured = on_mu / off_mu;
        Condition {
            speed_m_per_s,
            normal_n,
            level: first.level.or(first.tip_m_per_s),
            label: first.label.clone(),
            on: group.len(),
            off: off.len(),
            measured,
            sd: (on_variance + measured * measured * off_variance).sqrt() / off_mu,
            fitted: fit.model.ratio(&of, &point),
            within: group.iter().map(|at| (measurements[*at].mu - on_mu).powi(2) / fit.variances[*at]).sum(),
        }
    };
    let mut conditions: Vec<Condition> = groups.iter().map(one).collect();
    // Means of the same condition differ in the last digits.
    let key = |c: &Condition| [c.level, c.normal_n, Some(c.speed_m_per_s)].map(|value| rounded(value.unwrap_or(0.0), 2));
    conditions.sort_by(|a, b| a.label.cmp(&b.label).then(key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal)));
    conditions
}

/// Returns `true` if the fit misses the conditions by more than the scatter of their repeats.
pub(super) fn is_misfit(conditions: &[Condition], fit: &Fit) -> bool {
    let repeats: usize = conditions.iter().map(|c| c.on - 1).sum();
    let within: f64 = conditions.iter().map(|c| c.within).sum();
    let freedom = conditions.len().saturating_sub(fit.model.count()).max(1) as f64;
    let misfit: f64 = conditions.iter().map(|c| c.residual().powi(2)).sum::<f64>() / freedom;
    repeats >= 3 && misfit > MAX_MISFIT * within / repeats as f64
}

/// Returns warnings about the fit.
pub(super) fn warnings(conditions: &[Condition], fit: &Fit) -> Vec<String> {
    let mut warnings = Vec::new();
    if is_misfit(conditions, fit) {
        warnings.push(
            "the model does not fit: the residuals exceed the scatter of the repeats, and the intervals contain them".into(),
        );
    }
    if conditions.iter().all(|c| c.on == 1) {
        warnings.push("no condition ON is repeated: the scatter is that of the residuals of the fit".into());
    }
    if let Some(worst) =
        conditions.iter().filter(|c| c.residual().abs() > 3.0).max_by(|a, b| a.residual().abs().total_cmp(&b.residual().abs()))
    {
        warnings.push(format!(
            "the ratio at {} m/s differs from the fit by {:.1} standard deviations",
            significant(worst.speed_m_per_s),
            worst.residual()
        ));
    }
    if conditions.iter().all(|c| c.measured > 1.0 - 2.0 * c.sd) {
        warnings.push("no condition shows a reduction of friction: the tip velocity is not identified".into());
    }
    warnings
}
