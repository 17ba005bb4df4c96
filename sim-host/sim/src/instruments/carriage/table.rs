//! A carriage, stretch by stretch: what the controller measures, and the truth.

use super::metrics::sensed_w;
use super::stretch::{Stretch, all};
use crate::instruments::View;
use crate::numbers::precise;
use crate::record::Row;
use report::TableBlock;

/// The stretches of a carriage's run.
pub(super) fn stretches(run: &View) -> Option<TableBlock> {
    let stretches = all(run);
    let header = [
        "drive",
        "from [s]",
        "to [s]",
        "largest pull [N]",
        "jump [um]",
        "slips",
        "speed [mm/s]",
        "by the encoder",
        "rms over mean",
        "friction [N]",
        "by the force channel",
        "tip [m/s]",
        "by the controller",
        "power [W]",
        "by the controller",
    ];
    let caption = "From one edge of the drive to the next, of a running controller, as far as the carriage is pulled; of a drive that comes ON under a wound spring from 0.2 s \
                   after the edge on. The jump is the farthest that the carriage gains on the end of its spring.";
    (!stretches.is_empty()).then(|| {
        let rows = stretches.iter().map(|stretch| cells(run, stretch)).collect();
        TableBlock::new("carriage", "Carriage, drive ON and OFF", caption, &header, rows)
    })
}

fn cells(run: &View, stretch: &Stretch) -> Vec<String> {
    let cell = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), precise);
    let mean = |of: &dyn Fn(&Row) -> Option<f64>| cell(stretch.mean(of));
    let pulled = run.scene.carriage().is_some_and(|(_, carriage)| carriage.pull_m_per_s != 0.0);
    let force_factor = run.scene.controller.tracking.nominal_force_factor_n_per_v;
    vec![
        if stretch.on { "ON" } else { "OFF" }.into(),
        precise(stretch.begins_s()),
        precise(stretch.ends_s()),
        cell(stretch.most_n()),
        cell(pulled.then(|| 1e6 * stretch.jump_m())),
        if pulled && !stretch.on { stretch.slips_s().len().to_string() } else { "–".into() },
        cell(stretch.speed_m_per_s().map(|speed| 1e3 * speed)),
        cell(encoder_mm_per_s(run, stretch)),
        cell(stretch.ripple()),
        mean(&|row| Some(row.truth.friction_mean_n)),
        mean(&|row| row.force_n),
        mean(&|row| Some(row.truth.tip_velocity_m_per_s)),
        mean(&|row| force_factor.filter(|_| stretch.on).map(|factor| row.motional_current_a / factor)),
        mean(&|row| Some(row.truth.power_w)),
        mean(&|row| sensed_w(row).filter(|_| stretch.on)),
    ]
}

/// Mean speed by the counts of the encoder, mm/s.
fn encoder_mm_per_s(run: &View, stretch: &Stretch) -> Option<f64> {
    let counts_per_mm = run.scene.sensors.encoder_counts_per_mm?;
    let (first, last) = (stretch.settled().first()?, stretch.settled().last()?);
    let counts = f64::from(last.belt_counts?) - f64::from(first.belt_counts?);
    (last.time_s > first.time_s).then(|| counts / counts_per_mm / (last.time_s - first.time_s))
}
