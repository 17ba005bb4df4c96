//! Settings: what to tell the controller of a transducer, and why.
//!
//! * **Voltage**: at the series resonance the stack draws `V / |Rs + 1 / (1 / Rm + j omega C0)|`, which may reach neither the limit nor the end
//!   of the sensor's range.
//! * **Block**: rehearsed. A shorter block decides sooner, but a lock-in of less than 0.6 periods hardly tells sine from cosine.
//! * **Phase loop**, the fall-back: `B = 0.1 / (2 pi T_d)`, `T_d` two and a half blocks, which costs 0.1 rad of its phase margin at any Q.

use firmware::seam::block::LATENCY_BLOCKS;
use realfft::num_complex::Complex64;
use serde::Serialize;

use super::case::{Case, CaseError, NOMINAL_ERROR, Parts, rounded};
use super::prediction::{lock_times, percentile_ms};
use super::rig::Rig;
use super::transducer::Full;

/// A block of fewer periods does not determine its phasor well.
pub const LEAST_PERIODS: f64 = 0.6;
/// Lengths of a block that are compared, samples.
const BLOCKS: [u16; 6] = [8, 16, 24, 32, 48, 64];
/// Cold starts for each.
const DRAWS: u64 = 100;
/// The present length of a block stays if it locks at most so much later than the best: a shorter block takes more of the processor.
const GOOD_ENOUGH: f64 = 1.25;
/// Part of a sensor's range, and of a limit, that is used.
const USED: f64 = 0.9;
/// Phase that the fall-back loop may lose by its delay, rad.
const PHASE_RAD: f64 = 0.1;
/// Window about the nominal frequency: the error of the nominal resonance, and a quarter more.
const SPAN: f64 = 1.25 * NOMINAL_ERROR.resonance;
/// Part of the way to the antiresonance that a window may have.
const SHORT_OF: f64 = 0.9;
/// Steps of the bandwidth, Hz.
const STEP_HZ: f64 = 10.0;
/// Steps of the span.
const STEP: f64 = 5e-4;

/// The advised settings of the controller.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// Lines to paste into a scene.
    pub snippet: String,
    /// Samples in a block.
    pub block_samples: u16,
    /// Lengths that were compared.
    pub blocks: Vec<BlockTime>,
    /// Window to each side, as a part of the frequency.
    pub span: f64,
    /// Bandwidth of the fall-back loop, Hz.
    pub bandwidth_hz: f64,
    /// Advised drive voltage and its measurement.
    pub drive: Drive,
}

/// A length of a block, and when it locks to 4 Hz.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BlockTime {
    /// Samples in a block.
    pub samples: u16,
    /// Periods of the drive in it.
    pub periods: f64,
    /// Median of the lock times, ms.
    pub lock_4hz_median_ms: Option<f64>,
    /// 95th percentile of the lock times, ms.
    pub lock_4hz_p95_ms: Option<f64>,
}

/// The drive and what the converters see of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Drive {
    /// Peak voltage as asked for, V.
    pub asked_v: f64,
    /// Peak voltage as advised, V: as asked for, or as much of it as is allowed.
    pub advised_v: f64,
    /// Largest peak voltage that sensor, limits and amplifier allow at the resonance, V.
    pub largest_v: f64,
    /// Part or limit that bounds the largest voltage.
    pub bounded_by: &'static str,
    /// Peak current at the resonance at the advised voltage, A.
    pub current_a: f64,
    /// Peak current at the resonance at the voltage asked for, A.
    pub asked_current_a: f64,
    /// Peak current in LSB of its converter.
    pub current_lsb: f64,
    /// Peak voltage in LSB of its converter.
    pub voltage_lsb: f64,
    /// End of the converter's range, LSB.
    pub full_scale_lsb: f64,
    /// Part of the drive that is left at the stack at the resonance, behind the amplifier's source resistance.
    pub left_at_stack: f64,
    /// Rms noise of a block's motional current, A.
    pub block_noise_a: f64,
    /// Rms noise of a block's motional current over the current at the resonance, parts per million.
    pub block_noise_ppm: f64,
}

/// Advises, and gives the case with the settings that are advised.
pub fn advise(case: &Case) -> Result<Option<(Settings, Case)>, CaseError> {
    let Some(parts) = case.parts() else { return Ok(None) };
    let (largest_v, bounded_by) = largest_v(&parts);
    let advised_v = case.asked_v.min(largest_v);
    let (samples, keep) = case.block_samples;
    let mut blocks = Vec::new();
    for length in BLOCKS.into_iter().chain([samples]) {
        let periods = f64::from(length) * parts.circuit.series_resonance_hz() / parts.sensors.sample_hz;
        if (periods >= LEAST_PERIODS || length == samples) && !blocks.iter().any(|block: &BlockTime| block.samples == length) {
            let Some(rig) = Rig::of(&case.with(length, advised_v)?) else { continue };
            let [.., times] = lock_times(&rig, DRAWS);
            let (median, p95) = (percentile_ms(&times, 0.5), percentile_ms(&times, 0.95));
            blocks.push(BlockTime { samples: length, periods, lock_4hz_median_ms: median, lock_4hz_p95_ms: p95 });
        }
    }
    blocks.sort_by_key(|block| block.samples);
    let block_samples = if keep { samples } else { choose(&blocks, samples) };
    let block_s = f64::from(block_samples) / parts.sensors.sample_hz;
    let full = Full::of(&parts.circuit);
    let span = span(&full);
    let bandwidth_hz = bandwidth_hz(block_s);
    let advised = case.with(block_samples, advised_v)?.tracking(span, bandwidth_hz)?;
    let (Some(rig), Some(parts)) = (Rig::of(&advised), advised.parts()) else { return Ok(None) };
    let lsb = f64::from(1u32 << (parts.sensors.adc_bits - 1));
    let ohm = ohm(&parts);
    let current_a = advised_v / ohm;
    let drive = Drive {
        asked_v: case.asked_v,
        advised_v,
        largest_v,
        bounded_by,
        current_a,
        asked_current_a: case.asked_v / ohm,
        current_lsb: current_a / parts.sensors.i_full_scale_a * lsb,
        voltage_lsb: advised_v / parts.sensors.v_full_scale_v * lsb,
        full_scale_lsb: lsb,
        left_at_stack: (ohm_alone(&parts) / ohm).min(1.0),
        block_noise_a: rig.noise_a(),
        block_noise_ppm: 1e6 * rig.noise_a() * (parts.circuit.rm_ohm + parts.amplifier.source_ohm) / advised_v,
    };
    let settings = Settings { snippet: snippet(&parts), block_samples, blocks, span, bandwidth_hz, drive };
    Ok(Some((settings, advised)))
}

/// The length that was there if it is nearly as good as the best, else the best.
fn choose(blocks: &[BlockTime], present: u16) -> u16 {
    let time = |block: &BlockTime| block.lock_4hz_p95_ms.unwrap_or(f64::INFINITY);
    let fit = || blocks.iter().filter(|block| block.periods >= LEAST_PERIODS);
    let Some(best) = fit().min_by(|a, b| time(a).total_cmp(&time(b))) else { return present };
    let stays = fit().any(|block| block.samples == present && time(block) <= GOOD_ENOUGH * time(best));
    if stays { present } else { best.samples }
}

/// What the amplifier sees at the series resonance, ohm.
fn ohm(parts: &Parts<'_>) -> f64 {
    let circuit = &parts.circuit;
    let admittance = Complex64::new(1.0 / circuit.rm_ohm, circuit.omega() * circuit.c0_f);
    (admittance.inv() + parts.amplifier.source_ohm).norm()
}

/// The stack at its series resonance, ohm.
fn ohm_alone(parts: &Parts<'_>) -> f64 {
    let circuit = &parts.circuit;
    Complex64::new(1.0 / circuit.rm_ohm, circuit.omega() * circuit.c0_f).inv().norm()
}

/// The largest peak voltage, V, and what bounds it.
fn largest_v(parts: &Parts<'_>) -> (f64, &'static str) {
    let (sensors, limits) = (parts.sensors, &parts.controller.limits);
    let ohm = ohm(parts);
    let bounds = [
        (USED * sensors.i_full_scale_a * ohm, "the range of the current sensor"),
        (USED * limits.current_a * ohm, "limits.current_a"),
        (USED * sensors.v_full_scale_v, "the range of the voltage sensor"),
        (limits.voltage_v, "limits.voltage_v"),
        (USED * parts.amplifier.full_scale_v, "the amplifier"),
    ];
    let (volts, by) = bounds.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((limits.voltage_v, "limits.voltage_v"));
    // Two digits, downwards.
    let step = 10f64.powf(volts.log10().floor() - 1.0);
    (rounded((volts / step + 1e-9).floor() * step), by)
}

/// Short of the antiresonance, if there is room for the error of the nominal resonance.
fn span(full: &Full) -> f64 {
    let room = SHORT_OF * (full.parallel_resonance_hz / full.series_resonance_hz - 1.0);
    let span = if room > NOMINAL_ERROR.resonance { SPAN.min(room) } else { SPAN };
    rounded((span / STEP + 1e-9).floor() * STEP)
}

fn bandwidth_hz(block_s: f64) -> f64 {
    let delay_s = (LATENCY_BLOCKS as f64 + 0.5) * block_s;
    let hz = PHASE_RAD / (std::f64::consts::TAU * delay_s);
    ((hz / STEP_HZ).floor() * STEP_HZ).max(STEP_HZ)
}

/// The part of a scene that the advice is about.
fn snippet(parts: &Parts<'_>) -> String {
    let (controller, tracking) = (parts.controller, &parts.controller.tracking);
    format!(
        "[controller]\nblock_samples = {}\n\n[controller.drive]\nfrequency_hz = {:?}\namplitude_v = {:?}\n\n[controller.tracking]\nmode = \
         \"observer\"\nspan = {:?}\nbandwidth_hz = {:?}\nnominal_q = {:?}\nnominal_lm_h = {:?}\nnominal_c0_f = {:?}\n",
        controller.block_samples,
        controller.drive.frequency_hz,
        parts.volts(),
        tracking.span,
        tracking.bandwidth_hz,
        tracking.nominal_q,
        tracking.nominal_lm_h.unwrap_or(parts.circuit.lm_h),
        tracking.nominal_c0_f.unwrap_or(parts.circuit.c0_f),
    )
}
