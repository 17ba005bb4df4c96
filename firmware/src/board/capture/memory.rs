//! The memory of a capture: three rings of codes, and the blocks that have not played yet.
//!
//! Blocks of [`PART`] samples are copied whole, with a length and an alignment known at compile
//! time. Other blocks are copied in one or two runs. Sample by sample would take longer than the
//! block interrupt of a board has left while the drive starts.

use super::{PART, Part, SAMPLES};
use crate::seam::block::{LATENCY_BLOCKS, MAX_BLOCK_SAMPLES, dropped_from};

/// Ring buffer of samples.
type Ring = [u16; SAMPLES];

/// Memory of a capture, in the RAM of a board. The recorder owns it while it records, and the
/// background task while it is read.
#[repr(align(4))]
pub struct Memory {
    v: Ring,
    i: Ring,
    drive: Ring,
    /// Codes that were returned and have not played yet.
    coming: [[u16; MAX_BLOCK_SAMPLES]; LATENCY_BLOCKS],
}

impl Memory {
    /// Creates a memory of zeros.
    pub const fn new() -> Self {
        Memory { v: [0; SAMPLES], i: [0; SAMPLES], drive: [0; SAMPLES], coming: [[0; MAX_BLOCK_SAMPLES]; LATENCY_BLOCKS] }
    }

    /// Keeps codes that play two blocks later, in one of the two places for such blocks.
    #[inline]
    pub(super) fn keep_coming(&mut self, place: usize, codes: &[u16]) {
        let Some(coming) = self.coming.get_mut(place) else { return };
        if let (Ok(codes), Some(coming)) = (<&[u16; PART]>::try_from(codes), coming.first_chunk_mut::<PART>()) {
            coming.copy_from_slice(codes);
        } else {
            copy(coming, codes);
        }
    }

    /// Replaces the codes in a place that are
    /// [dropped](crate::seam::block::DriveBlock::drops_queue) with silence.
    #[cold]
    pub(super) fn drop_rest(&mut self, place: usize, samples: usize, silence: u16) {
        let coming = self.coming.get_mut(place).and_then(|coming| coming.get_mut(dropped_from(samples)..samples));
        coming.into_iter().for_each(|codes| codes.fill(silence));
    }

    /// Copies a block of [`PART`] samples of voltage and current, and the drive codes kept in a
    /// place, to an index of the rings. Returns `false` if the block has another size.
    #[inline]
    pub(super) fn take_block(&mut self, at: usize, v: &[u16], i: &[u16], coming: usize) -> bool {
        let (Ok(v), Ok(i)) = (<&[u16; PART]>::try_from(v), <&[u16; PART]>::try_from(i)) else { return false };
        let Some(coming) = self.coming.get(coming).filter(|_| at.is_multiple_of(PART)) else { return false };
        put(&mut self.v, at, v);
        put(&mut self.i, at, i);
        coming.first_chunk().into_iter().for_each(|codes| put(&mut self.drive, at, codes));
        true
    }

    /// Copies a block of any size.
    #[inline(never)]
    pub(super) fn take(&mut self, at: usize, v: &[u16], i: &[u16], coming: usize) {
        write(&mut self.v, at, v);
        write(&mut self.i, at, i);
        let codes = self.coming.get(coming).and_then(|coming| coming.get(..v.len()));
        write(&mut self.drive, at, codes.unwrap_or_default());
    }

    /// Returns part `number` of a capture whose first sample is at index `first`.
    pub fn part(&self, first: usize, number: u16) -> Part {
        let first = first + usize::from(number) * PART;
        let read = |ring: &Ring| core::array::from_fn(|n| ring[(first + n) % SAMPLES]);
        Part { part: number, v: read(&self.v), i: read(&self.i), drive: read(&self.drive) }
    }
}

impl Default for Memory {
    fn default() -> Self {
        Memory::new()
    }
}

/// Writes a whole part at an index of a ring.
#[inline]
fn put(ring: &mut Ring, at: usize, codes: &[u16; PART]) {
    if let Some(place) = ring.as_chunks_mut::<PART>().0.get_mut(at / PART) {
        place.copy_from_slice(codes);
    }
}

/// Writes codes into a ring from an index on.
fn write(ring: &mut Ring, at: usize, codes: &[u16]) {
    let (before, after) = ring.split_at_mut(at.min(SAMPLES));
    let (head, rest) = codes.split_at(after.len().min(codes.len()));
    copy(after, head);
    copy(before, rest);
}

/// Copies codes to the beginning of others, as many as both have.
fn copy(to: &mut [u16], from: &[u16]) {
    let length = to.len().min(from.len());
    to[..length].copy_from_slice(&from[..length]);
}
