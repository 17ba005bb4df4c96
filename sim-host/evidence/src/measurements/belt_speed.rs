//! Effects of the belt's speed in a crash on its friction: heat at the D-ring, and air under the
//! webbing.
//!
//! ```text
//! scene dring-crash --> tensions and speed, block by block --> power --> surface of the ring (contact::belt_heating)
//!                                                          `-----------> film of air        (contact::air_film)
//! ```
//!
//! Neither effect acts on the friction: no published friction coefficient of webbing over
//! temperature was available. The table shows how far a crash departs from dry, cold webbing.

use rayon::prelude::*;

use crate::evidence::Error;
use contact::SolveError;
use contact::air_film::{MEAN_FREE_PATH_M, speed_m_per_s, thickness_m};
use contact::belt_heating::{BeltOnRing, Material};
use plant::dring::crash::{Belt, Playback};
use report::{TableBlock, significant};
use scene::load::load;
use sim::run::{Watch, run};

/// ASSUMED, as of seat belts on the market: bending radius of the webbing, m.
const BEND_RADIUS_M: f64 = 0.01;
/// ASSUMED: width of the webbing, m.
const WEBBING_WIDTH_M: f64 = 0.047;
/// ASSUMED: mass of the webbing, kg/m.
const WEBBING_KG_PER_M: f64 = 0.06;
/// Heat capacity of polyester, tabulated, J/(kg K).
const HEAT_CAPACITY_J_PER_KG_K: f64 = 1300.0;
/// Rise from a cabin at 20 °C to the melting point of polyester at about 250 °C, K.
pub const MELTING_RISE_K: f64 = 230.0;
/// ASSUMED: height of the threads in woven webbing over which a film would have to lift it, m.
const THREAD_HEIGHT_M: f64 = 20e-6;
/// Largest number of steps of the heat's history; the cost grows with its square.
const MAX_STEPS: usize = 1000;

/// Crashes: name, changes of the scene dring-crash, `true` for the passive belt of the pair, and
/// power into the contact in addition to the friction power, W.
const CASES: [(&str, &[&str], bool, f64); 5] = [
    ("light, passive", &[], true, 0.0),
    ("light, ideal switch", &[], false, 0.0),
    ("light, 2.5 kW into the contact", &["rig.dring.actuator=\"power\""], false, 2500.0),
    ("medium, passive", &["rig.dring.occupant=\"50th\""], true, 0.0),
    ("heavy, passive", &["rig.dring.occupant=\"95th\""], true, 0.0),
];

/// Results for a belt in a crash at its D-ring.
#[derive(Clone, Debug, PartialEq)]
pub struct CrashAtRing {
    /// Name of the case.
    pub name: &'static str,
    /// Fastest payout, m/s.
    pub fastest_m_per_s: f64,
    /// Largest power, W.
    pub power_w: f64,
    /// Total heat, J.
    pub heat_j: f64,
    /// Largest rise of the surface temperature, K.
    pub rise_k: f64,
    /// Rise of the webbing through its thickness if it took all of the heat, K.
    pub webbing_k: f64,
    /// Largest thickness of the air film by the formula while the webbing slides, m.
    pub film_m: f64,
    /// Largest thickness of the air film while the webbing slides under at least half of its
    /// largest tension, m.
    pub film_loaded_m: f64,
    /// Speed for an air film thicker than the threads at the largest tension at the retractor, m/s.
    pub needed_m_per_s: f64,
}

/// Computes all crashes.
pub fn all() -> Result<Vec<CrashAtRing>, Error> {
    CASES.par_iter().map(|&(name, sets, passive, extra_w)| crash_at_ring(name, sets, passive, extra_w)).collect()
}

fn crash_at_ring(name: &'static str, sets: &[&str], passive: bool, extra_w: f64) -> Result<CrashAtRing, Error> {
    let trouble = |reason: String| Error::Contact(SolveError::Unsuited { method: "a scene", reason });
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    let loaded = load("dring-crash", &sets)?;
    let driven = loaded.scene.driven().ok_or_else(|| trouble("it has no drive".into()))?;
    let dring = driven.dring().ok_or_else(|| trouble("it has no D-ring".into()))?;
    let record = run(&driven, Watch::default()).map_err(|error| trouble(error.to_string()))?;
    let playback = record.crash.as_ref().ok_or_else(|| trouble("it has no crash".into()))?;
    let contact = BeltOnRing {
        arc_m: BEND_RADIUS_M * dring.wrap_deg.to_radians(),
        width_m: WEBBING_WIDTH_M,
        ring: Material::steel(),
        belt: Material::polyester(),
    };
    Ok(at_ring(name, playback, &contact, passive, extra_w))
}

fn at_ring(name: &'static str, playback: &Playback, contact: &BeltOnRing, passive: bool, extra_w: f64) -> CrashAtRing {
    let belts: Vec<(f64, &Belt, f64)> = playback
        .frames
        .iter()
        .map(|frame| (frame.time_s, if passive { &frame.passive } else { &frame.switched }, extra_w * frame.amplitude))
        .collect();
    let step_s =
        belts.first().zip(belts.last()).map_or(0.0, |(first, last)| (last.0 - first.0) / (belts.len() - 1).max(1) as f64);
    let difference = |belt: &Belt| (belt.shoulder_n - belt.retractor_n).abs();
    // Only sliding is counted. A belt at rest receives only vibration power, which stays in it.
    let power = |belt: &Belt, extra: f64| {
        if belt.payout_m_per_s == 0.0 { 0.0 } else { difference(belt) * belt.payout_m_per_s.abs() + extra }
    };
    let slides = || belts.iter().filter(|(_, belt, _)| belt.payout_m_per_s != 0.0);
    let most = |value: &dyn Fn(&Belt) -> f64| slides().map(|(_, belt, _)| value(belt)).fold(0.0, f64::max);
    let every = belts.len().div_ceil(MAX_STEPS).max(1);
    let steps: Vec<(f64, f64)> = belts
        .chunks(every)
        .map(|part| {
            let mean = |value: &dyn Fn(&(f64, &Belt, f64)) -> f64| part.iter().map(value).sum::<f64>() / part.len() as f64;
            (mean(&|(_, belt, extra)| power(belt, *extra)), mean(&|(_, belt, _)| belt.payout_m_per_s.abs()))
        })
        .collect();
    let film = |belt: &Belt| thickness_m(BEND_RADIUS_M, belt.payout_m_per_s, belt.retractor_n / WEBBING_WIDTH_M);
    let largest = most(&|belt| belt.retractor_n);
    CrashAtRing {
        name,
        fastest_m_per_s: most(&|belt| belt.payout_m_per_s.abs()),
        power_w: slides().map(|(_, belt, extra)| power(belt, *extra)).fold(0.0, f64::max),
        heat_j: step_s * slides().map(|(_, belt, extra)| power(belt, *extra)).sum::<f64>(),
        rise_k: contact.rises_k(step_s * every as f64, &steps).into_iter().fold(0.0, f64::max),
        webbing_k: most(&difference) / (WEBBING_KG_PER_M * HEAT_CAPACITY_J_PER_KG_K),
        film_m: most(&film),
        film_loaded_m: most(&|belt| if belt.retractor_n > 0.5 * largest { film(belt) } else { 0.0 }),
        needed_m_per_s: speed_m_per_s(BEND_RADIUS_M, THREAD_HEIGHT_M, largest / WEBBING_WIDTH_M),
    }
}

/// Tabulates the effects of the belt's speed at the D-ring.
pub fn table(crashes: &[CrashAtRing]) -> TableBlock {
    let row = |crash: &CrashAtRing| {
        let melts = if crash.rise_k < MELTING_RISE_K { "below melting" } else { "MELTS" };
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
        "Scene dring-crash, simulated. ASSUMED: webbing of {:.0} mm and {:.0} g/m over a steel ring of {:.0} mm radius, \
         threads of {:.0} um. Surface: mean over the nominal contact, above the cabin temperature; \
         melting: {MELTING_RISE_K} K above \
         20 °C, at about 250 °C. Webbing: through its thickness, if the ring took no heat. Film: by the formula of the foil \
         bearing, an upper bound for webbing; the largest overall, and the largest under at least half of the retractor's \
         largest tension; the mean free path of air is {:.0} nm. Needed: the speed for a film as thick as the threads at the \
         largest tension.",
        1e3 * WEBBING_WIDTH_M,
        1e3 * WEBBING_KG_PER_M,
        1e3 * BEND_RADIUS_M,
        1e6 * THREAD_HEIGHT_M,
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
