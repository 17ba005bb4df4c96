//! Mechanical design of transducers (2.1 to 2.3): figures 2.5, 2.7, 2.8 and 2.10 to 2.13.

mod ceramic;

use std::f64::consts::PI;

use super::StudyResult;
use super::claim::{Check, Claim, number};
use super::experiment_1::table_3_1;
use super::picture::{axis, column, figure, line};
use contact::SolveError;
use design::keys::{Design, Element, Kind, Material};
use design::{Solved, solve};
use report::Figure;

/// Frequency of the examples, Hz.
const FREQUENCY_HZ: f64 = 20e3;
/// Diameters of the stepped horn, m.
const DIAMETERS_M: [f64; 2] = [0.04, 0.02];
/// Places of the ceramics in a half-wave transducer, as a part of the length that is left for the
/// metal behind them.
const PLACES: usize = 40;

/// Computes the figures of chapter 2 and its claims.
pub fn study() -> Result<StudyResult, SolveError> {
    let (rod, horn, transducer) = (rod(), horn(), solved(&langevin(0.5)));
    let family = Family::new();
    Ok(StudyResult {
        figures: vec![
            mode_shapes(&rod),
            ceramic::strain(),
            ceramic::butterfly(),
            ceramic::stress_and_strain(),
            section("fig-2-11", "Transducer: displacement over its length", &transducer),
            section("fig-2-12", "Stepped horn: displacement over its length", &horn),
            family.figure(),
        ],
        claims: vec![rod_claim(&rod), horn_claim(&horn), prestress_claim(&transducer), family.claim(), table_claim()],
    })
}

/// Solves a design that is known to have a solution.
fn solved(design: &Design) -> Solved {
    solve(design).unwrap_or_else(|error| panic!("{}: {error}", error.path))
}

fn cylinder(material: &str, length_m: f64, diameter_m: f64) -> Element {
    let (length_m, diameter_m) = (Some(length_m), Some(diameter_m));
    Element { material: Some(material.into()), length_m, diameter_m, ..Element::default() }
}

fn steel() -> &'static Material {
    &design::library::MATERIALS.iter().find(|known| known.material.name == "steel").unwrap_or_else(|| unreachable!()).material
}

fn sound_m_per_s(material: &Material) -> f64 {
    (material.modulus_pa / material.density_kg_per_m3).sqrt()
}

/// Solves a free steel rod of half a wavelength.
fn rod() -> Solved {
    let length = sound_m_per_s(steel()) / (2.0 * FREQUENCY_HZ);
    solved(&Design { highest_hz: 3.5 * FREQUENCY_HZ, element: vec![cylinder("steel", length, 0.02)], ..Design::default() })
}

/// Solves a stepped horn of two quarters of a wavelength.
fn horn() -> Solved {
    let quarter = sound_m_per_s(steel()) / (4.0 * FREQUENCY_HZ);
    let element = DIAMETERS_M.map(|diameter| cylinder("steel", quarter, diameter)).to_vec();
    solved(&Design { highest_hz: 1.5 * FREQUENCY_HZ, q: Some(1e6), element, ..Design::default() })
}

/// Returns a transducer with steel before and behind two rings; `place` is the part behind them.
fn langevin(place: f64) -> Design {
    let metal_m = 0.11;
    let rings = Element {
        kind: Kind::Rings,
        material: Some("apc-841".into()),
        count: Some(2),
        thickness_m: Some(5e-3),
        diameter_m: Some(0.04),
        bore_m: Some(0.012),
        ..Element::default()
    };
    let element = vec![cylinder("steel", place * metal_m, 0.04), rings, cylinder("steel", (1.0 - place) * metal_m, 0.04)];
    Design {
        frequency_hz: Some(FREQUENCY_HZ),
        q: Some(500.0),
        highest_hz: 60e3,
        tip_velocity_m_per_s: Some(1.0),
        element,
        ..Design::default()
    }
}

/// Draws the first three mode shapes of the rod (2.11).
fn mode_shapes(rod: &Solved) -> Figure {
    let x: Vec<f64> = (0..=200).map(|point| f64::from(point) / 200.0).collect();
    let shape = |mode: usize| {
        let label = format!("n = {}", mode + 1);
        // The numbers of the modes are those of the chain; their shapes are cosines of it.
        let waves = rod.modes[mode].series_resonance_hz * 2.0 * rod.length_m / sound_m_per_s(steel());
        line(&label, column("displacement", &label), &x, x.iter().map(|x| (PI * waves * x).cos()).collect())
    };
    let caption = "Displacement over the length of a free rod, from the resonances of the chain.".to_owned();
    let axes = [axis("distance / length"), axis("displacement / displacement of the end")];
    figure("fig-2-05", "First three mode shapes of a free rod", caption, axes, (0..3).map(shape).collect())
}

/// Draws the displacement along a design.
fn section(id: &str, title: &str, of: &Solved) -> Figure {
    let points = &of.operating.points;
    let x: Vec<f64> = points.iter().map(|point| 1e3 * point.x_m).collect();
    let displacement = points.iter().map(|point| point.displacement_m / of.operating.tip_m).collect();
    let radius = points.iter().map(|point| point.radius_m / points[0].radius_m).collect();
    let caption = "Displacement in phase with the tip; the outline is relative to the radius at the back.".to_owned();
    let series = vec![
        line("displacement / displacement of the tip", "displacement", &x, displacement),
        line("radius", "radius", &x, radius),
    ];
    figure(id, title, caption, [axis("distance from the back [mm]"), axis("relative value")], series)
}

/// Transducers whose ceramics are at other places.
struct Family {
    places_mm: Vec<f64>,
    of: Vec<Solved>,
}

impl Family {
    fn new() -> Self {
        let places: Vec<f64> = (0..PLACES).map(|place| (place as f64 + 0.5) / PLACES as f64).collect();
        let of: Vec<Solved> = places.iter().map(|&place| solved(&langevin(place))).collect();
        Family { places_mm: places.iter().map(|place| 110.0 * place + 5.0).collect(), of }
    }

    fn couplings(&self) -> Vec<f64> {
        self.of.iter().map(|solved| solved.coupling(solved.working()).unwrap_or(0.0)).collect()
    }

    /// Draws the family of Figure 2.13.
    fn figure(&self) -> Figure {
        let stress = self.of.iter().map(|solved| {
            solved.operating.stresses.iter().find(|(index, _)| *index == 1).map_or(0.0, |(_, stress)| 1e-7 * stress)
        });
        let series = vec![
            line("coupling", "coupling", &self.places_mm, self.couplings()),
            line("stress in the ceramics at 1 m/s [10 MPa]", "stress_10_mpa", &self.places_mm, stress.collect()),
        ];
        let caption = "Two rings in a steel rod of 120 mm; the node is near its middle.".to_owned();
        figure(
            "fig-2-13",
            "Transducers with the ceramics at other places",
            caption,
            [axis("middle of the ceramics [mm]"), axis("")],
            series,
        )
    }

    /// Judges the design procedure: the node at the middle of the ceramics.
    fn claim(&self) -> Claim {
        let couplings = self.couplings();
        let best = (0..PLACES).max_by(|&a, &b| couplings[a].total_cmp(&couplings[b])).unwrap_or(0);
        let node = self.of[best].operating.nodes_m.first().map_or(0.0, |node| 1e3 * node);
        let off = (self.places_mm[best] - node).abs();
        let numbers = vec![
            number("place with the largest coupling [mm]", self.places_mm[best]),
            number("node there [mm]", node),
            number("coupling there", couplings[best]),
            number("coupling at the end", couplings[0]),
        ];
        Claim {
            id: "node-in-the-ceramics",
            section: "2.3.1.4",
            says: "Design begins with the displacement node at the middle of the ceramics.",
            checks: vec![Check::new("two rings in a steel rod", off < 3.0, numbers)],
        }
    }
}

fn rod_claim(rod: &Solved) -> Claim {
    let exact = |n: usize| n as f64 * sound_m_per_s(steel()) / (2.0 * rod.length_m);
    let off = (0..3).map(|mode| (rod.modes[mode].series_resonance_hz / exact(mode + 1) - 1.0).abs()).fold(0.0, f64::max);
    let numbers = (0..3).map(|mode| number(format!("f{} [Hz]", mode + 1), rod.modes[mode].series_resonance_hz)).collect();
    Claim {
        id: "rod-frequencies",
        section: "2.12",
        says: "A free rod resonates at multiples of c / 2 L.",
        checks: vec![Check::new("steel, half a wavelength at 20 kHz", off < 1e-9, numbers)],
    }
}

fn horn_claim(horn: &Solved) -> Claim {
    let (gain, areas) = (horn.operating.tip_m / horn.operating.back_m, (DIAMETERS_M[0] / DIAMETERS_M[1]).powi(2));
    let numbers = vec![number("gain", gain), number("ratio of the areas", areas)];
    Claim {
        id: "stepped-horn-gain",
        section: "2.3.1",
        says: "The gain of a stepped horn of two quarter waves is the ratio of its areas.",
        checks: vec![Check::new("free ends, plane waves", (gain / areas - 1.0).abs() < 1e-9, numbers)],
    }
}

/// Judges the prestress: how fast the tip may move before the joints open.
fn prestress_claim(transducer: &Solved) -> Claim {
    let stress = transducer.operating.stresses.iter().find(|(index, _)| *index == 1).map_or(0.0, |(_, stress)| *stress);
    let check = |tip_m_per_s: f64| {
        let numbers = vec![number("stress in the ceramics [MPa]", 1e-6 * stress * tip_m_per_s)];
        let condition = format!("30 MPa, two rings in a steel rod at 20 kHz, {tip_m_per_s} m/s at the tip");
        Check::new(condition, stress * tip_m_per_s < 30e6, numbers)
    };
    Claim {
        id: "prestress-raises-the-limit",
        section: "Figure 2.10",
        says: "Prestress resolves the tensile failure of the ceramics.",
        checks: [0.5, 1.0].map(check).to_vec(),
    }
}

/// Judges the frequency of the stack of Table 3.1, as the rod that 3.1.2 describes.
fn table_claim() -> Claim {
    let material = Material {
        name: "PMN-PT".into(),
        modulus_pa: table_3_1::MODULUS_PA,
        density_kg_per_m3: table_3_1::DENSITY_KG_PER_M3,
        q: 50.0,
        ..Material::default()
    };
    let rod = |length| Design {
        highest_hz: 60e3,
        element: vec![cylinder("PMN-PT", length, 0.01)],
        material: vec![material.clone()],
        ..Design::default()
    };
    let alone = solved(&rod(table_3_1::LENGTH_M)).working().series_resonance_hz;
    let with_shells = vec![shell(), cylinder("PMN-PT", table_3_1::LENGTH_M, 0.01), shell()];
    let shells = solved(&Design { element: with_shells, ..rod(table_3_1::LENGTH_M) }).working().series_resonance_hz;
    let holds = |hz: f64| (hz / 40e3 - 1.0).abs() < 0.01;
    Claim {
        id: "stack-at-40-khz",
        section: "3.1.2",
        says: "The transducer is a free rod with its first mode at 40 kHz.",
        checks: vec![
            Check::new("a rod of PMN-PT alone", holds(alone), vec![number("f [Hz]", alone)]),
            Check::new(
                "the same between two conical shells of aluminium of 5 mm, which 3.1.2 describes without dimensions",
                holds(shells),
                vec![number("f [Hz]", shells)],
            ),
        ],
    }
}

/// Returns a shell of the transducer: its size is chosen here.
fn shell() -> Element {
    Element { kind: Kind::Cone, end_diameter_m: Some(0.009), ..cylinder("aluminium", 0.005, 0.01) }
}
