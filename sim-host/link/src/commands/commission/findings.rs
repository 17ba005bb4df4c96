//! Output of a commissioning's result, as text and fields.

use serde_json::json;

use super::modes::Mode;
use super::proposal::{bound_hz, width_hz};
use super::{CommissionArgs, Commissioned, drawing, output};
use crate::answer::{Answer, quantity, short};
use crate::commands::circuit;

/// Returns the modes as lines of a table, with the chosen one marked.
pub fn table(modes: &[Mode], chosen: Option<usize>) -> Vec<String> {
    let mut lines = vec!["      f_s [Hz]    f_p [Hz]       Q       k          Rm          C0".to_owned()];
    lines.extend(modes.iter().enumerate().map(|(place, mode)| {
        let it = &mode.transducer;
        format!(
            "{}{:>2} {:>10.2}  {:>10.2}  {:>6.1}  {:>6.4}  {:>10}  {:>10}",
            if chosen == Some(place) { "*" } else { " " },
            place + 1,
            it.series_resonance_hz,
            it.parallel_resonance_hz,
            it.q,
            it.coupling,
            quantity(it.rm_ohm.into(), "ohm"),
            quantity(it.c0_f.into(), "F"),
        )
    }));
    lines
}

/// Returns the answer: the modes, the proposed settings and the test.
pub fn in_words(found: &Commissioned, args: &CommissionArgs) -> Answer {
    let (it, verified, proposal) = (&found.proposal.transducer, &found.verified, &found.proposal);
    let answer = Answer::to("commission").line(format!("{}: {}", found.name, found.load.in_words()));
    let answer = table(&found.modes, Some(found.chosen)).into_iter().fold(answer, Answer::line);
    let answer = answer.line(drawing::in_terminal(found)).line("proposed settings, and their effect or uncertainty:");
    let answer = output::worth(found)
        .into_iter()
        .fold(answer, |answer, [what, value, worth]| answer.line(format!("  {what:<24} {value:>14}  {worth}")));
    let answer = answer.line(format!(
        "test: locked at {:.2} Hz {:.0} ms after the order, at 0.7 of the amplitude {:.2} Hz, and {:.2} Hz after a burst; \
         motional current {}, {}",
        verified.locked_hz,
        verified.lock_ms,
        verified.stepped_hz.0,
        verified.after_burst_hz,
        quantity(verified.motional_a, "A"),
        quantity(verified.power_w, "W"),
    ));
    let off_hz = verified.locked_hz - f64::from(it.series_resonance_hz);
    let answer = if off_hz.abs() > bound_hz(it) {
        answer.line(format!(
            "note: the lock is {off_hz:+.2} Hz off the identified resonance, which is {:.1} % of the bandwidth, because of another \
             resonance nearby; the tip velocity is at most 1 % below its maximum",
            100.0 * off_hz.abs() / width_hz(it)
        ))
    } else {
        answer
    };
    let answer = match &args.output {
        Some(dir) => answer.line(format!("written: {}, with settings.txt and twin.toml", dir.join("report.html").display())),
        None => answer,
    };
    let answer = answer.line(if args.yes {
        "stored and active; the drive is silent"
    } else {
        "not stored: the settings are as before, and the drive is silent. --yes stores the new ones"
    });
    let modes: Vec<_> = found
        .modes
        .iter()
        .map(|mode| {
            let it = &mode.transducer;
            json!({
                "series_resonance_hz": short(it.series_resonance_hz), "parallel_resonance_hz": short(it.parallel_resonance_hz),
                "q": short(it.q), "coupling": short(it.coupling), "rm_ohm": short(it.rm_ohm), "lm_h": short(it.lm_h),
            })
        })
        .collect();
    let answer = found.thermal.iter().fold(answer, |answer, thermal| {
        answer
            .field("resistance_k_per_w", thermal.resistance_k_per_w)
            .field("heat_capacity_j_per_k", thermal.capacity_j_per_k)
            .field("thermal_deviations_rel", thermal.deviations_rel.to_vec())
    });
    circuit::fields(it, answer.field("modes", modes).field("mode", found.chosen + 1))
        .field("amplitude_v", proposal.volts)
        .field("tracking_mode", if proposal.observer { "observer" } else { "phase_lock" })
        .field("locked_hz", verified.locked_hz)
        .field("after_step_hz", verified.stepped_hz.1)
        .field("after_burst_hz", verified.after_burst_hz)
        .field("circle_distance", found.resolved.distance)
        .field("circle_resonances", found.resolved.resonances)
        .field("stored", args.yes)
}
