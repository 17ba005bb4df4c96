//! Controller settings for a transducer, and their reasons.
//!
//! * **Voltage**: at the series resonance the stack draws `V / |Rs + 1 / (1 / Rm + j omega C0)|`,
//!   which must stay below the limit and within the sensor's range.
//! * **Block**: rehearsed. A shorter block decides sooner, but a lock-in over fewer than 0.6
//!   periods hardly distinguishes sine from cosine.
//! * **Phase loop**, the fall-back: `B = 0.1 / (2 pi T_d)` with `T_d` of two and a half blocks;
//!   this costs 0.1 rad of its phase margin at any Q.

use firmware::seam::block::LATENCY_BLOCKS;
use realfft::num_complex::Complex64;
use serde::Serialize;

use super::case::{Case, CaseError, NOMINAL_ERROR, Parts, rounded};
use super::prediction::{lock_times, percentile_ms};
use super::rig::RehearsalRig;
use super::transducer::Full;

/// Minimum periods in a block that determine its phasor well.
pub const MIN_PERIODS: f64 = 0.6;
/// Block lengths that are compared, samples.
const BLOCKS: [u16; 6] = [8, 16, 24, 32, 48, 64];
/// Number of cold starts per block length.
const DRAWS: u64 = 100;
/// Maximum lock time with the present block length, relative to the best, at which it stays: a
/// shorter block takes more of the processor.
const MAX_TIME_RATIO: f64 = 1.25;
/// Fraction of a sensor's range, and of a limit, that is used.
const USED_FRACTION: f64 = 0.9;
/// Phase that the fall-back loop may lose by its delay, rad.
const LOOP_PHASE_RAD: f64 = 0.1;
/// Window about the nominal frequency, relative: 1.25 times the error of the nominal resonance.
const SPAN_REL: f64 = 1.25 * NOMINAL_ERROR.resonance;
/// Maximum window, relative to the distance to the antiresonance.
const MAX_SPAN_FRACTION: f64 = 0.9;
/// Rounding step of the bandwidth, Hz.
const BANDWIDTH_STEP_HZ: f64 = 10.0;
/// Distance of the highest tone of the power-on calibration above the end of the window, relative
/// to the nominal frequency.
const HIGHEST_TONE_REL: f64 = 0.1924;
/// Rounding step of the span.
const SPAN_STEP_REL: f64 = 5e-4;

/// Advised settings of the controller.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// Lines to paste into a scene.
    pub snippet: String,
    /// Samples in a block.
    pub block_samples: u16,
    /// Block lengths that were compared.
    pub blocks: Vec<BlockTime>,
    /// Window to each side, as a fraction of the frequency.
    pub span: f64,
    /// Bandwidth of the fall-back loop, Hz.
    pub bandwidth_hz: f64,
    /// Advised drive voltage and its measurement.
    pub drive: Drive,
}

/// A block length, and its lock times to 4 Hz.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BlockTime {
    /// Samples in a block.
    pub samples: u16,
    /// Periods of the drive in a block.
    pub periods: f64,
    /// Median of the lock times, ms.
    pub lock_4hz_median_ms: Option<f64>,
    /// 95th percentile of the lock times, ms.
    pub lock_4hz_p95_ms: Option<f64>,
}

/// Drive voltage and current, and their readings in the converters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Drive {
    /// Requested peak voltage, V.
    pub asked_v: f64,
    /// Advised peak voltage, V: the requested one, limited to the largest one.
    pub advised_v: f64,
    /// Largest peak voltage that sensor, limits and amplifier allow in calibration, scan and lock,
    /// V.
    pub largest_v: f64,
    /// Part or limit that bounds the largest voltage.
    pub bounded_by: &'static str,
    /// Peak current at the resonance at the advised voltage, A.
    pub current_a: f64,
    /// Largest peak current of calibration, scan and lock at the requested voltage, A.
    pub asked_current_a: f64,
    /// Peak current in LSB of its converter.
    pub current_lsb: f64,
    /// Peak voltage in LSB of its converter.
    pub voltage_lsb: f64,
    /// End of the converter's range, LSB.
    pub full_scale_lsb: f64,
    /// Fraction of the drive voltage at the stack at resonance, after the amplifier's source
    /// resistance.
    pub left_at_stack: f64,
    /// Rms noise of a block's motional current, A.
    pub block_noise_a: f64,
    /// Rms noise of a block's motional current over the current at the resonance, parts per
    /// million.
    pub block_noise_ppm: f64,
}

/// Advises settings; returns them, and the case with them.
pub fn advise(case: &Case) -> Result<Option<(Settings, Case)>, CaseError> {
    let Some(parts) = case.parts() else { return Ok(None) };
    let (largest_v, bounded_by) = largest_v(&parts);
    let advised_v = case.asked_v.min(largest_v);
    let (samples, keep) = case.block_samples;
    let mut blocks = Vec::new();
    for length in BLOCKS.into_iter().chain([samples]) {
        let periods = f64::from(length) * parts.circuit.series_resonance_hz() / parts.sensors.sample_hz;
        if (periods >= MIN_PERIODS || length == samples) && !blocks.iter().any(|block: &BlockTime| block.samples == length) {
            let Some(rig) = RehearsalRig::from_case(&case.with(length, advised_v)?) else { continue };
            let [.., times] = lock_times(&rig, DRAWS);
            let (median, p95) = (percentile_ms(&times, 0.5), percentile_ms(&times, 0.95));
            blocks.push(BlockTime { samples: length, periods, lock_4hz_median_ms: median, lock_4hz_p95_ms: p95 });
        }
    }
    blocks.sort_by_key(|block| block.samples);
    let block_samples = if keep { samples } else { choose(&blocks, samples) };
    let block_s = f64::from(block_samples) / parts.sensors.sample_hz;
    let full = Full::from_circuit(&parts.circuit);
    // A block holds at least half a period of the lowest frequency.
    let below = 1.0 - 0.5 / (block_s * parts.controller.drive.frequency_hz);
    let span = span(&full, below);
    let bandwidth_hz = bandwidth_hz(block_s);
    let advised = case.with(block_samples, advised_v)?.tracking(span, bandwidth_hz)?;
    let (Some(rig), Some(parts)) = (RehearsalRig::from_case(&advised), advised.parts()) else { return Ok(None) };
    let lsb = f64::from(1u32 << (parts.sensors.adc_bits - 1));
    let ohm = ohm(&parts);
    let current_a = advised_v / ohm;
    let drive = Drive {
        asked_v: case.asked_v,
        advised_v,
        largest_v,
        bounded_by,
        current_a,
        asked_current_a: case.asked_v / least_ohm(&parts),
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

/// Keeps the present length if it is nearly as good as the best; otherwise returns the best.
fn choose(blocks: &[BlockTime], present: u16) -> u16 {
    let time = |block: &BlockTime| block.lock_4hz_p95_ms.unwrap_or(f64::INFINITY);
    let fit = || blocks.iter().filter(|block| block.periods >= MIN_PERIODS);
    let Some(best) = fit().min_by(|a, b| time(a).total_cmp(&time(b))) else { return present };
    let stays = fit().any(|block| block.samples == present && time(block) <= MAX_TIME_RATIO * time(best));
    if stays { present } else { best.samples }
}

/// Returns the load of the amplifier at the series resonance, ohm.
fn ohm(parts: &Parts<'_>) -> f64 {
    let circuit = &parts.circuit;
    let admittance = Complex64::new(1.0 / circuit.rm_ohm, circuit.omega() * circuit.c0_f);
    (admittance.inv() + parts.amplifier.source_ohm).norm()
}

/// Returns the smallest load of the amplifier, ohm, at the frequencies of calibration, scan and
/// lock. At `M` of a few, the current is largest below the series resonance, where that of C0 adds
/// to the motional one, or at the highest tone.
fn least_ohm(parts: &Parts<'_>) -> f64 {
    let (circuit, tracking) = (&parts.circuit, &parts.controller.tracking);
    let (fs_hz, q) = (circuit.series_resonance_hz(), circuit.q());
    let load = |hz: f64| {
        let x = hz / fs_hz;
        let motional = Complex64::new(1.0, q * (x - 1.0 / x)).inv() / circuit.rm_ohm;
        let clamped = Complex64::new(0.0, std::f64::consts::TAU * hz * circuit.c0_f);
        ((motional + clamped).inv() + parts.amplifier.source_ohm).norm()
    };
    let near = (-800..=0).map(|step| fs_hz * (1.0 + 0.005 * f64::from(step) / (2.0 * q)));
    let highest_hz = parts.controller.drive.frequency_hz * (1.0 + tracking.span + HIGHEST_TONE_REL);
    near.filter(|hz| *hz > 0.0).chain([highest_hz]).map(load).fold(f64::INFINITY, f64::min)
}

/// Returns the impedance of the stack at its series resonance, ohm.
fn ohm_alone(parts: &Parts<'_>) -> f64 {
    let circuit = &parts.circuit;
    Complex64::new(1.0 / circuit.rm_ohm, circuit.omega() * circuit.c0_f).inv().norm()
}

/// Returns the largest peak voltage, V, and its limiting part.
fn largest_v(parts: &Parts<'_>) -> (f64, &'static str) {
    let (sensors, limits) = (parts.sensors, &parts.controller.limits);
    let ohm = least_ohm(parts);
    let bounds = [
        (USED_FRACTION * sensors.i_full_scale_a * ohm, "the range of the current sensor"),
        (USED_FRACTION * limits.current_a * ohm, "limits.current_a"),
        (USED_FRACTION * sensors.v_full_scale_v, "the range of the voltage sensor"),
        (limits.voltage_v, "limits.voltage_v"),
        (USED_FRACTION * parts.amplifier.full_scale_v, "the amplifier"),
    ];
    let (volts, by) = bounds.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((limits.voltage_v, "limits.voltage_v"));
    // Rounded down to two digits.
    let step = 10f64.powf(volts.log10().floor() - 1.0);
    (rounded((volts / step + 1e-9).floor() * step), by)
}

/// Returns the window: short of the antiresonance, if that leaves room for the error of the nominal
/// resonance, and at most this far below the resonance, relative.
fn span(full: &Full, below: f64) -> f64 {
    let room = MAX_SPAN_FRACTION * (full.parallel_resonance_hz / full.series_resonance_hz - 1.0);
    let span = if room > NOMINAL_ERROR.resonance { SPAN_REL.min(room) } else { SPAN_REL };
    rounded((span.min(below) / SPAN_STEP_REL + 1e-9).floor().max(1.0) * SPAN_STEP_REL)
}

fn bandwidth_hz(block_s: f64) -> f64 {
    let delay_s = (LATENCY_BLOCKS as f64 + 0.5) * block_s;
    let hz = LOOP_PHASE_RAD / (std::f64::consts::TAU * delay_s);
    ((hz / BANDWIDTH_STEP_HZ).floor() * BANDWIDTH_STEP_HZ).max(BANDWIDTH_STEP_HZ)
}

/// Returns the lines of a scene that contain the advice.
fn snippet(parts: &Parts<'_>) -> String {
    let (controller, tracking) = (parts.controller, &parts.controller.tracking);
    format!(
        "[controller]\nblock_samples = {}\n\n[controller.drive]\nfrequency_hz = {:?}\namplitude_v = \
         {:?}\n\n[controller.tracking]\nmode = \"observer\"\nspan = {:?}\nbandwidth_hz = {:?}\nnominal_q = {:?}\nnominal_lm_h = \
         {:?}\nnominal_c0_f = {:?}\n",
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
