//! Table of the exponent along the wrap over the velocity ratio, and its inverse: the sliding speed
//! of webbing at two tensions.
//!
//! G and H of [`exponent`](super::exponent) are smooth over `x = ln z` between the velocity ratios
//! at which a kink enters at an end of the wrap (`corners.rs`). There they have square-root
//! singularities, so they are stored as Chebyshev polynomials of the root (`chebyshev.rs`). Panels
//! are halved until the last coefficients are below the tolerance. Below the table the ratio is a
//! straight line over z. Above the table it is one, or approaches one as `1 / z^2`.
//!
//! The inverse is stored in the same way if it depends only on the ratio. With a normal part
//! Newton's method finds it in the table.

use super::chebyshev::{Limits, Panel, fill};
use super::normal::{Normal, fitted_effect, fitted_effect_fall};
use super::{Pull, Ring};

/// Limits of the panels for the mean friction ratio.
const VALUE_LIMITS: Limits = Limits { tail: 1e-9, narrowest: 1.0 / 256.0 };
/// Limits of the panels of the inverse, for the velocity ratio.
const INVERSE_LIMITS: Limits = Limits { tail: 1e-9, narrowest: 1.0 / 4096.0 };
/// Highest friction ratio of the inverse.
const HIGHEST_RATIO: f64 = 1.0 - 1e-6;
/// Rise of the ratio at the beginning of the table that counts as round-off.
const FLAT_RATIO_RISE: f64 = 1e-10;
/// Range beyond the table in which a speed is searched, in ln z.
const BEYOND_LN_RATIO: f64 = 40.0;
/// Largest number of iterations of Newton's method.
const MAX_ITERATIONS: u32 = 100;

/// Values at a velocity ratio: mean in-surface ratio, and mean shares of the fitted normal effect
/// with the higher tension at the shoulder and at the retractor.
type Values = [f64; 3];

/// Tabulated law of a ring.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    ring: Ring,
    normal: Option<Normal>,
    /// Panels over the logarithm of the velocity ratio.
    panels: Vec<Panel<3>>,
    /// Beginning of each panel.
    begins: Vec<Beginning>,
    /// Logarithms of the velocity ratio at both ends, and values there.
    ends: [(f64, Values); 2],
    /// Velocity ratio over the mean ratio, without a normal part, in order.
    inverse: Vec<Panel<1>>,
}

/// Beginning of a panel.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Beginning {
    x: f64,
    velocity_ratio: f64,
    values: Values,
}

/// Tensions and pulling end, for the inverse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tensioned {
    /// Mean friction ratio required by the tensions, `ln(T_high / T_low) / (mu wrap)`.
    pub ratio: f64,
    /// Lower tension, N.
    pub low_n: f64,
    /// End that pulls.
    pub pull: Pull,
}

/// Change of the ratio by a fitted normal part under a tension: `ln(1 - c e s) / (q mu wrap)`, with
/// an effect e and a share s.
struct Loss {
    which: usize,
    constant: f64,
    per_exponent: f64,
    tip_m_per_s: f64,
    amplitude: f64,
}

impl Loss {
    /// Returns the change at a share and a velocity ratio.
    fn at(&self, share: f64, velocity_ratio: f64) -> f64 {
        let effect = self.amplitude * fitted_effect(self.tip_m_per_s * velocity_ratio);
        (-self.constant * effect * share).ln_1p() / self.per_exponent
    }

    /// Returns the change and its slope over s, from the slopes of the share and of x over s.
    fn with_slope(&self, (share, share_slope): (f64, f64), velocity_ratio: f64, x_slope: f64) -> (f64, f64) {
        let speed_m_per_s = self.tip_m_per_s * velocity_ratio;
        let effect = self.amplitude * fitted_effect(speed_m_per_s);
        let effect_slope = effect * fitted_effect_fall(speed_m_per_s) * speed_m_per_s * x_slope;
        let taken = self.constant * effect * share;
        let slope = self.constant * (effect_slope * share + effect * share_slope);
        ((-taken).ln_1p() / self.per_exponent, -slope / ((1.0 - taken) * self.per_exponent))
    }
}

impl Table {
    /// Tabulates the law of a ring whose angle of wrap is positive.
    pub fn new(ring: Ring, normal: Option<Normal>) -> Self {
        let values = |x: f64| -> Values { ring.integrals(x.exp(), normal.as_ref()).map(|rad| rad / ring.wrap_rad) };
        let corners = ring.corners(normal.as_ref());
        let mut panels = Vec::new();
        for ends in corners.windows(2) {
            fill(&values, (ends[0], ends[1]), VALUE_LIMITS, &mut panels);
        }
        let begins = panels.iter().map(|panel| {
            let s = panel.lower_s();
            let x = panel.corner.x(s);
            Beginning { x, velocity_ratio: x.exp(), values: std::array::from_fn(|which| panel.value(which, s)) }
        });
        let begins = begins.collect();
        let ends = [corners[0], corners[corners.len() - 1]].map(|x| (x, values(x)));
        let mut table = Table { ring, normal, panels, begins, ends, inverse: Vec::new() };
        if normal.is_none() {
            table.inverse = table.inverted(&corners);
        }
        table
    }

    /// Returns the inverse between the ratios at these corners.
    fn inverted(&self, corners: &[f64]) -> Vec<Panel<1>> {
        let mut at: Vec<f64> = corners.iter().map(|&x| self.at(x)[0].min(HIGHEST_RATIO)).chain([HIGHEST_RATIO]).collect();
        at.sort_by(f64::total_cmp);
        let sought = |ratio: f64| [self.searched(&Tensioned { ratio, low_n: f64::INFINITY, pull: Pull::Shoulder }, 1.0, 1.0)];
        let mut inverse = Vec::new();
        for ends in at.windows(2).filter(|ends| ends[1] > ends[0]) {
            fill(&sought, (ends[0], ends[1]), INVERSE_LIMITS, &mut inverse);
        }
        inverse
    }

    /// Returns the ring.
    pub fn ring(&self) -> &Ring {
        &self.ring
    }

    /// Returns the normal part on which the fitted effect acts; `None` if it has no effect.
    pub fn normal(&self) -> Option<&Normal> {
        self.normal.as_ref()
    }

    /// Returns the number of panels of the table, and of its inverse.
    pub fn panels(&self) -> (usize, usize) {
        (self.panels.len(), self.inverse.len())
    }

    fn at(&self, x: f64) -> Values {
        let [first, last] = &self.ends;
        if x < first.0 {
            return self.below(x).map(|(value, _)| value);
        }
        if x > last.0 {
            return self.above(x).map(|(value, _)| value);
        }
        let panel = &self.panels[self.begins.partition_point(|begins| begins.x <= x).max(1) - 1];
        let s = panel.corner.s(x);
        std::array::from_fn(|which| panel.value(which, s))
    }

    /// Returns values below the table, with slopes over x: a straight line over z, starting at the
    /// floor.
    fn below(&self, x: f64) -> [(f64, f64); 3] {
        let (first, [ratio, shoulder, retractor]) = self.ends[0];
        let rise = (ratio - self.ring.floor) * (x - first).exp();
        [(self.ring.floor + rise, rise), (shoulder, 0.0), (retractor, 0.0)]
    }

    /// Returns values above the table, with slopes over x.
    fn above(&self, x: f64) -> [(f64, f64); 3] {
        let (last, [ratio, shoulder, retractor]) = self.ends[1];
        let left = (1.0 - ratio) * (2.0 * (last - x)).exp();
        [(1.0 - left, 2.0 * left), (shoulder, 0.0), (retractor, 0.0)]
    }

    /// Returns the mean in-surface friction ratio at a velocity ratio.
    pub fn in_surface(&self, velocity_ratio: f64) -> f64 {
        self.at(velocity_ratio.ln())[0]
    }

    /// Returns the mean friction ratio at a velocity ratio in units of the peak velocity
    /// `tip_m_per_s` at this amplitude (0 to 1), for a lower tension, N, and the end that pulls.
    pub fn ratio(&self, velocity_ratio: f64, (tip_m_per_s, amplitude): (f64, f64), (low_n, pull): (f64, Pull)) -> f64 {
        let values = self.at(velocity_ratio.ln());
        let loss = self.loss(&Tensioned { ratio: 0.0, low_n, pull }, tip_m_per_s, amplitude);
        values[0] + loss.map_or(0.0, |loss| loss.at(values[loss.which], velocity_ratio))
    }

    fn loss(&self, needed: &Tensioned, tip_m_per_s: f64, amplitude: f64) -> Option<Loss> {
        let normal = self.normal.as_ref()?;
        let which = if needed.pull == Pull::Shoulder { 1 } else { 2 };
        let (constant, per_exponent) = self.ring.fitted_constants(normal, needed.low_n);
        Some(Loss { which, constant, per_exponent, tip_m_per_s: amplitude * tip_m_per_s, amplitude })
    }

    /// Returns the velocity ratio at which webbing slides under two tensions, in units of the peak
    /// velocity `tip_m_per_s` at this amplitude (0 to 1).
    pub fn velocity_ratio(&self, needed: &Tensioned, tip_m_per_s: f64, amplitude: f64) -> f64 {
        let panel = self.inverse.get(self.inverse.partition_point(|panel| panel.upper() < needed.ratio));
        match panel {
            Some(panel) if needed.ratio > self.ends[0].1[0] + FLAT_RATIO_RISE => {
                panel.value(0, panel.corner.s(needed.ratio)).max(0.0)
            }
            _ => self.searched(needed, tip_m_per_s, amplitude),
        }
    }

    /// Finds the same velocity ratio by Newton's method.
    fn searched(&self, needed: &Tensioned, tip_m_per_s: f64, amplitude: f64) -> f64 {
        let loss = self.loss(needed, tip_m_per_s, amplitude);
        let [(first, at_first), (last, at_last)] = self.ends;
        if loss.is_none() && at_first[0] - needed.ratio >= -FLAT_RATIO_RISE {
            // A straight line over z, or the velocity ratio at which the floor is left.
            let rise = at_first[0] - self.ring.floor;
            let part = if rise > FLAT_RATIO_RISE { (needed.ratio - self.ring.floor).max(0.0) / rise } else { 1.0 };
            return first.exp() * part.min(1.0);
        }
        let total = |values: &Values, velocity_ratio: f64| {
            values[0] + loss.as_ref().map_or(0.0, |loss| loss.at(values[loss.which], velocity_ratio))
        };
        // Residual and its slope over s, from the slope of x over s.
        let off = |values: [(f64, f64); 3], x: f64, x_slope: f64| {
            let (ratio, slope) = values[0];
            let (lost, lost_slope) =
                loss.as_ref().map_or((0.0, 0.0), |loss| loss.with_slope(values[loss.which], x.exp(), x_slope));
            (ratio + lost - needed.ratio, slope + lost_slope)
        };
        // The panel that contains the ratio, from the beginnings of the panels.
        let at = |begins: &Beginning| total(&begins.values, begins.velocity_ratio);
        let above = self.begins.partition_point(|begins| at(begins) <= needed.ratio);
        if above == 0 {
            return root((first - BEYOND_LN_RATIO, first), first, |x| off(self.below(x), x, 1.0)).exp();
        }
        let (begins, panel) = (&self.begins[above - 1], &self.panels[above - 1]);
        let (upper, at_upper) = match self.begins.get(above) {
            Some(begins) => (begins.x, at(begins)),
            None => (last, total(&at_last, last.exp())),
        };
        if at_upper <= needed.ratio {
            if loss.is_none() && self.ring.plane.across == 0.0 {
                // Above the table the ratio is one.
                return last.exp();
            }
            return root((last, last + BEYOND_LN_RATIO), last, |x| off(self.above(x), x, 1.0)).exp();
        }
        let (low, high) = if panel.corner.reach > 0.0 { (panel.from, panel.to) } else { (panel.to, panel.from) };
        let at_begin = at(begins);
        let straight = begins.x + (upper - begins.x) * (needed.ratio - at_begin) / (at_upper - at_begin);
        let which = loss.as_ref().map_or(0, |loss| loss.which);
        let s = root((low, high), panel.corner.s(straight), |s| {
            let [ratio, share] = panel.values_and_slopes([0, which], s);
            off([ratio, share, share], panel.corner.x(s), 2.0 * panel.corner.reach * s)
        });
        panel.corner.x(s).exp()
    }
}

/// Finds the zero of a function that is negative at the first point and positive at the second, by
/// Newton's method from a point between them.
fn root((mut below, mut above): (f64, f64), from: f64, f: impl Fn(f64) -> (f64, f64)) -> f64 {
    /// Length of a Newton step below which the error, of the order of its square, is negligible.
    const SHORT_STEP_REL: f64 = 1e-8;
    let mut x = from;
    for _ in 0..MAX_ITERATIONS {
        let (value, slope) = f(x);
        *(if value > 0.0 { &mut above } else { &mut below }) = x;
        let newton = x - value / slope;
        let size = x.abs().max(1.0);
        if (newton - x).abs() < SHORT_STEP_REL * size && newton >= below.min(above) && newton <= below.max(above) {
            return newton;
        }
        let between = newton > below.min(above) && newton < below.max(above);
        let next = if between { newton } else { 0.5 * (below + above) };
        if (above - below).abs() < 1e-15 * size {
            return next;
        }
        x = next;
    }
    x
}
