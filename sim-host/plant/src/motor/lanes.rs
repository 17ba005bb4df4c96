//! Errors of the four amplifiers: gain and phase of each lane, and faults during a run
//! (`lane_fault.rs`).
//!
//! The thesis measured 5 to 10 degrees between amplifiers. The phase of its amplifiers grows with
//! frequency, as for any amplifier below its corner. A *delay* does so exactly in proportion and
//! changes no amplitude. After a converter that holds it can be integrated exactly: within a sample
//! the lane still plays the previous code until its delay is over. A lead is a delay shorter than
//! the common one; all lanes are delayed if one of them leads.
//!
//! ```text
//! delay_j = (largest lead - error_j) / (360 f),   phase error at f_any: error_j f_any / f
//! ```

use std::collections::VecDeque;

use firmware::seam::block::MAX_LANES;

use scene::Amplifier;

/// Four lanes with their errors.
#[derive(Clone, Debug)]
pub struct Lanes {
    /// Played voltages, the latest first, V.
    lines: [VecDeque<f64>; MAX_LANES],
    gain: [f64; MAX_LANES],
    /// Whole samples of delay.
    whole: [usize; MAX_LANES],
    /// Remaining fraction of the delay, samples, 0 to 1.
    rest: [f64; MAX_LANES],
    lead_turns: [f64; MAX_LANES],
    /// The converter that each amplifier is connected to.
    source: [usize; MAX_LANES],
    /// Factor of each amplifier's gain by faults; negative if it is reversed.
    fault_gain: [f64; MAX_LANES],
}

/// Output of the lanes within a sample: one voltage until a lane's delay is over, then the other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Played {
    /// Voltages before the lane's delay is over, V.
    pub before: [f64; MAX_LANES],
    /// Voltages after the lane's delay is over, V.
    pub after: [f64; MAX_LANES],
}

/// Returns the entry of a lane in a list that may be shorter.
fn entry(list: &[f64], lane: usize) -> f64 {
    list.get(lane).copied().unwrap_or(0.0)
}

impl Lanes {
    /// Creates the lanes of an amplifier whose phase errors are stated at `nominal_hz`, at rest.
    pub fn new(amplifier: &Amplifier, nominal_hz: f64, sample_hz: f64) -> Self {
        let lead_turns: [f64; MAX_LANES] = std::array::from_fn(|lane| entry(&amplifier.lane_phase_error_deg, lane) / 360.0);
        let most = lead_turns.iter().copied().fold(0.0, f64::max);
        let samples: [f64; MAX_LANES] = lead_turns.map(|lead| (most - lead) / nominal_hz * sample_hz);
        Lanes {
            lines: samples.map(|delay| std::iter::repeat_n(0.0, delay as usize + 2).collect()),
            gain: std::array::from_fn(|lane| 1.0 + entry(&amplifier.lane_gain_error, lane)),
            whole: samples.map(|delay| delay as usize),
            rest: samples.map(f64::fract),
            lead_turns,
            source: std::array::from_fn(|lane| lane),
            fault_gain: [1.0; MAX_LANES],
        }
    }

    /// Multiplies the output of a lane by `part` from now on.
    pub(crate) fn weaken(&mut self, lane: usize, part: f64) {
        self.fault_gain[lane] *= part;
    }

    /// Exchanges the inputs of two amplifiers from now on.
    pub(crate) fn exchange(&mut self, one: usize, other: usize) {
        self.source.swap(one, other);
    }

    /// Returns the converter that each amplifier is connected to.
    pub(crate) fn sources(&self) -> [usize; MAX_LANES] {
        self.source
    }

    /// Returns the time after the beginning of a sample at which each lane changes its voltage, in
    /// samples.
    pub fn rest(&self) -> [f64; MAX_LANES] {
        self.rest
    }

    /// Returns the errors themselves: gain and lead of each lane, the lead in turns at the nominal
    /// frequency. The gain is negative if the lane is reversed.
    pub fn errors(&self) -> [(f64, f64); MAX_LANES] {
        std::array::from_fn(|lane| (self.gain[lane] * self.fault_gain[lane], self.lead_turns[lane]))
    }

    /// Accepts the voltages that the converters hold in the next sample, V. Returns the inputs of
    /// the amplifiers within it.
    #[inline]
    pub fn play(&mut self, volts: &[f64; MAX_LANES]) -> Played {
        let mut played = Played::default();
        for (lane, line) in self.lines.iter_mut().enumerate() {
            line.pop_back();
            line.push_front(self.fault_gain[lane] * volts[self.source[lane]]);
            let whole = self.whole[lane];
            played.before[lane] = self.gain[lane] * line[whole + 1];
            played.after[lane] = self.gain[lane] * line[whole];
        }
        played
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lanes(phase: &[f64], gain: &[f64]) -> Lanes {
        let amplifier =
            Amplifier { lane_phase_error_deg: phase.to_vec(), lane_gain_error: gain.to_vec(), ..Amplifier::default() };
        Lanes::new(&amplifier, 40e3, 1e6)
    }

    #[test]
    fn without_errors_a_code_plays_at_once() {
        let mut lanes = lanes(&[], &[]);
        assert_eq!(lanes.rest(), [0.0; 4]);
        assert_eq!(lanes.play(&[1.0, 2.0, 3.0, 4.0]).after, [1.0, 2.0, 3.0, 4.0]);
    }

    /// A degree at 40 kHz is 1 / 14.4 of a microsecond.
    #[test]
    fn a_lead_delays_the_others() {
        let mut lanes = lanes(&[0.0, 7.2, -14.4], &[0.0, 0.0, 0.1]);
        let expected = [0.5, 0.0, 0.5, 0.5];
        assert!(lanes.rest().iter().zip(expected).all(|(got, expected)| (got - expected).abs() < 1e-12), "{:?}", lanes.rest());
        lanes.play(&[1.0; 4]);
        let played = lanes.play(&[2.0; 4]);
        assert_eq!((played.before, played.after), ([1.0, 1.0, 0.0, 1.0], [2.0, 2.0, 1.1, 2.0]));
    }
}
