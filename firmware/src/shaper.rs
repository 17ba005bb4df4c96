//! The shaper: phase, shape, lane and envelope to codes.
//! `drive(n, lane) = mid + envelope(n) * volts * gain(lane) * shape(phase(n) + offset(lane))`.

use heapless::Vec;

use crate::block::{Codes, DriveBlock, MAX_LANES};
use crate::burst::Envelope;
use crate::convert::DriveScale;
use crate::phasing::Lane;
use crate::shape::Table;

/// Writes one block of codes, of `samples` samples from `phase` on with tuning word `word` (2^64 a turn).
pub fn shape(
    drive: &mut DriveBlock,
    scale: &DriveScale,
    table: &Table,
    lanes: &Vec<Lane, MAX_LANES>,
    (phase, word, samples): (u64, u64, usize),
    volts: f32,
    envelope: &Envelope,
) {
    drive.lanes.clear();
    for lane in lanes {
        let lsb = volts * lane.gain * scale.lsb_per_volt();
        let at = |n: usize| {
            let turning = phase.wrapping_add(word.wrapping_mul(n as u64));
            table.at(((turning >> 32) as u32).wrapping_add(lane.offset))
        };
        let codes: Codes = match envelope {
            Envelope::Flat(level) if *level * lsb == 0.0 => core::iter::repeat_n(scale.silence(), samples).collect(),
            Envelope::Flat(level) => {
                let lsb = lsb * level;
                (0..samples).map(|n| scale.code(lsb * at(n))).collect()
            }
            Envelope::Edge(levels) => levels.iter().enumerate().map(|(n, level)| scale.code(lsb * level * at(n))).collect(),
        };
        // There are as many lanes in the block as in the configuration, at most MAX_LANES.
        let _ = drive.lanes.push(codes);
    }
}
