//! Record of the belt's encoder, and its extrapolation.

use firmware::seam::block::BeltSense;

/// Number of blocks over which the pace is averaged.
const PACE_BLOCKS: u32 = 1024;

/// Record of the readings of the encoder.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Encoder {
    last: BeltSense,
    /// Count at the start of the present measurement of the pace.
    first: i32,
    /// Number of blocks since that start.
    blocks: u32,
    /// Latest measured pace, counts per block.
    pace: Option<f64>,
    /// Counts that the extrapolation has added.
    extrapolated: f64,
}

impl Encoder {
    /// Records a reading.
    pub(super) fn update(&mut self, sense: BeltSense) {
        if self.blocks == 0 {
            self.first = sense.counts;
        } else if self.blocks == PACE_BLOCKS {
            self.pace = Some(f64::from(sense.counts.wrapping_sub(self.first)) / f64::from(self.blocks));
            (self.first, self.blocks) = (sense.counts, 0);
        }
        self.blocks += 1;
        self.last = sense;
    }

    /// Returns the last reading.
    pub(super) fn last(&self) -> BeltSense {
        self.last
    }

    /// Returns the next reading if the belt kept its pace.
    pub(super) fn extrapolate(&mut self) -> BeltSense {
        let moved = f64::from(self.last.counts.wrapping_sub(self.first));
        self.extrapolated += self.pace.unwrap_or(moved / f64::from(self.blocks.saturating_sub(1).max(1)));
        BeltSense { counts: self.last.counts.wrapping_add(self.extrapolated as i32), ..self.last }
    }
}
