//! The passage of a stretch: panels that are halved until the halves agree with the whole.

use super::super::problem::Law;
use super::super::timeline::Stretch;
use super::super::{Method, SolveError};
use super::marks::edges;
use super::panel::{Bristles, Passage};

/// A panel and its halves may differ by so much; the halves, which are taken, are off by much less.
const AGREE: f64 = 1e-14;
/// Below this a difference that does not become less is of round-off.
const NOISE: f64 = 1e-12;
/// From so many panels of a stretch on none is halved any more: the error estimate then says what that leaves.
const MOST_PANELS: u32 = 1 << 14;
/// Most halvings of a panel, beyond which it is as short as round-off.
const HALVINGS: u32 = 48;
/// Round-off that a panel adds to a mean.
const ROUND_OFF: f64 = 1e-17;

/// A passage, what it is off by at most, and in how many panels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Found {
    pub(super) passage: Passage,
    pub(super) error: f64,
    pub(super) panels: u32,
}

/// Called at a moment of a stretch with what the time up to there does.
type Seen<'a> = &'a mut dyn FnMut(f64, &Passage);

/// A stretch; differences count over a unit of time. `seen` is called at some moments in it, s from its beginning and in ascending order, with what
/// the time up to there does.
pub(super) fn of_stretch(
    bristles: &Bristles,
    stretch: &Stretch,
    unit_s: f64,
    (moments, seen): (&[f64], Seen),
) -> Result<Found, SolveError> {
    let diverged = || SolveError::Diverged { method: Method::Collocation.name(), time_s: stretch.start_s };
    let mut edges = edges(stretch, nearest(bristles), |steepest| shortest_s(bristles, steepest));
    edges.extend_from_slice(moments);
    edges.sort_by(f64::total_cmp);
    edges.dedup();
    let mut waiting = moments.iter().copied().peekable();
    let mut found = Found::default();
    let (mut left, mut off): (Vec<Part>, f64) = (Vec::new(), 0.0);
    for pair in [0.0].iter().chain(&edges).copied().collect::<Vec<_>>().windows(2) {
        if pair[1] > pair[0] {
            left.push(Part { from_s: pair[0], to_s: pair[1], halvings: 0, apart: f64::INFINITY });
        }
        while let Some(Part { from_s, to_s, halvings, apart }) = left.pop() {
            let panel = |passage: &Passage, from_s: f64, to_s: f64| {
                passage.and_panel(bristles, &stretch.forcing, (from_s, to_s)).ok_or_else(diverged)
            };
            let middle_s = 0.5 * (from_s + to_s);
            let whole = panel(&found.passage, from_s, to_s)?;
            let halves = panel(&panel(&found.passage, from_s, middle_s)?, middle_s, to_s)?;
            let before = apart;
            let (of_end, of_mean) = whole.distance(&halves, unit_s);
            let apart = of_end.max(of_mean);
            let rounded = (apart < NOISE && apart > 0.5 * before) || found.panels > MOST_PANELS;
            if apart > AGREE && halvings < HALVINGS && !rounded {
                left.push(Part { from_s: middle_s, to_s, halvings: halvings + 1, apart });
                left.push(Part { from_s, to_s: middle_s, halvings: halvings + 1, apart });
                continue;
            }
            // What the force is off by fades; the mean is off by what it is meanwhile.
            off *= (found.passage.fading - halves.fading).exp();
            off += of_end;
            found.error += of_mean + off * (to_s - from_s) / unit_s + ROUND_OFF;
            found.passage = halves;
            found.panels += 2;
        }
        while let Some(at_s) = waiting.next_if(|&at_s| at_s <= pair[1]) {
            seen(at_s, &found.passage);
        }
    }
    found.error += off;
    Ok(found)
}

/// A part of a stretch that is to be a panel.
struct Part {
    from_s: f64,
    to_s: f64,
    halvings: u32,
    /// By how much the panel that it is a half of differed from its halves.
    apart: f64,
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
