//! Figures of a travelling-wave motor: rotor, waves, path of a surface point, and lanes.

use super::window::WAVE;
use crate::instruments::View;
use crate::instruments::curves::{axis, binned, curve, shaded};
use crate::record::{Row, Window};
use plant::truth::{MotorSample, MotorTruth};
use report::{Figure, Series, Style};

/// Number of periods shown of lanes and surface.
const PERIODS: f64 = 3.0;

fn of_motor<'a>(run: &'a View, value: impl Fn(&MotorTruth) -> f64 + 'a) -> impl Fn(&Row) -> f64 + 'a {
    move |row| run.motor_truth(row).map_or(f64::NAN, &value)
}

/// Returns all figures, the most important first.
pub(super) fn all(run: &View) -> Vec<Figure> {
    if run.scene.stator().is_none() {
        return Vec::new();
    }
    let mut figures = Vec::new();
    figures.extend(rotor_speed(run));
    figures.push(waves(run));
    if let Some(window) = run.record.windows.iter().find(|window| window.title == WAVE && !window.samples.is_empty()) {
        figures.push(ellipse(run, window));
        figures.push(lanes(run, window));
    }
    figures
}

fn rotor_speed(run: &View) -> Option<Figure> {
    let rotor = run.scene.rotor()?;
    let rows = run.rows;
    let crests = |motor: &MotorTruth| (motor.forward_m_per_s - motor.backward_m_per_s) / rotor.radius_m;
    Some(Figure {
        id: "rotor-speed".into(),
        title: "Rotor speed".into(),
        caption: "The crests carry the rotor. It is slower than the crests because the flanks of each contact are slower, and \
             because of its load. Self-test, scan and lock also drive the motor. When the drive is OFF, the preload brakes and \
             holds the rotor."
            .into(),
        x: axis("time [s]"),
        y: axis("speed [rad/s]"),
        series: vec![
            curve(rows, "rotor", "rotor_rad_per_s", Style::Line, of_motor(run, |motor| motor.rotor_rad_per_s)),
            curve(rows, "crests: forward minus backward wave", "crests_rad_per_s", Style::Dashed, of_motor(run, crests)),
        ],
        shaded: shaded(run),
        hlines: vec![(0.0, String::new())],
        interactive: true,
        ..Figure::default()
    })
}

fn waves(run: &View) -> Figure {
    let rows = run.rows;
    let micrometres = |value: fn(&MotorTruth) -> f64| of_motor(run, move |motor| 1e6 * value(motor));
    let most = binned(rows).flatten().filter_map(|row| run.motor_truth(row)).map(|motor| motor.forward_m.max(motor.backward_m));
    let top = 2e6 * most.fold(0.0, f64::max).max(1e-12);
    Figure {
        id: "waves".into(),
        title: "Forward and backward wave on the stator".into(),
        caption: "Amplitudes of the wave that turns the rotor forwards, and of the opposite wave caused by unbalanced lanes. \
             A pure travelling wave has no backward wave."
            .into(),
        x: axis("time [s]"),
        y: report::Axis { label: "amplitude [µm]".into(), log: true, range: Some((5e-4 * top, top)), ..report::Axis::default() },
        series: vec![
            curve(rows, "forward wave", "forward_wave_um", Style::Line, micrometres(|motor| motor.forward_m)),
            curve(rows, "backward wave", "backward_wave_um", Style::Line, micrometres(|motor| motor.backward_m)),
        ],
        shaded: shaded(run),
        interactive: true,
        ..Figure::default()
    }
}

/// Returns the last periods of a window, with the time of each sample in us from the first.
fn last_periods(run: &View, window: &Window) -> Vec<(f64, MotorSample)> {
    let sample_s = run.record.sample_s;
    let count = (PERIODS / run.scene.controller.drive.frequency_hz / sample_s).ceil() as usize + 1;
    let samples = &window.samples[window.samples.len().saturating_sub(count)..];
    let motors = samples.iter().filter_map(|sample| sample.motor).enumerate();
    motors.map(|(n, motor)| (1e6 * n as f64 * sample_s, motor)).collect()
}

fn ellipse(run: &View, window: &Window) -> Figure {
    let samples = last_periods(run, window);
    let (x, y) = samples.iter().map(|(_, motor)| (1e9 * motor.surface_m[1], 1e9 * motor.surface_m[0])).unzip();
    let stator = run.scene.stator();
    let slope = stator.map_or(0.0, |stator| std::f64::consts::TAU / stator.wave_length_m * stator.surface_height_m);
    let across = samples.iter().map(|(_, motor)| 1e9 * motor.surface_m[0].abs()).fold(0.0, f64::max);
    // Thesis B.14; the amplitude is the largest displacement across the ring.
    let ideal = (0..=120).map(|n| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(n) / 120.0).sin_cos();
        (slope * across * cos, across * sin)
    });
    let (ideal_x, ideal_y) = ideal.unzip();
    let series =
        |name: &str, csv_column: &str, x, y, style| Series { name: name.into(), csv_column: csv_column.into(), x, y, style };
    Figure {
        id: "surface".into(),
        title: "Path of a surface point".into(),
        caption: format!(
            "Point under the first tab, over {PERIODS} periods before the drive ends. In a pure travelling wave the path is the \
             ellipse of thesis equation B.14 with half axes a and z k a (dashed, z k = {slope:.3}). A backward wave changes its \
             thickness along the ring and tilts it."
        ),
        x: axis("displacement along the ring [nm]"),
        y: axis("displacement across [nm]"),
        series: vec![
            series("surface point", "across_nm", x, y, Style::Line),
            series("pure wave of the same height", "across_pure_nm", ideal_x, ideal_y, Style::Dashed),
        ],
        equal_aspect: true,
        band_limited: true,
        ..Figure::default()
    }
}

fn lanes(run: &View, window: &Window) -> Figure {
    let samples = last_periods(run, window);
    let names = ["lane 0: sine", "lane 1: cosine", "lane 2: -sine", "lane 3: -cosine"];
    let series = names.iter().enumerate().map(|(lane, name)| Series {
        name: (*name).into(),
        csv_column: format!("lane_{lane}_v"),
        x: samples.iter().map(|(time, _)| *time).collect(),
        y: samples.iter().map(|(_, motor)| motor.lanes_v[lane]).collect(),
        style: Style::Line,
    });
    Figure {
        id: "lanes".into(),
        title: "The four lanes at the electrodes".into(),
        caption: "Voltages at the electrode tabs, including the amplifiers' errors, over the last periods before the drive ends."
            .into(),
        x: axis("time [µs]"),
        y: axis("voltage [V]"),
        series: series.collect(),
        band_limited: true,
        interactive: true,
        ..Figure::default()
    }
}
