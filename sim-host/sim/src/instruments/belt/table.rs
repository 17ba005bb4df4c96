//! Tables of a belt under a horn: its friction law, the deviation from the thesis, and this run in
//! closed form.

use super::law;
use crate::metrics::Metrics;
use crate::numbers::number;
use contact::empirical::reached;
use report::TableBlock;
use scene::Driven;

/// Returns the tables, if the scene has a belt.
pub(super) fn tables(scene: &Driven, metrics: &Metrics) -> Vec<TableBlock> {
    let Some((contact, belt)) = scene.belt() else { return Vec::new() };
    let law = contact.law();
    let lasting = law.lasting(belt.load_n, belt.speed_m_per_s, belt.amplitude_fraction);
    let on_s = metrics.get("on_time_s");
    let row = |what: &str, metric: &str, closed: Option<f64>, of: &str| {
        let cell = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), number);
        vec![what.into(), cell(metrics.get(metric)), cell(closed), of.into()]
    };
    let ordered = scene.ordered_velocity_m_per_s();
    let circuit = plant::circuit_of(scene);
    let power = ordered.map(|velocity| 0.5 * circuit.rm_ohm * (velocity * circuit.force_factor_n_per_v).powi(2));
    let rows = vec![
        row("amplitude, relative to full amplitude", "amplitude_fraction", Some(belt.amplitude_fraction), "set point"),
        row(
            "reduction at the end of ON [%]",
            "reduction_percent",
            on_s.map(|on_s| 100.0 * reached(lasting, on_s, belt.lag_s)),
            "law with its lag, from no reduction",
        ),
        row("reduction if ON lasted [%]", "lasting_reduction_percent", Some(100.0 * lasting), "law at the commanded amplitude"),
        row("pull, drive OFF [N]", "friction_off_n", Some(contact.mu * belt.load_n), "mu W"),
        row("power into the stack [W]", "drive_power_w", power, "(Rm + c / phi^2) I^2 / 2 at the commanded amplitude"),
    ];
    let caption = "This run includes the ring-up of the stack; the closed form does not.";
    let run =
        TableBlock::new("belt-run", "Belt: this run and closed form", caption, &["", "this run", "closed form", "formula"], rows);
    vec![run, law::constants(law, belt.lag_s), law::residuals(law, belt.lag_s)]
}
