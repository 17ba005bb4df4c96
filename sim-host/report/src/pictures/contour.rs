//! Contour lines of a map: marching squares, with linear interpolation between centres of cells.

use std::collections::BTreeMap;

/// Side between the centres of two cells: column and row of the first cell, and `true` if the
/// second cell is above it instead of to its right.
type Side = (usize, usize, bool);

/// Returns the lines of a level, in columns and rows from the centre of the lower left cell. A cell
/// without a value interrupts a line.
pub(super) fn lines(columns: &[Vec<f64>], level: f64) -> Vec<Vec<(f64, f64)>> {
    let mut links: BTreeMap<Side, Vec<Side>> = BTreeMap::new();
    for (x, pair) in columns.windows(2).enumerate() {
        for (y, (left, right)) in pair[0].windows(2).zip(pair[1].windows(2)).enumerate() {
            let corners = [left[0], right[0], right[1], left[1]];
            if !corners.iter().all(|value| value.is_finite()) {
                continue;
            }
            let sides = [(x, y, false), (x + 1, y, true), (x, y + 1, false), (x, y, true)];
            let above = corners.map(|value| value >= level);
            let mut crossed: Vec<Side> =
                (0..4).filter(|&side| above[side] != above[(side + 1) % 4]).map(|side| sides[side]).collect();
            // In a saddle, the mean decides which corners the lines cut off.
            if crossed.len() == 4 && above[0] != (corners.iter().sum::<f64>() >= 4.0 * level) {
                crossed.rotate_left(1);
            }
            for ends in crossed.chunks_exact(2) {
                links.entry(ends[0]).or_default().push(ends[1]);
                links.entry(ends[1]).or_default().push(ends[0]);
            }
        }
    }
    let point = |(x, y, up): Side| {
        let (from, to) = (columns[x][y], if up { columns[x][y + 1] } else { columns[x + 1][y] });
        let part = (level - from) / (to - from);
        if up { (x as f64, y as f64 + part) } else { (x as f64 + part, y as f64) }
    };
    // Open lines are followed from their ends, the closed ones afterwards from any side.
    let ends = links.iter().filter(|(_, next)| next.len() == 1).map(|(&side, _)| side);
    let starts: Vec<Side> = ends.chain(links.keys().copied()).collect();
    let mut lines = Vec::new();
    for mut side in starts {
        let mut line = vec![point(side)];
        while let Some(next) = links.get_mut(&side).and_then(Vec::pop) {
            links.entry(next).or_default().retain(|&back| back != side);
            line.push(point(next));
            side = next;
        }
        if line.len() > 1 {
            lines.push(line);
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(value: impl Fn(f64, f64) -> f64) -> Vec<Vec<f64>> {
        (0..9).map(|x| (0..7).map(|y| value(f64::from(x), f64::from(y))).collect()).collect()
    }

    #[test]
    fn a_plane_has_one_straight_line() {
        let plane = lines(&map(|x, y| x + 2.0 * y), 7.5);
        assert_eq!(plane.len(), 1);
        assert!(plane[0].len() > 8 && plane[0].iter().all(|(x, y)| (x + 2.0 * y - 7.5).abs() < 1e-12), "{plane:?}");
        assert!(lines(&map(|x, y| x + 2.0 * y), 21.0).is_empty());
    }

    /// The lines of a saddle do not cross: one on each side, which sides depends on the level.
    #[test]
    fn a_saddle_has_two_lines() {
        let saddle = |level| lines(&map(|x, y| (x - 3.5) * (y - 2.5)), level);
        for (level, sign) in [(0.1, 1.0), (-0.1, -1.0)] {
            let found = saddle(level);
            assert_eq!(found.len(), 2);
            for line in found {
                let side = (line[0].0 - 3.5).signum();
                assert!(line.iter().all(|(x, y)| (x - 3.5) * side > 0.0 && (y - 2.5) * side * sign > 0.0), "{line:?}");
            }
        }
    }

    #[test]
    fn a_peak_has_a_closed_line_that_a_missing_cell_interrupts() {
        let mut peak = map(|x, y| -(x - 4.0).hypot(y - 3.0));
        let closed = lines(&peak, -2.2);
        assert!(closed.len() == 1 && closed[0].first() == closed[0].last(), "{closed:?}");
        peak[6][3] = f64::NAN;
        let open = lines(&peak, -2.2);
        assert!(open.len() == 1 && open[0].first() != open[0].last() && open[0].len() < closed[0].len(), "{open:?}");
    }
}
