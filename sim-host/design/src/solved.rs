//! Solution of a design.

use std::f64::consts::TAU;

use crate::build::{self, DesignError, How, Parts, wrong};
use crate::keys::{Design, Kind};
use crate::limits::{self, Limit};
use crate::modes::{self, Mode, driven};
use crate::operating::{Operating, free_back};
use crate::part::chain;
use crate::port::C;

/// Lowest frequency of a mode, Hz: below it, a motion counts as rigid.
const LOWEST_HZ: f64 = 50.0;
/// Smallest part of a mode in the capacitance for which it counts as driven.
const LEAST_CAPACITANCE_REL: f64 = 1e-8;
/// Coupling relative to the largest from which a mode is the working one if none is wanted.
const STRONG_REL: f64 = 0.5;
/// Largest inductance and frequency range of a branch of a scene, H and Hz.
const SCENE_BRANCH: (f64, std::ops::Range<f64>) = (1e4, 100.0..450e3);
/// Largest number of further modes in the equivalent circuit.
const MOST_FURTHER: usize = 3;
/// Displacement of the tip if there is nothing to drive and none is given, m.
const DEFAULT_TIP_M: f64 = 1e-6;
/// Voltage if none is given, V.
const DEFAULT_DRIVE_V: f64 = 1.0;

/// Solution of a design.
#[derive(Clone, Debug, PartialEq)]
pub struct Solved {
    /// Modes up to the highest frequency, in order; rigid motions are left out.
    pub modes: Vec<Mode>,
    /// Equivalent circuit, if there are piezoelectric rings.
    pub circuit: Option<Circuit>,
    /// Operating point at the series resonance of the working mode.
    pub operating: Operating,
    /// Limits that are known.
    pub limits: Vec<Limit>,
    /// Limits that are not checked, because a material does not have them.
    pub unchecked: Vec<String>,
    /// Static compression of the elements in the grip of the bolt, Pa, by their index.
    pub preload_pa: Vec<(usize, f64)>,
    /// Static tension of the bolt, Pa.
    pub bolt_preload_pa: Option<f64>,
    /// Temperature of the rings over the surroundings, K.
    pub heating_k: Option<f64>,
    /// Change of the series resonance by the inertia of the lateral motion, Hz: included if
    /// `lateral_inertia` is set. Zero if no Poisson's ratio is known.
    pub lateral_hz: f64,
    /// Names of the elements, for tables.
    pub names: Vec<String>,
    /// Length from the back to the tip, m.
    pub length_m: f64,
    working: usize,
}

/// The capacitance of the equivalent circuit, and its further branches.
#[derive(Clone, Debug, PartialEq)]
pub struct Circuit {
    /// Capacitance next to the branches of the circuit, F: it includes all modes that are not
    /// branches.
    pub c0_f: f64,
    /// Dielectric loss tangent.
    pub loss_tangent: f64,
    /// Places of the further branches in the list of modes.
    pub further: Vec<usize>,
}

impl Solved {
    /// Returns the working mode.
    pub fn working(&self) -> &Mode {
        &self.modes[self.working]
    }

    /// Returns the effective coupling of a mode, `sqrt(Cm / (C0 + Cm))`.
    pub fn coupling(&self, mode: &Mode) -> Option<f64> {
        let (cm, circuit) = (capacitance(mode)?, self.circuit.as_ref()?);
        Some((cm / (circuit.c0_f + cm)).sqrt())
    }

    /// Returns the distance from the working mode to the next mode, Hz.
    pub fn separation_hz(&self) -> Option<f64> {
        let own = self.working().series_resonance_hz;
        let others = self.modes.iter().enumerate().filter(|(index, _)| *index != self.working);
        others.map(|(_, mode)| (mode.series_resonance_hz - own).abs()).min_by(f64::total_cmp)
    }

    /// Returns the admittance at frequencies around the working mode, Hz and S. It is empty without
    /// rings.
    pub fn admittance(&self, design: &Design) -> Vec<(f64, C)> {
        let lossy = build::parts(design, How { lossless: false, lateral: design.lateral_inertia });
        lossy.ok().filter(|_| self.circuit.is_some()).map_or_else(Vec::new, |lossy| around(&lossy, self.working()))
    }

    /// Returns the limit with the smallest margin, of stresses or of all.
    pub fn tightest(&self, only_stress: bool) -> Option<&Limit> {
        let known = self.limits.iter().filter(|limit| limit.value > 0.0 && (!only_stress || limit.is_stress()));
        known.min_by(|a, b| a.margin().total_cmp(&b.margin()))
    }

    /// Returns the largest alternating stress in the rings, Pa, and the preload there.
    pub fn ceramic_pa(&self, design: &Design) -> Option<(f64, f64)> {
        let is_ring = |index: usize| design.element.get(index).is_some_and(|element| element.kind == Kind::Rings);
        let stresses = self.operating.stresses.iter().filter(|(index, _)| is_ring(*index));
        let &(index, stress) = stresses.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let held = self.preload_pa.iter().find(|(other, _)| *other == index).map_or(0.0, |(_, held)| *held);
        Some((stress, held))
    }
}

/// Solves a design.
///
/// # Errors
/// If a key is missing or wrong, or if there is no mode.
pub fn solve(design: &Design) -> Result<Solved, DesignError> {
    let given = [
        ("drive_v", design.drive_v),
        ("tip_velocity_m_per_s", design.tip_velocity_m_per_s),
        ("tip_amplitude_m", design.tip_amplitude_m),
    ];
    let given: Vec<&str> = given.iter().filter(|(_, value)| value.is_some()).map(|(key, _)| *key).collect();
    if let [first, second, ..] = given[..] {
        return Err(wrong(second, format!("`{first}` and `{second}` exclude each other"), "there is one operating point"));
    }
    let has_rings = design.element.iter().any(|element| element.kind == Kind::Rings);
    if design.drive_v.is_some() && !has_rings {
        return Err(wrong("drive_v", "there are no rings to drive", "give `tip_velocity_m_per_s` or `tip_amplitude_m`"));
    }
    if let Some(wanted) = design.frequency_hz.filter(|wanted| *wanted > design.highest_hz) {
        let message = format!("the wanted {wanted} Hz are above `highest_hz`, {} Hz", design.highest_hz);
        return Err(wrong("frequency_hz", message, "raise `highest_hz`"));
    }
    let how = |lossless| How { lossless, lateral: design.lateral_inertia };
    let (lossless, lossy) = (build::parts(design, how(true))?, build::parts(design, how(false))?);
    if let Some(hz) = build::cutoff_hz(&lossless).filter(|hz| *hz < 1.1 * design.highest_hz) {
        let message = format!("with `lateral_inertia`, there are no waves above {hz:.0} Hz in the thickest part");
        return Err(wrong("highest_hz", message, "must be well below"));
    }
    let found = modes::resonances(&lossless, (LOWEST_HZ, design.highest_hz));
    let mut modes: Vec<Mode> = found.iter().map(|&found| modes::mode(&lossy, found, has_rings)).collect();
    let largest = modes.iter().filter_map(capacitance).fold(0.0, f64::max);
    for mode in &mut modes {
        if capacitance(mode).is_some_and(|capacitance| capacitance > LEAST_CAPACITANCE_REL * largest) {
            mode.parallel_resonance_hz = modes::parallel_resonance(&lossless, mode);
        } else {
            mode.branch = None;
        }
    }
    let mut possible = modes.iter().enumerate().filter(|(_, mode)| !has_rings || mode.branch.is_some());
    let working = match design.frequency_hz {
        Some(wanted) => possible.min_by(|a, b| off(a.1, wanted).total_cmp(&off(b.1, wanted))),
        // The square of the coupling is in proportion to the capacitance.
        None => possible.find(|(_, mode)| !has_rings || capacitance(mode) >= Some(STRONG_REL * STRONG_REL * largest)),
    };
    let Some((working, mode)) = working else {
        let excited = if has_rings { " that the rings excite" } else { "" };
        return Err(wrong("highest_hz", format!("there is no mode{excited} below {} Hz", design.highest_hz), "too low"));
    };
    let circuit = has_rings.then(|| circuit(&lossy, &modes, working));
    let operating = operating(design, &lossy, mode, has_rings);
    let (preload_pa, heating_k) = (limits::preload(design), limits::heating(design, &operating));
    let limits = limits::limits(design, &operating, &preload_pa, heating_k);
    let other = build::parts(design, How { lossless: true, lateral: !design.lateral_inertia })?;
    let near = 1.3 * mode.series_resonance_hz;
    let has_waves = build::cutoff_hz(&other).is_none_or(|hz| hz > near);
    let shifted = if has_waves { modes::resonance(&other, mode.number, near) } else { None };
    let sign = if design.lateral_inertia { -1.0 } else { 1.0 };
    let lateral_hz = shifted.map_or(0.0, |hz| sign * (hz - mode.series_resonance_hz));
    Ok(Solved {
        circuit,
        limits,
        heating_k,
        lateral_hz,
        unchecked: limits::unchecked(design),
        preload_pa,
        bolt_preload_pa: limits::bolt_preload(design),
        names: (0..design.element.len()).map(|index| build::name(design, index)).collect(),
        length_m: operating.points.last().map_or(0.0, |point| point.x_m),
        operating,
        working,
        modes,
    })
}

/// Returns the motional capacitance of a mode, F.
fn capacitance(mode: &Mode) -> Option<f64> {
    mode.branch.map(|branch| branch.cm_f)
}

fn off(mode: &Mode, wanted: f64) -> f64 {
    (mode.series_resonance_hz - wanted).abs()
}

/// Returns the equivalent circuit with the working mode and those next to it.
fn circuit(lossy: &Parts, modes: &[Mode], working: usize) -> Circuit {
    let own = &modes[working];
    let fits = |mode: &Mode| {
        mode.branch.is_some_and(|branch| branch.lm_h < SCENE_BRANCH.0) && SCENE_BRANCH.1.contains(&mode.series_resonance_hz)
    };
    let mut further: Vec<usize> = (0..modes.len()).filter(|&index| index != working && fits(&modes[index])).collect();
    further.sort_by(|&a, &b| off(&modes[a], own.series_resonance_hz).total_cmp(&off(&modes[b], own.series_resonance_hz)));
    further.truncate(MOST_FURTHER);
    further.sort_unstable();
    let w = own.resonance();
    let all = further.iter().map(|&index| modes[index].admittance(w)).sum::<C>() + own.admittance(w);
    let total = driven(&chain(lossy, C::new(w, 0.0)), C::new(w, 0.0)).1;
    let rest = total - all;
    Circuit { c0_f: rest.im / w, loss_tangent: (rest.re / rest.im).max(0.0), further }
}

/// Computes the operating point.
fn operating(design: &Design, lossy: &Parts, mode: &Mode, has_rings: bool) -> Operating {
    let w = mode.resonance();
    let port = chain(lossy, C::new(w, 0.0));
    let wanted_m = design.tip_amplitude_m.or(design.tip_velocity_m_per_s.map(|velocity| velocity / w));
    if !has_rings {
        return Operating::new(lossy, w, free_back(&port, wanted_m.unwrap_or(DEFAULT_TIP_M)), C::default());
    }
    let (back, _) = driven(&port, C::new(w, 0.0));
    let at = |volts: f64| Operating::new(lossy, w, back * volts, C::new(volts, 0.0));
    let volts = design.drive_v.unwrap_or(DEFAULT_DRIVE_V);
    wanted_m.map_or_else(|| at(volts), |wanted| at(wanted / at(1.0).tip_m))
}

/// Returns the admittance around a mode, S, with dense frequencies at its resonances.
fn around(lossy: &Parts, mode: &Mode) -> Vec<(f64, C)> {
    const POINTS: usize = 240;
    let series = mode.resonance() / TAU;
    let parallel = mode.parallel_resonance_hz.unwrap_or(series);
    let (low, high) = (
        series - 0.6 * (parallel - series) - 6.0 * series / mode.q,
        parallel + 0.6 * (parallel - series) + 6.0 * series / mode.q,
    );
    let even = (0..=POINTS).map(|point| low + (high - low) * point as f64 / POINTS as f64);
    let near = |center: f64| {
        (0..=POINTS).map(move |point| {
            let t = 2.0 * point as f64 / POINTS as f64 - 1.0;
            center + 6.0 * center / mode.q * t * t * t
        })
    };
    let mut all: Vec<f64> = even.chain(near(series)).chain(near(parallel)).filter(|hz| *hz > 1.0).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all.into_iter().map(|hz| (hz, driven(&chain(lossy, modes::angular(hz)), modes::angular(hz)).1)).collect()
}
