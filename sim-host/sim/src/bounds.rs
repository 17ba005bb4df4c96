//! Cramer-Rao bounds of a scene at its own values; varied values are not drawn.

use firmware::seam::block::LATENCY_BLOCKS;

use crate::cramer_rao::{Drive, Knowledge, PriorKnowledge, Setting, Start, ramp, time_to};

use plant::circuit::Circuit;
use plant::circuit_of;
use scene::{DisturbedKey, Driven};

/// Number of blocks from the end of the last measured one to the beginning of the first that plays
/// its estimate; the block between them was decided before.
const DECIDED_BLOCKS: f64 = LATENCY_BLOCKS as f64 - 1.0;
/// Number of blocks from the end of the last measured one to the end of the first that plays its
/// estimate, at which the error of a block is counted.
pub const PLAYED_BLOCKS: f64 = LATENCY_BLOCKS as f64;

/// Lower bounds of lock time and tracking error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounds {
    /// Time to play the resonance within 20 Hz and within 4 Hz at 95 %, ms: from rest, or from the
    /// step if there is one.
    pub times_ms: [Option<f64>; 2],
    /// Tracking error on the scene's ramp of an estimate for a constant resonance, Hz rms.
    pub ramp_hz: Option<f64>,
}

impl Bounds {
    /// Computes the bounds of a scene.
    pub fn new(scene: &Driven) -> Self {
        let Some(setting) = Setting::from_scene(scene).map(|cold| after_the_step(scene, &cold)) else { return Bounds::default() };
        let rate = scene.disturbance.iter().find_map(|change| change.rate_per_s);
        let known = Setting { prior: PriorKnowledge { voltage: Knowledge::Unknown, ..PriorKnowledge::LM_AND_C0 }, ..setting };
        Bounds {
            times_ms: [20.0, 4.0].map(|hz| time_to(&setting, hz, DECIDED_BLOCKS).map(|s| 1e3 * s)),
            ramp_hz: rate.and_then(|rate| ramp(&known, rate.abs(), PLAYED_BLOCKS)).map(|best| best.error_hz()),
        }
    }
}

/// Returns the stack after a step of the scene, driven at its previous resonance; the time of the
/// step, Lm and C0 are then known. Without a step, returns the cold start.
fn after_the_step(scene: &Driven, cold: &Setting) -> Setting {
    let steps = scene.disturbance.iter().filter_map(|change| Some((change.key, change.to?)));
    let before = circuit_of(scene);
    let (mut after, mut stepped) = (before, false);
    for (key, to) in steps {
        match key {
            DisturbedKey::SeriesResonance => after = after.with_series_resonance(to).with_q(after.q()),
            DisturbedKey::Q => after = after.with_q(to),
            _ => continue,
        }
        stepped = true;
    }
    if !stepped {
        return *cold;
    }
    let source_ohm = scene.amplifier.source_ohm;
    let loaded = |circuit: Circuit| Circuit { rm_ohm: circuit.rm_ohm + source_ohm, ..circuit };
    let volts = scene.controller.drive.amplitude_v.unwrap_or(cold.drive.volts);
    Setting {
        circuit: loaded(after),
        start: Start::Jump(loaded(before)),
        drive: Drive { volts, hz: before.series_resonance_hz(), ..cold.drive },
        prior: PriorKnowledge { voltage: Knowledge::Unknown, ..PriorKnowledge::LM_AND_C0 },
        ..*cold
    }
}
