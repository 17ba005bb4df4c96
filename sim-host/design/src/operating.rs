//! Operating point of a design: displacement and stress along the axis, and losses by part.

use std::f64::consts::PI;

use crate::build::{BOLT, Parts};
use crate::part::{Part, Rod, chain};
use crate::port::{C, Port, State};

/// Points in each part at which displacement and stress are sampled.
const POINTS: usize = 24;
/// Further points in each half wave.
const POINTS_PER_HALF_WAVE: f64 = 16.0;
/// Number of bisections for a node.
const BISECTIONS: usize = 50;

/// Operating point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Operating {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Voltage, V peak.
    pub drive_v: f64,
    /// Total current, A peak.
    pub current_a: f64,
    /// Displacement of the tip, m peak.
    pub tip_m: f64,
    /// Displacement of the back, m peak.
    pub back_m: f64,
    /// Electrical power, W; zero without piezoelectric rings.
    pub power_w: f64,
    /// Places along the axis, m from the back, at which displacement and stress are known.
    pub points: Vec<Point>,
    /// Places without displacement, m from the back.
    pub nodes_m: Vec<f64>,
    /// Largest stress in each element, Pa peak, by its index.
    pub stresses: Vec<(usize, f64)>,
    /// Largest stress in the bolt, Pa peak.
    pub bolt_pa: Option<f64>,
    /// Loss in each element, W, by its index; `usize::MAX` is the bolt.
    pub losses: Vec<(usize, f64)>,
}

/// A place along the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Distance from the back, m.
    pub x_m: f64,
    /// Index of the element.
    pub element: usize,
    /// Displacement in phase with the tip, m.
    pub displacement_m: f64,
    /// Stress in phase with the tip, Pa; positive: tension.
    pub stress_pa: f64,
    /// Radius of a full rod of the same area, m.
    pub radius_m: f64,
}

/// A run along a chain that collects the operating point.
struct Walk {
    w: C,
    v: C,
    /// Direction of the tip's displacement in the complex plane.
    tip: C,
    x_m: f64,
    found: Operating,
}

impl Operating {
    /// Computes the operating point of a chain at a real angular frequency, from the displacement
    /// of the back and the voltage.
    pub(crate) fn new(parts: &Parts, w: f64, back: C, v: C) -> Self {
        let w = C::new(w, 0.0);
        let left = State { u: back, f: C::default() };
        let (tip, charge) = chain(parts, w).apply(left, v);
        let current = C::i() * w * charge;
        let found = Operating {
            frequency_hz: w.re / (2.0 * PI),
            drive_v: v.norm(),
            current_a: current.norm(),
            tip_m: tip.u.norm(),
            back_m: back.norm(),
            power_w: 0.5 * (v * current.conj()).re,
            ..Operating::default()
        };
        let mut walk = Walk { w, v, tip: tip.u / tip.u.norm(), x_m: 0.0, found };
        walk.parts(parts, left);
        walk.found
    }
}

impl Walk {
    /// Walks along parts, and returns the state at their right end.
    fn parts(&mut self, parts: &[(usize, Part)], left: State) -> State {
        parts.iter().fold(left, |state, (index, part)| self.part(*index, part, state))
    }

    fn part(&mut self, index: usize, part: &Part, left: State) -> State {
        let port = part.port(self.w);
        let (right, charge) = port.apply(left, self.v);
        if let Part::Clamp { inside, bolt } = part {
            self.clamp(inside, bolt, left);
            return right;
        }
        if let Some(rod) = part.rod() {
            self.sample(index, part, rod, left, charge);
        }
        self.lose(index, self.power(left) - self.power(right) + 0.5 * (self.v * (C::i() * self.w * charge).conj()).re);
        right
    }

    /// Walks along the parts in the grip of a bolt.
    fn clamp(&mut self, inside: &[(usize, Part)], bolt: &Rod, left: State) {
        let of_bolt = Part::Rod(bolt.clone());
        let share = chain(inside, self.w).share_of(&of_bolt.port(self.w));
        let tension = share[0] * left.u + share[1] * left.f + share[2] * self.v;
        self.parts(inside, State { f: left.f - tension, ..left });
        let held = State { f: tension, ..left };
        let (end, _) = of_bolt.port(self.w).apply(held, C::default());
        self.lose(BOLT, self.power(held) - self.power(end));
        let stress = |x: f64| of_bolt.state_at(self.w, x, held, C::default()).f.norm() / bolt.area(0.0);
        self.found.bolt_pa = Some(peak((0..=POINTS).map(|point| stress(bolt.length * point as f64 / POINTS as f64))));
    }

    /// Returns the mechanical power that passes a section to the right, W.
    fn power(&self, state: State) -> f64 {
        -0.5 * (state.f * (C::i() * self.w * state.u).conj()).re
    }

    fn lose(&mut self, index: usize, loss_w: f64) {
        match self.found.losses.iter_mut().find(|(other, _)| *other == index) {
            Some((_, sum)) => *sum += loss_w,
            None => self.found.losses.push((index, loss_w)),
        }
    }

    /// Samples displacement and stress along a rod or ring.
    fn sample(&mut self, index: usize, part: &Part, rod: &Rod, left: State, charge: C) {
        let state = |x: f64| part.state_at(self.w, x, left, charge);
        let displacement = |x: f64| (state(x).u * self.tip.conj()).re;
        let count = POINTS + (POINTS_PER_HALF_WAVE * rod.half_waves(self.w.re)) as usize;
        let places: Vec<f64> = (0..=count).map(|point| rod.length * point as f64 / count as f64).collect();
        let nodes: Vec<f64> = places
            .windows(2)
            .filter(|pair| displacement(pair[0]) * displacement(pair[1]) < 0.0)
            .map(|pair| self.x_m + root(&displacement, (pair[0], pair[1])))
            .collect();
        let stress = peak(places.iter().map(|&x| state(x).f.norm() / rod.area(x)));
        let points: Vec<Point> = places
            .iter()
            .map(|&x| Point {
                x_m: self.x_m + x,
                element: index,
                displacement_m: displacement(x),
                stress_pa: (state(x).f * self.tip.conj()).re / rod.area(x),
                radius_m: rod.shape(x).0,
            })
            .collect();
        self.found.nodes_m.extend(nodes);
        self.found.points.extend(points);
        match self.found.stresses.iter_mut().find(|(other, _)| *other == index) {
            Some((_, largest)) => *largest = largest.max(stress),
            None => self.found.stresses.push((index, stress)),
        }
        self.x_m += rod.length;
    }
}

/// Returns the zero of a function that changes its sign in a range.
fn root(of: &impl Fn(f64) -> f64, (mut low, mut high): (f64, f64)) -> f64 {
    let positive = of(high) > 0.0;
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if (of(middle) > 0.0) == positive { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

/// Returns the largest of evenly spaced values, by a parabola through the largest and its
/// neighbours.
fn peak(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    let largest = (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
    match largest.checked_sub(1).and_then(|before| values.get(before..=largest + 1)) {
        Some(&[before, at, after]) if 2.0 * at > before + after => {
            at + (after - before).powi(2) / (8.0 * (2.0 * at - before - after))
        }
        _ => values.get(largest).copied().unwrap_or_default(),
    }
}

/// Returns the port of a chain without rings that moves its tip by 1 m at a resonance.
pub(crate) fn free_back(port: &Port, tip_m: f64) -> C {
    C::new(tip_m, 0.0) / port.m[0][0]
}
