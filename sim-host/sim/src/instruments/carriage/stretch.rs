//! The stretches of a run in which the drive of a carriage is ON throughout, or OFF.

use firmware::seam::mode::Mode;

use crate::instruments::View;
use crate::record::Row;
use plant::carriage::CarriageTruth;
use report::statistics::mean;

/// What a drive that comes ON under a wound spring releases is over after this time, s.
const RELEASE_S: f64 = 0.2;
/// What is shorter is the end of a lock, s.
const SHORTEST_S: f64 = 5e-3;
/// Parts of the largest gain of a stretch at which a slip begins and is over.
const SLIP: f64 = 0.5;

/// A stretch with the drive ON throughout, or OFF.
pub(super) struct Stretch<'a> {
    /// Whether the drive is ON.
    pub(super) on: bool,
    /// Whether the spring was pulled before it began.
    pub(super) wound: bool,
    /// The blocks of the stretch.
    pub(super) rows: &'a [Row],
    block_s: f64,
}

/// All stretches of a running controller in which the carriage is pulled.
pub(super) fn all<'a>(run: &View<'a>) -> Vec<Stretch<'a>> {
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
        (rows.len() as f64 * run.block_s > SHORTEST_S).then_some(Stretch {
            on,
            wound: from_s > carriage.pull_at_s,
            rows,
            block_s: run.block_s,
        })
    };
    begins.into_iter().zip(ends).filter_map(stretch).collect()
}

/// What moves the carriage at the end of a block.
pub(super) fn pull(row: &Row) -> CarriageTruth {
    row.truth.carriage.unwrap_or_default()
}

impl<'a> Stretch<'a> {
    /// When it begins, s.
    pub(super) fn begins_s(&self) -> f64 {
        self.rows.first().map_or(f64::NAN, |row| row.time_s - self.block_s)
    }

    /// When it ends, s.
    pub(super) fn ends_s(&self) -> f64 {
        self.rows.last().map_or(f64::NAN, |row| row.time_s)
    }

    /// Its blocks without the release of a spring that was wound while the drive was OFF.
    pub(super) fn settled(&self) -> &'a [Row] {
        let from_s = self.begins_s() + if self.on && self.wound { RELEASE_S } else { 0.0 };
        &self.rows[self.rows.partition_point(|row| row.time_s < from_s)..]
    }

    /// Its largest pull, N.
    pub(super) fn most_n(&self) -> Option<f64> {
        self.settled().iter().map(|row| pull(row).pull_n).reduce(f64::max)
    }

    /// The farthest that the carriage gains on the end of its spring, m.
    pub(super) fn jump_m(&self) -> f64 {
        let (mut ahead, mut jump) = (f64::INFINITY, 0.0f64);
        for row in self.settled() {
            let lead_m = row.truth.belt_position_m - pull(row).end_m;
            ahead = ahead.min(lead_m);
            jump = jump.max(lead_m - ahead);
        }
        jump
    }

    /// The farthest that the carriage is past the end of its spring, m, from the first block of the stretch on.
    pub(super) fn lead_m(&self) -> f64 {
        self.rows.iter().map(|row| row.truth.belt_position_m - pull(row).end_m).fold(0.0, f64::max)
    }

    /// When each slip is half over, s: a slip gains at least half of the largest, and the next one begins when half of that is lost again.
    pub(super) fn slips_s(&self) -> Vec<f64> {
        let enough_m = SLIP * self.jump_m();
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

    /// Mean speed, m/s, by the way that was made.
    pub(super) fn speed_m_per_s(&self) -> Option<f64> {
        let (first, last) = (self.settled().first()?, self.settled().last()?);
        let way_m = last.truth.belt_position_m - first.truth.belt_position_m;
        (last.time_s > first.time_s).then(|| way_m / (last.time_s - first.time_s))
    }

    /// Root mean square of the speed about its mean, over the mean.
    pub(super) fn ripple(&self) -> Option<f64> {
        let mean_m_per_s = self.speed_m_per_s()?;
        let square = self.mean(|row| Some((row.truth.belt_speed_m_per_s - mean_m_per_s).powi(2)))?;
        Some(square.sqrt() / mean_m_per_s.abs())
    }

    /// Mean over its settled blocks that have such a value.
    pub(super) fn mean(&self, value: impl Fn(&Row) -> Option<f64>) -> Option<f64> {
        mean(self.settled().iter().filter_map(value))
    }
}
