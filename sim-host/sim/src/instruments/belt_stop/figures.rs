//! Figures of a belt that stops: position and counts, drive, tip and force.

use firmware::seam::fault::Limit;
use firmware::seam::mode::Mode;

use crate::instruments::View;
use crate::instruments::curves::axis;
use crate::record::Row;
use report::{Figure, Panel, Series, Span, Style};

/// Time shown before and after the drive is muted, s.
const SHOWN_S: f64 = 0.012;

/// Returns both figures of a run with an encoder that was muted or faulted under drive.
pub(super) fn all(run: &View) -> Vec<Figure> {
    let Some(counts_per_mm) = run.scene.sensors.encoder_counts_per_mm else { return Vec::new() };
    let running = run.after(run.plays_from(Mode::Run).unwrap_or(f64::INFINITY));
    let ends = |pair: &&[Row]| pair[0].drive_v > 0.0 && pair[1].drive_v == 0.0 && is_muted(&pair[1]);
    let Some(muted_s) = running.windows(2).find(ends).map(|pair| pair[0].time_s) else { return Vec::new() };
    let (from_s, to_s) = (muted_s - SHOWN_S, muted_s + SHOWN_S);
    let shown: Vec<&Row> = running.iter().filter(|row| (from_s..=to_s).contains(&row.time_s)).collect();
    let time: Vec<f64> = shown.iter().map(|row| 1e3 * (row.time_s - muted_s)).collect();
    let curve = |name: &str, column: &str, style: Style, value: &dyn Fn(&Row) -> f64| Series {
        name: name.into(),
        csv_column: column.into(),
        x: time.clone(),
        y: shown.iter().map(|row| value(row)).collect(),
        style,
    };
    let span = Span { from: 0.0, to: time.last().copied().unwrap_or(0.0), label: "muted".into() };
    let first = shown.first().map_or(0.0, |row| row.truth.belt_position_m);
    let first_counts = shown.iter().find_map(|row| row.belt_counts).unwrap_or(0);
    let counted = |row: &Row| row.belt_counts.map_or(f64::NAN, |n| f64::from(n.wrapping_sub(first_counts)) / counts_per_mm);
    let motion = Figure {
        id: "belt-motion".into(),
        title: "Stop of the belt and of the drive".into(),
        caption: "Position of the belt, and position by its encoder: a line that ends is a lost encoder, a line that continues \
                  is an encoder that counts falsely. Time counts from the first block without drive."
            .into(),
        x: axis("time from the mute [ms]"),
        y: axis("belt position [mm]"),
        series: vec![
            curve("true position", "belt_true_mm", Style::Line, &|row| 1e3 * (row.truth.belt_position_m - first)),
            curve("encoder", "belt_counted_mm", Style::Dashed, &counted),
        ],
        shaded: vec![span.clone()],
        interactive: true,
        ..Figure::default()
    };
    let panel = |label: &str, series: Vec<Series>| Panel { y: axis(label), series, ..Panel::default() };
    let mut forces = vec![curve("true friction", "friction_n", Style::Line, &|row| row.truth.friction_mean_n)];
    if run.scene.sensors.force_hz.is_some() {
        forces.push(curve("force channel", "force_n", Style::Dashed, &|row| row.force_n.unwrap_or(f64::NAN)));
    }
    let drive = Figure {
        id: "belt-drive".into(),
        title: "Drive, tip and friction over the stop".into(),
        caption:
            "Amplitudes of drive and tip, and mean friction. Under ultrasound, the mean friction of a stopped belt is zero, \
             which the force channel shows; once the tip has rung down, the friction keeps its value."
                .into(),
        x: axis("time from the mute [ms]"),
        y: axis("drive [V]"),
        series: vec![curve("drive", "drive_v", Style::Line, &|row| row.drive_v)],
        panels: vec![
            panel(
                "tip velocity [m/s]",
                vec![curve("tip", "tip_velocity_m_per_s", Style::Line, &|row| row.truth.tip_velocity_m_per_s)],
            ),
            panel("force [N]", forces),
        ],
        shaded: vec![span],
        interactive: true,
        ..Figure::default()
    };
    vec![motion, drive]
}

fn is_muted(row: &Row) -> bool {
    row.limit == Limit::BeltMuted as u8 || row.fault != 0
}
