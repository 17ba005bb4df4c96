//! The design of a transducer or horn.

pub mod figures;
pub mod stack;
pub mod table;

use super::StudyError;
use crate::metrics::Metrics;
use ::design::{DesignError, Limit, Mode, Solved};
use scene::Designed;
use serde_json::{Value, json};

/// A solved design.
#[derive(Clone, Debug)]
pub struct Drawn<'a> {
    /// Scene of the design.
    pub scene: Designed<'a>,
    /// Solution.
    pub solved: Solved,
}

impl<'a> Drawn<'a> {
    /// Solves a design.
    pub(super) fn new(scene: Designed<'a>) -> Result<Self, DesignError> {
        Ok(Drawn { scene, solved: ::design::solve(scene.design)? })
    }
}

/// Returns the metrics of a grid cell.
pub(super) fn cell(scene: Designed) -> Result<Metrics, StudyError> {
    Ok(measure(&Drawn::new(scene)?))
}

/// Returns the metrics of a solved design.
pub(super) fn measure(Drawn { scene, solved }: &Drawn) -> Metrics {
    let (mode, at) = (solved.working(), &solved.operating);
    let velocity = std::f64::consts::TAU * at.frequency_hz * at.tip_m;
    let mut metrics = Metrics::default();
    metrics.put("series_resonance_hz", mode.series_resonance_hz);
    metrics.put("parallel_resonance_hz", mode.parallel_resonance_hz);
    metrics.put("coupling", solved.coupling(mode));
    let by_resonances = |fp: f64| (1.0 - (mode.series_resonance_hz / fp).powi(2)).sqrt();
    metrics.put("effective_coupling", mode.parallel_resonance_hz.map(by_resonances));
    metrics.put("q", mode.q);
    metrics.put("mode_separation_hz", solved.separation_hz());
    metrics.put("lateral_inertia_hz", Some(solved.lateral_hz).filter(|hz| *hz != 0.0));
    metrics.put("displacement_gain", at.tip_m / at.back_m);
    metrics.put("tip_amplitude_m", at.tip_m);
    metrics.put("tip_velocity_m_per_s", velocity);
    metrics.put("peak_stress_pa", at.stresses.iter().map(|(_, stress)| *stress).reduce(f64::max));
    metrics.put("bolt_stress_pa", at.bolt_pa);
    metrics.put("stress_margin", solved.tightest(true).map(Limit::margin));
    metrics.put("transducer_length_m", solved.length_m);
    metrics.put("ceramic_heating_k", solved.heating_k);
    if let (Some(branch), Some(circuit)) = (mode.branch, &solved.circuit) {
        metrics.put("rm_ohm", branch.rm_ohm);
        metrics.put("lm_h", branch.lm_h);
        metrics.put("cm_f", branch.cm_f);
        metrics.put("c0_f", circuit.c0_f);
        metrics.put("force_factor_n_per_v", branch.force_factor_n_per_v);
        metrics.put("tip_per_volt_m_per_v", at.tip_m / at.drive_v);
        metrics.put("tip_per_ampere_m_per_a", at.tip_m / at.current_a);
        metrics.put("drive_peak_v", at.drive_v);
        metrics.put("drive_current_a", at.current_a);
        metrics.put("drive_power_w", at.power_w);
    }
    metrics.put("bolt_preload_pa", solved.bolt_preload_pa);
    if let Some((stress, preload)) = solved.ceramic_pa(scene.design) {
        metrics.put("ceramic_stress_pa", stress);
        metrics.put("preload_stress_pa", preload);
    }
    metrics
}

/// Returns modes, parts and limits as JSON.
pub(crate) fn json(Drawn { solved, .. }: &Drawn) -> Value {
    let mode = |mode: &Mode| {
        let branch = mode.branch.map(|branch| {
            json!({
                "lm_h": branch.lm_h, "cm_f": branch.cm_f, "rm_ohm": branch.rm_ohm,
                "force_factor_n_per_v": branch.force_factor_n_per_v,
            })
        });
        json!({
            "series_resonance_hz": mode.series_resonance_hz, "parallel_resonance_hz": mode.parallel_resonance_hz,
            "coupling": solved.coupling(mode), "q": Some(mode.q).filter(|q| q.is_finite()), "branch": branch,
            "working": mode.number == solved.working().number,
        })
    };
    let at = &solved.operating;
    let find = |list: &[(usize, f64)], index| list.iter().find(|(other, _)| *other == index).map(|(_, value)| *value);
    let part = |(index, name): (usize, &String)| {
        json!({
            "name": name, "stress_pa": find(&at.stresses, index), "preload_pa": find(&solved.preload_pa, index),
            "loss_w": find(&at.losses, index),
        })
    };
    let limit = |limit: &Limit| json!({ "part": limit.part, "quantity": limit.quantity, "value": limit.value, "most": limit.most, "unit": limit.unit });
    json!({
        "modes": solved.modes.iter().map(mode).collect::<Vec<_>>(), "nodes_m": at.nodes_m,
        "parts": solved.names.iter().enumerate().map(part).collect::<Vec<_>>(),
        "limits": solved.limits.iter().map(limit).collect::<Vec<_>>(), "unchecked": solved.unchecked,
    })
}
