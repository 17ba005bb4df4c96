//! Lane offsets and trims: where each lane stands in the period, and how large it is.
//!
//! Four-phase motor signals are sine, cosine, -sine, -cosine: a quarter turn from lane to lane. Two lanes make the
//! quadrature pair of a two-phase motor, also a quarter turn apart; the wave runs from lane 0 towards lane 1 when it leads.

use heapless::Vec;

use crate::block::MAX_LANES;
use crate::config::{Direction, Phasing};
use crate::error::{Error, in_range};

/// One lane, ready to be applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lane {
    /// Phase offset, 2^32 a turn.
    pub offset: u32,
    /// Gain.
    pub gain: f32,
}

/// Turns to 2^32 a turn, wrapping.
fn phase_of_turns(turns: f32) -> u32 {
    (f64::from(turns) * 4_294_967_296.0) as i64 as u32
}

/// The gain of the loudest lane, at least one: a voltage limit is for that lane.
pub fn loudest(phasing: &Phasing) -> f32 {
    phasing.gain_trim.iter().fold(1.0, |loudest: f32, &gain| loudest.max(gain))
}

/// The lanes of a drive. Trims that are not given are none.
pub fn build(phasing: &Phasing, lanes: u8) -> Result<Vec<Lane, MAX_LANES>, Error> {
    in_range("lanes", lanes.into(), 1.0, MAX_LANES as f64)?;
    let quarter = match phasing.direction {
        Direction::Forward => 0.25,
        Direction::Reverse => -0.25,
    };
    (0..usize::from(lanes))
        .map(|lane| {
            let trim = phasing.phase_trim_turns.get(lane).copied().unwrap_or(0.0);
            let gain = phasing.gain_trim.get(lane).copied().unwrap_or(1.0);
            in_range("phasing.phase_trim_turns", trim.into(), -0.5, 0.5)?;
            in_range("phasing.gain_trim", gain.into(), 0.0, 2.0)?;
            Ok(Lane { offset: phase_of_turns(quarter * lane as f32 + trim), gain })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_lanes_are_a_quarter_turn_apart() {
        let lanes = build(&Phasing::default(), 4).unwrap();
        let offsets: Vec<u32, 4> = lanes.iter().map(|lane| lane.offset).collect();
        assert_eq!(offsets, [0, 1 << 30, 2 << 30, 3 << 30]);
    }

    #[test]
    fn reverse_runs_the_other_way_and_trims_add() {
        let mut phasing = Phasing { direction: Direction::Reverse, ..Phasing::default() };
        phasing.phase_trim_turns = [0.0, 0.125].into_iter().collect();
        let lanes = build(&phasing, 2).unwrap();
        assert_eq!(lanes[1].offset, (3 << 30) + (1 << 29));
    }
}
