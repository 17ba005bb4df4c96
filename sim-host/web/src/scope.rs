//! The scope: signals of a run over time, with command, estimate, sensor and truth in the same
//! plot.

use std::f64::consts::TAU;

use firmware::seam::fault::{Fault, Limit};
use firmware::seam::mode::Mode;
use report::decimate::keep;
use serde::Serialize;
use sim::instruments::View;
use sim::record::Row;
use sim::study::contact::Solved;
use sim::study::driven::Run;

/// Approximate number of points of a signal.
const MAX_POINTS: usize = 6000;
/// Room above and below the values of a lane, as a fraction of their extent.
const ROOM_REL: f64 = 0.15;
/// Largest number of changes of mode, fault and limit that are listed.
const MAX_EVENTS: usize = 60;

/// Data of a scope.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Scope {
    /// Time of the points, s.
    time_s: Vec<f64>,
    /// Signals, one plot each.
    lanes: Vec<Lane>,
    /// Intervals in which the drive was ON, s.
    on_s: Vec<(f64, f64)>,
    /// Events: time, s, and description.
    events: Vec<(f64, String)>,
}

/// A plot of the scope.
#[derive(Clone, Debug, Serialize)]
struct Lane {
    id: &'static str,
    label: &'static str,
    unit: &'static str,
    /// Range of values that is shown, if not all of them matter.
    range: Option<(f64, f64)>,
    signals: Vec<Signal>,
}

/// A curve of a plot.
#[derive(Clone, Debug, Serialize)]
struct Signal {
    /// `command`, `estimate`, `sensor` or `truth`.
    role: &'static str,
    name: &'static str,
    values: Vec<Option<f32>>,
    /// Smallest and largest value within each block.
    band: Option<[Vec<Option<f32>>; 2]>,
}

/// Converts a number for a screen; `None` if it is not finite.
fn point(value: f64) -> Option<f32> {
    Some(value as f32).filter(|value| value.is_finite())
}

/// Drawn rows, with functions for their signals.
struct Rows<'a>(Vec<&'a Row>);

impl Rows<'_> {
    fn values(&self, value: impl Fn(&Row) -> f64) -> Vec<Option<f32>> {
        self.0.iter().map(|row| point(value(row))).collect()
    }

    fn signal(&self, role: &'static str, name: &'static str, value: impl Fn(&Row) -> f64) -> Signal {
        Signal { role, name, values: self.values(value), band: None }
    }
}

impl Scope {
    /// Collects a run that was driven by the firmware.
    pub(crate) fn driven(run: &Run) -> Self {
        let view = View::new(&run.scene, &run.record);
        let all = &run.record.rows;
        let column = |value: fn(&Row) -> f64| all.iter().map(value).collect::<Vec<f64>>();
        let time_s = column(|row| row.time_s);
        let shapes = [
            column(|row| row.drive_v),
            column(|row| row.truth.tip_velocity_m_per_s),
            column(|row| row.truth.friction_mean_n),
            column(|row| row.frequency_hz),
        ];
        let columns: Vec<&[f64]> = std::iter::once(&time_s).chain(&shapes).map(Vec::as_slice).collect();
        let kept = keep(&columns, MAX_POINTS);
        let rows = Rows(kept.iter().map(|&place| &all[place]).collect());
        let lanes = [
            drive(&rows),
            current(&rows, run),
            velocity(&rows, run),
            friction(&rows, run),
            rotor(&rows, run),
            frequency(&rows, run),
        ];
        Scope {
            time_s: rows.0.iter().map(|row| rounded(row.time_s)).collect(),
            lanes: lanes.into_iter().flatten().collect(),
            on_s: view.on_windows(),
            events: events(all),
        }
    }

    /// Collects the last periods of a contact study.
    pub(crate) fn contact(solved: &Solved) -> Self {
        let states = solved.playback.last_periods();
        let lane = |id, label, unit, value: fn(&contact::State) -> f64| {
            let values = states.iter().map(|state| point(value(state))).collect();
            Lane { id, label, unit, range: None, signals: vec![Signal { role: "truth", name: "solution", values, band: None }] }
        };
        Scope {
            time_s: states.iter().map(|state| state.time_s).collect(),
            lanes: vec![
                lane("displacement", "displacement", "m", |state| state.x_m),
                lane("velocity", "velocity", "m/s", |state| state.v_m_per_s),
                lane("friction", "friction", "N", |state| state.force_n),
            ],
            ..Scope::default()
        }
    }
}

/// Rounds to ten significant digits, enough for a time.
fn rounded(value: f64) -> f64 {
    format!("{value:.9e}").parse().unwrap_or(value)
}

fn drive(rows: &Rows) -> Option<Lane> {
    let played = rows.signal("command", "played, peak", |row| row.drive_v);
    Some(Lane { id: "drive", label: "drive", unit: "V", range: None, signals: vec![played] })
}

fn current(rows: &Rows, run: &Run) -> Option<Lane> {
    let estimate = rows.signal("estimate", "controller's estimate", |row| row.motional_current_a);
    let truth = run.scene.stack.as_ref().map(|stack| {
        let factor = stack.bvd.force_factor_n_per_v;
        rows.signal("truth", "plant", move |row| factor * row.truth.tip_velocity_m_per_s)
    });
    let signals = std::iter::once(estimate).chain(truth).collect();
    Some(Lane { id: "current", label: "motional current", unit: "A", range: None, signals })
}

fn velocity(rows: &Rows, run: &Run) -> Option<Lane> {
    // A friction switch has its own set point; the ordered velocity is only its upper limit.
    let set = run.scene.ordered_velocity_m_per_s().filter(|_| run.scene.controller.friction.is_none());
    let set = set.map(|set| rows.signal("command", "set point", move |row| if row.envelope > 0.0 { set } else { 0.0 }));
    let nominal = run.scene.controller.tracking.nominal_force_factor_n_per_v;
    let estimate = nominal
        .map(|nominal| rows.signal("estimate", "by the nominal force factor", move |row| row.motional_current_a / nominal));
    let truth = rows.signal("truth", "plant", |row| row.truth.tip_velocity_m_per_s);
    let signals = set.into_iter().chain(estimate).chain([truth]).collect();
    Some(Lane { id: "velocity", label: "tip velocity", unit: "m/s", range: None, signals })
}

fn friction(rows: &Rows, run: &Run) -> Option<Lane> {
    let rubs = run.scene.sliding().is_some()
        || run.scene.belt().is_some()
        || run.scene.rotor().is_some()
        || run.scene.rig.as_ref().is_some_and(|rig| rig.carriage.is_some());
    if !rubs {
        return None;
    }
    let band = [rows.values(|row| row.truth.friction_min_n), rows.values(|row| row.truth.friction_max_n)];
    let truth = Signal {
        band: Some(band),
        ..rows.signal("truth", "plant, mean and extremes of a block", |row| row.truth.friction_mean_n)
    };
    let cell = rows.signal("sensor", "load cell", |row| row.truth.load_cell_n);
    let force = rows.0.iter().any(|row| row.force_n.is_some());
    let force = force.then(|| rows.signal("estimate", "force channel of the board", |row| row.force_n.unwrap_or(f64::NAN)));
    let cell = run.scene.sliding().is_some().then_some(cell);
    let signals = cell.into_iter().chain(force).chain([truth]).collect();
    Some(Lane { id: "friction", label: "friction", unit: "N", range: None, signals })
}

fn rotor(rows: &Rows, run: &Run) -> Option<Lane> {
    run.scene.rotor()?;
    let motors = &run.record.motors;
    let truth =
        rows.signal("truth", "plant", |row| motors.get(row.number as usize).map_or(f64::NAN, |motor| motor.rotor_rad_per_s));
    Some(Lane { id: "rotor", label: "rotor speed", unit: "rad/s", range: None, signals: vec![truth] })
}

/// Returns the frequency, in a range around the values in mode Run, as the scan before extends over
/// kilohertz.
fn frequency(rows: &Rows, run: &Run) -> Option<Lane> {
    let values = |row: &&Row| [row.frequency_hz, row.resonance_estimate_hz, row.truth.series_resonance_hz];
    let running = run.record.rows.iter().filter(|row| row.mode == Mode::Run);
    let ends = running
        .collect::<Vec<_>>()
        .iter()
        .flat_map(values)
        .filter(|hz| hz.is_finite() && *hz > 0.0)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), hz| (low.min(hz), high.max(hz)));
    let least_hz = run.scene.controller.drive.frequency_hz / TAU * 1e-4;
    let room = ROOM_REL * (ends.1 - ends.0).max(least_hz);
    let signals = vec![
        rows.signal("command", "played", |row| if row.drive_v > 0.0 { row.frequency_hz } else { f64::NAN }),
        rows.signal("estimate", "controller's estimate", |row| {
            if row.resonance_estimate_hz > 0.0 { row.resonance_estimate_hz } else { f64::NAN }
        }),
        rows.signal("truth", "resonance of the plant", |row| row.truth.series_resonance_hz),
    ];
    let range = (ends.0 <= ends.1).then_some((ends.0 - room, ends.1 + room));
    Some(Lane { id: "frequency", label: "frequency", unit: "Hz", range, signals })
}

/// Describes changes of mode, fault and limit.
fn events(rows: &[Row]) -> Vec<(f64, String)> {
    let mut last = (None, 0, 0);
    let mut events = Vec::new();
    for row in rows {
        if last.0 != Some(row.mode) {
            events.push((row.time_s, format!("mode {:?}", row.mode)));
        }
        if row.fault != last.1 && row.fault != 0 {
            let known = Fault::ALL.iter().find(|fault| fault.code() == row.fault);
            events.push((row.time_s, format!("fault {}: {}", row.fault, known.map_or("", |fault| fault.meaning()))));
        }
        if row.limit != last.2 && row.limit != 0 {
            let known = Limit::ALL.iter().find(|limit| limit.code() == row.limit);
            events.push((row.time_s, format!("limit {}: {}", row.limit, known.map_or("", |limit| limit.meaning()))));
        }
        if row.limit == 0 && last.2 != 0 {
            events.push((row.time_s, format!("limit {} has ended", last.2)));
        }
        last = (Some(row.mode), row.fault, row.limit);
    }
    events.truncate(MAX_EVENTS);
    events
}
