//! Outcome of a run, judged against the plant.
//!
//! A run that ends locked is judged by its **bias**: the mean of the drive frequency minus the true
//! series resonance over the last quarter of the run. It has three bounds:
//!
//! | bound | value |
//! |---|---|
//! | absolute | the larger of 1 Hz and 0.5 % of the bandwidth, `0.005 fs / Q` |
//! | stated | three standard deviations that the controller states for its resonance |
//! | half bandwidth | `fs / (2 Q)`: the motional phase is 45 degrees off |
//!
//! A drive needs velocity. At a bias `b` the tip velocity per volt of the working mode is
//! `1 / sqrt(1 + x^2)` of its maximum, with `x = 2 Q b / fs`: the loss.
//!
//! The outcome follows from the absolute bound and the loss; the other two bounds are also
//! reported. Every transducer of the bench is healthy, so a fault that reports a defect is false
//! unless its documented reason applies to the plant.

use firmware::seam::fault::{Fault, Limit};
use firmware::seam::mode::Mode;
use firmware::seam::transducer::{LockQuality, Transducer as Identified};
use plant::circuit_of;
use scene::{DisturbedKey, Driven};
use sim::record::{Record, Row};

/// Smallest absolute bound of a bias, Hz.
const MIN_BOUND_HZ: f64 = 1.0;
/// Absolute bound of a bias over the bandwidth.
const BOUND_REL: f64 = 0.005;
/// Largest loss of tip velocity of a good lock, relative to the maximum.
const MAX_LOSS_REL: f64 = 0.01;
/// Smallest bound for the lock times, Hz.
const TIMED_HZ: f64 = 20.0;
/// Number of standard deviations of the stated bound.
const BOUND_SIGMAS: f64 = 3.0;
/// Share of a run, at its end, in which it is judged.
const JUDGED_SHARE: f64 = 0.25;
/// Smallest relative shift of C0 from its nominal value that is a documented reason for fault 25.
const CAPACITANCE_SHIFT_REL: f64 = 0.4;
/// Smallest factor between true and nominal Lm that is a documented reason for fault 34.
const SAME_MODE_LM_FACTOR: f64 = 2.0;

/// Outcome of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The run ends locked within the absolute bound.
    Locked,
    /// The run ends locked outside the absolute bound, but loses at most 1 % of the tip velocity.
    Good,
    /// The run reported a doubtful lock: by limit 97, 98 or 107 in most blocks of the judged part
    /// that are not off resonance on purpose, or, half a bandwidth off, by fault 33 or 34.
    Reported,
    /// The run ends locked and loses more than 1 % of the tip velocity without a report.
    Silent,
    /// A false fault ended the run: its documented reason does not apply to the plant.
    FalseFault(Fault),
    /// A true fault ended the run: its documented reason applies to the plant.
    TrueFault(Fault),
    /// The run is not locked in time, or ended in fault 31 or 32, which report a missing lock.
    Late(Option<Fault>),
}

/// Parameters of a transducer that a controller states, in this order: series resonance, quality
/// factor, motional resistance and inductance, clamped capacitance.
pub const PARAMETERS: [&str; 5] = ["fs", "Q", "Rm", "Lm", "C0"];

/// Error of a stated value, and its stated standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stated {
    /// Stated value minus the true one.
    pub error: f64,
    /// Stated standard deviation.
    pub deviation: f64,
}

impl Stated {
    /// Returns `true` if the truth is within `sigmas` standard deviations.
    pub fn covers(&self, sigmas: f64) -> bool {
        self.error.abs() <= sigmas * self.deviation
    }
}

/// Verdict on a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JudgedRun {
    /// Outcome of the run.
    pub outcome: Outcome,
    /// Bias of a run that ends locked, Hz.
    pub bias_hz: Option<f64>,
    /// `true` if the bias of a run that ends locked is beyond three stated standard deviations;
    /// `None` if it states none.
    pub beyond_stated: Option<bool>,
    /// `true` if the bias of a run that ends locked is beyond half a bandwidth.
    pub beyond_half_bandwidth: Option<bool>,
    /// Time from the first block of the lock stage until the drive is permanently within 20 Hz, or
    /// the absolute bound if that is larger, ms.
    pub lock_ms: Option<f64>,
    /// Time from power-on, or from the last command to run, to the same bound, ms.
    pub power_on_ms: Option<f64>,
    /// Quality of the lock as the controller states it, if the run ends locked.
    pub quality: Option<LockQuality>,
    /// [Parameters](PARAMETERS) stated by the controller, if the run ends locked.
    pub stated: Option<[Stated; PARAMETERS.len()]>,
}

/// Judges a run.
pub fn judge(scene: &Driven, record: &Record) -> JudgedRun {
    let truth = Truth::new(scene, record);
    let mut judged = JudgedRun {
        outcome: Outcome::Late(None),
        bias_hz: None,
        beyond_stated: None,
        beyond_half_bandwidth: None,
        lock_ms: None,
        power_on_ms: None,
        quality: None,
        stated: None,
    };
    let rows = &record.rows;
    if let Some(fault) = record.last.fault {
        judged.outcome = truth.fault_outcome(fault, rows);
        return judged;
    }
    let judged_rows = &rows[rows.len() - (JUDGED_SHARE * rows.len() as f64) as usize..];
    if judged_rows.is_empty() || !judged_rows.iter().all(|row| row.mode == Mode::Run && row.locked && row.drive_v > 0.0) {
        return judged;
    }
    let steady = || judged_rows.iter().filter(|row| !row.probes());
    let blocks = steady().count();
    if blocks == 0 {
        return judged;
    }
    let bias_hz = steady().map(error_hz).sum::<f64>() / blocks as f64;
    let limited = [Limit::FrequencyWindow, Limit::NotTracking, Limit::LockUncertain].map(|limit| limit as u8);
    judged.outcome = match () {
        () if 2 * steady().filter(|row| limited.contains(&row.limit)).count() > blocks => Outcome::Reported,
        () if bias_hz.abs() <= truth.bound_hz() => Outcome::Locked,
        () if truth.loss(bias_hz) <= MAX_LOSS_REL => Outcome::Good,
        () => Outcome::Silent,
    };
    let deviation_hz = record.last.transducer.map(|found| f64::from(found.deviations.series_resonance_hz));
    judged.bias_hz = Some(bias_hz);
    judged.beyond_stated = deviation_hz.map(|deviation_hz| bias_hz.abs() > BOUND_SIGMAS * deviation_hz);
    judged.beyond_half_bandwidth = Some(bias_hz.abs() > truth.hz / (2.0 * truth.q));
    // The last run counts; a disturbance step ends the time to lock.
    let from = rows.iter().rposition(|row| row.mode == Mode::Idle).unwrap_or(0);
    let step_s = scene.disturbance.iter().map(|change| change.at_s).fold(f64::INFINITY, f64::min);
    let to = rows.partition_point(|row| row.time_s < step_s).max(from);
    (judged.lock_ms, judged.power_on_ms) = lock_times_ms(&rows[from..to], truth.bound_hz().max(TIMED_HZ)).unzip();
    judged.quality = record.last.transducer.map(|found| found.quality);
    judged.stated = record.last.transducer.map(|found| truth.against(&found));
    judged
}

/// Returns the absolute bound of a bias, Hz, for a resonance, Hz, and its Q.
pub fn bound_hz(hz: f64, q: f64) -> f64 {
    MIN_BOUND_HZ.max(BOUND_REL * hz / q)
}

/// True values of a transducer at the end of its run, compared with its nominal values.
struct Truth {
    hz: f64,
    q: f64,
    lm_h: f64,
    c0_f: f64,
    /// Relative distance of the resonance from its nominal value, and relative half width of the
    /// window.
    apart: (f64, f64),
    /// Clamped capacitance over its nominal value.
    c0_ratio: f64,
    /// Motional inductance over its nominal value; 1 without a nominal value.
    lm_ratio: f64,
    /// `true` if the current at the resonance exceeds the sensor's range or the limit.
    too_much: bool,
}

impl Truth {
    fn new(scene: &Driven, record: &Record) -> Self {
        let (circuit, controller) = (circuit_of(scene), scene.controller);
        let tracking = &controller.tracking;
        let hz = record.rows.last().map_or_else(|| circuit.series_resonance_hz(), |row| row.truth.series_resonance_hz);
        let most_a = scene.sensors.i_full_scale_a.min(controller.limits.current_a);
        let volts = controller.drive.amplitude_v.unwrap_or_default();
        let stepped_to = |key: DisturbedKey| {
            let of_key = scene.disturbance.iter().filter(|change| change.key == key);
            of_key.filter_map(|change| change.to).next_back()
        };
        Truth {
            hz,
            q: stepped_to(DisturbedKey::Q).unwrap_or_else(|| circuit.q()),
            lm_h: circuit.lm_h,
            c0_f: stepped_to(DisturbedKey::ClampedCapacitance).unwrap_or(circuit.c0_f),
            apart: (hz / controller.drive.frequency_hz - 1.0, tracking.span),
            c0_ratio: tracking.nominal_c0_f.map_or(1.0, |nominal| circuit.c0_f / nominal),
            lm_ratio: tracking.nominal_lm_h.map_or(1.0, |nominal| circuit.lm_h / nominal),
            too_much: volts / (circuit.rm_ohm + scene.amplifier.source_ohm) > most_a,
        }
    }

    /// Returns the absolute bound of a bias, Hz.
    fn bound_hz(&self) -> f64 {
        bound_hz(self.hz, self.q)
    }

    /// Returns the loss of tip velocity at a bias, Hz, relative to the maximum.
    fn loss(&self, bias_hz: f64) -> f64 {
        1.0 - 1.0 / 1f64.hypot(2.0 * self.q * bias_hz / self.hz)
    }

    /// Returns the outcome of a run that ends in a fault.
    fn fault_outcome(&self, fault: Fault, rows: &[Row]) -> Outcome {
        let locked = rows.iter().rev().find(|row| row.locked).map(error_hz);
        let was_elsewhere = locked.is_some_and(|error_hz| error_hz.abs() > self.hz / (2.0 * self.q));
        match fault {
            Fault::NoLock | Fault::LossOfLock => Outcome::Late(Some(fault)),
            Fault::TrackersDisagree | Fault::WrongMode if was_elsewhere => Outcome::Reported,
            _ if self.agrees_with(fault) => Outcome::TrueFault(fault),
            _ => Outcome::FalseFault(fault),
        }
    }

    /// Returns `true` if the documented reason of a fault applies.
    fn agrees_with(&self, fault: Fault) -> bool {
        match fault {
            Fault::OverCurrent | Fault::SenseSaturated => self.too_much,
            Fault::CapacitanceShifted => (self.c0_ratio - 1.0).abs() > CAPACITANCE_SHIFT_REL,
            Fault::NoResonance => self.apart.0.abs() > self.apart.1,
            Fault::WrongMode => !(1.0 / SAME_MODE_LM_FACTOR..SAME_MODE_LM_FACTOR).contains(&self.lm_ratio),
            _ => false,
        }
    }

    /// Compares the stated values with the true ones.
    fn against(&self, found: &Identified) -> [Stated; PARAMETERS.len()] {
        let deviations = &found.deviations;
        let rm_ohm = std::f64::consts::TAU * self.hz * self.lm_h / self.q;
        [
            (found.series_resonance_hz, deviations.series_resonance_hz, self.hz),
            (found.q, deviations.q, self.q),
            (found.rm_ohm, deviations.rm_ohm, rm_ohm),
            (found.lm_h, deviations.lm_h, self.lm_h),
            (found.c0_f, deviations.c0_f, self.c0_f),
        ]
        .map(|(value, deviation, truth)| Stated { error: f64::from(value) - truth, deviation: deviation.into() })
    }
}

/// Returns the drive frequency minus the true series resonance, Hz.
fn error_hz(row: &Row) -> f64 {
    row.frequency_hz - row.truth.series_resonance_hz
}

/// Returns the end of the last block that is off by more than a bound, Hz, from the first block of
/// the lock stage and from the first of these rows, ms; `None` if that block is the very last.
fn lock_times_ms(rows: &[Row], bound_hz: f64) -> Option<(f64, f64)> {
    let first = rows.iter().position(|row| row.mode == Mode::Lock)? + 1;
    let from_s = rows.get(first)?.time_s;
    let last_outside = rows.iter().rposition(|row| !row.probes() && error_hz(row).abs() > bound_hz);
    let at_s = match last_outside {
        Some(last) if last + 1 == rows.len() => return None,
        Some(last) => rows[last].time_s.max(from_s),
        None => from_s,
    };
    Some((1e3 * (at_s - from_s), 1e3 * (at_s - rows[0].time_s)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a resonance of 40 kHz and Q 50, 1 % above its nominal value in a window of 2 %, with
    /// these ratios of C0 and Lm to their nominal values.
    fn truth(c0_ratio: f64, lm_ratio: f64) -> Truth {
        Truth { hz: 40e3, q: 50.0, lm_h: 0.1, c0_f: 1e-9, apart: (0.01, 0.02), c0_ratio, lm_ratio, too_much: false }
    }

    #[test]
    fn a_fault_is_true_if_the_plant_agrees() {
        let outcome = |truth: Truth, fault: Fault| truth.fault_outcome(fault, &[]);
        for (c0_ratio, holds) in [(1.39, false), (1.41, true), (0.61, false), (0.59, true)] {
            let fault = Fault::CapacitanceShifted;
            let expected = if holds { Outcome::TrueFault(fault) } else { Outcome::FalseFault(fault) };
            assert_eq!(outcome(truth(c0_ratio, 1.0), fault), expected, "{c0_ratio}");
        }
        assert_eq!(outcome(truth(1.0, 2.1), Fault::WrongMode), Outcome::TrueFault(Fault::WrongMode));
        assert_eq!(outcome(truth(1.0, 1.9), Fault::WrongMode), Outcome::FalseFault(Fault::WrongMode));
        assert_eq!(outcome(truth(1.0, 1.0), Fault::NoResonance), Outcome::FalseFault(Fault::NoResonance));
        assert_eq!(
            outcome(Truth { apart: (0.03, 0.02), ..truth(1.0, 1.0) }, Fault::NoResonance),
            Outcome::TrueFault(Fault::NoResonance)
        );
        assert_eq!(outcome(truth(1.0, 1.0), Fault::ResonanceDamaged), Outcome::FalseFault(Fault::ResonanceDamaged));
        assert_eq!(outcome(truth(1.0, 1.0), Fault::NoLock), Outcome::Late(Some(Fault::NoLock)));
    }

    /// 0.5 % of a bandwidth of 800 Hz is 4 Hz; for a bandwidth of 80 Hz the bound is 1 Hz.
    #[test]
    fn the_bound_is_the_larger_of_both() {
        assert_eq!(truth(1.0, 1.0).bound_hz(), 4.0);
        assert_eq!(Truth { q: 500.0, ..truth(1.0, 1.0) }.bound_hz(), 1.0);
    }

    /// A phase of 8.11 degrees costs 1 % of the velocity, one of 45 degrees 29 %.
    #[test]
    fn the_loss_is_that_of_a_resonance() {
        let loss = |phase_deg: f64| truth(1.0, 1.0).loss(400.0 * phase_deg.to_radians().tan());
        assert!((loss(8.1096) - 0.01).abs() < 1e-6 && (loss(-45.0) - 0.292893).abs() < 1e-6, "{} {}", loss(8.1096), loss(-45.0));
    }

    #[test]
    fn two_standard_deviations_cover() {
        assert!(Stated { error: -1.9, deviation: 1.0 }.covers(2.0) && !Stated { error: 2.1, deviation: 1.0 }.covers(2.0));
    }
}
