//! Middleware on the converters: records their codes.
//!
//! A running hash of all drive codes shows if two runs are identical, bit for bit. The last blocks
//! in both directions are retained for inspection, and [`Tracer::dump`] prints them.

use std::collections::VecDeque;
use std::fmt;

use crc::{CRC_64_XZ, Crc, Digest, Table};
use firmware::seam::block::{Codes, DriveBlock, MAX_BLOCK_SAMPLES, SenseBlock};

use crate::analog::Analog;

static CRC: Crc<u64, Table<16>> = Crc::<u64, Table<16>>::new(&CRC_64_XZ);

/// Running hash of drive codes: CRC-64/XZ over the codes as little-endian pairs of bytes, lane by
/// lane, block by block.
#[derive(Clone)]
pub struct DriveHash(Digest<'static, u64, Table<16>>);

impl Default for DriveHash {
    fn default() -> Self {
        DriveHash(CRC.digest())
    }
}

impl fmt::Debug for DriveHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "DriveHash({:016x})", self.value())
    }
}

impl DriveHash {
    /// Adds one block to the hash.
    pub fn add(&mut self, drive: &DriveBlock) {
        let mut bytes = [0; 2 * MAX_BLOCK_SAMPLES];
        for lane in &drive.lanes {
            for (pair, code) in bytes.chunks_exact_mut(2).zip(lane) {
                pair.copy_from_slice(&code.to_le_bytes());
            }
            self.0.update(&bytes[..2 * lane.len()]);
        }
    }

    /// Returns the hash so far.
    pub fn value(&self) -> u64 {
        self.0.clone().finalize()
    }
}

/// Codes of one block in both directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Exchange {
    /// Number of the block, counted from zero.
    pub block: u64,
    /// Codes that were played in the block.
    pub drive: DriveBlock,
    /// Codes that were sampled in the block.
    pub sense: SenseBlock,
}

/// One line: the lowest and highest code of each channel, and the available slow readings.
impl fmt::Display for Exchange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "block {:>6}  drive", self.block)?;
        self.drive.lanes.iter().try_for_each(|lane| write_range(f, lane))?;
        f.write_str("  v")?;
        write_range(f, &self.sense.v)?;
        f.write_str("  i")?;
        write_range(f, &self.sense.i)?;
        let slow = &self.sense.slow;
        slow.belt.map_or(Ok(()), |belt| write!(f, "  belt {}{}", belt.counts, if belt.broken { " broken" } else { "" }))?;
        slow.missed_blocks.filter(|&missed| missed > 0).map_or(Ok(()), |missed| write!(f, "  missed {missed}"))?;
        slow.trips.filter(|trips| trips.over_current).map_or(Ok(()), |_| f.write_str("  over-current"))
    }
}

fn write_range(f: &mut fmt::Formatter<'_>, codes: &Codes) -> fmt::Result {
    match (codes.iter().min(), codes.iter().max()) {
        (Some(low), Some(high)) if low == high => write!(f, " {low:>10} "),
        (Some(low), Some(high)) => write!(f, " {low:>5}..{high:<5}"),
        _ => write!(f, " {:>10} ", "none"),
    }
}

/// Analog side whose blocks are recorded.
#[derive(Clone, Debug)]
pub struct Tracer<A> {
    /// Analog side without the record.
    pub inner: A,
    hash: DriveHash,
    keep: usize,
    retained: VecDeque<Exchange>,
    block: u64,
}

impl<A> Tracer<A> {
    /// Traces the codes to and from `inner`, and keeps the last `keep` blocks.
    pub fn new(inner: A, keep: usize) -> Self {
        Tracer { inner, hash: DriveHash::default(), keep, retained: VecDeque::new(), block: 0 }
    }

    /// Returns the hash of all drive codes so far.
    pub fn hash(&self) -> u64 {
        self.hash.value()
    }

    /// Returns the retained blocks, the oldest first.
    pub fn blocks(&self) -> impl DoubleEndedIterator<Item = &Exchange> + ExactSizeIterator {
        self.retained.iter()
    }

    /// Returns the retained blocks as text, one per line.
    pub fn dump(&self) -> String {
        self.retained.iter().map(|exchange| format!("{exchange}\n")).collect()
    }
}

impl<A: Analog> Analog for Tracer<A> {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        self.inner.exchange(drive, sense);
        self.hash.add(drive);
        if self.keep > 0 {
            self.retained.drain(..(self.retained.len() + 1).saturating_sub(self.keep));
            self.retained.push_back(Exchange { block: self.block, drive: drive.clone(), sense: sense.clone() });
        }
        self.block += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loop_back::LoopBack;

    fn ramp(from: u16) -> DriveBlock {
        DriveBlock { lanes: [(from..from + 4).collect()].into_iter().collect(), listen: 0, drops_queue: false }
    }

    fn traced(keep: usize, blocks: &[DriveBlock]) -> Tracer<LoopBack> {
        let mut tracer = Tracer::new(LoopBack::new(2048, 1.0), keep);
        blocks.iter().for_each(|drive| tracer.exchange(drive, &mut SenseBlock::default()));
        tracer
    }

    #[test]
    fn keeps_the_last_blocks_in_order() {
        let tracer = traced(2, &[ramp(1), ramp(2), ramp(3)]);
        let retained: Vec<_> = tracer.blocks().map(|exchange| (exchange.block, exchange.drive.clone())).collect();
        assert_eq!(retained, [(1, ramp(2)), (2, ramp(3))]);
    }

    #[test]
    fn the_hash_depends_only_on_the_codes_and_their_order() {
        let hash = |keep, blocks: &[DriveBlock]| traced(keep, blocks).hash();
        let whole = hash(0, &[ramp(1), ramp(2)]);
        assert_eq!(whole, hash(9, &[ramp(1), ramp(2)]));
        assert_ne!(whole, hash(0, &[ramp(2), ramp(1)]));
        assert_ne!(whole, hash(0, &[ramp(1)]));
        let mut other = ramp(2);
        other.lanes[0][3] ^= 0x8000;
        assert_ne!(whole, hash(0, &[ramp(1), other]));
    }

    #[test]
    fn the_dump_has_one_line_per_block() {
        let tracer = traced(8, &[DriveBlock::silent(2, 4, 2048), ramp(2050)]);
        let expected = "block      0  drive       2048        2048   v       2048   i       2048 \n\
                        block      1  drive  2050..2053   v  2050..2053   i  2049..2050 \n";
        assert_eq!(tracer.dump(), expected);
    }
}
