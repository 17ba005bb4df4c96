//! The envelope of one block: a constant level, or the levels of an edge.

/// The envelope of one block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Envelope<'a> {
    /// A constant envelope.
    Flat(f32),
    /// An envelope that changes, sample by sample.
    Edge(&'a [f32]),
}

impl Envelope<'_> {
    /// The envelope's mean over the block.
    pub(crate) fn mean(&self) -> f32 {
        match self {
            Envelope::Flat(level) => *level,
            Envelope::Edge(levels) => {
                let (fours, rest) = levels.as_chunks::<4>();
                // Four sums, none of which waits for another.
                let [a, b, c, d] = fours.iter().fold([0.0; 4], |[a, b, c, d], [w, x, y, z]| [a + w, b + x, c + y, d + z]);
                ((a + b) + (c + d) + rest.iter().sum::<f32>()) / levels.len().max(1) as f32
            }
        }
    }

    /// Whether it is the same throughout.
    pub(crate) fn is_flat(&self) -> bool {
        matches!(self, Envelope::Flat(_))
    }
}
