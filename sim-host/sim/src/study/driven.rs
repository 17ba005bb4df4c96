//! A study in which the firmware drives.

use std::sync::atomic::AtomicBool;

use super::sweep_record::{self, SweepRecord};
use super::{Start, StudyError};
use crate::instruments;
use crate::metrics::Metrics;
use crate::record::{Record, Window};
use crate::run::{self, RunError, Watch};
use crate::schedule::{first_on, first_window};
use contact::Clock;
use plant::circuit_of;
use scene::Driven;
use scene::settings;

/// Title of the window that shows a motor's wave and lanes in their last periods.
pub const WAVE: &str = "wave";
/// Length of that window, drive periods.
const WAVE_PERIODS: f64 = 10.0;

/// Where the controller of a study ran, and so what its result can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// The controller ran on the host.
    Sil,
    /// As thumb code in an emulator.
    Pil,
}

impl Level {
    /// The level of runs whose processors are started like this.
    pub fn of(start: Option<Start>) -> Self {
        if start.is_some() { Level::Pil } else { Level::Sil }
    }
}

impl std::fmt::Display for Level {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Level::Sil => "SIL (software in the loop: the controller on the host)",
            Level::Pil => "PIL (processor in the loop: the controller as thumb code in QEMU)",
        })
    }
}

/// A run in which the firmware drove, with its results.
#[derive(Clone, Debug)]
pub struct Run<'a> {
    /// Scene that was run.
    pub scene: Driven<'a>,
    /// Where the controller ran.
    pub level: Level,
    /// Record of the run.
    pub record: Record,
}

/// Runs a scene, and measures it, with what its figures need.
pub(super) fn run<'a, 'w>(
    scene: Driven<'a>,
    (start, clock): (Option<Start>, Option<Clock>),
    stop: &'w AtomicBool,
    progress: Option<&'w mut dyn FnMut(f64)>,
) -> Result<(Run<'a>, Metrics), StudyError> {
    let mut windows = [edge_windows(&scene), wave_window(&scene)].concat();
    windows.extend(sweep_record::window(&scene));
    let watch = Watch { windows, stop: Some(stop), progress, clock };
    let record = run_where(&scene, start, watch)?;
    let metrics = instruments::measure(&scene, &record);
    Ok((Run { scene, level: Level::of(start), record }, metrics))
}

/// Runs a scene with the controller on a processor that `start` starts, or in this process.
fn run_where(scene: &Driven, start: Option<Start>, watch: Watch) -> Result<Record, RunError> {
    match start {
        Some(start) => run::run_on(&mut *start(&settings::config(scene))?, scene, watch),
        None => run::run(scene, watch),
    }
}

/// Runs a scene, and measures it.
pub(super) fn measured(scene: &Driven, start: Option<Start>, stop: &AtomicBool) -> Result<(Record, Metrics), StudyError> {
    let record = run_where(scene, start, Watch { stop: Some(stop), ..Watch::default() })?;
    let metrics = instruments::measure(scene, &record);
    Ok((record, metrics))
}

/// The sweep of a scene that is a cell, sample by sample.
pub(super) fn sweep(scene: &Driven, name: &str, stop: &AtomicBool) -> Result<Option<SweepRecord>, StudyError> {
    let windows = sweep_record::window(scene).into_iter().collect();
    let record = run::run(scene, Watch { windows, stop: Some(stop), ..Watch::default() })?;
    Ok(SweepRecord::of(name, scene, &record))
}

/// Both edges of the first ON window, sample by sample: a little before, and five time constants after. Of a repeated burst the
/// last period, because the first ones find the stack not yet locked.
fn edge_windows(scene: &Driven) -> Vec<Window> {
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
    window.map_or_else(Vec::new, |(on, off)| vec![edge("on", on), edge("off", off)])
}

/// The last periods of a motor's first ON window, or of its run.
fn wave_window(scene: &Driven) -> Vec<Window> {
    if scene.stator().is_none() {
        return Vec::new();
    }
    let window = scene.controller.burst.as_ref().and_then(|burst| first_window(burst, 0.0));
    let end_s = window.map_or(scene.duration_s, |(_, off)| off.min(scene.duration_s));
    // An edge may be moved to the end of a period.
    let period_s = 1.0 / scene.controller.drive.frequency_hz;
    let (from_s, to_s) = (end_s - (WAVE_PERIODS + 2.0) * period_s, end_s - 2.0 * period_s);
    vec![Window { title: WAVE.into(), edge_s: from_s, from_s, to_s, ..Window::default() }]
}
