//! Figures of both edges of a burst, sample by sample.

use firmware::seam::mode::Mode;

use super::windows::{OFF, ON};
use crate::instruments::View;
use crate::instruments::curves::axis;
use crate::record::Window;
use plant::truth::Sample;
use report::{Figure, Panel, Series, Span, Style};

/// Returns one figure for each edge that was recorded in `Run`; an ON window may begin before the
/// lock.
pub(super) fn all(run: &View) -> Vec<Figure> {
    let Some(run_s) = run.plays_from(Mode::Run) else { return Vec::new() };
    let at_an_edge = |window: &Window| [ON, OFF].contains(&window.title.as_str());
    let played = |window: &&Window| window.edge_s > run_s && at_an_edge(window) && !window.samples.is_empty();
    run.record.windows.iter().filter(played).map(|window| edge(run, window)).collect()
}

fn edge(run: &View, window: &Window) -> Figure {
    let sample_s = run.record.sample_s;
    let time: Vec<f64> =
        (0..window.samples.len()).map(|n| 1e3 * (window.start_s + n as f64 * sample_s - window.edge_s)).collect();
    let values = |value: &dyn Fn(&Sample) -> f64| window.samples.iter().map(value).collect::<Vec<f64>>();
    let curve = |name: &str, column: &str, value: &dyn Fn(&Sample) -> f64| Series {
        name: name.into(),
        csv_column: column.into(),
        x: time.clone(),
        y: values(value),
        style: Style::Line,
    };
    let panel = |label: &str, curve: Series| Panel { y: axis(label), series: vec![curve], ..Panel::default() };
    let (what_moves, velocity) =
        if run.scene.stator().is_some() { ("crest", "crest velocity [m/s]") } else { ("tip", "tip velocity [m/s]") };
    let moving = vec![
        curve(what_moves, "tip_velocity_m_per_s", &|sample| sample.tip_velocity_m_per_s),
        curve("its envelope", "tip_envelope_m_per_s", &|sample| sample.tip_envelope_m_per_s),
    ];
    let mut panels = Vec::new();
    if run.scene.sliding().is_some() {
        panels.push(panel("friction [N]", curve("friction", "friction_n", &|sample| sample.friction_n)));
    }
    if run.scene.rotor().is_some() {
        let speed = |sample: &Sample| sample.motor.map_or(0.0, |motor| motor.rotor_rad_per_s);
        panels.push(panel("rotor speed [rad/s]", curve("rotor", "rotor_speed_rad_per_s", &speed)));
    }
    let on = window.title == ON;
    let what = match (on, run.scene.sliding().is_some(), run.scene.rotor().is_some()) {
        (true, _, true) => "drive ON, the rotor starts",
        (false, _, true) => "drive OFF, the rotor stops",
        (true, true, _) => "drive ON, friction falls",
        (false, true, _) => "drive OFF, friction returns",
        (true, false, _) => "drive ON, ring-up",
        (false, false, _) => "drive OFF, ring-down",
    };
    let (first, last) = (time.first().copied().unwrap_or(0.0), time.last().copied().unwrap_or(0.0));
    let (from, to) = if on { (0.0, last) } else { (first, 0.0) };
    Figure {
        id: format!("burst-{}", window.title),
        title: format!("Burst edge: {what}"),
        caption:
            "Sample by sample. Time counts from the first DAC sample of the edge; a resonance rings with its own time constant."
                .into(),
        x: axis("time from the edge [ms]"),
        y: axis(velocity),
        series: moving,
        panels,
        band_limited: true,
        shaded: vec![Span { from, to, label: "ON".into() }],
        interactive: true,
        ..Figure::default()
    }
}
