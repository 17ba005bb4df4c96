//! Remarks and tables of a design.

use super::Drawn;
use crate::instruments::Line;
use crate::numbers::{number, precise};
use ::design::keys::Element;
use report::TableBlock;

/// Introduction to a design.
pub const PREFACE: &str = "A design: plane waves along a chain of parts, solved in closed form with the losses of the materials. Both \
     ends are free unless a part holds them. The operating point is at the series resonance.";

/// Level of a design.
pub const LEVEL: &str = "design (no controller)";

/// Headline metrics: label, metric, unit.
pub const HEADLINE: &[Line] = &[
    ("series resonance", "series_resonance_hz", "Hz"),
    ("coupling", "coupling", ""),
    ("gain", "displacement_gain", ""),
    ("tip displacement", "tip_amplitude_m", "m"),
    ("drive", "drive_peak_v", "V"),
    ("power", "drive_power_w", "W"),
    ("stress margin", "stress_margin", ""),
];

/// Distance from the wanted frequency from which a remark states it, relative.
const FAR_REL: f64 = 0.1;
/// Ratio of the inertia of the lateral motion to the frequency from which a remark states it.
const SHOWN_LATERAL_REL: f64 = 2e-3;

/// Returns remarks that a reader must know before the numbers.
pub fn remarks(drawn: &Drawn) -> Vec<String> {
    let (solved, design) = (&drawn.solved, drawn.scene.design);
    let mut remarks = Vec::new();
    let own = solved.working().series_resonance_hz;
    if solved.lateral_hz.abs() > SHOWN_LATERAL_REL * own {
        let state = if design.lateral_inertia { "is included" } else { "is left out: `lateral_inertia = true` includes it" };
        remarks.push(format!(
            "Thick parts: the inertia of the lateral motion shifts the resonance by {} Hz and {state}.",
            number(solved.lateral_hz)
        ));
    }
    if design.drive_v.is_none() && design.tip_velocity_m_per_s.is_none() && design.tip_amplitude_m.is_none() {
        let assumed = if solved.circuit.is_some() { "1 V at the electrodes" } else { "1 um at the tip" };
        remarks.push(format!("Assumed, because no operating point is given: {assumed}."));
    }
    if design.q.is_none() {
        remarks.push("Q is that of the materials; joints and the mount usually lose more. `design.q` replaces it.".to_owned());
    }
    let opens = solved.limits.iter().find(|limit| limit.quantity == "tension" && limit.margin() < 1.0);
    remarks.extend(opens.map(|limit| {
        let (value, most) = (number(limit.value / 1e6), number(limit.most / 1e6));
        format!("The joints of `{}` open: a tension of {value} MPa, but a preload of {most} MPa.", limit.part)
    }));
    if let Some(wanted) = design.frequency_hz.filter(|wanted| (own / wanted - 1.0).abs() > FAR_REL) {
        remarks.push(format!("The nearest mode that the rings excite is at {} Hz, but {wanted} Hz are wanted.", number(own)));
    }
    let quarter = |part: &Element| {
        let material = part.material.as_deref().and_then(|name| ::design::material(design, name))?;
        Some((material.modulus_pa / material.density_kg_per_m3).sqrt() / (4.0 * own))
    };
    for (index, part) in design.element.iter().enumerate() {
        if let Some(most) = quarter(part).filter(|most| part.diameter_m.is_some_and(|diameter| diameter > *most)) {
            let (name, most) = (&solved.names[index], number(1e3 * most));
            remarks
                .push(format!("`{name}` is thicker than a quarter of a wavelength, {most} mm: plane waves do not describe it."));
        }
    }
    if !solved.unchecked.is_empty() {
        remarks.push(format!("Not checked, because no limit is known: {}.", solved.unchecked.join(", ")));
    }
    remarks
}

/// Returns the tables of modes, parts and limits.
pub fn tables(drawn: &Drawn) -> Vec<TableBlock> {
    vec![modes(drawn), parts(drawn), limits(drawn), materials(drawn)]
}

fn modes(drawn: &Drawn) -> TableBlock {
    let solved = &drawn.solved;
    let or_none = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), number);
    let hz = |value: f64| format!("{value:.1}");
    let row = |mode: &::design::Mode| {
        let is_working = mode.number == solved.working().number;
        vec![
            if is_working { "working".to_owned() } else { String::new() },
            hz(mode.series_resonance_hz),
            mode.parallel_resonance_hz.map_or_else(|| "–".to_owned(), hz),
            or_none(solved.coupling(mode)),
            or_none(Some(mode.q).filter(|q| q.is_finite())),
            or_none(mode.branch.map(|branch| branch.rm_ohm)),
            or_none(mode.branch.map(|branch| branch.force_factor_n_per_v)),
        ]
    };
    let header = ["", "fs [Hz]", "fp [Hz]", "coupling", "Q", "Rm [ohm]", "force factor [N/V]"];
    let caption = "All modes up to `design.highest_hz`. Without fp, no rings excite the mode.";
    TableBlock::new("modes", "Modes", caption, &header, solved.modes.iter().map(row).collect())
}

fn parts(drawn: &Drawn) -> TableBlock {
    let (solved, at) = (&drawn.solved, &drawn.solved.operating);
    let find = |list: &[(usize, f64)], index: usize| list.iter().find(|(other, _)| *other == index).map(|(_, value)| *value);
    let mega = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| number(value / 1e6));
    let loss = |index: usize| find(&at.losses, index).map_or_else(|| "–".to_owned(), |loss| number(loss.max(0.0)));
    let row = |(index, name): (usize, &String)| {
        let points = || at.points.iter().filter(|point| point.element == index);
        let nodes = |from: f64, to: f64| at.nodes_m.iter().filter(move |node| (from..=to).contains(*node));
        let span = points().next().zip(points().next_back()).map(|(first, last)| (first.x_m, last.x_m));
        let places = span.map_or_else(|| "–".to_owned(), |(from, to)| format!("{:.2} to {:.2}", 1e3 * from, 1e3 * to));
        let nodes = span.map_or_else(Vec::new, |(from, to)| nodes(from, to).map(|node| format!("{:.2}", 1e3 * node)).collect());
        vec![
            name.clone(),
            places,
            nodes.join(", "),
            mega(find(&at.stresses, index)),
            mega(find(&solved.preload_pa, index)),
            loss(index),
        ]
    };
    let mut rows: Vec<Vec<String>> = solved.names.iter().enumerate().map(row).collect();
    if let Some(stress) = at.bolt_pa {
        let none = String::new;
        rows.push(vec!["bolt".into(), none(), none(), mega(Some(stress)), mega(solved.bolt_preload_pa), loss(usize::MAX)]);
    }
    let header = ["part", "x [mm]", "nodes [mm]", "stress [MPa peak]", "preload [MPa]", "loss [W]"];
    let caption = "From the back to the tip, at the operating point; the preload of the bolt is its tension. A transducer is held \
                   at a node.";
    TableBlock::new("parts", "Parts", caption, &header, rows)
}

fn limits(drawn: &Drawn) -> TableBlock {
    let row = |limit: &::design::Limit| {
        let (factor, unit) = if limit.unit == "K" {
            (1.0, "K")
        } else if limit.is_stress() {
            (1e6, "MPa")
        } else {
            (1e3, "V/mm")
        };
        let shown = |value: f64| format!("{} {unit}", number(value / factor));
        let margin = if limit.margin().is_finite() { number(limit.margin()) } else { "–".to_owned() };
        vec![limit.part.clone(), limit.quantity.to_owned(), shown(limit.value), shown(limit.most), margin]
    };
    let header = ["part", "quantity", "value", "most", "margin"];
    TableBlock::new("limits", "Limits", "A margin below one is exceeded.", &header, drawn.solved.limits.iter().map(row).collect())
}

fn materials(drawn: &Drawn) -> TableBlock {
    let design = drawn.scene.design;
    let own = |name: &str| design.material.iter().any(|material| material.name == name);
    let used = design.element.iter().flat_map(|part| [&part.material, &part.electrode_material]).flatten();
    let mut names: Vec<&str> = used.map(String::as_str).chain(design.bolt.iter().map(|bolt| bolt.material.as_str())).collect();
    names.sort_unstable();
    names.dedup();
    let row = |name: &str| {
        let material = ::design::material(design, name)?;
        let source = ::design::library::MATERIALS.iter().find(|known| known.material.name == name && !own(name));
        let source = source.map_or("this design", |known| known.source);
        let (modulus, density) = (number(1e-9 * material.modulus_pa), number(material.density_kg_per_m3));
        Some(vec![name.to_owned(), modulus, density, number(material.q), source.to_owned()])
    };
    let header = ["material", "modulus [GPa]", "density [kg/m^3]", "Q", "source"];
    TableBlock::new("materials", "Materials", "", &header, names.into_iter().filter_map(row).collect())
}

/// Returns the level for the footer.
pub fn footer() -> Vec<(&'static str, String)> {
    vec![("level", LEVEL.to_owned())]
}

/// Describes the solution in one line.
pub fn manner(drawn: &Drawn) -> String {
    let counted = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    let (parts, modes) = (counted(drawn.solved.names.len(), "part"), counted(drawn.solved.modes.len(), "mode"));
    format!("{LEVEL}; {parts}, {modes}, {} m long", precise(drawn.solved.length_m))
}
