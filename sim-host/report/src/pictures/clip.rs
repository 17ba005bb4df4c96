//! Clipping of curves at the edge of the plot.
//!
//! The plotting library moves a point outside the plot to its edge, which bends the line to that
//! point. Cutting each segment at its crossing with the edge keeps its direction. Cuts and gaps
//! both divide a curve into pieces.

/// A point in positions along the two axes; `None` is a gap.
pub(super) type Point = Option<(f64, f64)>;

/// The visible part of the plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    /// Lowest and highest x.
    pub x: (f64, f64),
    /// Lowest and highest y.
    pub y: (f64, f64),
}

/// Returns the pieces of a polyline inside the window.
pub(super) fn polyline(points: impl Iterator<Item = Point>, window: Window) -> Vec<Vec<(f64, f64)>> {
    let mut pieces: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut last: Point = None;
    let mut open = false;
    for point in points {
        let visible = last.zip(point).and_then(|(a, b)| segment(a, b, window));
        match visible {
            Some((_, end)) if open => pieces.last_mut().into_iter().for_each(|p| p.push(end)),
            Some((start, end)) => pieces.push(vec![start, end]),
            None => {}
        }
        // A segment that was cut short leaves the window; the next piece begins elsewhere.
        open = visible.is_some_and(|(_, end)| Some(end) == point);
        last = point;
    }
    pieces
}

/// Returns the part of a segment inside the window, after Liang and Barsky.
fn segment(a: (f64, f64), b: (f64, f64), window: Window) -> Option<((f64, f64), (f64, f64))> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let edges = [(-dx, a.0 - window.x.0), (dx, window.x.1 - a.0), (-dy, a.1 - window.y.0), (dy, window.y.1 - a.1)];
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (outward, room) in edges {
        if outward == 0.0 {
            if room < 0.0 {
                return None;
            }
        } else if outward < 0.0 {
            enter = enter.max(room / outward);
        } else {
            leave = leave.min(room / outward);
        }
    }
    let at = |t: f64| match t {
        0.0 => a,
        1.0 => b,
        _ => (a.0 + t * dx, a.1 + t * dy),
    };
    (enter <= leave).then(|| (at(enter), at(leave)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Window = Window { x: (0.0, 1.0), y: (0.0, 1.0) };

    #[test]
    fn a_curve_inside_is_unchanged() {
        let inside = [(0.1, 0.1), (0.5, 0.9), (0.9, 0.2)];
        assert_eq!(polyline(inside.into_iter().map(Some), UNIT), [inside.to_vec()]);
    }

    #[test]
    fn crossings_lie_on_the_edge() {
        let through = [(-0.5, 0.5), (0.5, 0.5), (0.5, 2.0), (0.75, 2.0), (0.75, 0.5)];
        let pieces = polyline(through.into_iter().map(Some), UNIT);
        assert_eq!(pieces, [vec![(0.0, 0.5), (0.5, 0.5), (0.5, 1.0)], vec![(0.75, 1.0), (0.75, 0.5)]]);
    }

    #[test]
    fn gaps_split() {
        let points = [Some((0.1, 0.1)), Some((0.2, 0.2)), None, Some((0.3, 0.3)), Some((0.4, 0.4))];
        assert_eq!(polyline(points.into_iter(), UNIT).len(), 2);
    }
}
