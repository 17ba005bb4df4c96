//! The passage of a stretch: panels that are halved until the halves agree with the whole.

use super::super::timeline::Stretch;
use super::super::{Method, SolveError};
use super::marks::edges;
use super::panel::{Bristles, Passage};
use super::super::problem::Law;

/// A panel and its halves may differ by so much; the halves, which are taken, are off by much less.
const AGREE: f64 = 1e-14;
/// Most halvings of a panel, beyond which it is as short as round-off.
const HALVINGS: u32 = 48;
/// Round-off of a mean.
const ROUND_OFF: f64 = 1e-15;

/// A passage, what it is off by at most, and in how many panels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Found {
    pub(super) passage: Passage,
    pub(super) error: f64,
    pub(super) panels: u32,
}

/// A part of a stretch, s from its beginning; differences count over a unit of time.
pub(super) fn of_part(
    bristles: &Bristles,
    stretch: &Stretch,
    (from_s, to_s): (f64, f64),
    unit_s: f64,
) -> Result<Found, SolveError> {
    let diverged = || SolveError::Diverged { method: Method::Collocation.name(), time_s: stretch.start_s };
    let panel = |from_s: f64, to_s: f64| Passage::of_panel(bristles, &stretch.forcing, (from_s, to_s)).ok_or_else(diverged);
    let edges = edges(stretch, nearest(bristles), |steepest| shortest_s(bristles, steepest));
    let mut found = Found::default();
    let mut left: Vec<(f64, f64, Passage, u32)> = Vec::new();
    for pair in edges.windows(2) {
        let (from, to) = (pair[0].max(from_s), pair[1].min(to_s));
        if to <= from {
            continue;
        }
        left.push((from, to, panel(from, to)?, 0));
        while let Some((from, to, whole, halvings)) = left.pop() {
            let middle = 0.5 * (from + to);
            let halves = (panel(from, middle)?, panel(middle, to)?);
            let both = halves.0.then(&halves.1);
            let apart = whole.distance(&both, unit_s);
            if apart > AGREE && halvings < HALVINGS {
                left.push((middle, to, halves.1, halvings + 1));
                left.push((from, middle, halves.0, halvings + 1));
                continue;
            }
            found.passage = found.passage.then(&both);
            found.error += apart.max(ROUND_OFF);
            found.panels += 2;
        }
    }
    Ok(found)
}

/// A whole stretch.
pub(super) fn of_stretch(bristles: &Bristles, stretch: &Stretch, unit_s: f64) -> Result<Found, SolveError> {
    of_part(bristles, stretch, (0.0, stretch.length_s), unit_s)
}

/// Vibration velocity at which the slip is smallest, m/s: `-V cos a`.
fn nearest(bristles: &Bristles) -> f64 {
    -bristles.sliding_m_per_s * bristles.direction.along
}

/// The shortest time in which friction turns under a vibration that changes so fast, s: that in which the vibration passes the smallest slip
/// `V sin a`, or the Stribeck velocity, or in which it slips by the length of the bristles.
fn shortest_s(bristles: &Bristles, steepest: f64) -> f64 {
    let across = (bristles.sliding_m_per_s * bristles.direction.across).abs();
    let (stiffness, stribeck) = match bristles.law {
        Law::Coulomb => return f64::INFINITY,
        Law::Dahl { stiffness_n_per_m } => (stiffness_n_per_m, f64::INFINITY),
        Law::Lugre { stiffness_n_per_m, stribeck_m_per_s, .. } => (stiffness_n_per_m, stribeck_m_per_s),
    };
    let across = if across > 0.0 { across } else { f64::INFINITY };
    let slips = (bristles.coulomb_n / (stiffness * steepest)).sqrt();
    (across.min(stribeck) / steepest).min(slips)
}
