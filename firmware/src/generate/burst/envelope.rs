//! The envelope of one block: a constant level, or the levels of an edge.

/// The envelope of one block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Envelope<'a> {
    /// A constant envelope.
    Flat(f32),
    /// An envelope that changes, sample by sample.
    Edge(Levels<'a>),
}

/// The levels of an edge, sample by sample, in fixed point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels<'a> {
    /// Of the loudest level: 2^31 for all of it.
    pub parts: &'a [i32],
    /// The loudest level that there may be; at least one.
    pub loudest: f32,
    /// Mean of the levels.
    pub mean: f32,
}

impl Levels<'_> {
    /// What makes a level a part of the loudest one. A level of all of it saturates, one step of 2^-31 below.
    #[inline]
    pub(crate) fn one(loudest: f32) -> f32 {
        2_147_483_648.0 / loudest
    }

    /// The levels, one by one.
    #[cfg(test)]
    pub(crate) fn to_vec(self) -> std::vec::Vec<f32> {
        self.parts.iter().map(|&part| part as f32 / Levels::one(self.loudest)).collect()
    }
}

impl Envelope<'_> {
    /// The envelope's mean over the block.
    pub(crate) fn mean(&self) -> f32 {
        match self {
            Envelope::Flat(level) => *level,
            Envelope::Edge(levels) => levels.mean,
        }
    }

    /// Whether it is the same throughout.
    pub(crate) fn is_flat(&self) -> bool {
        matches!(self, Envelope::Flat(_))
    }
}
