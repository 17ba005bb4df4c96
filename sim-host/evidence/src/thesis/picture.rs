//! Figures in the thesis's numbering.

use report::{Axis, Figure, Series, Style};

/// Axis of the velocity ratio.
pub const VELOCITY_RATIO: &str = "velocity ratio Vt/Vv";
/// Axis of the friction ratio.
pub const FRICTION_RATIO: &str = "friction ratio";
/// Axis of the power dissipation ratio.
pub const POWER_RATIO: &str = "power dissipation ratio";
/// What a run from rest declares.
pub const FROM_REST: &str = "Declared here, open in the thesis: from rest, passive sign (V = Vt + x'), means over the whole first \
                             millisecond (60 periods), friction over mu m g.";
/// What a steady curve declares.
pub const STEADY: &str = "Declared here, open in the thesis: steady state, start-up excluded, passive sign (V = Vt + x'), velocity \
                          ratio by the steady vibration velocity, friction over mu m g.";

/// A figure of curves.
pub fn figure(id: &str, title: &str, caption: String, axes: [Axis; 2], series: Vec<Series>) -> Figure {
    let [x, y] = axes;
    Figure { id: id.into(), title: title.into(), caption, x, y, series, interactive: true, ..Figure::default() }
}

/// An axis that the data decide.
pub fn axis(label: &str) -> Axis {
    Axis { label: label.into(), ..Axis::default() }
}

/// A logarithmic axis with a label.
pub fn log_axis(label: &str) -> Axis {
    Axis { label: label.into(), log: true, ..Axis::default() }
}

/// An axis of an interval.
pub fn ranged(label: &str, from: f64, to: f64) -> Axis {
    Axis { label: label.into(), range: Some((from, to)), ..Axis::default() }
}

/// A curve as a solid line.
pub fn line(name: impl Into<String>, column: impl Into<String>, x: &[f64], y: Vec<f64>) -> Series {
    Series { name: name.into(), csv_column: column.into(), x: x.to_vec(), y, style: Style::Line }
}

/// A curve as a dashed line.
pub fn dashed(name: impl Into<String>, column: impl Into<String>, x: &[f64], y: Vec<f64>) -> Series {
    Series { style: Style::Dashed, ..line(name, column, x, y) }
}

/// A quantity and a label as the name of a column: lower case, everything else an underscore.
pub fn column(quantity: &str, label: &str) -> String {
    let name = format!("{quantity}_{label}").replace("µ ", "mu ").replace('µ', "u");
    let plain = name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' });
    plain.collect::<String>().trim_matches('_').to_owned()
}

#[cfg(test)]
mod tests {
    use super::column;

    #[test]
    fn columns_are_plain() {
        assert_eq!(column("control force", "192 N"), "control_force_192_n");
        assert_eq!(column("ks", "2842 N/µm (resonance)"), "ks_2842_n_um__resonance");
        assert_eq!(column("friction coefficient", "µ 0.1"), "friction_coefficient_mu_0_1");
    }
}
