//! Parts of a sweep: files with the rows of consecutive points. Their names contain the range of
//! the points and the checksum of the file.
//!
//! Each of n shards has every n-th of [`BLOCKS`] n blocks of points, so that shards take equally
//! long although neighbouring points are similar. A part lies within one block. The missing points
//! of a sweep or a shard follow from the names of its parts.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use bytes::Bytes;

use super::FolderError;
use crate::output::folder::checksum;

/// Number of blocks of points per shard.
const BLOCKS: u64 = 8;

/// Share of a sweep that a process computes, written as `i/n`, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    number: u64,
    of: u64,
}

impl Shard {
    /// Shard that contains the whole sweep.
    pub const WHOLE: Shard = Shard { number: 1, of: 1 };

    /// Returns the ranges of points of the shard, for a sweep of `count` points.
    fn ranges(self, count: u64) -> Vec<Range<u64>> {
        let blocks = (self.of * BLOCKS).min(count);
        // The product of points and blocks can exceed 64 bits.
        let begin = |block: u64| (u128::from(count) * u128::from(block) / u128::from(blocks)) as u64;
        let mine = (0..blocks).filter(|block| block % self.of == self.number - 1);
        if self.of == 1 {
            std::iter::once(0..count).collect()
        } else {
            mine.map(|block| begin(block)..begin(block + 1)).collect()
        }
    }

    /// Returns the ranges of the shard's points that are in none of the parts.
    pub fn missing(self, count: u64, parts: &[Part]) -> Vec<Range<u64>> {
        self.ranges(count).into_iter().flat_map(|range| gaps(range, parts)).collect()
    }

    /// Returns `true` if some of these points belong to the shard, for a sweep of `count` points.
    pub(super) fn has_points_of(self, points: &Range<u64>, count: u64) -> bool {
        self.ranges(count).iter().any(|range| range.start < points.end && points.start < range.end)
    }

    /// Returns `true` if both shards have a point in common, for a sweep of `count` points.
    pub(super) fn overlaps(self, other: Self, count: u64) -> bool {
        other.ranges(count).iter().any(|range| self.has_points_of(range, count))
    }

    /// Returns the number of points of the shard, for a sweep of `count` points.
    pub fn count(self, count: u64) -> u64 {
        self.ranges(count).iter().map(|range| range.end - range.start).sum()
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        /// Maximum number of shards of a sweep.
        const MOST: u64 = 100_000;
        let (number, of) = text.split_once('/').ok_or("a shard is written i/n, for example 1/4 to 4/4")?;
        let whole = |text: &str| text.trim().parse::<u64>().map_err(|_| format!("`{text}` is not a whole number"));
        let (number, of) = (whole(number)?, whole(of)?);
        if !(1..=MOST).contains(&of) || !(1..=of).contains(&number) {
            return Err(format!("there is no shard {number} of {of}: shards are numbered from 1"));
        }
        Ok(Shard { number, of })
    }
}

/// A part: its points, its file and the checksum of this file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Range of its points.
    pub points: Range<u64>,
    /// Path of its file.
    pub path: PathBuf,
    /// CRC-64/XZ of its file, as in the name; `None` until the file is complete.
    checksum: Option<String>,
}

impl Part {
    /// Creates the part of these points in a folder, for a file with this checksum.
    pub(super) fn new(dir: &Path, points: Range<u64>, checksum: Option<String>) -> Self {
        let sum = checksum.as_ref().map_or_else(String::new, |sum| format!("-{sum}"));
        let path = dir.join(format!("part-{:09}-{:09}{sum}.parquet", points.start, points.end));
        Part { points, path, checksum }
    }

    /// Returns the content of its file.
    ///
    /// # Errors
    /// If the file cannot be read, or does not match its checksum.
    pub(super) fn read(&self) -> Result<Bytes, FolderError> {
        let read = || fs::read(&self.path).and_then(|bytes| Ok((checksum(&bytes[..])?, bytes)));
        let (sum, bytes) = read().map_err(super::read(&self.path))?;
        let why = match &self.checksum {
            Some(known) if *known == sum => return Ok(bytes.into()),
            Some(_) => "does not match the checksum in its name",
            None => "has no checksum in its name",
        };
        Err(FolderError::Damaged { path: self.path.clone(), why })
    }

    fn named(path: PathBuf) -> Option<Self> {
        let name = path.file_name()?.to_str()?.strip_prefix("part-")?.strip_suffix(".parquet")?;
        let mut fields = name.splitn(3, '-');
        let points = fields.next()?.parse().ok()?..fields.next()?.parse().ok()?;
        let checksum = fields.next().map(str::to_owned);
        (points.start < points.end).then_some(Part { points, path, checksum })
    }
}

/// Returns the parts in a folder, in the order of their points.
pub(super) fn list(dir: &Path) -> Result<Vec<Part>, FolderError> {
    let mut parts = Vec::new();
    for entry in fs::read_dir(dir).map_err(super::read(dir))? {
        parts.extend(Part::named(entry.map_err(super::read(dir))?.path()));
    }
    sort(&mut parts);
    Ok(parts)
}

/// Returns the unfinished parts of this shard that killed processes have left.
pub(super) fn unfinished(dir: &Path, shard: Shard, count: u64) -> Result<Vec<PathBuf>, FolderError> {
    let ranges = shard.ranges(count);
    let mut left = Vec::new();
    for entry in fs::read_dir(dir).map_err(super::read(dir))? {
        let path = entry.map_err(super::read(dir))?.path();
        // The name is `part-….parquet`, followed by the process.
        let whole = path.with_extension("").with_extension("");
        let part = path.extension().is_some_and(|end| end == "tmp").then(|| Part::named(whole)).flatten();
        let mine = |part: &Part| ranges.iter().any(|range| range.start <= part.points.start && part.points.end <= range.end);
        left.extend(part.filter(mine).map(|_| path));
    }
    Ok(left)
}

/// Sorts parts by their points.
pub(super) fn sort(parts: &mut [Part]) {
    parts.sort_by(|a, b| (a.points.start, a.points.end, &a.path).cmp(&(b.points.start, b.points.end, &b.path)));
}

/// Returns the points of a range that are in none of these sorted parts.
pub(super) fn gaps(range: Range<u64>, parts: &[Part]) -> Vec<Range<u64>> {
    let mut gaps = Vec::new();
    let mut next = range.start;
    for part in parts.iter().filter(|part| part.points.end > range.start && part.points.start < range.end) {
        if part.points.start > next {
            gaps.push(next..part.points.start);
        }
        next = next.max(part.points.end);
    }
    if next < range.end {
        gaps.push(next..range.end);
    }
    gaps
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each point belongs to exactly one shard. Shards are equally large, within one point per
    /// block.
    #[test]
    fn shards_share_all_points() {
        for (count, of) in [(1, 1), (1, 3), (7, 2), (100, 3), (1000, 7), (100_000_000, 64)] {
            let mut ranges: Vec<Range<u64>> = (1..=of).flat_map(|number| Shard { number, of }.ranges(count)).collect();
            ranges.sort_by_key(|range| range.start);
            assert!(ranges.windows(2).all(|pair| pair[0].end == pair[1].start), "{count}, {of}");
            assert_eq!((ranges[0].start, ranges[ranges.len() - 1].end), (0, count));
            let counts: Vec<u64> = (1..=of).map(|number| Shard { number, of }.count(count)).collect();
            assert!(counts.iter().max() <= counts.iter().min().map(|least| least + BLOCKS).as_ref(), "{counts:?}");
        }
        assert!(["0/2", "3/2", "1", "a/2", "1/0"].iter().all(|text| text.parse::<Shard>().is_err()));
        assert_eq!("2/3".parse::<Shard>().map(|shard| shard.to_string()), Ok("2/3".to_owned()));
    }

    /// Only unfinished files of the own shard are removed.
    #[test]
    fn leftovers_are_found_by_their_points() {
        let dir = std::env::temp_dir().join(format!("left-{}", std::process::id()));
        fs::create_dir_all(&dir).expect("a folder");
        let written = |points: Range<u64>| super::super::unfinished(&Part::new(&dir, points, None).path);
        for path in [written(0..10), written(10..20), dir.join("sweep.csv.7.tmp"), Part::new(&dir, 20..30, None).path] {
            fs::write(path, "").expect("a file");
        }
        assert_eq!(unfinished(&dir, Shard { number: 2, of: 2 }, 160).expect("a folder"), [written(10..20)]);
        fs::remove_dir_all(&dir).expect("removed");
    }

    #[test]
    fn points_without_a_part_are_missing() {
        let parts: Vec<Part> = [0..3, 5..6, 5..9].map(|points| Part::new(Path::new("d"), points, None)).into();
        assert_eq!(gaps(0..12, &parts), [3..5, 9..12]);
        assert!(gaps(4..8, &parts).into_iter().eq(std::iter::once(4..5)));
        assert_eq!(gaps(6..8, &parts), []);
        assert!(Shard::WHOLE.missing(9, &parts).into_iter().eq(std::iter::once(3..5)));
        let named = |name: &str| Part::named(PathBuf::from(name));
        for sum in [None, Some("0123456789abcdef".to_owned())] {
            let part = Part::new(Path::new("d"), 5..9, sum);
            assert_eq!(named(&part.path.to_string_lossy()), Some(part));
        }
        assert!(
            ["part-9-5.parquet", "part-a-5.parquet", "part-1-5.parquet.tmp", "sweep.parquet"]
                .iter()
                .all(|name| named(name).is_none())
        );
    }
}
