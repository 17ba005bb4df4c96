//! The first event of an interval: a margin that falls below zero.
//!
//! Event 0 is a reversal of the slip, with the margin `V sgn V`; the others are the switches of the
//! law. A margin is judged at the points of the interval and half-way between them.

use super::panel::{Equations, Panel};
use crate::forcing::Forcing;
use crate::radau::{STAGES, halfway, rule};

/// Round-off of a margin, relative to its largest value in the interval.
pub(super) const ROUND_OFF_REL: f64 = 1e-13;
/// Largest margin that is left where an event was located, relative to its largest value.
const LOCATED_REL: f64 = 1e-9;
/// Number of places at the beginning of an interval at which the margin of the event before it may
/// be wrong.
const PLACES_OF_AN_EVENT: usize = 2;

/// Search of events in an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Found {
    /// No margin falls below zero.
    Nothing,
    /// A margin is not a number.
    NotANumber,
    /// A margin falls below zero: the part of the interval before it, and its number.
    Event(f64, usize),
}

/// Returns `true` if the margin of an event is zero at the end of an interval, which was solved up
/// to the event.
pub(super) fn is_located(
    equations: &Equations,
    forcing: &Forcing,
    (from_s, length_s): (f64, f64),
    panel: &Panel,
    which: usize,
) -> bool {
    let margin = |y: &[f64], at: f64| equations.margins(y, forcing.value(from_s + at * length_s))[which].abs();
    let nodes = panel.values[1..].iter().zip(rule().at);
    let size = nodes.fold(margin(&panel.values[0], 0.0), |size, (y, at)| size.max(margin(y, at)));
    margin(&panel.values[STAGES], 1.0) <= LOCATED_REL * size
}

/// Returns the first event of an interval of a forcing. `turned` is the event with which the
/// interval began.
pub(super) fn first(
    equations: &Equations,
    forcing: &Forcing,
    (from_s, length_s): (f64, f64),
    panel: &Panel,
    turned: Option<usize>,
) -> Found {
    // The slip is the sum of these velocities, whose round-off it has.
    let speed = equations.problem.sliding_m_per_s.abs() + equations.scale.get(equations.states + 1).copied().unwrap_or(0.0);
    let (rule, halfway) = (rule(), halfway());
    let at_part = |y: &[f64], part: f64| equations.margins(y, forcing.value(from_s + part * length_s));
    let (mut parts, mut all) = (vec![0.0], vec![at_part(&panel.values[0], 0.0)]);
    for node in 0..STAGES {
        parts.extend([halfway.at[node], rule.at[node]]);
        all.push(at_part(&panel.sum(&halfway.of_all[node]), halfway.at[node]));
        all.push(at_part(&panel.values[node + 1], rule.at[node]));
    }
    if all.iter().flatten().any(|margin| margin.is_nan()) {
        return Found::NotANumber;
    }
    let margins = |part: f64| at_part(&panel.sum(&rule.factors(part)), part);
    let events = (0..all[0].len()).filter_map(|which| {
        let size = all.iter().map(|margins| margins[which].abs()).fold(0.0, f64::max);
        let tolerated = ROUND_OFF_REL * size.max(if which == 0 { speed } else { 0.0 });
        // The event that has just been located left a margin of the error of its location, of
        // either sign.
        let begins = all.iter().take(PLACES_OF_AN_EVENT + 1).position(|margins| margins[which] > tolerated);
        let skipped = begins.filter(|_| turned == Some(which)).unwrap_or(0);
        let index = skipped + all[skipped..].iter().position(|margins| margins[which] < -tolerated)?;
        let Some(before) = index.checked_sub(1) else { return Some((0.0, which)) };
        if before == 0 && all[0][which] <= tolerated {
            return Some((0.0, which));
        }
        let of = |part: f64| margins(part)[which];
        Some((root(of, (parts[before], all[before][which]), (parts[index], all[index][which])), which))
    });
    let first = events.min_by(|one, other| one.0.total_cmp(&other.0));
    first.map_or(Found::Nothing, |(part, which)| Found::Event(part, which))
}

/// Returns the root of a function between a positive and a negative value, by regula falsi with
/// halved ends (Illinois).
fn root(of: impl Fn(f64) -> f64, (mut low, mut at_low): (f64, f64), (mut high, mut at_high): (f64, f64)) -> f64 {
    let mut side = 0;
    for _ in 0..100 {
        let next = high - at_high * (high - low) / (at_high - at_low);
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        let value = of(next);
        if value == 0.0 || high - low < 1e-15 {
            return next;
        }
        if value > 0.0 {
            (low, at_low) = (next, value);
            if side == 1 {
                at_high *= 0.5;
            }
            side = 1;
        } else {
            (high, at_high) = (next, value);
            if side == -1 {
                at_low *= 0.5;
            }
            side = -1;
        }
    }
    high
}
