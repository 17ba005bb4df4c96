//! What became of a run, judged against the truth of the plant.
//!
//! A run that ends locked is judged by its **bias**, the mean of what was played less the true series resonance over the last quarter of the run. Three bounds:
//!
//! | bound | is |
//! |---|---|
//! | absolute | the larger of 1 Hz and 0.5 % of the bandwidth, `0.005 fs / Q` |
//! | stated | three of the standard deviations that the controller states for its resonance |
//! | half bandwidth | `fs / (2 Q)`: the motional phase is 45 degrees off |
//!
//! The outcome follows from the absolute bound; the other two are reported beside it. Every transducer of the bench is healthy, so that a fault that names a defect
//! is a false accusation, unless the plant agrees with what the fault says.

use firmware::seam::fault::{Fault, Limit};
use firmware::seam::mode::Mode;
use firmware::seam::transducer::Transducer as Identified;
use plant::circuit_of;
use scene::{DisturbedKey, Driven};
use sim::record::{Record, Row};

/// Least absolute bound of a bias, Hz.
const LEAST_BOUND_HZ: f64 = 1.0;
/// Absolute bound of a bias as a part of the bandwidth.
const BOUND_PART: f64 = 0.005;
/// Bound of the lock times, Hz, where the absolute bound is not larger.
const TIMED_HZ: f64 = 20.0;
/// Standard deviations of the stated bound.
const SIGMAS: f64 = 3.0;
/// Part of a run at its end in which it is judged.
const JUDGED_PART: f64 = 0.25;
/// Shift of C0 from its nominal value from which fault 25 is documented, relative.
const CAPACITANCE_SHIFT: f64 = 0.4;
/// Factor between true and nominal Lm from which fault 34 is documented.
const SAME_MODE: f64 = 2.0;

/// What became of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It ends locked, within the absolute bound.
    Locked,
    /// It was locked outside the bound, and said so: by limit 97, 98 or 107 in most blocks of the judged part, or by fault 33 or 34.
    Named,
    /// It ends locked outside the bound, and says nothing.
    Silent,
    /// A fault that does not hold has ended it.
    Accused(Fault),
    /// A fault that holds has ended it.
    Refused(Fault),
    /// It is not locked in time, or has ended in fault 31 or 32, which say no more than that.
    Late(Option<Fault>),
}

/// What a controller states of a transducer, in this order: series resonance, quality factor, motional resistance and inductance, clamped capacitance.
pub const PARAMETERS: [&str; 5] = ["fs", "Q", "Rm", "Lm", "C0"];

/// Value and stated standard deviation, against the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stated {
    /// Stated value less the true one.
    pub error: f64,
    /// Stated standard deviation.
    pub deviation: f64,
}

impl Stated {
    /// Whether the truth is within so many standard deviations.
    pub fn covers(&self, sigmas: f64) -> bool {
        self.error.abs() <= sigmas * self.deviation
    }
}

/// A run, judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    /// What became of the run.
    pub outcome: Outcome,
    /// Bias of a run that ends locked, Hz.
    pub bias_hz: Option<f64>,
    /// Whether the bias is beyond three stated standard deviations, of a run that ends locked and states one.
    pub beyond_stated: Option<bool>,
    /// Whether the bias is beyond half a bandwidth, of a run that ends locked.
    pub beyond_half_bandwidth: Option<bool>,
    /// From the first block of the lock stage until the drive is within 20 Hz, or the absolute bound if that is larger, for good, ms.
    pub lock_ms: Option<f64>,
    /// The same from power-on, or from the last order to run, ms.
    pub power_on_ms: Option<f64>,
    /// The [parameters](PARAMETERS) as the controller states them, of a run that ends locked.
    pub stated: Option<[Stated; PARAMETERS.len()]>,
}

/// Judges a run.
pub fn judge(scene: &Driven, record: &Record) -> Judged {
    let truth = Truth::of(scene, record);
    let mut judged = Judged {
        outcome: Outcome::Late(None),
        bias_hz: None,
        beyond_stated: None,
        beyond_half_bandwidth: None,
        lock_ms: None,
        power_on_ms: None,
        stated: None,
    };
    let rows = &record.rows;
    if let Some(fault) = record.last.fault {
        judged.outcome = truth.of_fault(fault, rows);
        return judged;
    }
    let judged_rows = &rows[rows.len() - (JUDGED_PART * rows.len() as f64) as usize..];
    if judged_rows.is_empty() || !judged_rows.iter().all(|row| row.mode == Mode::Run && row.locked && row.drive_v > 0.0) {
        return judged;
    }
    let errors = || judged_rows.iter().filter(|row| !row.probes()).map(error_hz);
    let blocks = errors().count();
    if blocks == 0 {
        return judged;
    }
    let bias_hz = errors().sum::<f64>() / blocks as f64;
    let limited = [Limit::FrequencyWindow, Limit::NotTracking, Limit::LockUncertain].map(|limit| limit as u8);
    judged.outcome = match () {
        () if bias_hz.abs() <= truth.bound_hz() => Outcome::Locked,
        () if 2 * judged_rows.iter().filter(|row| limited.contains(&row.limit)).count() > judged_rows.len() => Outcome::Named,
        () => Outcome::Silent,
    };
    let deviation_hz = record.last.transducer.map(|found| f64::from(found.deviations.series_resonance_hz));
    judged.bias_hz = Some(bias_hz);
    judged.beyond_stated = deviation_hz.map(|deviation_hz| bias_hz.abs() > SIGMAS * deviation_hz);
    judged.beyond_half_bandwidth = Some(bias_hz.abs() > truth.hz / (2.0 * truth.q));
    // The last run counts, and a step ends the time to lock.
    let from = rows.iter().rposition(|row| row.mode == Mode::Idle).unwrap_or(0);
    let step_s = scene.disturbance.iter().map(|change| change.at_s).fold(f64::INFINITY, f64::min);
    let to = rows.partition_point(|row| row.time_s < step_s).max(from);
    (judged.lock_ms, judged.power_on_ms) = lock_times_ms(&rows[from..to], truth.bound_hz().max(TIMED_HZ)).unzip();
    judged.stated = record.last.transducer.map(|found| truth.against(&found));
    judged
}

/// Absolute bound of a bias, Hz, of a resonance, Hz, and its Q.
pub fn bound_hz(hz: f64, q: f64) -> f64 {
    LEAST_BOUND_HZ.max(BOUND_PART * hz / q)
}

/// What is true of a transducer at the end of its run, and what its nominal values say.
struct Truth {
    hz: f64,
    q: f64,
    lm_h: f64,
    c0_f: f64,
    /// Distance of the resonance from its nominal value, and the window, relative.
    apart: (f64, f64),
    /// Clamped capacitance over its nominal value.
    c0_ratio: f64,
    /// Motional inductance over its nominal value, if there is one.
    lm_ratio: f64,
    /// Whether the current at the resonance is more than the sensor or the limit takes.
    too_much: bool,
}

impl Truth {
    fn of(scene: &Driven, record: &Record) -> Self {
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

    /// Absolute bound of a bias, Hz.
    fn bound_hz(&self) -> f64 {
        bound_hz(self.hz, self.q)
    }

    /// What a run has become that ends in a fault.
    fn of_fault(&self, fault: Fault, rows: &[Row]) -> Outcome {
        let locked = rows.iter().rev().find(|row| row.locked).map(error_hz);
        let was_elsewhere = locked.is_some_and(|error_hz| error_hz.abs() > self.hz / (2.0 * self.q));
        match fault {
            Fault::NoLock | Fault::LossOfLock => Outcome::Late(Some(fault)),
            Fault::TrackersDisagree | Fault::WrongMode if was_elsewhere => Outcome::Named,
            _ if self.agrees_with(fault) => Outcome::Refused(fault),
            _ => Outcome::Accused(fault),
        }
    }

    /// Whether what a fault says is true, by its own documentation.
    fn agrees_with(&self, fault: Fault) -> bool {
        match fault {
            Fault::OverCurrent | Fault::SenseSaturated => self.too_much,
            Fault::CapacitanceShifted => (self.c0_ratio - 1.0).abs() > CAPACITANCE_SHIFT,
            Fault::NoResonance => self.apart.0.abs() > self.apart.1,
            Fault::WrongMode => !(1.0 / SAME_MODE..SAME_MODE).contains(&self.lm_ratio),
            _ => false,
        }
    }

    /// Stated values against the true ones.
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

/// What was played less the true series resonance, Hz.
fn error_hz(row: &Row) -> f64 {
    row.frequency_hz - row.truth.series_resonance_hz
}

/// When the last block is over that plays off by more than a bound, Hz: from the first block of the lock stage, and from the first of these rows, ms; none if that is the very
/// last.
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

    /// A resonance of 40 kHz and Q 50, 1 % above its nominal value in a window of 2 %, with a C0 and an Lm that are off by these factors.
    fn truth(c0_ratio: f64, lm_ratio: f64) -> Truth {
        Truth { hz: 40e3, q: 50.0, lm_h: 0.1, c0_f: 1e-9, apart: (0.01, 0.02), c0_ratio, lm_ratio, too_much: false }
    }

    #[test]
    fn a_fault_holds_where_the_plant_agrees() {
        let outcome = |truth: Truth, fault: Fault| truth.of_fault(fault, &[]);
        for (c0_ratio, holds) in [(1.39, false), (1.41, true), (0.61, false), (0.59, true)] {
            let fault = Fault::CapacitanceShifted;
            let expected = if holds { Outcome::Refused(fault) } else { Outcome::Accused(fault) };
            assert_eq!(outcome(truth(c0_ratio, 1.0), fault), expected, "{c0_ratio}");
        }
        assert_eq!(outcome(truth(1.0, 2.1), Fault::WrongMode), Outcome::Refused(Fault::WrongMode));
        assert_eq!(outcome(truth(1.0, 1.9), Fault::WrongMode), Outcome::Accused(Fault::WrongMode));
        assert_eq!(outcome(truth(1.0, 1.0), Fault::NoResonance), Outcome::Accused(Fault::NoResonance));
        assert_eq!(
            outcome(Truth { apart: (0.03, 0.02), ..truth(1.0, 1.0) }, Fault::NoResonance),
            Outcome::Refused(Fault::NoResonance)
        );
        assert_eq!(outcome(truth(1.0, 1.0), Fault::ResonanceDamaged), Outcome::Accused(Fault::ResonanceDamaged));
        assert_eq!(outcome(truth(1.0, 1.0), Fault::NoLock), Outcome::Late(Some(Fault::NoLock)));
    }

    /// 0.5 % of a bandwidth of 800 Hz are 4 Hz; of one of 80 Hz less than 1 Hz.
    #[test]
    fn the_bound_is_the_larger_of_both() {
        assert_eq!(truth(1.0, 1.0).bound_hz(), 4.0);
        assert_eq!(Truth { q: 500.0, ..truth(1.0, 1.0) }.bound_hz(), 1.0);
    }

    #[test]
    fn two_standard_deviations_cover() {
        assert!(Stated { error: -1.9, deviation: 1.0 }.covers(2.0) && !Stated { error: 2.1, deviation: 1.0 }.covers(2.0));
    }
}
