//! Both edges of a burst, sample by sample.

use firmware::seam::mode::Mode;

use super::windows::{OFF, ON};
use crate::instruments::View;
use crate::instruments::curves::axis;
use crate::record::Window;
use report::{Figure, Series, Span, Style};

/// One figure for each edge that was recorded and played: an ON window may begin before there is a lock.
pub(super) fn of(run: &View) -> Vec<Figure> {
    let Some(run_s) = run.plays_from(Mode::Run) else { return Vec::new() };
    let at_an_edge = |window: &Window| [ON, OFF].contains(&window.title.as_str());
    let played = |window: &&Window| window.edge_s > run_s && at_an_edge(window) && !window.samples.is_empty();
    run.record.windows.iter().filter(played).map(|window| edge(run, window)).collect()
}

fn edge(run: &View, window: &Window) -> Figure {
    let sample_s = run.record.sample_s;
    let time: Vec<f64> =
        (0..window.samples.len()).map(|n| 1e3 * (window.start_s + n as f64 * sample_s - window.edge_s)).collect();
    let largest = |value: &dyn Fn(usize) -> f64| (0..time.len()).map(value).fold(f64::MIN_POSITIVE, |a, b| a.max(b.abs()));
    let friction = |n: usize| window.samples[n].friction_n;
    let velocity = |n: usize| window.samples[n].tip_velocity_m_per_s;
    let relative = |name: &str, column: &str, value: &dyn Fn(usize) -> f64| {
        let scale = largest(value);
        let y = (0..time.len()).map(|n| value(n) / scale).collect();
        Series { name: name.into(), csv_column: column.into(), x: time.clone(), y, style: Style::Line }
    };
    let what_moves = if run.scene.stator().is_some() { "crest velocity" } else { "tip velocity" };
    let mut series = vec![relative(what_moves, "tip_velocity_relative", &velocity)];
    series.push(relative("its envelope", "tip_envelope_relative", &|n| window.samples[n].tip_envelope_m_per_s));
    if run.scene.sliding().is_some() {
        series.push(relative("friction", "friction_relative", &friction));
    }
    if run.scene.rotor().is_some() {
        let speed = |n: usize| window.samples[n].motor.map_or(0.0, |motor| motor.rotor_rad_per_s);
        series.push(relative("rotor speed", "rotor_speed_relative", &speed));
    }
    let on = window.title == ON;
    let what = match (on, run.scene.sliding().is_some(), run.scene.rotor().is_some()) {
        (true, _, true) => "drive ON, the rotor starts",
        (false, _, true) => "drive OFF, the rotor stops",
        (true, true, _) => "drive ON, friction falls",
        (false, true, _) => "drive OFF, friction comes back",
        (true, false, _) => "drive ON, it rings up",
        (false, false, _) => "drive OFF, it rings down",
    };
    let (first, last) = (time.first().copied().unwrap_or(0.0), time.last().copied().unwrap_or(0.0));
    let (from, to) = if on { (0.0, last) } else { (first, 0.0) };
    Figure {
        id: format!("burst-{}", window.title),
        title: format!("Burst edge: {what}"),
        caption:
            "Sample by sample, each relative to its largest value in this window. Time counts from the first DAC sample of the \
                  edge; what resonates rings with its own time constant."
                .into(),
        x: axis("time from the edge [ms]"),
        y: axis("relative to its largest value"),
        series,
        shaded: vec![Span { from, to, label: "ON".into() }],
        interactive: true,
        ..Figure::default()
    }
}
