//! Energy budget: distribution of the amplifier's work, and the error of the balance.

use super::curves::{axis, binned, mean, shaded};
use super::{Instrument, View};
use crate::metrics::Metrics;
use plant::truth::Truth;
use report::{Axis, Figure, Series, Style};

/// Instrument of every driven scene. A crash has its own balance.
pub(super) struct EnergyBudget;

impl Instrument for EnergyBudget {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        let energy = &run.record.energy;
        let balanced = run.record.crash.is_none() && energy.supplied_j != 0.0;
        metrics.put("energy_residual", balanced.then(|| energy.residual()));
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        budget(run).into_iter().collect()
    }
}

/// Returns the figure of the work since the beginning, on a logarithmic scale: the switched
/// friction takes a thousandth of the stack's own loss.
fn budget(run: &View) -> Option<Figure> {
    let rows = run.rows;
    let lost = |truth: &Truth| truth.lost_w;
    let cumulative = |name: &str, csv_column: &str, style: Style, power: &dyn Fn(&Truth) -> f64| {
        let mut work = 0.0;
        let (x, y) = binned(rows)
            .map(|bin| {
                let length_s = bin.len() as f64 * run.record.sample_s * run.record.block_samples as f64;
                work += mean(bin, |row| power(&row.truth)) * length_s;
                // Zero on a logarithmic scale is drawn as a gap.
                (mean(bin, |row| row.time_s), if work > 1e-9 { work } else { f64::NAN })
            })
            .unzip();
        Series { name: name.into(), csv_column: csv_column.into(), x, y, style }
    };
    let transducer = if run.scene.stator().is_some() { "stator" } else { "stack" };
    let mut series = vec![
        cumulative("from the amplifier", "supplied_j", Style::Line, &|truth| truth.power_w),
        cumulative(&format!("heat in the {transducer}"), "lost_j", Style::Dashed, &lost),
    ];
    if run.scene.rotor().is_some() {
        series.push(cumulative("wave against friction", "friction_on_wave_j", Style::Line, &|t| t.friction_on_tip_w));
        series.push(cumulative("friction on the rotor", "friction_on_rotor_j", Style::Line, &|t| -t.friction_on_slider_w));
    }
    if run.scene.sliding().is_some() {
        series.push(cumulative("slider against friction", "friction_on_slider_j", Style::Line, &|t| t.friction_on_slider_w));
        series.push(cumulative("tip against friction", "friction_on_tip_j", Style::Line, &|t| t.friction_on_tip_w));
    }
    (run.record.energy.supplied_j > 0.0).then(|| Figure {
        id: "energy".into(),
        title: "Energy budget".into(),
        caption: format!(
            "Work since the beginning. The error of the balance is {:.1e} of the supplied work.",
            run.record.energy.residual().abs()
        ),
        x: axis("time [s]"),
        y: Axis { label: "work [J]".into(), log: true, ..Axis::default() },
        series,
        shaded: shaded(run),
        interactive: true,
        ..Figure::default()
    })
}
