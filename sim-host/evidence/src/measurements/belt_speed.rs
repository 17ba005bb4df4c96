//! What the speed of a belt in a crash does to its friction: heat at the D-ring, and air under the webbing.
//!
//! ```text
//! scene dring-crash --> tensions and speed, block by block --> power --> surface of the ring (contact::belt_heating)
//!                                                          `-----------> film of air        (contact::air_film)
//! ```
//!
//! Nothing of it acts on the friction: no coefficient of webbing over its temperature was at hand. The table says how far from dry, cold webbing a crash gets.

use rayon::prelude::*;

use crate::evidence::Error;
use contact::SolveError;
use contact::air_film::{MEAN_FREE_PATH_M, speed_m_per_s, thickness_m};
use contact::belt_heating::{BeltOnRing, Material};
use plant::dring::crash::{Belt, Playback};
use report::{TableBlock, significant};
use scene::load::load;
use sim::run::{Watch, run};

/// ASSUMED: radius that the webbing bends around, m, its width, m, and its mass, kg/m, as of seat belts on the market.
const RADIUS_M: f64 = 0.01;
const WIDTH_M: f64 = 0.047;
const KG_PER_M: f64 = 0.06;
/// Heat capacity of polyester, J/(kg K), as tabulated.
const CAPACITY: f64 = 1300.0;
/// Polyester melts at about 250 °C: so far above a cabin of 20 °C, K.
pub const MELTS_K: f64 = 230.0;
/// ASSUMED: height of threads in woven webbing that a film would have to lift it over, m.
const THREAD_M: f64 = 20e-6;
/// Most steps of the heat's history, whose cost goes with their square.
const STEPS: usize = 1000;

/// Crashes: name, changes of the scene dring-crash, whether the passive belt beside it is meant, and power into the contact besides friction's, W.
const CASES: [(&str, &[&str], bool, f64); 5] = [
    ("light, passive", &[], true, 0.0),
    ("light, ideal switch", &[], false, 0.0),
    ("light, 2.5 kW into the contact", &["rig.dring.actuator=\"power\""], false, 2500.0),
    ("medium, passive", &["rig.dring.occupant=\"50th\""], true, 0.0),
    ("heavy, passive", &["rig.dring.occupant=\"95th\""], true, 0.0),
];

/// A belt in a crash, at its D-ring.
#[derive(Clone, Debug, PartialEq)]
pub struct AtRing {
    /// Name of the case.
    pub name: &'static str,
    /// Fastest payout, m/s.
    pub fastest_m_per_s: f64,
    /// Most power, W.
    pub power_w: f64,
    /// All heat, J.
    pub heat_j: f64,
    /// Largest rise of the surface, K.
    pub rise_k: f64,
    /// Rise of the webbing through its thickness if all heat were its own, K.
    pub webbing_k: f64,
    /// Thickest film of air of the formula while the webbing slides, m,
    pub film_m: f64,
    /// and while it carries half of its largest tension.
    pub film_loaded_m: f64,
    /// Speed at which the film would be over threads at the largest tension at the retractor, m/s.
    pub needed_m_per_s: f64,
}

/// All crashes.
pub fn all() -> Result<Vec<AtRing>, Error> {
    CASES.par_iter().map(|&(name, sets, passive, extra_w)| of(name, sets, passive, extra_w)).collect()
}

fn of(name: &'static str, sets: &[&str], passive: bool, extra_w: f64) -> Result<AtRing, Error> {
    let trouble = |reason: String| Error::Contact(SolveError::Unsuited { method: "a scene", reason });
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    let loaded = load("dring-crash", &sets)?;
    let driven = loaded.scene.driven().ok_or_else(|| trouble("it drives nothing".into()))?;
    let dring = driven.dring().ok_or_else(|| trouble("it has no D-ring".into()))?;
    let record = run(&driven, Watch::default()).map_err(|error| trouble(error.to_string()))?;
    let playback = record.crash.as_ref().ok_or_else(|| trouble("it has no crash".into()))?;
    let contact = BeltOnRing {
        arc_m: RADIUS_M * dring.wrap_deg.to_radians(),
        width_m: WIDTH_M,
        ring: Material::steel(),
        belt: Material::polyester(),
    };
    Ok(at_ring(name, playback, &contact, passive, extra_w))
}

fn at_ring(name: &'static str, playback: &Playback, contact: &BeltOnRing, passive: bool, extra_w: f64) -> AtRing {
    let belts: Vec<(f64, &Belt, f64)> = playback
        .frames
        .iter()
        .map(|frame| (frame.time_s, if passive { &frame.passive } else { &frame.switched }, extra_w * frame.amplitude))
        .collect();
    let step_s =
        belts.first().zip(belts.last()).map_or(0.0, |(first, last)| (last.0 - first.0) / (belts.len() - 1).max(1) as f64);
    let difference = |belt: &Belt| (belt.shoulder_n - belt.retractor_n).abs();
    // Nothing enters the contact of a belt that stands but what shakes it, which a belt that stands keeps: only sliding is counted.
    let power = |belt: &Belt, extra: f64| {
        if belt.payout_m_per_s == 0.0 { 0.0 } else { difference(belt) * belt.payout_m_per_s.abs() + extra }
    };
    let slides = || belts.iter().filter(|(_, belt, _)| belt.payout_m_per_s != 0.0);
    let most = |value: &dyn Fn(&Belt) -> f64| slides().map(|(_, belt, _)| value(belt)).fold(0.0, f64::max);
    let every = belts.len().div_ceil(STEPS).max(1);
    let steps: Vec<(f64, f64)> = belts
        .chunks(every)
        .map(|part| {
            let mean = |value: &dyn Fn(&(f64, &Belt, f64)) -> f64| part.iter().map(value).sum::<f64>() / part.len() as f64;
            (mean(&|(_, belt, extra)| power(belt, *extra)), mean(&|(_, belt, _)| belt.payout_m_per_s.abs()))
        })
        .collect();
    let film = |belt: &Belt| thickness_m(RADIUS_M, belt.payout_m_per_s, belt.retractor_n / WIDTH_M);
    let largest = most(&|belt| belt.retractor_n);
    AtRing {
        name,
        fastest_m_per_s: most(&|belt| belt.payout_m_per_s.abs()),
        power_w: slides().map(|(_, belt, extra)| power(belt, *extra)).fold(0.0, f64::max),
        heat_j: step_s * slides().map(|(_, belt, extra)| power(belt, *extra)).sum::<f64>(),
        rise_k: contact.rises_k(step_s * every as f64, &steps).into_iter().fold(0.0, f64::max),
        webbing_k: most(&difference) / (KG_PER_M * CAPACITY),
        film_m: most(&film),
        film_loaded_m: most(&|belt| if belt.retractor_n > 0.5 * largest { film(belt) } else { 0.0 }),
        needed_m_per_s: speed_m_per_s(RADIUS_M, THREAD_M, largest / WIDTH_M),
    }
}

/// What the belt's speed does at the D-ring.
pub fn table(crashes: &[AtRing]) -> TableBlock {
    let row = |crash: &AtRing| {
        let melts = if crash.rise_k < MELTS_K { "below melting" } else { "MELTS" };
        vec![
            crash.name.into(),
            significant(crash.fastest_m_per_s),
            significant(1e-3 * crash.power_w),
            significant(crash.heat_j),
            format!("{:.0}", crash.rise_k),
            melts.into(),
            format!("{:.0}", crash.webbing_k),
            format!("{:.0}", 1e9 * crash.film_m),
            format!("{:.0}", 1e9 * crash.film_loaded_m),
            format!("{:.0}", 1e-3 * crash.needed_m_per_s),
        ]
    };
    let caption = format!(
        "Scene dring-crash, simulated; ASSUMED: webbing of {:.0} mm and {:.0} g/m over a steel ring of {:.0} mm radius, threads of {:.0} um. Surface: the mean over the nominal contact, \
         above the cabin; melting: {MELTS_K} K above 20 °C, at about 250 °C. Webbing: through its thickness, if the ring took nothing. Film: of the foil bearing's formula, an upper bound for \
         webbing, at most and under at least half of the retractor's largest tension; the mean free path of air is {:.0} nm. Needed: the speed for a film as high as the threads at the largest tension.",
        1e3 * WIDTH_M,
        1e3 * KG_PER_M,
        1e3 * RADIUS_M,
        1e6 * THREAD_M,
        1e9 * MEAN_FREE_PATH_M
    );
    let header = [
        "crash",
        "payout up to [m/s]",
        "power up to [kW]",
        "heat [J]",
        "surface up to [K]",
        "",
        "webbing [K]",
        "film at most [nm]",
        "film under load [nm]",
        "speed needed for a film [km/s]",
    ];
    TableBlock::new("belt-speed", "Heat and air at the belt's speed", caption, &header, crashes.iter().map(row).collect())
}
