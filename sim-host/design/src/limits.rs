//! Limits of a design at its operating point: strength, preload, depolarisation, field and heat.
//!
//! ```text
//! metal:   endurance / alternating stress
//! bolt:    endurance (1 - static / tensile) / alternating stress             (Goodman)
//! ceramic: (preload + endurance) / alternating stress                        (tension)
//!          (compression - preload) / alternating stress                      (depolarisation)
//! ```

use std::f64::consts::PI;

use crate::build::{self, BOLT};
use crate::keys::{Design, Element, Kind, Material};
use crate::operating::Operating;

/// Part of the Curie point that is the highest operating temperature, degrees Celsius.
const HOTTEST_PER_CURIE: f64 = 0.5;
/// Temperature of the surroundings, degrees Celsius.
const AMBIENT_C: f64 = 25.0;

/// A limit and the value at the operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// Name of the part.
    pub part: String,
    /// Quantity that is limited.
    pub quantity: &'static str,
    /// Value at the operating point.
    pub value: f64,
    /// Largest value.
    pub most: f64,
    /// Unit of both.
    pub unit: &'static str,
}

impl Limit {
    /// Returns the factor by which the operating point may be raised.
    pub fn margin(&self) -> f64 {
        self.most / self.value
    }

    /// Returns `true` if the value is a stress.
    pub fn is_stress(&self) -> bool {
        self.unit == "Pa"
    }
}

/// Returns the static compression of the elements in the grip of the bolt, Pa, by their index.
pub(crate) fn preload(design: &Design) -> Vec<(usize, f64)> {
    let Some(bolt) = &design.bolt else { return Vec::new() };
    let find = |wanted: &str| (0..design.element.len()).find(|&index| build::name(design, index) == wanted);
    let from = find(&bolt.from).unwrap_or_default();
    let to = bolt.to.as_deref().and_then(find).unwrap_or(from);
    let elements = design.element.iter().enumerate().take(to + 1).skip(from);
    elements.filter_map(|(index, element)| Some((index, bolt.preload_n / area(element)?))).collect()
}

/// Returns the area of a cylinder or ring, m^2.
fn area(element: &Element) -> Option<f64> {
    let bore = element.bore_m.unwrap_or_default();
    Some(PI / 4.0 * (element.diameter_m?.powi(2) - bore * bore))
}

/// Returns the temperature of the rings over the surroundings, K, if its thermal resistance is
/// known.
pub(crate) fn heating(design: &Design, operating: &Operating) -> Option<f64> {
    let is_ring = |index: usize| design.element.get(index).is_some_and(|element| element.kind == Kind::Rings);
    let loss_w: f64 = operating.losses.iter().filter(|(index, _)| is_ring(*index)).map(|(_, loss)| loss).sum();
    design.thermal_resistance_k_per_w.map(|resistance| resistance * loss_w)
}

/// Returns all limits that are known.
pub(crate) fn limits(design: &Design, operating: &Operating, preload: &[(usize, f64)], heating_k: Option<f64>) -> Vec<Limit> {
    let mut limits = Vec::new();
    for (index, element) in design.element.iter().enumerate() {
        let part = build::name(design, index);
        let held = preload.iter().find(|(other, _)| *other == index).map_or(0.0, |(_, held)| *held);
        let stress = operating.stresses.iter().find(|(other, _)| *other == index).map(|(_, stress)| *stress);
        let material = element.material.as_deref().and_then(|name| build::material(design, name));
        let (Some(value), Some(material)) = (stress, material) else { continue };
        let mut add = |quantity, value: f64, most: Option<f64>, unit| {
            limits.extend(most.map(|most| Limit { part: part.clone(), quantity, value, most, unit }));
        };
        if element.kind != Kind::Rings {
            add("alternating stress", value, material.endurance_pa, "Pa");
            // Parts in the grip are not joined otherwise.
            add("tension", value, Some(held).filter(|held| *held > 0.0), "Pa");
            continue;
        }
        let is_pressed = preload.iter().any(|(other, _)| *other == index);
        let tension = material.endurance_pa.or(is_pressed.then_some(0.0));
        add("tension", value, tension.map(|endurance| endurance + held), "Pa");
        add("compression", value, material.compression_pa.map(|most| (most - held).max(0.0)), "Pa");
        let field = element.thickness_m.map_or(0.0, |thickness| operating.drive_v / thickness);
        add("field", field, material.field_v_per_m, "V/m");
        let hottest_k = material.curie_c.map(|curie| HOTTEST_PER_CURIE * curie - AMBIENT_C);
        if let Some(heating_k) = heating_k {
            add("heating", heating_k, hottest_k, "K");
        }
    }
    limits.extend(of_bolt(design, operating));
    limits
}

/// Returns the static tension of the bolt, Pa.
pub(crate) fn bolt_preload(design: &Design) -> Option<f64> {
    design.bolt.as_ref().map(|bolt| bolt.preload_n / (PI / 4.0 * bolt.diameter_m.powi(2)))
}

/// Returns the limits that are not checked, because a material does not have them.
pub(crate) fn unchecked(design: &Design) -> Vec<String> {
    let mut unchecked = Vec::new();
    for (index, element) in design.element.iter().enumerate() {
        let Some(material) = element.material.as_deref().and_then(|name| build::material(design, name)) else { continue };
        let lacks = match element.kind {
            Kind::Rings => material.compression_pa.is_none().then_some(("depolarisation by compression", "compression_pa")),
            _ => material.endurance_pa.is_none().then_some(("strength", "endurance_pa")),
        };
        unchecked.extend(lacks.map(|(limit, key)| format!("{limit} of `{}` (`{key}`)", build::name(design, index))));
    }
    let bolt = design.bolt.as_ref().and_then(|bolt| build::material(design, &bolt.material));
    let lacks = bolt.is_some_and(|material| material.endurance_pa.is_none() || material.tensile_pa.is_none());
    unchecked.extend(lacks.then(|| "strength of the bolt (`endurance_pa`, `tensile_pa`)".to_owned()));
    unchecked
}

/// Returns the limit of the bolt.
fn of_bolt(design: &Design, operating: &Operating) -> Option<Limit> {
    let bolt = design.bolt.as_ref()?;
    let material: &Material = build::material(design, &bolt.material)?;
    let held = bolt_preload(design)?;
    let most = material.endurance_pa? * (1.0 - held / material.tensile_pa?);
    let (part, value) = (build::name(design, BOLT), operating.bolt_pa?);
    Some(Limit { part, quantity: "alternating stress", value, most: most.max(0.0), unit: "Pa" })
}
