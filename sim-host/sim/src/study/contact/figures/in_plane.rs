//! Figures of the last period of a contact with vibration at an angle to the sliding: both
//! components.

use super::{TIME, coulomb_n, line};
use crate::instruments::curves::axis;
use crate::study::in_plane::InPlane;
use contact::Problem;
use contact::plane::Moment;
use report::{Figure, Series};

/// Returns the figures; none for a study without a watch.
pub(super) fn all(problem: &Problem, in_plane: &InPlane) -> Vec<Figure> {
    let moments = &in_plane.last_period;
    let Some(last) = moments.last() else { return Vec::new() };
    let hz = problem.waveform.frequency_hz();
    let coulomb_n = coulomb_n(problem, last.time_s);
    let values = |value: &dyn Fn(&Moment) -> f64| moments.iter().map(value).collect::<Vec<f64>>();
    let periods = values(&|moment| hz * moment.time_s);
    let over_time = |name: &str, column: &str, value: &dyn Fn(&Moment) -> f64| line(name, column, periods.clone(), values(value));
    let figure = |(id, title, caption): (&str, &str, &str), y: &str, series: Vec<Series>| Figure {
        id: id.into(),
        title: title.into(),
        caption: caption.into(),
        x: axis(TIME),
        y: axis(y),
        series,
        interactive: true,
        hlines: vec![(0.0, String::new())],
        ..Figure::default()
    };
    let mut friction = figure(
        (
            "friction",
            "Friction over the last period",
            "Along and transverse to the sliding. Dashed: the Coulomb force, which is the friction along the sliding without \
             vibration.",
        ),
        "friction [N]",
        vec![
            over_time("along the sliding", "friction_n", &|moment| moment.friction_n[0]),
            over_time("transverse to the sliding", "friction_across_n", &|moment| moment.friction_n[1]),
        ],
    );
    friction.hlines.extend([(coulomb_n, "mu N".into()), (-coulomb_n, "-mu N".into())]);
    let path = Figure {
        id: "friction-path".into(),
        title: "Friction transverse to the sliding against friction along it".into(),
        caption: "Coulomb friction lies on the circle of mu N, opposite to the slip. Bristles turn with the slip; friction lies \
                  inside the circle until they have turned."
            .into(),
        x: axis("friction along the sliding [N]"),
        y: axis("friction transverse to the sliding [N]"),
        series: vec![line(
            "friction",
            "friction_across_n",
            values(&|moment| moment.friction_n[0]),
            values(&|moment| moment.friction_n[1]),
        )],
        hlines: vec![(0.0, String::new())],
        ..Figure::default()
    };
    let velocity = figure(
        (
            "velocity",
            "Velocity over the last period",
            "The vibration in its own direction, and the slip along and transverse to the sliding. Friction turns fastest when \
             the slip is smallest.",
        ),
        "velocity [m/s]",
        vec![
            over_time("vibration x'", "velocity_m_per_s", &|moment| moment.vibration_m_per_s),
            over_time("slip along", "slip_m_per_s", &|moment| moment.slip_m_per_s[0]),
            over_time("slip transverse", "slip_across_m_per_s", &|moment| moment.slip_m_per_s[1]),
        ],
    );
    let mut power = figure(
        (
            "power",
            "Power into friction over the last period",
            "Friction times slip velocity, both components. Dashed: power dissipated by Coulomb friction without vibration.",
        ),
        "power [mW]",
        vec![over_time("F w", "power_mw", &|moment| {
            1e3 * (moment.friction_n[0] * moment.slip_m_per_s[0] + moment.friction_n[1] * moment.slip_m_per_s[1])
        })],
    );
    power.hlines.push((1e3 * coulomb_n * problem.sliding_m_per_s, "mu N Vt".into()));
    vec![friction, path, velocity, power]
}
