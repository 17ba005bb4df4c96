//! Conversion of a value to a colour: dark blue over green to yellow, evenly in lightness. Equal
//! steps look equal, also in grey and to readers with any common kind of colour vision. The knots
//! are those of viridis (Smith and van der Walt 2015), public domain.

use plotters::style::RGBColor;

const KNOTS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 44.0, 122.0],
    [59.0, 81.0, 139.0],
    [44.0, 113.0, 142.0],
    [33.0, 144.0, 141.0],
    [39.0, 173.0, 129.0],
    [92.0, 200.0, 99.0],
    [170.0, 220.0, 50.0],
    [253.0, 231.0, 37.0],
];

/// Returns the colour of a share from 0 to 1; NaN has the colour of zero.
pub(super) fn colour(share: f64) -> RGBColor {
    let place = if share > 0.0 { share.min(1.0) * (KNOTS.len() - 1) as f64 } else { 0.0 };
    let below = (place as usize).min(KNOTS.len() - 2);
    let part = place - below as f64;
    let channel = |c: usize| (KNOTS[below][c] + part * (KNOTS[below + 1][c] - KNOTS[below][c])).round() as u8;
    RGBColor(channel(0), channel(1), channel(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the lightness L* of CIE 1976, from the sRGB of the screen.
    fn lightness(RGBColor(r, g, b): RGBColor) -> f64 {
        let linear = |c: u8| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        let y = 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
        116.0 * y.cbrt() - 16.0
    }

    #[test]
    fn equal_steps_are_equally_lighter() {
        let steps: Vec<f64> = (0..=100).map(|n| lightness(colour(f64::from(n) / 100.0))).collect();
        assert!(steps.windows(2).all(|pair| pair[1] > pair[0]));
        // From 15 to 91; the knots are rounded to whole numbers, so the steps of a tenth are equal
        // to 12.5 %.
        let tenths: Vec<f64> = steps.windows(11).step_by(10).map(|tenth| tenth[10] - tenth[0]).collect();
        let mean = (steps[100] - steps[0]) / 10.0;
        assert!(tenths.iter().all(|tenth| (tenth / mean - 1.0).abs() < 0.125), "{tenths:?} {mean}");
    }

    #[test]
    fn ends_and_beyond() {
        let ends = [colour(-1.0), colour(f64::NAN), colour(0.0), colour(1.0), colour(2.0)];
        let rgb = ends.map(|c| (c.0, c.1, c.2));
        assert_eq!(rgb, [(68, 1, 84), (68, 1, 84), (68, 1, 84), (253, 231, 37), (253, 231, 37)]);
    }
}
