//! Parts of a flash that are written while the board runs.

/// A part of the flash, whole pages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Area {
    /// Address of its first byte.
    pub start: u32,
    /// Bytes.
    pub size: u32,
}

impl Area {
    /// The address of `length` bytes at an offset; `None` beyond the end, or off the grid.
    #[inline]
    pub fn address(&self, offset: u32, length: u32, grid: u32) -> Option<u32> {
        let end = offset.checked_add(length)?;
        (end <= self.size && offset.is_multiple_of(grid) && length.is_multiple_of(grid)).then_some(self.start + offset)
    }
}
