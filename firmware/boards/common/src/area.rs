//! Parts of a flash that are written while the board runs.

/// Area of the flash that consists of whole pages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Area {
    /// Address of the first byte.
    pub start: u32,
    /// Size, bytes.
    pub size: u32,
}

impl Area {
    /// Returns the address of `length` bytes at an offset. Returns `None` beyond the end, or if
    /// offset or length is not a multiple of `grid`.
    #[inline]
    pub fn address(&self, offset: u32, length: u32, grid: u32) -> Option<u32> {
        let end = offset.checked_add(length)?;
        (end <= self.size && offset.is_multiple_of(grid) && length.is_multiple_of(grid)).then_some(self.start + offset)
    }
}
