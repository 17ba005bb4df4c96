//! Amplifier for a wanted tip velocity, from the equivalent circuit at the series resonance.
//!
//! ```text
//! im = A v,    V = Rm im,    I = V |1 / Rm + j w C0|,    E = V + Rs I
//! S = V I / 2,    P = V im / 2,    dE/dt = w |E|
//! ```
//!
//! `A` is the force factor, `v` the peak tip velocity, `Rs` the source resistance; all are peak
//! values. A load lowers Q, and `Rm = w Lm / Q` then needs more voltage at the same velocity. A
//! burst that begins with `h` times the steady voltage reaches 90 % after `tau ln(h / (h - 0.9))`,
//! with `tau = 2 Lm / (Rm + Re{Rs / (1 + j w C0 Rs)})`.

use realfft::num_complex::Complex64;
use report::TableBlock;
use serde::Serialize;

use super::case::Parts;
use crate::numbers::number;
use plant::circuit::Circuit;

/// Factors by which Q falls.
const Q_FACTORS: [f64; 4] = [1.0, 0.5, 0.25, 0.1];
/// Fraction of the steady amplitude at which a rise ends.
const RISEN_FRACTION: f64 = 0.9;
/// Factor of the drive frequency at which a first-order amplifier of this bandwidth has lost 0.5 %
/// of its gain and 6 degrees.
const BANDWIDTH_FACTOR: f64 = 10.0;

/// Demand on the amplifier at one Q.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Demand {
    /// Quality factor.
    pub q: f64,
    /// Peak voltage at the stack, V.
    pub stack_v: f64,
    /// Peak voltage of the source, before its resistance, V.
    pub source_v: f64,
    /// Peak current, A.
    pub current_a: f64,
    /// Apparent power at the stack, VA.
    pub apparent_va: f64,
    /// Active power into the stack, W.
    pub active_w: f64,
}

/// Amplifier for a wanted tip velocity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Amplifier {
    /// Peak tip velocity, m/s.
    pub tip_m_per_s: f64,
    /// Peak tip displacement, m.
    pub tip_m: f64,
    /// Force factor of the stack, N/V.
    pub force_factor_n_per_v: f64,
    /// `true` if the user did not set the force factor.
    pub force_factor_is_assumed: bool,
    /// Demand at the stack's Q, and at lower ones.
    pub demands: Vec<Demand>,
    /// Largest rate of change of the source voltage at the stack's Q, V/us.
    pub slew_v_per_us: f64,
    /// Bandwidth of a first-order amplifier with 0.5 % and 6 degrees of error, Hz.
    pub bandwidth_hz: f64,
    /// Largest peak voltage of the scene's amplifier, V.
    pub available_v: f64,
    /// Current limit of the scene, peak, A.
    pub available_a: f64,
    /// Lowest Q at which voltage and current of the scene keep this velocity; `None` if they do not
    /// at the stack's Q.
    pub lowest_q: Option<f64>,
    /// Rise to 90 % with the steady voltage, and with the largest one of the scene's amplifier, ms;
    /// `None` if voltage or current of the scene do not suffice.
    pub rise_ms: (f64, Option<f64>),
}

/// Computes the amplifier for a peak tip velocity, m/s; `None` takes that of the requested voltage.
pub(super) fn amplifier(parts: &Parts<'_>, tip_m_per_s: Option<f64>, force_factor_is_assumed: bool) -> Amplifier {
    let (circuit, source_ohm) = (&parts.circuit, parts.amplifier.source_ohm);
    let own_v = parts.volts() / source_v(circuit, source_ohm, 1.0);
    let tip_m_per_s = tip_m_per_s.unwrap_or(own_v / circuit.rm_ohm / circuit.force_factor_n_per_v);
    let demand_at = |q: f64| demand(&circuit.with_q(q), source_ohm, tip_m_per_s);
    let demands: Vec<Demand> = Q_FACTORS.iter().map(|factor| demand_at(circuit.q() * factor)).collect();
    let available_v = parts.amplifier.full_scale_v.min(parts.controller.limits.voltage_v);
    let available_a = parts.controller.limits.current_a;
    let suffices = |demand: &Demand| demand.source_v <= available_v && demand.current_a <= available_a;
    let steady = demand_at(circuit.q());
    // The source, in parallel with C0, damps the motional branch.
    let source = source_ohm / Complex64::new(1.0, circuit.omega() * circuit.c0_f * source_ohm);
    let tau_s = 2.0 * circuit.lm_h / (circuit.rm_ohm + source.re);
    let rise = |headroom: f64| 1e3 * tau_s * (headroom / (headroom - RISEN_FRACTION)).ln();
    let headroom = available_v / steady.source_v;
    Amplifier {
        tip_m_per_s,
        tip_m: tip_m_per_s / circuit.omega(),
        force_factor_n_per_v: circuit.force_factor_n_per_v,
        force_factor_is_assumed,
        demands,
        slew_v_per_us: 1e-6 * circuit.omega() * steady.source_v,
        bandwidth_hz: BANDWIDTH_FACTOR * circuit.series_resonance_hz(),
        available_v,
        available_a,
        lowest_q: lowest_q(circuit.q(), |q| suffices(&demand_at(q))),
        rise_ms: (rise(1.0), suffices(&steady).then(|| rise(headroom))),
    }
}

/// Returns the source voltage for a voltage at the stack.
fn source_v(circuit: &Circuit, source_ohm: f64, stack_v: f64) -> f64 {
    let admittance = Complex64::new(1.0 / circuit.rm_ohm, circuit.omega() * circuit.c0_f);
    stack_v * (1.0 + source_ohm * admittance).norm()
}

fn demand(circuit: &Circuit, source_ohm: f64, tip_m_per_s: f64) -> Demand {
    let motional_a = circuit.force_factor_n_per_v * tip_m_per_s;
    let stack_v = circuit.rm_ohm * motional_a;
    let current_a = stack_v * Complex64::new(1.0 / circuit.rm_ohm, circuit.omega() * circuit.c0_f).norm();
    Demand {
        q: circuit.q(),
        stack_v,
        source_v: source_v(circuit, source_ohm, stack_v),
        current_a,
        apparent_va: 0.5 * stack_v * current_a,
        active_w: 0.5 * stack_v * motional_a,
    }
}

/// Returns the lowest Q, by bisection, at which the voltage suffices: it grows as Q falls.
fn lowest_q(own: f64, suffices: impl Fn(f64) -> bool) -> Option<f64> {
    let (mut low, mut high) = (1e-3 * own, own);
    if !suffices(high) {
        return None;
    }
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        if suffices(middle) { high = middle } else { low = middle }
    }
    Some(high)
}

/// Returns the tables of the amplifier.
pub(super) fn tables(it: &Amplifier) -> [TableBlock; 2] {
    let assumed = if it.force_factor_is_assumed { " (assumed: add --set stack.bvd.force_factor_n_per_v=X)" } else { "" };
    let lowest = match it.lowest_q {
        Some(q) => format!("Q {}", number(q)),
        None => "not at this Q".to_owned(),
    };
    let boosted = it.rise_ms.1.map_or_else(|| "–".to_owned(), |ms| format!("{} ms", number(ms)));
    let row = |what: &str, value: String| vec![what.to_owned(), value];
    let rows = vec![
        row("tip velocity, peak", format!("{} m/s", number(it.tip_m_per_s))),
        row("tip displacement, peak", format!("{} um", number(1e6 * it.tip_m))),
        row("force factor", format!("{} N/V{assumed}", number(it.force_factor_n_per_v))),
        row("slew rate of the source", format!("{} V/us", number(it.slew_v_per_us))),
        row("bandwidth for 0.5 % of gain and 6 degrees", format!("{} kHz", number(1e-3 * it.bandwidth_hz))),
        row("available in this scene", format!("{} V, {} A peak", number(it.available_v), number(it.available_a))),
        row("sufficient down to", lowest),
        row("rise to 90 %, steady voltage", format!("{} ms", number(it.rise_ms.0))),
        row("rise to 90 %, full voltage", boosted),
    ];
    let header = ["Q", "stack [V peak]", "source [V peak]", "current [A peak]", "apparent [VA]", "active [W]"];
    let of = |demand: &Demand| {
        let Demand { q, stack_v, source_v, current_a, apparent_va, active_w } = *demand;
        [q, stack_v, source_v, current_a, apparent_va, active_w].map(number).to_vec()
    };
    let caption = "At the series resonance and the same tip velocity. A load lowers Q; the first row is without a load.";
    [
        TableBlock::new("amplifier", "Amplifier", "", &["", ""], rows),
        TableBlock::new("demand", "Demand on the amplifier", caption, &header, it.demands.iter().map(of).collect()),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::case::{Case, Wishes};
    use super::*;
    use scene::load::load;

    /// The simulated stack reaches the wanted velocity with the voltage that is demanded.
    #[test]
    fn the_simulated_stack_moves_as_demanded() {
        let wanted = 0.2;
        let loaded = load("lock", &[]).unwrap();
        let case = Case::of(&loaded, None, &Wishes::default()).unwrap();
        let it = amplifier(&case.parts().unwrap(), Some(wanted), false);
        let volts = it.demands[0].source_v;
        let simulated = load("lock", &[format!("controller.drive.amplitude_v={volts}"), "disturbance=[]".to_owned()]).unwrap();
        let study = crate::study::run(&simulated, crate::study::Options::default()).unwrap();
        let (tip, power) = (study.metrics.get("tip_velocity_m_per_s").unwrap(), study.metrics.get("drive_power_w").unwrap());
        assert!((tip / wanted - 1.0).abs() < 0.01, "{tip}");
        assert!((power / it.demands[0].active_w - 1.0).abs() < 0.02, "{power} {it:?}");
    }

    #[test]
    fn the_lowest_q_uses_all_of_the_voltage() {
        let case = Case::of(&load("lock", &[]).unwrap(), None, &Wishes::default()).unwrap();
        let parts = case.parts().unwrap();
        let it = amplifier(&parts, Some(0.3), false);
        let at = demand(&parts.circuit.with_q(it.lowest_q.unwrap()), parts.amplifier.source_ohm, 0.3);
        assert!((at.source_v / it.available_v - 1.0).abs() < 1e-9, "{at:?}");
        assert!(it.rise_ms.1.unwrap() < it.rise_ms.0, "{it:?}");
        // A current limit counts, and a source resistance damps.
        let limited = |sets: &[&str]| {
            let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
            let case = Case::of(&load("lock", &sets).unwrap(), None, &Wishes::default()).unwrap();
            amplifier(&case.parts().unwrap(), Some(0.3), false)
        };
        assert_eq!(limited(&["controller.limits.current_a=0.5"]).lowest_q, None);
        let damped = limited(&["amplifier.source_ohm=3"]).rise_ms.0 / it.rise_ms.0;
        // `run burst` with hard edges: 0.78 ms instead of 1.40 ms.
        assert!((0.5..0.62).contains(&damped), "{damped}");
        let fast = amplifier(&parts, Some(300.0), false);
        assert!(fast.lowest_q.is_none() && fast.rise_ms.1.is_none(), "{fast:?}");
    }
}
