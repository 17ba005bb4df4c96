//! Figures in the thesis's numbering.

use report::{Axis, Figure, Series, Style};

/// Label of the velocity ratio axis.
pub const VELOCITY_RATIO: &str = "velocity ratio Vt/Vv";
/// Label of the friction ratio axis.
pub const FRICTION_RATIO: &str = "friction ratio";
/// Label of the power dissipation ratio axis.
pub const POWER_RATIO: &str = "power dissipation ratio";
/// Choices for a run from rest, as text for captions.
pub const FROM_REST: &str = "Chosen here, open in the thesis: from rest, passive sign (V = Vt + x'), means over the whole first \
                             millisecond (60 periods), friction over mu m g.";
/// Choices for a steady curve, as text for captions.
pub const STEADY: &str = "Chosen here, open in the thesis: steady state without the start transient, passive sign (V = Vt + \
                          x'), velocity ratio relative to the steady vibration velocity, friction over mu m g.";

/// Creates a figure of curves.
pub fn figure(id: &str, title: &str, caption: String, axes: [Axis; 2], series: Vec<Series>) -> Figure {
    let [x, y] = axes;
    Figure { id: id.into(), title: title.into(), caption, x, y, series, interactive: true, ..Figure::default() }
}

/// Creates an axis with the range of the data.
pub fn axis(label: &str) -> Axis {
    Axis { label: label.into(), ..Axis::default() }
}

/// Creates a logarithmic axis.
pub fn log_axis(label: &str) -> Axis {
    Axis { label: label.into(), log: true, ..Axis::default() }
}

/// Creates an axis with a range.
pub fn ranged(label: &str, from: f64, to: f64) -> Axis {
    Axis { label: label.into(), range: Some((from, to)), ..Axis::default() }
}

/// Creates a solid line.
pub fn line(name: impl Into<String>, column: impl Into<String>, x: &[f64], y: Vec<f64>) -> Series {
    Series { name: name.into(), csv_column: column.into(), x: x.to_vec(), y, style: Style::Line }
}

/// Creates a dashed line.
pub fn dashed(name: impl Into<String>, column: impl Into<String>, x: &[f64], y: Vec<f64>) -> Series {
    Series { style: Style::Dashed, ..line(name, column, x, y) }
}

/// Formats a quantity and a label as a column name: lower case, with underscores for other
/// characters.
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
