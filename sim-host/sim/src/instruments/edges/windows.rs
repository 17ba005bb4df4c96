//! Windows around the edges of a burst that are recorded sample by sample.

use crate::record::Window;
use crate::schedule::first_on;
use plant::circuit_of;
use scene::Driven;

/// Title of the window around the beginning of a burst.
pub(super) const ON: &str = "on";
/// Title of the window around the end of a burst.
pub(super) const OFF: &str = "off";

/// Returns windows for both edges of the first ON window, from slightly before to five time
/// constants after. For a repeated burst, the last period is used, because the first ones may
/// precede the lock.
pub(super) fn around_edges(scene: &Driven) -> Vec<Window> {
    let after_s = 5.0 * circuit_of(scene).time_constant_s();
    let Some(burst) = &scene.controller.burst else { return Vec::new() };
    let late = burst.period_s.map_or(0.0, |period_s| scene.duration_s - 2.0 * period_s);
    let window = first_on(scene, late).filter(|window| window.0 < scene.duration_s);
    let edge = |title: &str, at_s: f64| Window {
        title: title.into(),
        edge_s: at_s,
        from_s: at_s - 0.2 * after_s,
        to_s: at_s + after_s,
        ..Window::default()
    };
    window.map_or_else(Vec::new, |(on, off)| vec![edge(ON, on), edge(OFF, off)])
}
