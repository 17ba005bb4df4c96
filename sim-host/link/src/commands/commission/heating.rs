//! Heating run: measures the thermal resistance and the heat capacity of the stack by its own
//! losses.
//!
//! ```text
//! f = f0 + k x + d I^2,   C dx/dt = P - x / R
//! ```
//!
//! `k` is `thermometer.hz_per_k`; frequency `f`, electrical power `P` and motional current `I` are
//! measured. The drive is at the proposed amplitude, then at half of it: a shift by the amplitude
//! follows at once, a shift by the temperature with the time constant R C. The temperature rise at
//! the beginning is fitted, because the preceding test has heated the stack.

use std::time::Duration;

use firmware::board::command::Command;
use firmware::seam::block::{Amplitude, Gate};
use firmware::seam::mode::Mode;
use firmware::seam::phasor::magnitude;
use import::least_squares::{Linear, minimise};

use super::board_settings::BoardSettings;
use super::probe;
use super::proposal::{Proposal, settle_s};
use crate::commands::status::power_w;
use crate::link_error::LinkError;
use crate::session::Session;
use crate::words;

/// Phases of the run: part of the time, and amplitudes relative to the proposed one. The last
/// amplitude of a phase is held. A clamped capacitance draws a current peak with each step.
const PHASES: [(f64, &[f64]); 2] = [(0.6, &[1.0]), (0.4, &[0.75, 0.5])];
/// Largest number of reports of a run.
const MAX_REPORTS: f64 = 1600.0;
/// Minimum number of blocks between two reports.
const MIN_REPORT_BLOCKS: f64 = 64.0;
/// Time constants from which the fit starts, relative to the run.
const STARTS_REL: [f64; 6] = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0];
/// Largest permitted standard deviation of a result, relative.
const MAX_DEVIATION_REL: f64 = 0.15;
/// Standard deviation of both results by the model, relative: C0, which changes with the
/// temperature, shifts the lock, and the stack is not a single body.
const MODEL_ERROR_REL: f64 = 0.02;
/// Smallest proposed tolerance.
const MIN_TOLERANCE: f64 = 0.05;

/// Values of a report.
struct Point {
    /// Time, s.
    seconds: f64,
    /// Tracked series resonance, Hz.
    hz: f64,
    /// Electrical power, W.
    watts: f64,
    /// Square of the peak motional current, A^2.
    square_a2: f64,
}

/// Thermal values of a stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermal {
    /// Thermal resistance from the stack to its surroundings, K/W.
    pub resistance_k_per_w: f64,
    /// Heat capacity, J/K.
    pub capacity_j_per_k: f64,
    /// Relative standard deviations of resistance and heat capacity.
    pub deviations_rel: [f64; 2],
}

impl Thermal {
    /// Returns the values as parameters of the board, by their names.
    pub fn settings(&self) -> Vec<(&'static str, f32)> {
        let largest = self.deviations_rel[0].max(self.deviations_rel[1]);
        let tolerance = (100.0 * MIN_TOLERANCE.max(2.0 * largest) - 1e-9).ceil() / 100.0;
        let rounded = |value: f64| format!("{value:.3e}").parse().unwrap_or(value as f32);
        vec![
            ("thermometer.resistance_k_per_w", rounded(self.resistance_k_per_w)),
            ("thermometer.heat_capacity_j_per_k", rounded(self.capacity_j_per_k)),
            ("thermometer.tolerance", tolerance as f32),
        ]
    }
}

/// Returns the temperature coefficient of the resonance, Hz/K. Refuses a board without it.
pub fn hz_per_k(board: &BoardSettings) -> Result<f64, LinkError> {
    let hz_per_k = f64::from(board.before("thermometer.hz_per_k"));
    if hz_per_k != 0.0 {
        return Ok(hz_per_k);
    }
    Err(LinkError::Failed(
        "--heating reads the temperature from the resonance, but its coefficient `thermometer.hz_per_k` is zero. Measure the \
         resonance at two temperatures of the whole stack, then send `settings set thermometer.hz_per_k HZ_PER_K`, `settings \
         store` and `reset`"
            .into(),
    ))
}

/// Heats the stack for this time with the active settings, and returns its thermal values.
pub fn measure(time_s: f64, proposal: &Proposal, board: &BoardSettings, session: &mut Session) -> Result<Thermal, LinkError> {
    session.live.stage(&format!("heating run of {} s", time_s as f32));
    let points = record(time_s, proposal, session)?;
    probe::quiet(session)?;
    fit(&points, time_s, hz_per_k(board)?).map_err(LinkError::Failed)
}

/// Returns the locked reports of the run.
fn record(time_s: f64, proposal: &Proposal, session: &mut Session) -> Result<Vec<Point>, LinkError> {
    let ended_by =
        |fault| LinkError::Failed(format!("the heating run ends with {}. Lower --max-volts or --heating", words::fault(fault)));
    let converters = session.identity.converters;
    let block_s = f64::from(converters.block_samples) / f64::from(converters.sample_hz);
    let every = (time_s / (MAX_REPORTS * block_s)).max(MIN_REPORT_BLOCKS) as u32;
    session.client.order(Command::Gate(Gate::On))?;
    probe::run(session)?.map_err(ended_by)?;
    let first = probe::driven(settle_s(&proposal.transducer), session)?.map_err(ended_by)?.block;
    let mut points = Vec::new();
    for (part, levels) in PHASES {
        for level in levels {
            session.client.order(Command::Amplitude(Some(Amplitude::Volts((level * proposal.volts) as f32))))?;
        }
        let ended = session.watch(Duration::from_secs_f64(part * time_s), every, |report| {
            if report.mode == Mode::Run && report.locked {
                points.push(Point {
                    seconds: f64::from(report.block.wrapping_sub(first)) * block_s,
                    hz: report.resonance.0.into(),
                    watts: power_w(report).into(),
                    square_a2: f64::from(magnitude(report.motional_current)).powi(2),
                });
            }
            report.fault.filter(|_| report.mode == Mode::Fault)
        })?;
        if let Some(fault) = ended {
            return Err(ended_by(fault));
        }
    }
    Ok(points)
}

/// Fits resistance and heat capacity to the points of a run. Returns the reason if the points do
/// not determine them.
fn fit(points: &[Point], time_s: f64, hz_per_k: f64) -> Result<Thermal, String> {
    let start = |part: f64| [points.first().map_or(0.0, |first| first.hz), 0.0, 0.0, 0.0, (part * time_s).ln()];
    let fits = STARTS_REL.into_iter().filter_map(|part| minimise(&start(part), |at| evaluate(points, at)));
    let Some(found) = fits.min_by(|a, b| a.cost.total_cmp(&b.cost)) else {
        return Err("the lock was lost in the heating run: lower --max-volts".into());
    };
    let (hz_per_w, time_constant_s) = (found.parameters[1], found.parameters[4].exp());
    // Residuals that are not independent contain less information.
    let residuals = &found.linear.residuals;
    let products: f64 = residuals.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let correlation = (products / found.cost).clamp(0.0, 0.99);
    let noise_hz = (found.cost / residuals.len() as f64).sqrt();
    let variance = noise_hz.powi(2) * (1.0 + correlation) / (1.0 - correlation);
    let deviations_rel = found.covariance().map_or([f64::INFINITY; 2], |by| {
        let (resistance, both, time) = (by[(1, 1)] / hz_per_w.powi(2), by[(1, 4)] / hz_per_w, by[(4, 4)]);
        [resistance, resistance + time - 2.0 * both].map(|relative| (variance * relative).sqrt().hypot(MODEL_ERROR_REL))
    });
    let uncertain = deviations_rel.into_iter().any(|deviation| deviation > MAX_DEVIATION_REL);
    let moved_hz = hz_per_w * points.iter().map(|point| point.watts).fold(0.0, f64::max);
    if time_constant_s > time_s || uncertain && 2.0 * time_constant_s > time_s {
        let needed_s = (3.0 * time_constant_s).clamp(2.0 * time_s, 10.0 * time_s).ceil();
        Err(format!(
            "the heating run of {} s is too short for the stack's thermal time constant: use --heating {needed_s}",
            time_s as f32
        ))
    } else if uncertain {
        Err(format!(
            "the heating run does not determine the thermal values: the power shifts the resonance by {moved_hz:.1} Hz, with \
             {noise_hz:.1} Hz of noise. Raise --max-volts or --max-amps, and keep the load of the stack constant"
        ))
    } else if hz_per_w * hz_per_k < 0.0 {
        Err(format!(
            "heating shifts the resonance by {moved_hz:+.1} Hz, but `thermometer.hz_per_k` is {hz_per_k}: correct its sign"
        ))
    } else {
        let resistance_k_per_w = hz_per_w / hz_per_k;
        Ok(Thermal { resistance_k_per_w, capacity_j_per_k: time_constant_s / resistance_k_per_w, deviations_rel })
    }
}

/// Computes the residuals, Hz, and their derivatives by frequency of the cold stack at rest, Hz,
/// shift by power, Hz/W, shift at the beginning, Hz, shift by amplitude, Hz/A^2, and the logarithm
/// of the time constant, s.
fn evaluate(points: &[Point], parameters: &[f64]) -> Option<Linear> {
    let (first, last) = (points.first()?, points.last()?);
    let time_constant_s = parameters[4].exp();
    if !(1e-3..1e3).contains(&(time_constant_s / (last.seconds - first.seconds))) {
        return None;
    }
    let mut columns = vec![vec![1.0; points.len()], vec![], vec![], vec![], vec![]];
    // Mean power by the exponential window, W, and the remaining part of the shift at the
    // beginning, each with its derivative by the logarithm of the time constant.
    let (mut watts, mut watts_slope, mut before) = (0.0, 0.0, first);
    for point in points {
        let step = (point.seconds - before.seconds) / time_constant_s;
        let (remains, input_w) = ((-step).exp(), 0.5 * (before.watts + point.watts));
        watts_slope = remains * (watts_slope + step * (watts - input_w));
        watts = input_w + (watts - input_w) * remains;
        let age = (point.seconds - first.seconds) / time_constant_s;
        let start = (-age).exp();
        let by_time_constant = parameters[1] * watts_slope + parameters[2] * age * start;
        let slopes = [watts, start, point.square_a2, by_time_constant];
        columns[1..].iter_mut().zip(slopes).for_each(|(column, slope)| column.push(slope));
        before = point;
    }
    let model = |n: usize| (0..4).map(|column| parameters[column] * columns[column][n]).sum::<f64>();
    let residuals = points.iter().enumerate().map(|(n, point)| model(n) - point.hz).collect();
    Some(Linear { residuals, columns })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fits a run of a stack with 5 K/W and 8 J/K that begins 3 K warm and shifts by -10 Hz/K and
    /// -20 Hz/A^2. The power falls while it heats, and to a quarter later.
    fn fitted(time_s: f64, watts: f64, noise_hz: f64, hz_per_k: f64) -> Result<Thermal, String> {
        let (mut kelvin, mut seed, step_s) = (3.0, 1_u64, time_s / 2e3);
        let points = (0..2000).map(|n| {
            let watts = watts * if n < 1200 { 1.0 } else { 0.25 } / (1.0 + 0.005 * kelvin);
            let square_a2 = watts / (1.0 + 0.005 * kelvin);
            seed = seed.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            let noise_hz = noise_hz * 12.0_f64.sqrt() * ((seed >> 11) as f64 / 2.0_f64.powi(53) - 0.5);
            let hz = 4e4 - 10.0 * kelvin - 20.0 * square_a2 + noise_hz;
            kelvin += step_s * (watts - kelvin / 5.0) / 8.0;
            Point { seconds: step_s * f64::from(n), hz, watts, square_a2 }
        });
        fit(&points.collect::<Vec<Point>>(), time_s, hz_per_k)
    }

    #[test]
    fn the_thermal_values_are_within_their_deviations() {
        for (time_s, noise_hz) in [(400.0, 0.0), (120.0, 0.6), (60.0, 0.3)] {
            let found = fitted(time_s, 2.0, noise_hz, -10.0).unwrap();
            let errors = [found.resistance_k_per_w / 5.0 - 1.0, found.capacity_j_per_k / 8.0 - 1.0];
            let fits =
                errors.iter().zip(found.deviations_rel).all(|(error, deviation)| error.abs() < 0.1_f64.min(2.5 * deviation));
            assert!(fits, "{time_s}: {errors:?}, {found:?}");
        }
    }

    #[test]
    fn an_unsuitable_run_is_refused_with_its_remedy() {
        for (time_s, watts, noise_hz, hz_per_k, message) in [
            (20.0, 2.0, 0.6, -10.0, "too short"),
            (200.0, 0.01, 5.0, -10.0, "Raise --max-volts"),
            (200.0, 2.0, 0.3, 10.0, "correct its sign"),
        ] {
            let refused = fitted(time_s, watts, noise_hz, hz_per_k).unwrap_err();
            assert!(refused.contains(message), "{refused}");
        }
    }
}
