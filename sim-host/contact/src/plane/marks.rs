//! The initial edges of the panels of a stretch.
//!
//! Around each moment of smallest slip, panels become shorter in proportion to the distance, down
//! to the shortest time in which friction turns. Each such moment is an edge, so no narrow feature
//! lies between the nodes of all panels.

use std::f64::consts::TAU;

use super::super::forcing::Forcing;
use super::super::timeline::Stretch;

/// Ratio of the distances of successive edges from a moment of smallest slip.
const GROWTH_RATIO: f64 = 4.0;
/// Shortest panel, as a fraction of the stretch.
const SHORTEST_FRACTION: f64 = 1e-13;

/// Returns the edges of the panels of a stretch, s from its beginning, in ascending order.
///
/// The slip is smallest when the forcing is `nearest`. `short_s` computes the shortest time in
/// which friction turns from the steepest slope of the forcing.
pub(super) fn edges(stretch: &Stretch, nearest: f64, short_s: impl Fn(f64) -> f64) -> Vec<f64> {
    let length_s = stretch.length_s;
    let (mut marks, steepest) = match stretch.forcing {
        Forcing::Cosine { size, turns, hz, hz_per_s } => {
            let end = turns + length_s * (hz + 0.5 * hz_per_s * length_s);
            let mut phases = vec![0.0, 0.5];
            if nearest.abs() < size.abs() {
                let turns = (nearest / size).acos() / TAU;
                phases.extend([turns, 1.0 - turns]);
            }
            let (first, last) = (turns.min(end).floor(), turns.max(end).ceil());
            let whole = (0..=(last - first) as u32).map(|turn| first + f64::from(turn));
            let at = |phase: f64| {
                // phase = turns + hz s + hz_per_s s^2 / 2
                let ahead = phase - turns;
                2.0 * ahead / (hz + (hz * hz + 2.0 * hz_per_s * ahead).max(0.0).sqrt())
            };
            let marks: Vec<f64> = whole.flat_map(|whole| phases.iter().map(move |phase| at(whole + phase))).collect();
            (marks, TAU * size.abs() * hz.abs().max((hz + hz_per_s * length_s).abs()))
        }
        Forcing::Line { value, slope } if slope != 0.0 => (vec![(nearest - value) / slope], slope.abs()),
        Forcing::Line { .. } => (Vec::new(), 0.0),
    };
    let shortest_s = SHORTEST_FRACTION * length_s;
    marks.retain(|&mark| mark > shortest_s && mark < length_s - shortest_s);
    let short_s = short_s(steepest).clamp(shortest_s, length_s);
    marks.extend([0.0, length_s]);
    marks.sort_by(f64::total_cmp);
    marks.dedup_by(|one, other| *one - *other < shortest_s);
    let mut edges = vec![0.0];
    for pair in marks.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let middle = 0.5 * (from + to);
        let mut reach: Vec<f64> = std::iter::successors(Some(short_s), |reach| Some(GROWTH_RATIO * reach))
            .take_while(|&reach| from + reach < middle - 0.5 * reach)
            .collect();
        edges.extend(reach.iter().map(|reach| from + reach));
        edges.push(middle);
        reach.reverse();
        edges.extend(reach.iter().map(|reach| to - reach));
        edges.push(to);
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stretch(forcing: Forcing) -> Stretch {
        let (start_s, length_s, fastest_hz) = (0.0, 1.0, 1.0);
        Stretch { start_s, length_s, template: None, forcing, fastest_hz, load: None, opens: false, closes: false }
    }

    #[test]
    fn moments_of_smallest_slip_are_edges() {
        for (hz_per_s, turns) in [(0.0, 0.0), (0.7, 0.2), (-0.5, 1.3)] {
            let forcing = Forcing::Cosine { size: 2.0, turns, hz: 1.0, hz_per_s };
            let edges = edges(&stretch(forcing), -0.6, |_| 1e-6);
            assert!(edges.windows(2).all(|pair| pair[1] > pair[0]) && edges[0] == 0.0 && edges[edges.len() - 1] == 1.0);
            let nearest = edges.iter().filter(|&&edge| (forcing.value(edge) + 0.6).abs() < 1e-12).count();
            assert!(nearest >= 1 && edges.len() < 150, "{nearest} {}", edges.len());
            let shortest = edges.windows(2).map(|pair| pair[1] - pair[0]).fold(1.0, f64::min);
            assert!((shortest - 1e-6).abs() < 1e-10, "{shortest}");
        }
        let edges = edges(&stretch(Forcing::Line { value: -1.0, slope: 3.0 }), 0.5, |_| 1e-3);
        assert!(edges.contains(&0.5) && edges.len() < 40);
    }
}
