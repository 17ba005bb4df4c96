//! Integration over a stretch of the timeline with adaptive panels: a panel is halved until its
//! result agrees with that of its two halves.

use super::super::problem::Law;
use super::super::timeline::Stretch;
use super::super::{Method, SolveError};
use super::marks::edges;
use super::panel::{Bristles, Passage};

/// Largest permitted difference between a panel and its two halves. The halves are used; their
/// error is far smaller.
const AGREEMENT: f64 = 1e-14;
/// Difference below which a panel whose halving does not help is limited by round-off.
const NOISE_DIFFERENCE: f64 = 1e-12;
/// Number of panels in a stretch above which none is halved further; the error estimate includes
/// the rest.
const MAX_PANELS: u32 = 1 << 14;
/// Largest number of halvings of a panel, which is then as short as round-off.
const MAX_HALVINGS: u32 = 48;
/// Round-off that a panel adds to a mean.
const ROUND_OFF: f64 = 1e-17;

/// Passage, upper bound of its error, and number of panels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Found {
    pub(super) passage: Passage,
    pub(super) error: f64,
    pub(super) panels: u32,
}

/// Observer that receives a moment of a stretch and the passage up to it.
type Seen<'a> = &'a mut dyn FnMut(f64, &Passage);

/// Computes the passage of a stretch; `unit_s` is the unit of time for differences of means.
///
/// `seen` receives the passage up to each of the moments, s from the beginning of the stretch, in
/// ascending order.
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
            let rounded = (apart < NOISE_DIFFERENCE && apart > 0.5 * before) || found.panels > MAX_PANELS;
            if apart > AGREEMENT && halvings < MAX_HALVINGS && !rounded {
                left.push(Part { from_s: middle_s, to_s, halvings: halvings + 1, apart });
                left.push(Part { from_s, to_s: middle_s, halvings: halvings + 1, apart });
                continue;
            }
            // The error of the force fades; meanwhile it contributes to the error of the mean.
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

/// Section of a stretch that is to become a panel.
struct Part {
    from_s: f64,
    to_s: f64,
    halvings: u32,
    /// Difference of the parent panel from its halves.
    apart: f64,
}

/// Returns the vibration velocity at which the slip is smallest, m/s: `-V cos a`.
fn nearest(bristles: &Bristles) -> f64 {
    -bristles.sliding_m_per_s * bristles.direction.along
}

/// Returns the shortest time in which friction turns under a given steepest slope of the vibration,
/// s.
///
/// In this time the vibration passes the smallest slip `V sin a` or the Stribeck velocity, or slips
/// by the length of the bristles.
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
