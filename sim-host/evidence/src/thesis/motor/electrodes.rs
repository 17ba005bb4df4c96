//! The electrodes: twelve tabs (B.4.1), four signals (B.4.2), and the bending waves that they drive
//! in each direction.
//!
//! Tabs at `n p` with signals `exp(i (w t + phi_n))` drive a forward wave `exp(i (w t - k x))` by
//! the spatial Fourier transform of the pattern at k, and a backward wave by its value at -k. The
//! tabs are equal and the sheet endless; reflections at the edges are not included.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use realfft::num_complex::Complex64;

use super::MEASURED_HZ;
use super::sheet::{INCH_M, SIDE_M, Sheet};
use crate::thesis::claim::{Check, Claim, number};
use crate::thesis::picture::{dashed, figure as draw, line, ranged};
use crate::thesis::sweep;
use report::{Figure, Marker};

/// Largest ratio of the weaker to the stronger direction at which the amplitude of a wave varies
/// less than twofold along it.
pub const TRAVELLING_RATIO: f64 = 1.0 / 3.0;

/// Assignment of the signals to the tabs, which the text leaves open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignalOrder {
    /// Each tab lags the one before it by a quarter period.
    FourPhase,
    /// Half of the tabs alternate between sine and its opposite, the others between cosine and its
    /// opposite.
    TwoGroups,
}

/// Pattern of tabs on the sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pattern {
    /// Number of tabs on the sheet.
    pub tabs: u32,
    /// Width of a tab, m.
    pub width_m: f64,
    /// Gap between two tabs, m.
    pub gap_m: f64,
    /// Assignment of the signals to the tabs.
    pub order: SignalOrder,
}

impl SignalOrder {
    /// Returns the order in words.
    pub fn words(self) -> &'static str {
        match self {
            SignalOrder::FourPhase => "each tab a quarter period after the last",
            SignalOrder::TwoGroups => "six tabs with alternating sine, six with alternating cosine",
        }
    }
}

impl Pattern {
    /// Pattern of the prototype (B.4.1).
    pub const PRINTED: Pattern =
        Pattern { tabs: 12, width_m: 0.2196 * INCH_M, gap_m: 0.0196 * INCH_M, order: SignalOrder::FourPhase };

    /// Returns the distance of the tabs, m.
    pub fn pitch_m(&self) -> f64 {
        self.width_m + self.gap_m
    }

    /// Returns the length from the first tab's edge to the last's, m.
    pub fn length_m(&self) -> f64 {
        f64::from(self.tabs) * self.width_m + f64::from(self.tabs - 1) * self.gap_m
    }

    /// Returns the wave number of the signals, rad/m: four tabs a wave, or two.
    pub fn wave_number(&self) -> f64 {
        let tabs = match self.order {
            SignalOrder::FourPhase => 4.0,
            SignalOrder::TwoGroups => 2.0,
        };
        TAU / (tabs * self.pitch_m())
    }

    /// Returns the phase of a tab's signal, rad.
    pub fn phase(&self, tab: u32) -> f64 {
        match self.order {
            SignalOrder::FourPhase => -FRAC_PI_2 * f64::from(tab),
            SignalOrder::TwoGroups if tab < self.tabs / 2 => PI * f64::from(tab),
            SignalOrder::TwoGroups => FRAC_PI_2 + PI * f64::from(tab - self.tabs / 2),
        }
    }

    /// Returns the spatial Fourier transform at a wave number (positive: along the tabs), m, for
    /// one volt on each tab.
    pub fn transform(&self, k: f64) -> Complex64 {
        let half = 0.5 * k * self.width_m;
        let tab = if half == 0.0 { self.width_m } else { self.width_m * half.sin() / half };
        (0..self.tabs).map(|n| Complex64::from_polar(tab, self.phase(n) + k * self.pitch_m() * f64::from(n))).sum()
    }

    /// Returns the drive of the forward and backward wave of a wave number, relative to all tabs in
    /// phase with a wave.
    pub fn coupling(&self, k: f64) -> [f64; 2] {
        [k, -k].map(|k| self.transform(k).norm() / (f64::from(self.tabs) * self.width_m))
    }

    /// Returns the weaker direction over the stronger.
    pub fn weaker_over_stronger(&self, k: f64) -> f64 {
        let [along, back] = self.coupling(k);
        along.min(back) / along.max(back)
    }
}

/// Draws the coupling over frequency, for both orders.
pub fn figures() -> Vec<Figure> {
    let khz = sweep::spaced(1.0, 60.0, 591);
    let drawn = |order: SignalOrder, id: &str, title: &str, remark: &str| {
        let pattern = Pattern { order, ..Pattern::PRINTED };
        let at = |hz: f64| pattern.coupling(Sheet::BEAM.wave_number(hz));
        let of = |side: usize| khz.iter().map(|khz| at(1e3 * khz)[side]).collect();
        let series =
            vec![line("forward wave", "coupling_along", &khz, of(0)), dashed("backward wave", "coupling_back", &khz, of(1))];
        let caption = format!(
            "Coupling relative to the largest of twelve tabs, by the spatial Fourier transform of the pattern of B.4.1 at \
             the wave number of B.12. {remark} Equal tabs, endless sheet. Dots: the stronger wave at the frequencies of \
             B.5; their labels: the weaker over the stronger."
        );
        let axes = [ranged("frequency [kHz]", 0.0, 60.0), ranged("coupling", 0.0, 1.0)];
        let mut figure = draw(id, title, caption, axes, series);
        figure.markers = MEASURED_HZ
            .map(|hz| {
                let [along, back] = at(hz);
                let ratio = along.min(back) / along.max(back);
                Marker { x: hz / 1e3, y: along.max(back), label: format!("{ratio:.2}") }
            })
            .to_vec();
        figure
    };
    vec![
        drawn(
            SignalOrder::FourPhase,
            "app-b-pattern",
            "Appendix B.4: coupling, each tab a quarter period after the last",
            "The signals fit the wave at 9 kHz.",
        ),
        drawn(
            SignalOrder::TwoGroups,
            "app-b-pattern-groups",
            "Appendix B.4: coupling, six tabs with alternating sine, six with alternating cosine",
            "The signals fit the wave at 36 kHz, but drive both directions equally.",
        ),
    ]
}

/// Judges the claims about the electrodes.
pub fn claims() -> Vec<Claim> {
    vec![fills(), travels()]
}

fn fills() -> Claim {
    let inches = Pattern::PRINTED.length_m() / INCH_M;
    let numbers = vec![number("twelve tabs and eleven gaps [in]", inches), number("sheet [in]", SIDE_M / INCH_M)];
    Claim {
        id: "tabs-fill-sheet",
        section: "B.4.1",
        says: "Twelve tabs of 0.2196 in with gaps of 0.0196 in divide the surface of the sheet.",
        checks: vec![Check::new("sum against 2.85 in (within 0.001 in)", (inches - SIDE_M / INCH_M).abs() < 1e-3, numbers)],
    }
}

fn travels() -> Claim {
    let check = |order: SignalOrder, hz: Option<f64>| {
        let pattern = Pattern { order, ..Pattern::PRINTED };
        let theories = [("beam", Sheet::BEAM), ("plate", Sheet::PLATE)];
        let mut numbers = Vec::new();
        let mut ratios = Vec::new();
        for (theory, sheet) in theories {
            let hz = hz.unwrap_or_else(|| sheet.frequency_hz(pattern.wave_number()));
            let k = sheet.wave_number(hz);
            let [along, back] = pattern.coupling(k);
            ratios.push(pattern.weaker_over_stronger(k));
            numbers.push(number(format!("{theory}: frequency [kHz]"), hz / 1e3));
            numbers.push(number(format!("{theory}: coupling along the tabs"), along));
            numbers.push(number(format!("{theory}: backward"), back));
        }
        let at = hz.map_or("at the frequency that fits the tabs".to_owned(), |hz| format!("{} kHz", hz / 1e3));
        Check::new(format!("{}, {at}", order.words()), ratios.iter().all(|ratio| *ratio < TRAVELLING_RATIO), numbers)
    };
    Claim {
        id: "four-signals-travel",
        section: "B.4.2, B.5",
        says: "Sine, -sine, cosine and -cosine on the tabs form a travelling wave (its amplitude varies less than twofold \
               along it, as beam and as plate).",
        checks: vec![
            check(SignalOrder::FourPhase, None),
            check(SignalOrder::FourPhase, Some(MEASURED_HZ[0])),
            check(SignalOrder::FourPhase, Some(MEASURED_HZ[1])),
            check(SignalOrder::TwoGroups, None),
            check(SignalOrder::TwoGroups, Some(MEASURED_HZ[0])),
            check(SignalOrder::TwoGroups, Some(MEASURED_HZ[1])),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the wave on an endless beam due to bending moments under the tabs, by its Green's
    /// function (`g'''' - k^4 g = delta`), integrated numerically, on either side beyond the near
    /// field.
    fn sent(pattern: &Pattern, k: f64, side: f64) -> f64 {
        let i = Complex64::i();
        // g'' as the sum of outgoing wave and near field.
        let bent = |distance: f64| {
            let outgoing = i * 0.25 / k * (-i * k * distance.abs()).exp();
            outgoing - 0.25 / k * (-k * distance.abs()).exp()
        };
        let steps = 400;
        let at = |x: f64| {
            let mut sum = Complex64::default();
            for tab in 0..pattern.tabs {
                let signal = Complex64::from_polar(1.0, pattern.phase(tab));
                let left = pattern.pitch_m() * f64::from(tab) - 0.5 * pattern.width_m;
                for step in 0..steps {
                    let s = left + pattern.width_m * (f64::from(step) + 0.5) / f64::from(steps);
                    sum += signal * bent(x - s) * (pattern.width_m / f64::from(steps));
                }
            }
            sum
        };
        let middle = 0.5 * pattern.length_m();
        at(middle + side * (middle + 6.0 * TAU / k)).norm() * 4.0 * k
    }

    #[test]
    fn the_transform_is_the_radiated_wave() {
        for order in [SignalOrder::FourPhase, SignalOrder::TwoGroups] {
            let pattern = Pattern { order, ..Pattern::PRINTED };
            for k in [258.5, 384.0, 517.0, 543.0] {
                for (side, signed) in [(1.0, k), (-1.0, -k)] {
                    let (found, expected) = (sent(&pattern, k, side), pattern.transform(signed).norm());
                    // Error of the midpoint rule: (k ds)^2/24, 2e-6 of the largest.
                    assert!((found - expected).abs() < 1e-5 * pattern.length_m(), "{order:?} {k} {side}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn signals_in_step_with_the_wave_drive_it_one_way() {
        let pattern = Pattern::PRINTED;
        let [along, back] = pattern.coupling(pattern.wave_number());
        let half = 0.5 * pattern.wave_number() * pattern.width_m;
        assert!((along - half.sin() / half).abs() < 1e-12 && back < 1e-12, "{along} {back}");
        assert!((1e-3 * Sheet::BEAM.frequency_hz(pattern.wave_number()) - 9.08).abs() < 0.01);
    }
}
