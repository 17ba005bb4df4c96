//! Sections of a carriage's run in which the drive is constantly ON, or constantly OFF.

use firmware::seam::mode::Mode;

use crate::instruments::View;
use crate::record::Row;
use plant::carriage::CarriageTruth;
use report::statistics::mean;

/// Duration of the release of a wound spring after the drive comes ON, s.
const RELEASE_S: f64 = 0.2;
/// Minimum duration of a section, s; a shorter one is the end of a lock.
const SHORTEST_S: f64 = 5e-3;
/// Fraction of the largest gain of a section at which a slip begins and ends.
const SLIP_FRACTION: f64 = 0.5;

/// Section with the drive constantly ON, or constantly OFF.
pub(super) struct DriveSection<'a> {
    /// `true` if the drive is ON.
    pub(super) on: bool,
    /// `true` if the spring was pulled before the section began.
    pub(super) wound: bool,
    /// Blocks of the section.
    pub(super) rows: &'a [Row],
    block_s: f64,
}

/// Returns all sections in `Run` in which the carriage is pulled.
pub(super) fn sections<'a>(run: &View<'a>) -> Vec<DriveSection<'a>> {
    let Some((_, carriage)) = run.scene.carriage() else { return Vec::new() };
    let running_s = run.plays_from(Mode::Run).unwrap_or(f64::INFINITY);
    let windows = run.on_windows().into_iter().filter(|(from_s, to_s)| to_s - from_s > SHORTEST_S);
    let edges = windows.flat_map(|(from_s, to_s)| [(from_s, true), (to_s, false)]);
    let mut begins: Vec<(f64, bool)> = vec![(running_s, false)];
    begins.extend(edges);
    let ends = begins.iter().skip(1).map(|begin| begin.0).chain([f64::INFINITY]).collect::<Vec<_>>();
    let stretch = |((from_s, on), to_s): ((f64, bool), f64)| {
        let rows = run.after(from_s.max(carriage.pull_at_s));
        let rows = &rows[..rows.partition_point(|row| row.time_s <= to_s + 1e-9)];
        (rows.len() as f64 * run.block_s > SHORTEST_S).then_some(DriveSection {
            on,
            wound: from_s > carriage.pull_at_s,
            rows,
            block_s: run.block_s,
        })
    };
    begins.into_iter().zip(ends).filter_map(stretch).collect()
}

/// Returns the pull of the carriage at the end of a block.
pub(super) fn pull(row: &Row) -> CarriageTruth {
    row.truth.carriage.unwrap_or_default()
}

impl<'a> DriveSection<'a> {
    /// Returns the beginning of the section, s.
    pub(super) fn begins_s(&self) -> f64 {
        self.rows.first().map_or(f64::NAN, |row| row.time_s - self.block_s)
    }

    /// Returns the end of the section, s.
    pub(super) fn ends_s(&self) -> f64 {
        self.rows.last().map_or(f64::NAN, |row| row.time_s)
    }

    /// Returns the blocks without the release of a spring that was wound while the drive was OFF.
    pub(super) fn settled(&self) -> &'a [Row] {
        let from_s = self.begins_s() + if self.on && self.wound { RELEASE_S } else { 0.0 };
        &self.rows[self.rows.partition_point(|row| row.time_s < from_s)..]
    }

    /// Returns the largest pull, N.
    pub(super) fn largest_pull_n(&self) -> Option<f64> {
        self.settled().iter().map(|row| pull(row).pull_n).reduce(f64::max)
    }

    /// Returns the largest distance that the carriage gains on the end of its spring, m.
    pub(super) fn jump_m(&self) -> f64 {
        let (mut ahead, mut jump) = (f64::INFINITY, 0.0f64);
        for row in self.settled() {
            let lead_m = row.truth.belt_position_m - pull(row).end_m;
            ahead = ahead.min(lead_m);
            jump = jump.max(lead_m - ahead);
        }
        jump
    }

    /// Returns the largest distance of the carriage beyond the end of its spring, m, from the first
    /// block of the section on.
    pub(super) fn lead_m(&self) -> f64 {
        self.rows.iter().map(|row| row.truth.belt_position_m - pull(row).end_m).fold(0.0, f64::max)
    }

    /// Returns the time at which each slip is half over, s. A slip gains at least half of the
    /// largest gain; the next one begins after half of the largest gain is lost again.
    pub(super) fn slips_s(&self) -> Vec<f64> {
        let enough_m = SLIP_FRACTION * self.jump_m();
        let (mut lowest, mut highest, mut up, mut slips) = (f64::INFINITY, f64::NEG_INFINITY, false, Vec::new());
        for row in self.settled() {
            let lead_m = row.truth.belt_position_m - pull(row).end_m;
            if up {
                highest = highest.max(lead_m);
                if lead_m < highest - enough_m {
                    (up, lowest) = (false, lead_m);
                }
            } else {
                lowest = lowest.min(lead_m);
                if lead_m > lowest + enough_m {
                    (up, highest) = (true, lead_m);
                    slips.push(row.time_s);
                }
            }
        }
        slips
    }

    /// Returns the mean speed, m/s: displacement over time.
    pub(super) fn speed_m_per_s(&self) -> Option<f64> {
        let (first, last) = (self.settled().first()?, self.settled().last()?);
        let way_m = last.truth.belt_position_m - first.truth.belt_position_m;
        (last.time_s > first.time_s).then(|| way_m / (last.time_s - first.time_s))
    }

    /// Returns the root mean square of the speed about its mean, over the mean.
    pub(super) fn ripple(&self) -> Option<f64> {
        let mean_m_per_s = self.speed_m_per_s()?;
        let square = self.mean(|row| Some((row.truth.belt_speed_m_per_s - mean_m_per_s).powi(2)))?;
        Some(square.sqrt() / mean_m_per_s.abs())
    }

    /// Returns the mean over the settled blocks that have a value.
    pub(super) fn mean(&self, value: impl Fn(&Row) -> Option<f64>) -> Option<f64> {
        mean(self.settled().iter().filter_map(value))
    }
}
