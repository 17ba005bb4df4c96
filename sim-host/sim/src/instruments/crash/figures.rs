//! Figures of a crash: force, excursion and speed over time, of the switched belt and the passive
//! one.

use crate::instruments::curves::axis;
use plant::dring::crash::{Belt, Frame, Playback};
use report::{Figure, Series, Span, Style};

/// Maximum number of points of a curve.
const MAX_POINTS: usize = 3000;

/// Returns the figures of a crash.
pub(super) fn all(playback: &Playback) -> Vec<Figure> {
    vec![
        figure(
            playback,
            "crash-force",
            "Force at the shoulder",
            "Force that pulls the torso back and presses on it. The limiter and the friction at the D-ring set the pull of each \
             belt: the limiter's force times exp(mu theta).",
            ("force at the shoulder [N]", "shoulder_n"),
            |belt| belt.shoulder_n,
        ),
        figure(
            playback,
            "crash-excursion",
            "Excursion of the torso",
            "Measured from the initial position of the torso. Less force allows a larger excursion.",
            ("excursion [mm]", "excursion_mm"),
            |belt| 1e3 * belt.x_m,
        ),
        figure(
            playback,
            "crash-payout",
            "Sliding speed of the webbing over the D-ring",
            "A tangential vibration lowers friction only if its own velocity exceeds this speed.",
            ("sliding speed [m/s]", "payout_m_per_s"),
            |belt| belt.payout_m_per_s,
        ),
    ]
}

fn figure(
    playback: &Playback,
    id: &str,
    title: &str,
    caption: &str,
    (label, column): (&str, &str),
    value: fn(&Belt) -> f64,
) -> Figure {
    let every = playback.frames.len().div_ceil(MAX_POINTS).max(1);
    let frames: Vec<&Frame> = playback.frames.iter().step_by(every).collect();
    let series = |name: &str, side: &str, style: Style, belt: fn(&Frame) -> &Belt| Series {
        name: name.into(),
        csv_column: format!("{side}_{column}"),
        x: frames.iter().map(|frame| 1e3 * frame.time_s).collect(),
        y: frames.iter().map(|frame| value(belt(frame))).collect(),
        style,
    };
    let end_ms = frames.last().map_or(0.0, |frame| 1e3 * frame.time_s);
    let low = playback.low_s.map(|from_s| Span { from: 1e3 * from_s, to: end_ms, label: "drive ON".into() });
    Figure {
        id: id.into(),
        title: title.into(),
        caption: caption.into(),
        x: axis("time since the crash began [ms]"),
        y: axis(label),
        series: vec![
            series("switched belt", "switched", Style::Line, |frame| &frame.switched),
            series("passive belt", "passive", Style::Dashed, |frame| &frame.passive),
        ],
        shaded: low.into_iter().collect(),
        interactive: true,
        ..Figure::default()
    }
}
