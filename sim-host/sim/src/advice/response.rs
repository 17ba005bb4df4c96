//! Bandwidth from the true resonance to the drive frequency. It is rehearsed without noise, so that
//! it is the response of the filter with its converged gains.

use super::rehearsal::Rehearsal;
use super::rig::RehearsalRig;

const TAU: f64 = std::f64::consts::TAU;
/// Amplitude of the modulation, Hz: comparable to the filter's noise.
const SWING_HZ: f64 = 0.5;
/// Gain at the bandwidth, -3 dB.
const HALF_POWER: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Lowest modulation frequency, Hz.
const LOWEST_HZ: f64 = 10.0;
/// Ratio of successive modulation frequencies.
const STEP_RATIO: f64 = 1.3;
/// Highest modulation frequency, relative to the block rate.
const HIGHEST_REL: f64 = 0.25;
/// Number of periods before the measurement.
const SETTLING_PERIODS: f64 = 4.0;
/// Number of measured periods.
const MEASURED_PERIODS: f64 = 4.0;
/// Number of bisections between two modulation frequencies.
const BISECTIONS: u32 = 6;

/// Returns the highest modulation frequency that is attenuated by at most 3 dB, Hz; `None` if the
/// lowest one is attenuated more.
pub fn bandwidth_hz(settled: &Rehearsal, rig: &RehearsalRig) -> Option<f64> {
    let follows = |hz: f64| gain(settled, rig, hz) >= HALF_POWER;
    let fastest = HIGHEST_REL / rig.block_s;
    let tried: Vec<f64> =
        std::iter::successors(Some(LOWEST_HZ), |hz| Some(hz * STEP_RATIO)).take_while(|&hz| hz < fastest).collect();
    let last = tried.iter().rposition(|&hz| follows(hz))?;
    let (mut low, mut high) = (tried[last], tried.get(last + 1).copied().unwrap_or(fastest));
    for _ in 0..BISECTIONS {
        let middle = (low * high).sqrt();
        if follows(middle) { low = middle } else { high = middle }
    }
    Some((low * high).sqrt())
}

/// Returns the gain from the modulation of the resonance to the drive frequency.
fn gain(settled: &Rehearsal, rig: &RehearsalRig, swing_hz: f64) -> f64 {
    let mut rehearsal = settled.clone();
    let (from_s, own_hz) = (rehearsal.time_s(), rig.circuit.series_resonance_hz());
    let (before, counted) = (SETTLING_PERIODS / swing_hz, MEASURED_PERIODS / swing_hz);
    let (before, all) = (rig.blocks(before), rig.blocks(before + counted));
    let (mut sine, mut cosine) = (0.0, 0.0);
    for block in 0..all {
        let angle = TAU * swing_hz * (rehearsal.time_s() - from_s);
        let circuit = rig.circuit.with_series_resonance(own_hz + SWING_HZ * angle.sin());
        let played = rehearsal.step(&circuit).played_hz - own_hz;
        if block >= before {
            sine += played * angle.sin();
            cosine += played * angle.cos();
        }
    }
    2.0 * sine.hypot(cosine) / ((all - before) as f64 * SWING_HZ)
}
