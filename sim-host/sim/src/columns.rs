//! The signals of a study as columns: names, units, meanings and values, for a program that has no use for a file.

use crate::data::{Cell, OVERVIEW, PERIODS, signals};
use crate::record::Record;
use crate::study::contact::Solved;
use crate::study::{Outcome, Study};
use crate::trace::Tracer;

/// A column.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name of the column, with its unit.
    pub name: String,
    /// Unit of the column; `1` of a ratio or a count, empty of a text.
    pub unit: String,
    /// Meaning of the column.
    pub meaning: String,
    /// Values of the column.
    pub values: Values,
}

/// The values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Numbers.
    Numbers(Vec<f64>),
    /// Words.
    Texts(Vec<String>),
}

/// The signals of a study, each as long as the others: of a driven run what its `[trace]` asks for, or a row for every block that was recorded; of a
/// contact study the last periods, a row a step. None of several runs.
pub fn of(study: &Study) -> Vec<Column> {
    match &study.outcome {
        Outcome::Driven(run) => match &run.record.trace {
            Some(tracer) => of_signals(tracer),
            None => of_record(&run.record),
        },
        Outcome::Contact(solved) => of_last_periods(solved),
        Outcome::MonteCarlo(_) => Vec::new(),
    }
}

fn of_signals(tracer: &Tracer) -> Vec<Column> {
    let described = signals();
    let names = std::iter::once("time_s".to_owned()).chain(tracer.signals().iter().map(|signal| signal.name()));
    let column = |(place, name): (usize, String)| {
        let known = described.iter().find(|column| column.name == name);
        let (unit, meaning) = known.map_or_else(Default::default, |column| (column.unit.clone(), column.meaning.clone()));
        Column { name, unit, meaning, values: Values::Numbers(tracer.rows().iter().map(|row| row[place]).collect()) }
    };
    names.enumerate().map(column).collect()
}

fn of_record(record: &Record) -> Vec<Column> {
    let column = |column: &crate::data::RowColumn| {
        let cells = || record.rows.iter().map(column.value);
        let text = |cell: Cell| if let Cell::Text(text) = cell { Some(text) } else { None };
        let number = |cell: Cell| if let Cell::Number(number) = cell { number } else { f64::NAN };
        // A column that has a unit is one of numbers.
        let values = match column.unit {
            "" => Values::Texts(cells().filter_map(text).collect()),
            _ => Values::Numbers(cells().map(number).collect()),
        };
        Column { name: column.name.into(), unit: column.unit.into(), meaning: column.meaning.into(), values }
    };
    OVERVIEW.iter().map(column).collect()
}

fn of_last_periods(solved: &Solved) -> Vec<Column> {
    let states = solved.playback.last_periods();
    let columns: [Vec<f64>; 4] = [
        states.iter().map(|state| state.time_s).collect(),
        states.iter().map(|state| state.x_m).collect(),
        states.iter().map(|state| state.v_m_per_s).collect(),
        states.iter().map(|state| state.force_n).collect(),
    ];
    let column = |((name, unit, meaning), values): ((&str, &str, &str), Vec<f64>)| Column {
        name: name.into(),
        unit: unit.into(),
        meaning: meaning.into(),
        values: Values::Numbers(values),
    };
    PERIODS.into_iter().zip(columns).map(column).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{self, Options};
    use scene::load::load;

    /// Columns are as long as each other, of every kind of study, and their names are those of the file.
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
            let columns = of(&study);
            let length = |column: &Column| match &column.values {
                Values::Numbers(numbers) => numbers.iter().filter(|number| !number.is_nan()).count(),
                Values::Texts(texts) => texts.len(),
            };
            assert!(length(&columns[0]) > 100 && columns.iter().all(|column| length(column) == length(&columns[0])), "{scene}");
            for name in names {
                assert!(columns.iter().any(|column| column.name == name), "{scene}: {name}");
            }
        }
    }
}
