//! Remarks on a driven run, and the tables of its instruments.

use std::fmt::Write as _;

use firmware::seam::fault::Fault;

use crate::instruments::{DRIVEN, View};
use crate::metrics::Metrics;
use crate::study::driven::Run;
use report::TableBlock;

/// Returns the introduction: the level, and the meaning of command, estimate and truth.
pub(super) fn preface(run: &Run) -> String {
    format!(
        "{}, against a simulated {}. Command is the controller's output, estimate is its internal value, and truth is the state \
         of the simulated plant; the controller reads only converter codes.",
        run.level,
        match (run.scene.stator(), run.scene.dring()) {
            (Some(_), _) => "stator and rotor",
            (None, Some(_)) => "stack, seat belt and torso",
            (None, None) => "stack and contact",
        },
    )
}

/// Returns remarks that a reader must know before the numbers.
pub(super) fn remarks(run: &Run) -> Vec<String> {
    let view = View::new(&run.scene, &run.record);
    DRIVEN.iter().flat_map(|instrument| instrument.remarks(&view)).collect()
}

/// Returns the fault that ended the run, as a headline.
pub(super) fn fault(run: &Run) -> Option<(String, String)> {
    let fault = Fault::try_from(run.record.rows.last()?.fault).ok()?;
    Some(("ended in fault".to_owned(), format!("{}, {}", fault.code(), fault.called())))
}

/// Returns the tables of a driven run.
pub(super) fn tables(run: &Run, metrics: &Metrics) -> Vec<TableBlock> {
    let view = View::new(&run.scene, &run.record);
    DRIVEN.iter().flat_map(|instrument| instrument.tables(&view, metrics)).collect()
}

/// Returns drive hash, plant states and level for the footer.
pub(super) fn footer(run: &Run) -> Vec<(&'static str, String)> {
    vec![
        ("drive hash", format!("{:016x}", run.record.drive_hash)),
        ("plant states", run.record.plant_states.to_string()),
        ("level", run.level.to_string()),
    ]
}

/// Describes in one line how it was run.
pub(super) fn manner(run: &Run) -> String {
    let speed = run.record.simulated_s_per_wall_s();
    let speed = speed.map_or_else(String::new, |speed| format!("{} simulated seconds per wall second, ", super::number(speed)));
    format!("{}; {speed}{} plant states; drive hash {:016x}", run.level, run.record.plant_states, run.record.drive_hash)
}

/// Returns the time that an interrupted run reached, s.
pub(super) fn reached_s(run: &Run) -> f64 {
    run.record.rows.last().map_or(0.0, |row| row.time_s)
}

/// Returns the modes of the controller with their times.
pub(super) fn modes(run: &Run) -> String {
    let mut text = String::new();
    let mut last = None;
    for row in &run.record.rows {
        if last != Some((row.mode, row.fault)) {
            last = Some((row.mode, row.fault));
            let fault = if row.fault == 0 { String::new() } else { format!(" {}", row.fault) };
            let _ = writeln!(text, "{:12.6} s  {:?}{fault}", row.time_s, row.mode);
        }
    }
    text
}
