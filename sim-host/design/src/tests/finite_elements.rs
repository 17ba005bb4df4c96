//! A finite-element model of the same design, without a common step: linear elements between
//! nodes, and charge as a static condensation.

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, SymmetricEigen};

use super::{cylinder, design, random, solved};
use crate::keys::{Design, Element, Kind, Material};

/// Elements in each rod.
const EACH: usize = 24;

/// Stiffness and mass of a structure that grows.
struct Structure {
    links: Vec<(usize, usize, f64)>,
    grounds: Vec<(usize, f64)>,
    masses: Vec<f64>,
}

impl Structure {
    fn node(&mut self) -> usize {
        self.masses.push(0.0);
        self.masses.len() - 1
    }

    /// Adds a rod from a node, and returns the node at its end: a given one, or a new one.
    fn rod(
        &mut self,
        from: usize,
        to: Option<usize>,
        length: f64,
        modulus: f64,
        density: f64,
        area: &dyn Fn(f64) -> f64,
    ) -> usize {
        let step = length / EACH as f64;
        (0..EACH).fold(from, |left, index| {
            let right = if index + 1 == EACH { to.unwrap_or_else(|| self.node()) } else { self.node() };
            let middle = area((index as f64 + 0.5) * step);
            self.links.push((left, right, modulus * middle / step));
            for node in [left, right] {
                self.masses[node] += 0.5 * density * middle * step;
            }
            right
        })
    }

    /// Returns the lowest resonances, Hz.
    fn resonances(&self) -> Vec<f64> {
        let size = self.masses.len();
        let mut matrix = DMatrix::<f64>::zeros(size, size);
        for &(a, b, stiffness) in &self.links {
            matrix[(a, a)] += stiffness;
            matrix[(b, b)] += stiffness;
            matrix[(a, b)] -= stiffness;
            matrix[(b, a)] -= stiffness;
        }
        self.grounds.iter().for_each(|&(node, stiffness)| matrix[(node, node)] += stiffness);
        let root: Vec<f64> = self.masses.iter().map(|mass| mass.sqrt()).collect();
        let scaled = DMatrix::from_fn(size, size, |row, column| matrix[(row, column)] / (root[row] * root[column]));
        let mut found: Vec<f64> =
            SymmetricEigen::new(scaled).eigenvalues.iter().map(|square| square.max(0.0).sqrt() / TAU).collect();
        found.sort_by(f64::total_cmp);
        found
    }
}

/// Returns the resonances of a design with shorted electrodes.
fn resonances(design: &Design) -> Vec<f64> {
    let material = |name: &str| -> &Material { design.material.iter().find(|material| material.name == name).unwrap() };
    let mut model = Structure { links: Vec::new(), grounds: Vec::new(), masses: Vec::new() };
    let mut at = model.node();
    for element in &design.element {
        let start = at;
        let metal = element.material.as_deref().map(material);
        let (d1, d2) = (element.diameter_m.unwrap_or(0.0), element.end_diameter_m.unwrap_or(element.diameter_m.unwrap_or(0.0)));
        let (length, bore) = (element.length_m.unwrap_or(0.0), element.bore_m.unwrap_or(0.0));
        let ring = PI / 4.0 * (d1 * d1 - bore * bore);
        let diameter = |x: f64| match element.kind {
            Kind::Cone => d1 + (d2 - d1) * x / length,
            Kind::Exponential => d1 * (d2 / d1).powf(x / length),
            Kind::Catenoidal => d2 * ((d1 / d2).acosh() * (1.0 - x / length)).cosh(),
            _ => d1,
        };
        match element.kind {
            Kind::Rings => at = add_rings(&mut model, at, element, metal.unwrap(), material("light"), ring),
            Kind::Joint => {
                let next = model.node();
                model.links.push((at, next, element.stiffness_n_per_m.unwrap()));
                at = next;
            }
            Kind::Mass => model.masses[at] += element.mass_kg.unwrap(),
            Kind::Ground => model.grounds.push((at, element.stiffness_n_per_m.unwrap())),
            _ => {
                let (metal, area) = (metal.unwrap(), |x: f64| PI / 4.0 * diameter(x).powi(2));
                at = model.rod(at, None, length, metal.modulus_pa, metal.density_kg_per_m3, &area);
            }
        }
        if let Some(bolt) = design.bolt.as_ref().filter(|_| element.kind == Kind::Rings) {
            let grip = f64::from(element.count.unwrap()) * (element.thickness_m.unwrap() + element.electrode_m.unwrap());
            let (steel, area) = (material(&bolt.material), PI / 4.0 * bolt.diameter_m.powi(2));
            model.rod(start, Some(at), grip, steel.modulus_pa, steel.density_kg_per_m3, &|_| area);
        }
    }
    model.resonances()
}

/// Adds rings and their electrodes. With shorted electrodes a ring is a rod of the modulus at
/// constant charge, whose charge `C0 G (u2 - u1)` softens it as a whole.
fn add_rings(model: &mut Structure, mut at: usize, element: &Element, ceramic: &Material, metal: &Material, area: f64) -> usize {
    let (compliance, permittivity) = (1.0 / ceramic.modulus_pa, 8.854_187_812_8e-12 * ceramic.permittivity.unwrap());
    let d33 = ceramic.d33_m_per_v.unwrap();
    let k_square = d33 * d33 / (compliance * permittivity);
    let (modulus, thickness) = (ceramic.modulus_pa / (1.0 - k_square), element.thickness_m.unwrap());
    let gamma = d33 / permittivity * modulus;
    let c0 = permittivity * (1.0 - k_square) * area / thickness;
    for _ in 0..element.count.unwrap() {
        let start = at;
        at = model.rod(at, None, thickness, modulus, ceramic.density_kg_per_m3, &|_| area);
        model.links.push((start, at, -gamma * gamma * c0));
        at = model.rod(at, None, element.electrode_m.unwrap(), metal.modulus_pa, metal.density_kg_per_m3, &|_| area);
    }
    at
}

/// No mode is missed, and none is invented.
#[test]
fn modes_are_those_of_finite_elements() {
    for seed in 0..60 {
        let design = random(seed);
        let (found, all) = (solved(&design), resonances(&design));
        let rigid = usize::from(!design.element.iter().any(|element| element.kind == Kind::Ground));
        let expected: Vec<f64> = all.into_iter().skip(rigid).take_while(|hz| *hz < 100e3).collect();
        let got: Vec<f64> = found.modes.iter().map(|mode| mode.series_resonance_hz).collect();
        assert!(!expected.is_empty() && got.len() >= expected.len(), "{seed}: {got:?} {expected:?}");
        for (got, expected) in got.iter().zip(&expected) {
            assert!((got / expected - 1.0).abs() < 0.01, "{seed}: {got} Hz, {expected} Hz");
        }
    }
}

/// Two equal rods with a soft joint have pairs of modes; both of each pair are found.
#[test]
fn close_modes_are_told_apart() {
    for stiffness in [1e-2, 1.0, 1e3] {
        let joint = Element { kind: Kind::Joint, stiffness_n_per_m: Some(stiffness), ..Element::default() };
        let rods = design(vec![cylinder("light", 0.1, 0.02), joint, cylinder("light", 0.1, 0.02)]);
        let found = solved(&rods);
        let hz: Vec<f64> = found.modes.iter().map(|mode| mode.series_resonance_hz).filter(|hz| *hz > 1e3).collect();
        assert_eq!(hz.len(), 10, "{stiffness}: {hz:?}");
    }
}
