//! What a belt's encoder has said, and how it would go on.

use firmware::seam::block::BeltSense;

/// The pace is the mean over so many blocks.
const PACE_BLOCKS: u32 = 1024;

/// The encoder, as it has been read.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Encoder {
    last: BeltSense,
    /// Where the present measurement of the pace began, and how many blocks ago.
    first: i32,
    blocks: u32,
    /// Counts a block, as last measured.
    pace: Option<f64>,
    /// Counts that a lie has added.
    lied: f64,
}

impl Encoder {
    /// Takes what it says.
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

    /// What it has said last.
    pub(super) fn last(&self) -> BeltSense {
        self.last
    }

    /// What it would say next if its belt moved on.
    pub(super) fn lie(&mut self) -> BeltSense {
        let moved = f64::from(self.last.counts.wrapping_sub(self.first));
        self.lied += self.pace.unwrap_or(moved / f64::from(self.blocks.saturating_sub(1).max(1)));
        BeltSense { counts: self.last.counts.wrapping_add(self.lied as i32), ..self.last }
    }
}
