//! Closed forms of horns and rings, reciprocity, energy, and an independent finite-element model.

mod finite_elements;
mod horns;

use std::f64::consts::TAU;

use crate::build::{How, parts};
use crate::keys::{Bolt, Design, Element, Kind, Material};
use crate::part::chain;
use crate::port::C;
use crate::{Solved, solve};

/// A generator of random numbers: splitmix64.
pub(super) struct Draw(u64);

impl Draw {
    /// Returns a number, log-uniform between two.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low * (high / low).powf(((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// Returns a whole number below another.
    fn below(&mut self, most: usize) -> usize {
        (self.between(1.0, 1.0 + most as f64) as usize - 1).min(most - 1)
    }
}

/// Returns two metals and a ceramic.
fn materials() -> Vec<Material> {
    let metal = |name: &str, modulus_pa, density_kg_per_m3, q| Material {
        name: name.into(),
        modulus_pa,
        density_kg_per_m3,
        q,
        ..Material::default()
    };
    let ceramic = Material {
        d33_m_per_v: Some(289e-12),
        permittivity: Some(1300.0),
        loss_tangent: 0.004,
        ..metal("ceramic", 64.5e9, 7500.0, 500.0)
    };
    vec![metal("light", 71e9, 2800.0, 5000.0), metal("heavy", 207e9, 7850.0, 2000.0), ceramic]
}

pub(super) fn cylinder(material: &str, length_m: f64, diameter_m: f64) -> Element {
    let (length_m, diameter_m) = (Some(length_m), Some(diameter_m));
    Element { material: Some(material.into()), length_m, diameter_m, ..Element::default() }
}

fn rings(count: u32, thickness_m: f64, diameter_m: f64) -> Element {
    Element {
        kind: Kind::Rings,
        material: Some("ceramic".into()),
        count: Some(count),
        thickness_m: Some(thickness_m),
        diameter_m: Some(diameter_m),
        bore_m: Some(0.4 * diameter_m),
        electrode_m: Some(0.2e-3),
        electrode_material: Some("light".into()),
        ..Element::default()
    }
}

pub(super) fn design(element: Vec<Element>) -> Design {
    Design { highest_hz: 150e3, element, material: materials(), ..Design::default() }
}

pub(super) fn solved(design: &Design) -> Solved {
    solve(design).unwrap_or_else(|error| panic!("{error}: {}", error.path))
}

/// Returns a random transducer with rings, a bolt, steps, a horn, a joint, a mass and a support.
pub(super) fn random(seed: u64) -> Design {
    let mut draw = Draw(seed);
    let wide = draw.between(0.01, 0.04);
    let metal = |draw: &mut Draw| ["light", "heavy"][draw.below(2)];
    let mut elements = vec![cylinder(metal(&mut draw), draw.between(0.005, 0.05), wide)];
    let count = 1 + draw.below(6) as u32;
    elements.push(rings(count, draw.between(0.5e-3, 6e-3), wide));
    let kind = [Kind::Cylinder, Kind::Cone, Kind::Exponential, Kind::Catenoidal][draw.below(4)];
    let thin = wide * draw.between(0.3, 0.9);
    let horn = cylinder(metal(&mut draw), draw.between(0.005, 0.06), wide);
    elements.push(match kind {
        Kind::Cylinder => horn,
        kind => Element { kind, end_diameter_m: Some(thin), ..horn },
    });
    if draw.below(2) == 0 {
        let stiffness_n_per_m = Some(draw.between(1e7, 1e10));
        elements.push(Element { kind: Kind::Joint, stiffness_n_per_m, ..Element::default() });
    }
    elements.push(cylinder(metal(&mut draw), draw.between(0.005, 0.06), thin));
    if draw.below(2) == 0 {
        elements.push(Element { kind: Kind::Mass, mass_kg: Some(draw.between(1e-3, 0.05)), ..Element::default() });
    }
    if draw.below(3) == 0 {
        let stiffness_n_per_m = Some(draw.between(1e5, 1e9));
        elements.push(Element { kind: Kind::Ground, stiffness_n_per_m, damping_n_s_per_m: Some(1.0), ..Element::default() });
    }
    let bolt =
        Bolt { material: "heavy".into(), diameter_m: 0.3 * wide, from: "rings 2".into(), preload_n: 5e3, ..Bolt::default() };
    let bolt = (draw.below(3) > 0).then_some(bolt);
    Design { bolt, ..design(elements) }
}

/// A free ring between electrodes: `fp = c / 2 t` at constant charge, and
/// `k33^2 = pi/2 fs/fp tan(pi/2 (fp - fs)/fp)` (IEEE Std 176-1987, 6.4.2).
#[test]
fn free_ring_has_the_resonances_of_the_standard() {
    let ring = Element { electrode_m: None, electrode_material: None, count: Some(1), ..rings(1, 0.02, 0.004) };
    let found = solved(&design(vec![ring]));
    let (fs, fp) = (found.working().series_resonance_hz, found.working().parallel_resonance_hz.unwrap());
    let k_square = 289e-12_f64.powi(2) * 64.5e9 / (1300.0 * 8.854_187_812_8e-12);
    let sound = (64.5e9 / (1.0 - k_square) / 7500.0_f64).sqrt();
    assert!((fp / (sound / 0.04) - 1.0).abs() < 1e-9, "{fp}");
    let half = TAU / 4.0;
    let by_standard = half * fs / fp * (half * (fp - fs) / fp).tan();
    assert!((by_standard / k_square - 1.0).abs() < 1e-9, "{by_standard} {k_square}");
}

/// Forces by displacements and charges are symmetric, as are charge by displacement and force by
/// voltage, at any frequency, with losses.
#[test]
fn every_chain_is_reciprocal() {
    for seed in 0..300 {
        let design = random(seed);
        let parts = parts(&design, How { lossless: false, lateral: false }).unwrap();
        let hz = Draw(seed).between(1e3, 150e3);
        let port = chain(&parts, C::new(TAU * hz, 0.0));
        let [[a, b, by_volt], [c, d, f_by_volt]] = port.m;
        // At u1 = u2 = 0 a voltage causes the tension F1; at V = 0 a displacement causes a charge.
        let f1 = -by_volt / b;
        let q1 = port.q[0] - port.q[1] * a / b;
        let f2 = f_by_volt + d * f1;
        let q2 = port.q[1] / b;
        let same = |x: C, y: C| (x - y).norm() <= 1e-9 * (x.norm() + y.norm());
        assert!(((a * d - b * c) - 1.0).norm() < 1e-9 * (a * d).norm().max(1.0), "{seed}: {}", a * d - b * c);
        assert!(same(f1, q1) && same(f2, -q2), "{seed} at {hz}: {f1} {q1} {f2} {q2}");
    }
}

/// All losses together are the electrical power.
#[test]
fn energy_is_balanced() {
    for seed in 0..300 {
        let found = solved(&random(seed));
        let sum: f64 = found.operating.losses.iter().map(|(_, loss)| loss).sum();
        let power = found.operating.power_w;
        assert!((sum / power - 1.0).abs() < 1e-9, "{seed}: {sum} W of {power} W");
        assert!(found.operating.losses.iter().all(|(_, loss)| *loss > -1e-9 * power), "{seed}: {:?}", found.operating.losses);
    }
}

/// The circuit has the admittance of the chain around the resonance, within the part by which
/// losses of materials and supports differ from that of a resistance in each branch.
#[test]
fn circuit_has_the_admittance_of_the_chain() {
    for seed in 0..100 {
        let design = random(seed);
        let found = solved(&design);
        let circuit = found.circuit.as_ref().unwrap();
        let lossy = parts(&design, How { lossless: false, lateral: false }).unwrap();
        for detuned in [-3.0, -1.0, 0.0, 0.7, 4.0] {
            let w = found.working().resonance() * (1.0 + detuned / (2.0 * found.working().q));
            let port = chain(&lossy, C::new(w, 0.0));
            let truth = crate::modes::driven(&port, C::new(w, 0.0)).1;
            let branches = circuit.further.iter().map(|&index| found.modes[index].admittance(w)).sum::<C>();
            let own = found.working().admittance(w);
            let largest = 1.0 / found.working().branch.unwrap().rm_ohm;
            let rest = C::new(circuit.loss_tangent, 1.0) * (w * circuit.c0_f);
            let off = (rest + branches + own - truth).norm() / largest;
            assert!(off < 0.02, "{seed}, {detuned}: {off}");
        }
    }
}

/// The force factor is the motional current per velocity of the tip.
#[test]
fn force_factor_is_current_per_tip_velocity() {
    for seed in 0..50 {
        let found = solved(&Design { drive_v: Some(10.0), ..random(seed) });
        let (mode, at) = (found.working(), &found.operating);
        let motional = 10.0 / mode.branch.unwrap().rm_ohm;
        let velocity = mode.resonance() * at.tip_m;
        let ratio = motional / velocity / mode.branch.unwrap().force_factor_n_per_v;
        assert!((ratio - 1.0).abs() < 0.02 + 3.0 / mode.q, "{seed}: {ratio}");
    }
}

/// Mistakes are refused with the key that is wrong.
#[test]
fn mistakes_name_their_key() {
    let good = random(1);
    assert!(solve(&good).is_ok());
    let with = |change: &dyn Fn(&mut Design)| {
        let mut design = good.clone();
        change(&mut design);
        solve(&design).map_or_else(|error| error.path, |_| "accepted".to_owned())
    };
    let bolt = Some(Bolt { material: "heavy".into(), diameter_m: 0.1, from: "rings 2".into(), ..Bolt::default() });
    assert_eq!(with(&|design| design.element[0].material = Some("unobtainium".into())), "element.0.material");
    assert_eq!(with(&|design| design.element[0].length_m = None), "element.0");
    assert_eq!(with(&|design| design.element[0].end_diameter_m = Some(0.1)), "element.0.end_diameter_m");
    assert_eq!(with(&|design| design.element[1].bore_m = Some(0.5)), "element.1.bore_m");
    assert_eq!(with(&|design| design.element[1].material = Some("heavy".into())), "element.1.material");
    assert_eq!(with(&|design| design.bolt = bolt.clone()), "element.1");
    assert_eq!(with(&|design| (design.drive_v, design.tip_amplitude_m) = (Some(1.0), Some(1e-6))), "tip_amplitude_m");
    assert_eq!(with(&|design| design.highest_hz = 200.0), "highest_hz");
    assert_eq!(with(&|design| design.material[2].d33_m_per_v = Some(1e-9)), "element.1.material");
    assert_eq!(with(&|design| design.material[2].permittivity = None), "element.1.material");
}
