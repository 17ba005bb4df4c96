//! Estimates of the resonance: stated deviation, actual error and bound, for each tracking scene.
//!
//! Each run has another noise, and another resonance, Q and C0 than the nominal ones. The error is
//! that of the estimate in the last block under drive. The true resonance includes the stiffness of
//! a contact: it follows from the true phase of the motional current.
//!
//! The **bound** is that of an estimate from the same blocks if all else were known: the variance
//! of a Kalman filter with two states, the motional current in quadrature and the resonance, which
//! wanders at random by 24 Hz in a second at 40 kHz, as the observer assumes (posterior Cramér-Rao
//! bound; P. Tichavsky, C. H. Muravchik and A. Nehorai 1998). At a drive of `V`, with the source's
//! resistance in `R`,
//!
//! ```text
//! di' = (g df - di) / tau,   tau = 2 Lm / R,   g = 4 pi Lm V / R^2,   measured: di + noise
//! ```
//!
//! The in-phase current is taken as settled. It shares no code with the firmware. The efficiency is
//! the variance of the bound over the mean square error; it exceeds one where the true resonance
//! wanders less.

use std::f64::consts::{PI, TAU};

use plant::circuit::Circuit;
use plant::circuit_of;
use report::TableBlock;
use scene::Transducer;
use scene::load::load;
use scene::settings;
use sim::cramer_rao::noise;
use sim::processor::Here;
use sim::record::Row;
use sim::run::{RunError, Watch, run_on};
use sim::study::StudyError;

use crate::campaign::{self, cells, columns, count, digits, each};
use crate::evidence::{Error, Evidence, Options};
use crate::random::Random;

/// Scenes in which the observer tracks a stack.
const SCENES: [&str; 7] = ["lock-cold", "lock-welder", "lock-drift", "burst", "self-heating", "experiment-1", "friction-burst"];
/// Runs of each scene, full and quick.
const RUNS: [u32; 2] = [40, 4];
/// Seed of the first run.
const SEED: u64 = 1 << 34;
/// Assumed wander of the resonance in a second, relative.
const WANDER_REL: f64 = 6e-4;
/// Blocks over which the true phase is averaged.
const SHIFT_BLOCKS: usize = 100;
/// Smallest efficiency, largest stated deviation, Hz, and smallest part within two of these.
const TARGETS: (f64, f64, f64) = (0.5, 0.5, 0.9);

/// Estimate at the end of a run.
struct Estimate {
    /// Identified series resonance minus the true one, Hz.
    error_hz: f64,
    /// Stated standard deviation, Hz.
    stated_hz: f64,
    /// Bound of the standard deviation, Hz.
    bound_hz: f64,
}

/// Runs the scenes, and returns the evidence.
pub(crate) fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let runs = options.count.unwrap_or(RUNS[usize::from(options.quick)]);
    let (mut rows, mut missed) = (Vec::new(), Vec::new());
    for scene in SCENES {
        (options.progress)(&format!("{scene}: {runs} runs"));
        let set = each(runs, options.stop, |number| run(scene, number))?;
        let rms = |of: fn(&Estimate) -> f64| (set.iter().map(|run| of(run).powi(2)).sum::<f64>() / set.len() as f64).sqrt();
        let (error_hz, stated_hz, bound_hz) = (rms(|run| run.error_hz), rms(|run| run.stated_hz), rms(|run| run.bound_hz));
        let efficiency = (bound_hz / error_hz).powi(2);
        let within = count(&set, |run| run.error_hz.abs() <= 2.0 * run.stated_hz);
        if efficiency < TARGETS.0 {
            missed.push(format!("{scene}: efficiency {efficiency:.2}"));
        }
        if within as f64 / (set.len() as f64) < TARGETS.2 {
            missed.push(format!("{scene}: {within} of {} within two stated deviations", set.len()));
        }
        if stated_hz > TARGETS.1 {
            missed.push(format!("{scene}: states {stated_hz:.2} Hz"));
        }
        let percent = |part: f64| format!("{:.0} %", 100.0 * part);
        rows.push(cells![
            scene,
            runs,
            digits(stated_hz),
            digits(error_hz),
            digits(bound_hz),
            percent(efficiency),
            percent(within as f64 / set.len() as f64)
        ]);
    }
    let caption = "Of the resonance in the last block under drive, with the stiffness of a contact: root mean squares. Bound: \
                   standard deviation of an estimate from the same blocks that knows all else, and assumes the same wander. \
                   Efficiency: its variance over the mean square error. Within 2 sd: of the stated deviation.";
    let header = "scene | runs | stated [Hz] | error [Hz] | bound [Hz] | efficiency | within 2 sd";
    let table = TableBlock::new("estimates", "Estimates of the resonance", caption, &columns(header), rows);
    let title = "Estimates of the resonance: stated deviation, error and bound";
    let subtitle = "Simulated: the controller on the host against the simulated stack and its converters";
    Ok(campaign::evidence(title, subtitle, vec![table], vec![], missed))
}

/// Runs a scene with another noise and another stack.
fn run(scene: &str, number: u32) -> Result<Estimate, Error> {
    let loaded = load(scene, &[])?;
    let nominal = loaded.scene.driven().ok_or(StudyError::Incomplete)?;
    let Transducer::Stack(stack, _) = nominal.transducer else { return Err(StudyError::Incomplete.into()) };
    let (bvd, mut random) = (&stack.bvd, Random::new(SEED + u64::from(number)));
    // Not less damping than that for which the limits are chosen.
    let (tuning, damping, c0) = (1.0 + 0.005 * random.side(), random.between(1.0, 1.33), 1.0 + 0.1 * random.side());
    let scaled = [
        ("series_resonance_hz", bvd.series_resonance_hz, tuning),
        ("q", bvd.q, 1.0 / damping),
        ("cm_f", bvd.cm_f, tuning.powi(-2)),
        ("rm_ohm", bvd.rm_ohm, damping),
        ("c0_f", Some(bvd.c0_f), c0),
    ];
    let scaled = scaled.into_iter().filter_map(|(key, value, factor)| Some(format!("stack.bvd.{key}={}", value? * factor)));
    let sets: Vec<String> = scaled.chain([format!("seed={}", number + 1)]).collect();
    let loaded = load(scene, &sets)?;
    let driven = loaded.scene.driven().ok_or(StudyError::Incomplete)?;
    let record = run_on(&mut Here::new(&settings::config(&driven))?, &driven, Watch::default());
    let record = record.map_err(|error: RunError| StudyError::from(error))?;
    let found = record.last.transducer.ok_or(StudyError::Incomplete)?;
    let circuit = circuit_of(&driven);
    let block_s = f64::from(driven.controller.block_samples) / driven.sensors.sample_hz;
    let sensors = &driven.sensors;
    let (hz, loaded_ohm) = (record.rows[0].truth.series_resonance_hz, circuit.rm_ohm + driven.amplifier.source_ohm);
    // Of a component of a block's phasor. The voltage is measured, and acts through the admittance.
    let part = |noise: f64| 2.0 * noise * noise / f64::from(driven.controller.block_samples);
    let admittance = (1.0 / circuit.rm_ohm).hypot(TAU * hz * circuit.c0_f);
    let noise_a2 =
        part(noise(sensors, sensors.i_full_scale_a)) + admittance.powi(2) * part(noise(sensors, sensors.v_full_scale_v));
    let filter = Filter {
        decay: (-block_s * loaded_ohm / (2.0 * circuit.lm_h)).exp(),
        gain_per_v: 4.0 * PI * circuit.lm_h / loaded_ohm.powi(2),
        wander_hz2: (WANDER_REL * hz).powi(2) * block_s,
        noise_a2,
    };
    let last = record.rows.iter().rposition(|row| row.locked && row.envelope == 1.0).ok_or(StudyError::Incomplete)?;
    let bound_hz = filter.deviation_hz(&record.rows[..=last]);
    let shift_hz = if driven.contact.is_some() { shift_hz(&record.rows[..=last], &circuit) } else { 0.0 };
    let row = &record.rows[last];
    let error_hz = row.resonance_estimate_hz - row.truth.series_resonance_hz - shift_hz;
    Ok(Estimate { error_hz, stated_hz: f64::from(found.deviations.series_resonance_hz), bound_hz })
}

/// Returns by how much a contact shifts the resonance at the end of these rows, Hz: the motional
/// current then has a reactance at the resonance of the stack alone.
fn shift_hz(rows: &[Row], circuit: &Circuit) -> f64 {
    let shift = |row: &Row| {
        let off_hz = row.truth.quadrature_w / row.truth.lost_w * circuit.rm_ohm / (4.0 * PI * circuit.lm_h);
        row.frequency_hz - off_hz - row.truth.series_resonance_hz
    };
    let full = rows.iter().rev().filter(|row| row.locked && row.envelope == 1.0).take(SHIFT_BLOCKS);
    let shifts: Vec<f64> = full.map(shift).collect();
    shifts.iter().sum::<f64>() / shifts.len() as f64
}

/// Kalman filter of the motional current in quadrature, A, and of the resonance, Hz.
struct Filter {
    /// Decay of the current in a block.
    decay: f64,
    /// Current in quadrature per hertz and volt, once it has settled.
    gain_per_v: f64,
    /// Variance of the wander in a block, Hz².
    wander_hz2: f64,
    /// Variance of the measured current of a block, A².
    noise_a2: f64,
}

impl Filter {
    /// Returns the standard deviation of the resonance after these blocks, from an unknown one.
    fn deviation_hz(&self, rows: &[Row]) -> f64 {
        let (mut ii, mut fi, mut ff) = (0.0, 0.0, 1e6);
        for row in rows.iter().filter(|row| row.mode == firmware::seam::mode::Mode::Run) {
            let (a, b) = (self.decay, (1.0 - self.decay) * self.gain_per_v * row.drive_v);
            (ii, fi, ff) = (a * a * ii + 2.0 * a * b * fi + b * b * ff, a * fi + b * ff, ff + self.wander_hz2);
            if row.envelope == 1.0 {
                let sum = ii + self.noise_a2;
                (ii, fi, ff) = (ii * self.noise_a2 / sum, fi * self.noise_a2 / sum, ff - fi * fi / sum);
            }
        }
        ff.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use report::docs::block;
    use report::markdown;

    #[test]
    fn the_quick_variant_has_the_documented_numbers() {
        let Evidence { docs, .. } = campaign::quick(evidence, None);
        block("evidence/tracking.md", "evidence estimates --quick", &markdown(&docs));
    }
}
