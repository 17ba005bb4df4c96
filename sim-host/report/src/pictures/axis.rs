//! Conversion of values to positions along an axis: range, ticks and their labels.
//!
//! A *position* is the value itself on a linear axis and its decimal logarithm on a logarithmic
//! one. Straight lines of a picture are straight in positions. Everything is therefore clipped and
//! thinned as positions, and the plotting library receives plain numbers.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;

use super::number;
use crate::figure::Axis;

/// Room beyond the data, as a fraction of their extent: below the lowest and above the highest.
pub(super) type Margins = [f64; 2];

/// Largest position; beyond it the distance between two of them may overflow.
const MAX_POSITION: f64 = 1e300;
/// Smallest distance that differs from zero.
const MIN_DISTANCE: f64 = 1e-300;

/// An axis with its final range.
#[derive(Debug, Clone)]
pub(super) struct Scale {
    log: bool,
    /// Position of the axis' beginning.
    pub low: f64,
    /// Position of the axis' end.
    pub high: f64,
    ticks: usize,
    names: Vec<String>,
}

impl Scale {
    /// Creates a scale for the axis' own range, or by default for the values with some room around
    /// them.
    ///
    /// With `anchored`, the axis begins at zero if the values come near to it.
    pub fn fit(axis: &Axis, values: &[f64], margins: Margins, anchored: bool) -> Self {
        let log = axis.log;
        let requested = axis.range.and_then(|(a, b)| Some((position(log, a)?, position(log, b)?)));
        let (low, high) = requested
            .filter(|(low, high)| high - low > MIN_DISTANCE)
            .unwrap_or_else(|| surround(log, values, margins, anchored && !log));
        Self { log, low, high, ticks: 10, names: axis.names.clone() }
    }

    /// Limits the number of labels to `ticks`.
    pub fn with_ticks(self, ticks: usize) -> Self {
        Self { ticks, ..self }
    }

    /// Returns the values at the two ends.
    pub fn ends(&self) -> (f64, f64) {
        let value = |position: f64| if self.log { 10f64.powf(position) } else { position };
        (value(self.low), value(self.high))
    }

    /// Returns the position of the value; `None` if it has none on this axis.
    pub fn position(&self, value: f64) -> Option<f64> {
        position(self.log, value)
    }

    /// Returns the distance between the two ends.
    pub fn extent(&self) -> f64 {
        self.high - self.low
    }

    /// Returns `true` if the position is visible.
    pub fn shows(&self, position: f64) -> bool {
        (self.low..=self.high).contains(&position)
    }

    /// Extends both ends equally until the extent reaches `extent`.
    pub fn widen_to(&mut self, extent: f64) {
        let missing = (extent - self.extent()).max(0.0);
        self.low -= missing / 2.0;
        self.high += missing / 2.0;
    }

    /// Returns the positions of the labelled ticks.
    pub fn ticks(&self) -> Vec<f64> {
        if !self.names.is_empty() {
            return (0..self.names.len()).map(|place| place as f64).filter(|&place| self.shows(place)).collect();
        }
        if !self.log {
            return round_values(self.low, self.high, self.ticks);
        }
        let decades = self.extent();
        if decades < 0.7 {
            let (low, high) = (10f64.powf(self.low), 10f64.powf(self.high));
            return round_values(low, high, self.ticks).into_iter().map(f64::log10).collect();
        }
        let digits: &[f64] = if decades < 2.0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let stride = (decades / self.ticks as f64).ceil().max(1.0) as i32;
        self.in_decades(digits, stride)
    }

    /// Returns the positions of the fine grid between the ticks.
    fn fine_grid(&self) -> Vec<f64> {
        if self.log && self.extent() < self.ticks as f64 {
            self.in_decades(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0], 1)
        } else {
            Vec::new()
        }
    }

    fn in_decades(&self, digits: &[f64], stride: i32) -> Vec<f64> {
        (self.low.floor() as i32..=self.high.ceil() as i32)
            .filter(|exponent| exponent.rem_euclid(stride) == 0)
            .flat_map(|exponent| digits.iter().map(move |d| f64::from(exponent) + d.log10()))
            .filter(|&p| self.shows(p))
            .collect()
    }

    /// Returns the label of the tick at `position`.
    pub fn label(&self, position: f64) -> String {
        if let Some(name) = self.names.get(position.round() as usize) {
            return name.clone();
        }
        if self.log && self.extent() >= 0.7 {
            return self.log_label(position);
        }
        let value = |p: f64| if self.log { 10f64.powf(p) } else { p };
        let ticks: Vec<f64> = self.ticks().into_iter().map(value).collect();
        let step = ticks.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
        let step = if step.is_finite() { step } else { self.extent() };
        let largest = value(self.low).abs().max(value(self.high).abs());
        let exponent = largest.log10().floor() as i32;
        if (-3..6).contains(&exponent) {
            number::fixed(value(position), number::decimals(step))
        } else {
            let decimals = number::decimals(step / 10f64.powi(exponent));
            number::scaled(value(position), exponent, decimals)
        }
    }

    fn log_label(&self, position: f64) -> String {
        let exponent = (position + 1e-9).floor() as i32;
        let digit = 10f64.powf(position - f64::from(exponent)).round();
        if self.low >= -3.5 && self.high <= 4.5 {
            let decimals = usize::try_from(-exponent).unwrap_or(0);
            number::fixed(digit * 10f64.powi(exponent), decimals)
        } else if digit == 1.0 {
            number::power_of_ten(exponent)
        } else {
            format!("{digit}·{}", number::power_of_ten(exponent))
        }
    }
}

fn position(log: bool, value: f64) -> Option<f64> {
    let position = if log { value.log10() } else { value };
    (position.abs() < MAX_POSITION).then_some(position)
}

fn surround(log: bool, values: &[f64], margins: Margins, anchored: bool) -> (f64, f64) {
    let positions = || values.iter().filter_map(|&v| position(log, v));
    let low = positions().fold(f64::INFINITY, f64::min);
    let high = positions().fold(f64::NEG_INFINITY, f64::max);
    if low > high {
        return (0.0, 1.0);
    }
    let extent = high - low;
    // A constant, up to rounding, gets an axis on which it looks constant.
    if extent <= 1e-12 * high.abs().max(low.abs()) || extent < MIN_DISTANCE {
        let room = if log || high.abs() < MIN_DISTANCE { 1.0 } else { 0.1 * high.abs() };
        return (low - room, high + room);
    }
    let near_zero = anchored && low >= 0.0 && low < 0.45 * high;
    let start = if near_zero { 0.0 } else { low - margins[0] * extent };
    let end = high + margins[1] * (high - start.min(low));
    if log { (start, end) } else { completed(start, end) }
}

/// Extends the interval to a round value just beyond its end.
///
/// A trace of six seconds ends one sample before the sixth; its axis should still end at 6.
fn completed(low: f64, high: f64) -> (f64, f64) {
    let extent = high - low;
    let ticks = round_values(low, high, 10);
    let Some(step) = ticks.windows(2).map(|w| w[1] - w[0]).next() else { return (low, high) };
    let (below, above) = ((low / step).floor() * step, (high / step).ceil() * step);
    let near = |end: f64, round: f64| if (end - round).abs() < 0.01 * extent { round } else { end };
    (near(low, below), near(high, above))
}

/// Returns values of the form 1, 2 or 5 times a power of ten.
///
/// The library lays out ticks well but treats an interval below 1e-16 as a point, so it receives
/// the interval in units of its own size.
fn round_values(low: f64, high: f64, most: usize) -> Vec<f64> {
    let unit = 10f64.powi((high - low).log10().floor() as i32);
    let ticks = RangedCoordf64::from(low / unit..high / unit).key_points(most);
    ticks.into_iter().map(|tick| tick * unit).collect()
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, position: &f64, limit: (i32, i32)) -> i32 {
        RangedCoordf64::from(self.range()).map(position, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { self.fine_grid() } else { self.ticks() }
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Scale {
    fn format_ext(&self, position: &f64) -> String {
        self.label(*position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: Axis, values: &[f64]) -> Vec<String> {
        let scale = Scale::fit(&axis, values, [0.0, 0.0], false).with_ticks(8);
        scale.ticks().into_iter().map(|t| scale.label(t)).collect()
    }

    #[test]
    fn labels_are_exact_and_carry_no_noise() {
        assert_eq!(labels(Axis::default(), &[0.0, 0.3]), ["0.00", "0.05", "0.10", "0.15", "0.20", "0.25", "0.30"]);
        assert_eq!(labels(Axis::default(), &[39_998.0, 40_002.0]).len(), 5);
        assert_eq!(labels(Axis::default(), &[39_998.0, 40_002.0])[2], "40\u{202f}000");
        assert_eq!(labels(Axis::default(), &[0.0, 3e-20])[1], "0.5·10⁻²⁰");
    }

    #[test]
    fn named_places_are_the_only_ticks() {
        let axis = Axis { names: ["mu", "normal_n", "ratio"].map(String::from).into(), ..Axis::default() };
        assert_eq!(labels(axis, &[0.0, 2.0]), ["mu", "normal_n", "ratio"]);
    }

    #[test]
    fn log_axes_label_decades() {
        let log = Axis { log: true, ..Axis::default() };
        assert_eq!(labels(log.clone(), &[0.01, 100.0]), ["0.01", "0.1", "1", "10", "100"]);
        assert_eq!(labels(log.clone(), &[1e-12, 1e-9])[0], "10⁻¹²");
        assert_eq!(labels(log, &[-1.0, 0.0, 3.0, 30.0]), ["5", "10", "20"]);
    }

    #[test]
    fn unusable_data_still_give_an_axis() {
        let huge = [-1e308, 1e299, f64::INFINITY];
        let hopeless = [&[][..], &[f64::NAN], &[5.0], &[0.0, 0.0], &huge, &[1e-320, 1e-310], &[0.0, 5e-324], &[1e9, 1e9 + 1e-6]];
        for (values, log) in hopeless.into_iter().flat_map(|values| [(values, false), (values, true)]) {
            let axis = Axis { log, ..Axis::default() };
            let scale = Scale::fit(&axis, values, [0.05, 0.05], true).with_ticks(8);
            assert!(scale.low < scale.high, "{values:?}");
            let labels: Vec<String> = scale.ticks().into_iter().map(|t| scale.label(t)).collect();
            assert!(labels.iter().all(|label| !label.contains("NaN")), "{labels:?}");
        }
    }

    #[test]
    fn an_axis_ends_at_a_near_round_value() {
        let scale = Scale::fit(&Axis::default(), &[0.0, 5.9995], [0.0, 0.0], false);
        assert_eq!(scale.ends(), (0.0, 6.0));
        let requested = Axis { range: Some((0.0, 5.9995)), ..Axis::default() };
        assert_eq!(Scale::fit(&requested, &[], [0.0, 0.0], false).ends(), (0.0, 5.9995));
    }
}
