//! The envelope of one block: a constant level, or the levels of an edge.

/// Envelope of one block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Envelope<'a> {
    /// A constant envelope.
    Flat(f32),
    /// An envelope that changes, sample by sample.
    Edge(Levels<'a>),
}

/// Levels of an edge, sample by sample, in fixed point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels<'a> {
    /// Parts of the largest level: 2^31 for all of it.
    pub parts: &'a [i32],
    /// Largest possible level; at least one.
    pub loudest: f32,
    /// Mean of the levels.
    pub mean: f32,
}

impl Levels<'_> {
    /// Returns the factor from a level to a part of the largest one. The largest level itself
    /// saturates, one step of 2^-31 below.
    #[inline]
    pub(crate) fn one(loudest: f32) -> f32 {
        2_147_483_648.0 / loudest
    }

    /// Returns the levels, one by one.
    #[cfg(test)]
    pub(crate) fn to_vec(self) -> std::vec::Vec<f32> {
        self.parts.iter().map(|&part| part as f32 / Levels::one(self.loudest)).collect()
    }
}

impl Envelope<'_> {
    /// Returns the mean of the envelope over the block.
    pub(crate) fn mean(&self) -> f32 {
        match self {
            Envelope::Flat(level) => *level,
            Envelope::Edge(levels) => levels.mean,
        }
    }

    /// Returns `true` if the envelope is constant.
    pub(crate) fn is_flat(&self) -> bool {
        matches!(self, Envelope::Flat(_))
    }
}
