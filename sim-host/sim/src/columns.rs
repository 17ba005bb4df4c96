//! Signals of a study as columns with names, units, meanings and values, for programs that need no
//! file.

use crate::data::{Cell, Column, OVERVIEW, PERIODS, RowColumn, fixed, signals};
use crate::record::Record;
use crate::study::contact::Solved;
use crate::study::{Outcome, Study};
use crate::trace::Tracer;
use contact::State;

/// The values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Numeric values.
    Numbers(Vec<f64>),
    /// Words.
    Texts(Vec<String>),
}

/// Returns the columns of the signals of a study. A driven run has those of its `[trace]`, or those
/// of every recorded block; a contact study has those of its last periods. Designs and several runs
/// have none.
pub fn heads(study: &Study) -> Vec<Column> {
    match &study.outcome {
        Outcome::Driven(run) => match &run.record.trace {
            Some(tracer) => of_trace(tracer),
            None => OVERVIEW.iter().map(|column| fixed((column.name, column.unit, column.meaning))).collect(),
        },
        Outcome::Contact(_) => PERIODS.into_iter().map(fixed).collect(),
        Outcome::Design(_) | Outcome::MonteCarlo(_) => Vec::new(),
    }
}

/// Returns the values of a signal by its index in [`heads`]; all signals of a study have the same
/// length. `None` if the index is too large.
pub fn values(study: &Study, place: usize) -> Option<Values> {
    match &study.outcome {
        Outcome::Driven(run) => match &run.record.trace {
            Some(tracer) => traced(tracer, place),
            None => OVERVIEW.get(place).map(|column| recorded(&run.record, column)),
        },
        Outcome::Contact(solved) => last_periods(solved, place),
        Outcome::Design(_) | Outcome::MonteCarlo(_) => None,
    }
}

fn of_trace(tracer: &Tracer) -> Vec<Column> {
    let described = signals();
    let names = std::iter::once("time_s".to_owned()).chain(tracer.signals().iter().map(|signal| signal.name()));
    let column = |name: String| {
        let known = described.iter().find(|column| column.name == name);
        let (unit, meaning) = known.map_or_else(Default::default, |column| (column.unit.clone(), column.meaning.clone()));
        Column { name, unit, meaning }
    };
    names.map(column).collect()
}

fn traced(tracer: &Tracer, place: usize) -> Option<Values> {
    (place <= tracer.signals().len()).then(|| Values::Numbers(tracer.rows().iter().map(|row| row[place]).collect()))
}

fn recorded(record: &Record, column: &RowColumn) -> Values {
    let cells = || record.rows.iter().map(column.value);
    let text = |cell: Cell| if let Cell::Text(text) = cell { Some(text) } else { None };
    let number = |cell: Cell| if let Cell::Number(number) = cell { number } else { f64::NAN };
    // A column with a unit contains numbers.
    match column.unit {
        "" => Values::Texts(cells().filter_map(text).collect()),
        _ => Values::Numbers(cells().map(number).collect()),
    }
}

fn last_periods(solved: &Solved, place: usize) -> Option<Values> {
    let value: fn(&State) -> f64 = match PERIODS.get(place)?.0 {
        "time_s" => |state| state.time_s,
        "displacement_m" => |state| state.x_m,
        "velocity_m_per_s" => |state| state.v_m_per_s,
        _ => |state| state.force_n,
    };
    Some(Values::Numbers(solved.playback.last_periods().iter().map(value).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{self, Options};
    use scene::load::load;

    /// Columns of every kind of study have equal lengths and the names of the file.
    #[test]
    fn columns_are_those_of_the_trace_file() {
        let traced = ["trace.signals=[\"friction_n\", \"frequency_hz\"]", "trace.every=100"];
        for (scene, sets, names) in [
            ("lock", &[][..], vec!["time_s", "mode", "frequency_command_hz"]),
            ("lock", &traced[..], vec!["time_s", "friction_n", "frequency_hz"]),
            ("contact", &[][..], vec!["time_s", "displacement_m", "velocity_m_per_s", "friction_n"]),
        ] {
            let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
            let loaded = load(scene, &sets).unwrap_or_else(|error| panic!("{error}"));
            let study = study::run(&loaded, Options::default()).expect("a study");
            let columns = heads(&study);
            let length = |place: usize| match values(&study, place).unwrap_or_else(|| panic!("{scene}: no column {place}")) {
                Values::Numbers(numbers) => numbers.iter().filter(|number| !number.is_nan()).count(),
                Values::Texts(texts) => texts.len(),
            };
            assert!(length(0) > 100 && (0..columns.len()).all(|place| length(place) == length(0)), "{scene}");
            assert_eq!(values(&study, columns.len()), None, "{scene}");
            for name in names {
                assert!(columns.iter().any(|column| column.name == name), "{scene}: {name}");
            }
        }
    }
}
