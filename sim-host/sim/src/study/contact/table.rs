//! Remarks and tables of a contact study.

use crate::instruments::Line;
use crate::numbers::{number, precise};
use crate::study::Study;
use crate::study::answer::Answer;
use crate::study::contact::Solved;
use contact::{Method, Solution};
use report::TableBlock;
use scene::{Body, MeanWindow, Model, Sign, VibrationVelocity, problem};

/// Introduction to a contact study.
pub const PREFACE: &str = "A contact study: a given excitation vibrates the contact; no controller, converter or stack is \
     simulated. Fc is the Coulomb force, mu N; Vt the sliding speed, Vv the vibration velocity; means are over the stated \
     window.";

/// Returns remarks that a reader must know before the numbers.
pub fn remarks(solved: &Solved) -> Vec<String> {
    let mut remarks = Vec::new();
    if let Body::Sdof(sdof) = solved.scene.body
        && !matches!(solved.scene.model, Model::Hertz(_))
        && problem::resonates(sdof.mass_kg, sdof.stiffness_n_per_m, sdof.damping_ratio, solved.scene.excitation.frequency_hz)
    {
        remarks.push(
            "The excitation is at the resonance of an undamped oscillator: the motion grows without bound, and every ratio \
             depends on the window. Set `rig.sdof.damping_ratio` for a steady state."
                .into(),
        );
    }
    if solved.scene.model.sign() == Sign::Literal && matches!(solved.scene.body, Body::Sdof(_)) {
        remarks.push(
            "With the literal sign of 4.14 and 4.16, friction feeds energy into the oscillator: its own motion \
                      grows."
                .into(),
        );
    }
    let is_wanted = solved.scene.integrator.window == Some(MeanWindow::Steady);
    let is_silent = |answer: &Answer| !is_steady(&answer.solution) && answer.solution.warnings.is_empty();
    if is_wanted && solved.answer.as_ref().is_some_and(is_silent) {
        remarks.push(
            "`integrator.window = \"steady\"` has no effect: the steady state is found for a contact that vibrates along the \
             sliding, with a tolerance of the mean."
                .into(),
        );
    }
    remarks.extend(solved.answer.iter().flat_map(|answer| answer.solution.warnings.iter().map(|warning| sentence(warning))));
    remarks
}

/// Returns `true` if the means are those of the steady state.
fn is_steady(solution: &Solution) -> bool {
    solution.orbit.is_some() || solution.method == Method::Closed
}

/// Formats a warning as a sentence.
fn sentence(warning: &str) -> String {
    let mut letters = warning.chars();
    let first = letters.next().map(|letter| letter.to_uppercase().to_string()).unwrap_or_default();
    let stop = if warning.ends_with('.') { "" } else { "." };
    format!("{first}{}{stop}", letters.as_str())
}

/// Headline metrics: label, metric, unit.
pub const HEADLINE: &[Line] = &[
    ("friction reduction", "reduction_percent", "%"),
    ("mean friction", "friction_on_n", "N"),
    ("without vibration", "friction_off_n", "N"),
    ("power ratio", "power_ratio", ""),
    ("velocity ratio", "velocity_ratio", ""),
    ("kappa", "kappa", ""),
];

/// Relative numerical error from which the headline shows it.
const SHOWN_ERROR_REL: f64 = 1e-4;

/// Returns the friction ratio as a headline, with its numerical error if that matters.
pub fn ratio(solved: &Solved) -> Option<(String, String)> {
    let solution = &solved.answer.as_ref()?.solution;
    let ratio = solution.ratios.friction;
    let error = solution.error_estimate.filter(|error| *error >= SHOWN_ERROR_REL * ratio.abs());
    let value = error.map_or_else(|| number(ratio), |error| format!("{} ± {error:.0e} (numerical error)", precise(ratio)));
    Some(("friction ratio".to_owned(), value))
}

/// Returns method and level for the footer.
pub fn footer(solved: &Solved) -> Vec<(&'static str, String)> {
    let method = solved.answer.as_ref().map_or_else(String::new, |answer| answer.solution.method.name().to_owned());
    vec![("method", method), ("level", LEVEL.to_owned())]
}

/// Level of a contact study.
pub const LEVEL: &str = "contact study (no controller)";

/// Describes the solution in one line.
pub fn manner(solved: &Solved) -> String {
    let Some(answer) = &solved.answer else { return LEVEL.to_owned() };
    let solution = &answer.solution;
    let steps = solution.steps_per_period.map_or_else(String::new, |steps| format!(", {steps} steps per period"));
    let order = solution.order.map_or_else(String::new, |order| format!(", order {order}"));
    let time = solution.ns_per_period.map_or_else(String::new, |ns| format!("{} ns per period, ", number(ns)));
    format!("{LEVEL}; method {}{steps}{order}: {time}{} states", solution.method.name(), solution.states)
}

/// Returns the time that an interrupted study reached, s.
pub fn reached_s(solved: &Solved) -> f64 {
    solved.playback.bins().last().map_or(0.0, |bin| bin.end_s)
}

/// Returns the tables of the answer and of its solution.
pub fn tables(study: &Study, solved: &Solved) -> Vec<TableBlock> {
    let Some(answer) = &solved.answer else { return Vec::new() };
    vec![ratios(study, solved, &answer.solution), solution(&answer.solution)]
}

fn ratios(study: &Study, solved: &Solved, solution: &Solution) -> TableBlock {
    let own = |metric: &str| study.metrics.get(metric).map(precise);
    let (from_s, to_s) = solved.answer.as_ref().map_or((0.0, 0.0), |answer| answer.problem.window_s);
    let hz = solved.scene.excitation.frequency_hz;
    let sliding = solved.answer.as_ref().map(|answer| precise(answer.problem.sliding_m_per_s));
    let vv = match solved.scene.excitation.velocity_ratio_of {
        VibrationVelocity::Peak if solved.scene.excitation.velocity_ratio.is_some() => {
            "Vt over the steady Vv of the sine (in the scene, it is over the peak)"
        }
        _ => "Vt over the steady Vv of the sine, without friction",
    };
    let rows = [
        ("friction ratio", Some(precise(solution.ratios.friction)), "mean friction / Fc (4.17)"),
        ("of the steady state", own("steady_friction_ratio").filter(|_| solution.orbit.is_none()), "to which the run settles"),
        (
            "settling [periods]",
            own("settling_periods"),
            "until a small disturbance of the steady state has fallen to a thousandth",
        ),
        ("transverse friction [N]", own("transverse_friction_n"), "root mean square of the friction transverse to the sliding"),
        ("power ratio", own("power_ratio"), "mean F V / (Fc Vt) (4.18)"),
        ("input ratio", own("input_ratio"), "power of the excitation / (Fc Vt) (4.31)"),
        ("stored ratio", own("stored_ratio"), "energy gained by mass and spring / (Fc Vt T)"),
        ("damper ratio", own("damper_ratio"), "loss in the damper / (Fc Vt T)"),
        ("power ratio as printed", own("power_ratio_as_printed"), "1 + phi_iu - phi_su (4.35): wrong, see the errata"),
        ("energy residual", own("energy_residual"), "error of the energy identity / (Fc Vt T)"),
        ("velocity ratio", own("velocity_ratio"), vv),
        ("sliding speed Vt [m/s]", sliding, ""),
        ("kappa", own("kappa"), "Kt Vv / (w Fc): vibration amplitude in Dahl lengths"),
        ("peak velocity [m/s]", own("peak_velocity_m_per_s"), if is_steady(solution) { "" } else { "over the whole run" }),
    ];
    let across = [
        ("in contact [% of the time]", own("contact_time_percent"), "vibration normal to the surface"),
        ("mean indentation [m]", own("mean_indentation_m"), "zero while the bodies are apart"),
        ("mean normal force [N]", own("mean_normal_n"), "equals the load, unless something else carries it"),
        ("largest normal force [N]", own("peak_normal_n"), ""),
        ("sticking [% of the time]", own("stick_time_percent"), "friction below mu times the normal force"),
        ("critical speed [m/s]", own("critical_speed_m_per_s"), "the contact never sticks above it"),
        ("coefficient ratio", own("coefficient_ratio"), "mean friction / (mu times the mean normal force)"),
    ];
    let rows =
        rows.into_iter().chain(across).filter_map(|(what, value, is)| Some(vec![what.into(), value?, is.into()])).collect();
    let caption = match is_steady(solution) {
        true => "Means over one period of the steady state.".to_owned(),
        false => format!("Means over periods {} to {}.", number(from_s * hz), number(to_s * hz)),
    };
    TableBlock::new("ratios", "Friction and power", &caption, &["", "value", "definition"], rows)
}

fn solution(solution: &Solution) -> TableBlock {
    let or_none = |number: Option<u32>| number.map_or_else(|| "–".to_owned(), |number| number.to_string());
    let error = |error: f64| format!("{error:.1e}");
    let of_mean = solution.error_estimate.map_or_else(|| "–".to_owned(), error);
    let rows = [
        ("method", Some(solution.method.name().to_owned())),
        ("reason", Some(solution.why.clone())),
        ("steps per period", Some(or_none(solution.steps_per_period))),
        ("order", Some(or_none(solution.order))),
        ("error estimate of the friction ratio", Some(of_mean)),
        ("residual after one period", solution.orbit.map(|orbit| error(orbit.residual))),
        ("error estimate of the record", solution.record_error_estimate.map(error)),
        ("states", Some(solution.states.to_string())),
    ];
    let rows = rows.into_iter().filter_map(|(what, value)| Some(vec![what.into(), value?])).collect();
    TableBlock::new("solution", "Solution", "", &["", ""], rows)
}
