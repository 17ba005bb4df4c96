//! The window of a motor's run that is recorded sample by sample.

use crate::record::Window;
use crate::schedule::first_window;
use scene::Driven;

/// Title of the window with a motor's wave and lanes in their last periods.
pub(super) const WAVE: &str = "wave";
/// Length of the window, drive periods.
const WAVE_PERIODS: f64 = 10.0;

/// Returns the window of the last periods of a motor's first ON window, or of its run.
pub(super) fn wave_window(scene: &Driven) -> Option<Window> {
    scene.stator()?;
    let window = scene.controller.burst.as_ref().and_then(|burst| first_window(burst, 0.0));
    let end_s = window.map_or(scene.duration_s, |(_, off)| off.min(scene.duration_s));
    // An edge may move to the end of a period.
    let period_s = 1.0 / scene.controller.drive.frequency_hz;
    let (from_s, to_s) = (end_s - (WAVE_PERIODS + 2.0) * period_s, end_s - 2.0 * period_s);
    Some(Window { title: WAVE.into(), edge_s: from_s, from_s, to_s, ..Window::default() })
}
