//! Bandwidth: how fast a swing of the true resonance may be for the drive to follow it. Rehearsed without noise, so that it is the response
//! of the filter with the gains that it has come to.

use super::rehearsal::Rehearsal;
use super::rig::Rig;

const TAU: f64 = std::f64::consts::TAU;
/// Size of the swing, Hz: so small that it is no more to the filter than its noise is.
const SWING_HZ: f64 = 0.5;
/// Of the swing, at the bandwidth: -3 dB.
const HALF_POWER: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// The slowest swing that is tried, Hz, and from one to the next.
const SLOWEST: (f64, f64) = (10.0, 1.3);
/// Swings are tried up to this part of the blocks' rate.
const FASTEST: f64 = 0.25;
/// Swings before it counts, and those that count.
const PERIODS: (f64, f64) = (4.0, 4.0);
/// Bisections between two swings.
const BISECTIONS: u32 = 6;

/// The swing that comes out 3 dB smaller, Hz; beyond it none comes out larger. Nothing where even the slowest does.
pub fn bandwidth_hz(settled: &Rehearsal, rig: &Rig) -> Option<f64> {
    let follows = |hz: f64| gain(settled, rig, hz) >= HALF_POWER;
    let fastest = FASTEST / rig.block_s;
    let tried: Vec<f64> =
        std::iter::successors(Some(SLOWEST.0), |hz| Some(hz * SLOWEST.1)).take_while(|&hz| hz < fastest).collect();
    let last = tried.iter().rposition(|&hz| follows(hz))?;
    let (mut low, mut high) = (tried[last], tried.get(last + 1).copied().unwrap_or(fastest));
    for _ in 0..BISECTIONS {
        let middle = (low * high).sqrt();
        if follows(middle) { low = middle } else { high = middle }
    }
    Some((low * high).sqrt())
}

/// How much of a swing comes out.
fn gain(settled: &Rehearsal, rig: &Rig, swing_hz: f64) -> f64 {
    let mut rehearsal = settled.clone();
    let (from_s, own_hz) = (rehearsal.time_s(), rig.circuit.series_resonance_hz());
    let (before, counted) = (PERIODS.0 / swing_hz, PERIODS.1 / swing_hz);
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
