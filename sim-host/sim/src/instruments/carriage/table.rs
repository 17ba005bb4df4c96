//! Table of the sections of a carriage's run: measurements of the controller, and the truth.

use super::metrics::sensed_w;
use super::stretch::{DriveSection, sections};
use crate::instruments::View;
use crate::numbers::number;
use crate::record::Row;
use report::TableBlock;

/// Returns the table of the sections of a carriage's run.
pub(super) fn stretches(run: &View) -> Option<TableBlock> {
    let stretches = sections(run);
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
    let caption = "Sections from one edge of the drive to the next, in Run, while the carriage is pulled. If the drive comes ON \
                   under a wound spring, the section begins 0.2 s after the edge. The jump is the largest distance that the \
                   carriage gains on the end of its spring.";
    (!stretches.is_empty()).then(|| {
        let rows = stretches.iter().map(|stretch| cells(run, stretch)).collect();
        TableBlock::new("carriage", "Carriage, drive ON and OFF", caption, &header, rows)
    })
}

fn cells(run: &View, stretch: &DriveSection) -> Vec<String> {
    let cell = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), number);
    let mean = |of: &dyn Fn(&Row) -> Option<f64>| cell(stretch.mean(of));
    let pulled = run.scene.carriage().is_some_and(|(_, carriage)| carriage.pull_m_per_s != 0.0);
    let force_factor = run.scene.controller.tracking.nominal_force_factor_n_per_v;
    vec![
        if stretch.on { "ON" } else { "OFF" }.into(),
        number(stretch.begins_s()),
        number(stretch.ends_s()),
        cell(stretch.largest_pull_n()),
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

/// Returns the mean speed from the encoder counts, mm/s.
fn encoder_mm_per_s(run: &View, stretch: &DriveSection) -> Option<f64> {
    let counts_per_mm = run.scene.sensors.encoder_counts_per_mm?;
    let (first, last) = (stretch.settled().first()?, stretch.settled().last()?);
    let counts = f64::from(last.belt_counts?) - f64::from(first.belt_counts?);
    (last.time_s > first.time_s).then(|| counts / counts_per_mm / (last.time_s - first.time_s))
}
