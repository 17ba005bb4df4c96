//! Parts of a chain from the keys of a design, with the mistakes that a schema cannot express.

use crate::keys::{Bolt, Design, Element, Kind, Material};
use crate::library;
use crate::part::{Part, Ring, Rod, Taper};
use crate::port::C;

/// Mistake in a design.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct DesignError {
    /// Path of the wrong key, from the table of the design on, such as `element.2.bore_m`.
    pub path: String,
    /// Description of the mistake.
    pub message: String,
    /// Remedy in a few words, or the range of values.
    pub label: String,
}

/// Material of the electrodes, if the design names none.
const ELECTRODE: &str = "beryllium-copper";
/// Quality factor without losses.
const LOSSLESS_Q: f64 = f64::INFINITY;

/// Largest number of rings in all elements.
const MOST_RINGS: u32 = 1000;

/// Parts of a chain with the index of the element of each.
pub(crate) type Parts = Vec<(usize, Part)>;

/// Index of the bolt, which is not an element.
pub(crate) const BOLT: usize = usize::MAX;

/// Options of a calculation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct How {
    /// `true` to leave out all losses.
    pub(crate) lossless: bool,
    /// `true` to include the inertia of the lateral motion.
    pub(crate) lateral: bool,
}

/// A builder of parts.
struct Builder<'a> {
    design: &'a Design,
    how: How,
}

/// Returns the name of an element in tables.
pub(crate) fn name(design: &Design, index: usize) -> String {
    let Some(element) = design.element.get(index) else { return "bolt".to_owned() };
    let kind = format!("{:?}", element.kind).to_lowercase();
    element.name.clone().unwrap_or_else(|| format!("{kind} {}", index + 1))
}

/// Returns the lowest frequency at which a part has no waves, because its lateral inertia counts,
/// Hz.
pub(crate) fn cutoff_hz(parts: &[(usize, Part)]) -> Option<f64> {
    let of_part = |(_, part): &(usize, Part)| match part {
        Part::Clamp { inside, bolt } => [cutoff_hz(inside), bolt.cutoff_hz()].into_iter().flatten().reduce(f64::min),
        part => part.rod().and_then(Rod::cutoff_hz),
    };
    parts.iter().filter_map(of_part).reduce(f64::min)
}

/// Returns the parts of a design.
pub(crate) fn parts(design: &Design, how: How) -> Result<Parts, DesignError> {
    let builder = Builder { design, how };
    builder.check_names()?;
    let of_element = |(index, element): (usize, &Element)| Ok((index, builder.element(index, element)?));
    let elements: Vec<(usize, Vec<Part>)> = design.element.iter().enumerate().map(of_element).collect::<Result<_, _>>()?;
    let flat = |range: &[(usize, Vec<Part>)]| -> Parts {
        range.iter().flat_map(|(index, parts)| parts.iter().map(|part| (*index, part.clone()))).collect()
    };
    let Some(bolt) = &design.bolt else { return Ok(flat(&elements)) };
    let (from, to) = builder.span(bolt)?;
    let inside = flat(&elements[from..=to]);
    let length = inside.iter().filter_map(|(_, part)| part.rod()).map(|rod| rod.length).sum();
    if length == 0.0 {
        return Err(wrong("bolt.from", "the grip of the bolt has no length", "joints alone have none"));
    }
    let material = builder.material("bolt.material", &bolt.material)?;
    let bolt = builder.rod(material, Taper::Linear, length, [bolt.diameter_m; 2], 0.0);
    let clamp = (BOLT, Part::Clamp { inside, bolt });
    Ok([flat(&elements[..from]), vec![clamp], flat(&elements[to + 1..])].concat())
}

/// Returns the material of a name: one of the design, or a built-in one.
pub fn material<'a>(design: &'a Design, name: &str) -> Option<&'a Material> {
    design.material.iter().find(|material| material.name == name).or_else(|| library::material(name))
}

/// Creates the error of a key.
pub(crate) fn wrong(path: impl Into<String>, message: impl Into<String>, label: impl Into<String>) -> DesignError {
    DesignError { path: path.into(), message: message.into(), label: label.into() }
}

impl<'a> Builder<'a> {
    fn material(&self, path: &str, name: &str) -> Result<&'a Material, DesignError> {
        let label = || {
            let mut all: Vec<&str> = library::names().collect();
            all.extend(self.design.material.iter().map(|material| material.name.as_str()));
            format!("known: {}, or one of your own in `[[design.material]]`", all.join(", "))
        };
        let found = material(self.design, name).ok_or_else(|| wrong(path, format!("there is no material `{name}`"), label()))?;
        if found.d33_m_per_v.is_some() != found.permittivity.is_some() {
            let message = format!("`{name}` has only one of `d33_m_per_v` and `permittivity`");
            return Err(wrong(path, message, "a piezoelectric material needs both"));
        }
        if found.ceramic(LOSSLESS_Q, 0.0).is_some_and(|ceramic| ceramic.coupling_square().re >= 1.0) {
            let message = format!("the coupling of `{name}` is above one: d33^2 modulus / permittivity");
            return Err(wrong(path, message, "such a material would be a source of energy"));
        }
        Ok(found)
    }

    /// Returns the quality factor for a material.
    fn q(&self, material: &Material) -> f64 {
        if self.how.lossless { LOSSLESS_Q } else { self.design.q.unwrap_or(material.q) }
    }

    fn rod(&self, material: &Material, taper: Taper, length: f64, diameters: [f64; 2], bore: f64) -> Rod {
        let radii = diameters.map(|diameter| 0.5 * (diameter * diameter - bore * bore).sqrt());
        // Polar radius of gyration; of a horn, that of its mean section.
        let mean_square = 0.5 * (diameters[0].powi(2) + diameters[1].powi(2)) + bore * bore;
        let lateral_m2 = if self.how.lateral { material.poisson.powi(2) * mean_square / 8.0 } else { 0.0 };
        let modulus = material.modulus(self.q(material));
        Rod { taper, length, radii, modulus, density: material.density_kg_per_m3, lateral_m2 }
    }

    /// Returns the parts of an element.
    fn element(&self, index: usize, element: &Element) -> Result<Vec<Part>, DesignError> {
        let path = |key: &str| format!("element.{index}.{key}");
        self.check_keys(index, element, &path)?;
        let material = || self.material(&path("material"), element.material.as_deref().unwrap_or_default());
        let number = |value: Option<f64>| value.unwrap_or_default();
        let (outer, bore) = (number(element.diameter_m), number(element.bore_m));
        if bore > 0.0 && bore >= outer {
            return Err(wrong(path("bore_m"), "the hole is not smaller than the part", format!("less than {outer}")));
        }
        let horn = |taper: Taper| {
            let diameters = [outer, number(element.end_diameter_m)];
            Ok(vec![Part::Rod(self.rod(material()?, taper, number(element.length_m), diameters, 0.0))])
        };
        match element.kind {
            Kind::Cylinder => {
                Ok(vec![Part::Rod(self.rod(material()?, Taper::Linear, number(element.length_m), [outer; 2], bore))])
            }
            Kind::Cone => horn(Taper::Linear),
            Kind::Exponential => horn(Taper::Exponential),
            Kind::Catenoidal => horn(Taper::Catenoidal),
            Kind::Rings => self.rings(element, material()?, &path),
            Kind::Joint => {
                let stiffness = number(element.stiffness_n_per_m);
                let loss = if self.how.lossless { 0.0 } else { self.design.q.map_or(0.0, |q| 1.0 / q) };
                Ok(vec![Part::Joint { stiffness: C::new(stiffness, stiffness * loss) }])
            }
            Kind::Mass => Ok(vec![Part::Point { mass: number(element.mass_kg), stiffness: 0.0, damping: 0.0 }]),
            Kind::Ground => {
                let damping = if self.how.lossless { 0.0 } else { number(element.damping_n_s_per_m) };
                Ok(vec![Part::Point { mass: 0.0, stiffness: number(element.stiffness_n_per_m), damping }])
            }
        }
    }

    fn rings(&self, element: &Element, material: &Material, path: &dyn Fn(&str) -> String) -> Result<Vec<Part>, DesignError> {
        let loss_tangent = if self.how.lossless { 0.0 } else { material.loss_tangent };
        let Some(ceramic) = material.ceramic(self.q(material), loss_tangent) else {
            let message = format!("`{}` is not piezoelectric", material.name);
            return Err(wrong(path("material"), message, "rings need a material with d33 and permittivity"));
        };
        let (diameters, bore) = ([element.diameter_m.unwrap_or_default(); 2], element.bore_m.unwrap_or_default());
        let rod = self.rod(material, Taper::Linear, element.thickness_m.unwrap_or_default(), diameters, bore);
        let ring = Part::Ring(Ring::new(rod, &ceramic));
        let electrode = match element.electrode_m {
            None => None,
            Some(thickness) => {
                let name = element.electrode_material.as_deref().unwrap_or(ELECTRODE);
                let metal = self.material(&path("electrode_material"), name)?;
                Some(Part::Rod(self.rod(metal, Taper::Linear, thickness, diameters, bore)))
            }
        };
        let one = |_| std::iter::once(ring.clone()).chain(electrode.clone());
        Ok((0..element.count.unwrap_or_default()).flat_map(one).collect())
    }

    /// Checks that an element has the keys that its kind needs, and no others.
    fn check_keys(&self, index: usize, element: &Element, path: &dyn Fn(&str) -> String) -> Result<(), DesignError> {
        let given = [
            ("material", element.material.is_some()),
            ("length_m", element.length_m.is_some()),
            ("diameter_m", element.diameter_m.is_some()),
            ("end_diameter_m", element.end_diameter_m.is_some()),
            ("bore_m", element.bore_m.is_some()),
            ("count", element.count.is_some()),
            ("thickness_m", element.thickness_m.is_some()),
            ("electrode_m", element.electrode_m.is_some()),
            ("electrode_material", element.electrode_material.is_some()),
            ("mass_kg", element.mass_kg.is_some()),
            ("stiffness_n_per_m", element.stiffness_n_per_m.is_some()),
            ("damping_n_s_per_m", element.damping_n_s_per_m.is_some()),
        ];
        let (needed, possible): (&[&str], &[&str]) = match element.kind {
            Kind::Cylinder => (&["material", "length_m", "diameter_m"], &["bore_m"]),
            Kind::Cone | Kind::Exponential | Kind::Catenoidal => (&["material", "length_m", "diameter_m", "end_diameter_m"], &[]),
            Kind::Rings => {
                (&["material", "count", "thickness_m", "diameter_m"], &["bore_m", "electrode_m", "electrode_material"])
            }
            Kind::Joint => (&["stiffness_n_per_m"], &[]),
            Kind::Mass => (&["mass_kg"], &[]),
            Kind::Ground => (&["stiffness_n_per_m"], &["damping_n_s_per_m"]),
        };
        let kind = format!("{:?}", element.kind).to_lowercase();
        for (key, given) in given {
            if needed.contains(&key) && !given {
                let at = path("");
                let message = format!("`{key}` is missing in `{}`", name(self.design, index));
                return Err(wrong(at.trim_end_matches('.'), message, format!("{kind} needs {}", needed.join(", "))));
            }
            if key == "electrode_material" && given && element.electrode_m.is_none() {
                return Err(wrong(
                    path(key),
                    "`electrode_material` has no effect without `electrode_m`",
                    "there are no electrodes",
                ));
            }
            if given && !needed.contains(&key) && !possible.contains(&key) {
                let label = format!("{kind} has {}", [needed, possible].concat().join(", "));
                return Err(wrong(path(key), format!("`{key}` has no meaning in this part"), label));
            }
        }
        Ok(())
    }

    /// Checks that names are unique, and that the rings are not too many.
    fn check_names(&self) -> Result<(), DesignError> {
        let all: Vec<String> = (0..self.design.element.len()).map(|index| name(self.design, index)).collect();
        for (index, own) in all.iter().enumerate() {
            if all[..index].contains(own) || own.is_empty() || *own == name(self.design, BOLT) {
                let message = format!("the name `{own}` is taken, or empty");
                return Err(wrong(format!("element.{index}"), message, "give another `name`"));
            }
        }
        let materials = &self.design.material;
        for (index, material) in materials.iter().enumerate() {
            if materials[..index].iter().any(|other| other.name == material.name) {
                let message = format!("there are two materials `{}`", material.name);
                return Err(wrong(format!("material.{index}.name"), message, "second occurrence"));
            }
        }
        let rings: u32 = self.design.element.iter().filter_map(|element| element.count).sum();
        if rings > MOST_RINGS {
            return Err(wrong("element", format!("there are {rings} rings"), format!("at most {MOST_RINGS}")));
        }
        Ok(())
    }

    /// Returns the first and last element that the bolt passes.
    fn span(&self, bolt: &Bolt) -> Result<(usize, usize), DesignError> {
        let find = |key: &str, wanted: &str| {
            let all = || (0..self.design.element.len()).map(|index| name(self.design, index));
            let label = || format!("parts: {}", all().collect::<Vec<_>>().join(", "));
            all().position(|name| name == wanted).ok_or_else(|| wrong(key, format!("there is no part `{wanted}`"), label()))
        };
        let from = find("bolt.from", &bolt.from)?;
        let to = bolt.to.as_deref().map_or(Ok(from), |to| find("bolt.to", to))?;
        if to < from {
            return Err(wrong("bolt.to", "the bolt ends before it begins", "a part after `from`"));
        }
        for (index, element) in self.design.element.iter().enumerate().take(to + 1).skip(from) {
            let path = format!("element.{index}");
            match element.kind {
                Kind::Cylinder | Kind::Rings if element.bore_m.unwrap_or_default() >= bolt.diameter_m => {}
                Kind::Cylinder | Kind::Rings => {
                    let label = format!("`bore_m` must be at least {} m", bolt.diameter_m);
                    return Err(wrong(path, format!("the bolt does not pass through `{}`", name(self.design, index)), label));
                }
                Kind::Joint => {}
                Kind::Cone | Kind::Exponential | Kind::Catenoidal | Kind::Mass | Kind::Ground => {
                    let message = format!("`{}` cannot be in the grip of the bolt", name(self.design, index));
                    return Err(wrong(path, message, "cylinders, rings and joints can"));
                }
            }
        }
        Ok((from, to))
    }
}
