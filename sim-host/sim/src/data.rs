//! Data that a run writes: every file with its columns, units and scale.
//! `docs/metrics-and-files.md` is generated from this module and from the
//! [table of metrics](scene::metrics); the files are written from the same columns.

mod faults_page;
mod page;

use std::fmt;

use crate::record::Row;
use scene::metrics::MACHINE;
use scene::schema::Schema;

pub use faults_page::faults_page;
pub use page::page;
pub use scene::figures::{FIGURES, FigureData};

/// A column of a table, or a field of a JSON file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Name of the column.
    pub name: String,
    /// Unit of the column; `1` for a ratio or a count, empty for text.
    pub unit: String,
    /// Meaning of the column.
    pub meaning: String,
}

/// A file that a run writes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DataFile {
    /// Name of the file.
    pub name: &'static str,
    /// Kinds of runs that write the file.
    pub of: &'static str,
    /// Contents of the file.
    pub meaning: &'static str,
    /// Columns or fields of the file, if they are the same in every run.
    pub columns: Vec<Column>,
}

/// A value of the table of a whole run.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cell {
    /// A number.
    Number(f64),
    /// A word.
    Text(String),
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Cell::Number(number) => number.fmt(f),
            Cell::Text(text) => text.fmt(f),
        }
    }
}

/// A column of the table of a whole run: name, unit, meaning, and its value in a row.
pub(crate) struct RowColumn {
    pub(crate) name: &'static str,
    pub(crate) unit: &'static str,
    pub(crate) meaning: &'static str,
    pub(crate) value: fn(&Row) -> Cell,
}

/// Creates a column of the list below.
const fn column(name: &'static str, unit: &'static str, meaning: &'static str, value: fn(&Row) -> Cell) -> RowColumn {
    RowColumn { name, unit, meaning, value }
}

/// Columns of the table of a whole driven run, if its scene has no trace.
pub(crate) const OVERVIEW: &[RowColumn] = &[
    column("time_s", "s", "End of the block", |row| Cell::Number(row.time_s)),
    column("mode", "", "Mode of the controller after it had measured this block", |row| Cell::Text(format!("{:?}", row.mode))),
    column("fault_code", "1", "Number of the fault; 0 means no fault", |row| Cell::Number(row.fault.into())),
    column("limit_code", "1", "Number of the limit; 0 means no limit", |row| Cell::Number(row.limit.into())),
    column("frequency_command_hz", "Hz", "Drive frequency", |row| Cell::Number(row.frequency_hz)),
    column("resonance_estimate_hz", "Hz", "The controller's estimate of the resonance", |row| {
        Cell::Number(row.resonance_estimate_hz)
    }),
    column("series_resonance_true_hz", "Hz", "Series resonance of the simulated transducer alone", |row| {
        Cell::Number(row.truth.series_resonance_hz)
    }),
    column("drive_v", "V", "Peak drive voltage, times the mean envelope", |row| Cell::Number(row.drive_v)),
    column("envelope", "1", "Mean envelope of the drive, 0 to 1", |row| Cell::Number(row.envelope)),
    column("motional_current_estimate_a", "A", "The controller's estimate of the motional current, amplitude", |row| {
        Cell::Number(row.motional_current_a)
    }),
    column("tip_velocity_true_m_per_s", "m/s", "Tip velocity of the simulated stack, amplitude", |row| {
        Cell::Number(row.truth.tip_velocity_m_per_s)
    }),
    column("friction_true_n", "N", "Simulated friction, mean over the block", |row| Cell::Number(row.truth.friction_mean_n)),
    column("load_cell_n", "N", "Reading of the load cell", |row| Cell::Number(row.truth.load_cell_n)),
    column("power_true_w", "W", "Electrical power into the motional branch, mean over the block", |row| {
        Cell::Number(row.truth.power_w)
    }),
];

/// Columns of the last periods of a contact study, step by step: name, unit, meaning.
pub(crate) const PERIODS: [(&str, &str, &str); 4] = [
    ("time_s", "s", "End of the step"),
    ("displacement_m", "m", "Displacement by the vibration, without the sliding motion"),
    ("velocity_m_per_s", "m/s", "Velocity of the vibration"),
    ("friction_n", "N", "Friction"),
];

/// Creates a column from fixed texts.
pub(crate) fn fixed((name, unit, meaning): (&str, &str, &str)) -> Column {
    Column { name: name.into(), unit: unit.into(), meaning: meaning.into() }
}

/// Creates the fields of a JSON file.
fn fields(fields: &[(&str, &str, &str)]) -> Vec<Column> {
    fields.iter().copied().map(fixed).collect()
}

/// Returns the signals that the `[trace]` of a scene may list.
pub(crate) fn signals() -> Vec<Column> {
    let choices = Schema::root().at("trace.signals").and_then(Schema::items).map_or_else(Vec::new, Schema::described_choices);
    let time = fixed(("time_s", "s", "End of the sample"));
    let signal = |(name, meaning): (&str, &str)| {
        let code = name.contains("code");
        let unit = scene::schema::unit_of(name).unwrap_or_else(|| if code { "LSB".into() } else { "1".into() });
        let meaning = meaning.trim_end_matches('.');
        let meaning = meaning.strip_suffix(&format!(", {unit}")).unwrap_or(meaning);
        Column { name: name.into(), meaning: meaning.into(), unit }
    };
    std::iter::once(time).chain(choices.into_iter().map(signal)).collect()
}

/// Returns all files that a run writes into its folder, except those of its figures.
pub fn files() -> Vec<DataFile> {
    let date = ("date", "", "Time of the run, UTC; not in `--format json`. `SOURCE_DATE_EPOCH` sets it");
    let machine = MACHINE.iter().map(|figure| (figure.name, figure.unit, figure.meaning)).chain([date]).map(fixed).collect();
    let overview = OVERVIEW.iter().map(|column| fixed((column.name, column.unit, column.meaning))).collect();
    vec![
        DataFile {
            name: "manifest.json",
            of: "every run",
            meaning: "Everything that the run depends on, and its files. It is moved into the folder last: a folder without it \
                      contains no run. Every command that writes a folder writes a manifest. The same command replaces the \
                      listed files, and no others. A folder is not changed if it contains files of another command, a file that \
                      was changed after it was written, or an input of the command. The command then uses another folder within \
                      `out` and names it, or refuses the folder given by `-o`. Runs of the same scene have the same manifest, \
                      except for the checksum of `machine.json` and its own",
            columns: fields(&[
                ("program", "", "`sim-host`"),
                ("version", "", "Version of the program"),
                (
                    "commit",
                    "",
                    "Commit of the program's source, with `+` if files were changed; absent if it was built outside a checkout",
                ),
                ("scene", "", "Name of the scene"),
                ("seed", "1", "Seed of all noise"),
                ("level", "", "Level at which the controller ran"),
                ("input_hash", "", "Hash of the scene's text (CRC-64/XZ)"),
                ("set", "", "Changes by `--set`"),
                ("resolved_scene", "", "The scene with all its defaults"),
                (
                    "inherited",
                    "",
                    "If the scene has a `base`: its name, the values changed, and which of title, source, notes and expectations \
                     still apply",
                ),
                ("overlays_not_drawn, assumed", "", "As in `summary.json`"),
                ("drive_hash", "", "Hash of every DAC code played; for several runs, of their hashes"),
                ("interrupted", "", "`true` if the run was stopped before its end"),
                ("complete", "", "`true` if the run is complete"),
                ("command", "", "Command that wrote the files: `run`, `import admittance`, `link commission` and so on"),
                ("files", "", "All other files of the run"),
                ("checksums", "", "CRC-64/XZ of each file, and of the manifest with an empty string here"),
                ("former", "", "Only while `complete` is false: checksums of the files of the previous run"),
            ]),
        },
        DataFile {
            name: "summary.json",
            of: "every run",
            meaning: "The result: the output of `--format json`, without `machine`. It is identical, byte for byte, for every \
                      run of the same scene",
            columns: fields(&[
                ("scene", "", "Name of the scene"),
                ("seed", "1", "Seed of all noise"),
                (
                    "metrics",
                    "",
                    "The metrics by name; a metric without a meaning in the scene is absent, and an infinite statistic is null",
                ),
                (
                    "expect",
                    "",
                    "The expectations: `metric`, `value`, `limit`, `pass`, `source`; for a comparison also `case` and `match`; \
                     `counts` is false for one inherited from a base scene whose inputs were changed",
                ),
                (
                    "grid",
                    "",
                    "The grid, if the scene has one: `keys` and `metrics`, each with its value at every point, and `failures`",
                ),
                ("comparison", "", "The comparison, if the scene has one: its cases for each matched quantity"),
                (
                    "overlays_not_drawn",
                    "",
                    "Measured curves of the scene that match no figure of the run, with the reason, if there are any",
                ),
                (
                    "assumed",
                    "",
                    "Values of stack and contact that the user did not set: `key`, `value`, and `base`, the built-in scene that \
                     the value is from (absent for a default), if there are any",
                ),
                ("drive_hash", "", "As in `manifest.json`; absent for a contact study"),
                (
                    "solution",
                    "",
                    "Solution of a contact study: `method`, `why`, `order`, `steps_per_period`, `error_estimate`, \
                     `tolerance_met`, `warnings`; and `record_error_estimate`, if the tolerance applies to the record",
                ),
                ("runs", "1", "Number of completed runs, if there are several"),
                (
                    "variance",
                    "",
                    "Of a scene with distributions: the main `metric`, the `part` of its variance that each of its `keys` explains by \
                     itself, and the `rest`",
                ),
                ("interrupted", "", "`true` if the run was stopped before its end"),
            ]),
        },
        DataFile {
            name: "machine.json",
            of: "every run",
            meaning: "Figures that depend on the machine and differ from run to run; `--format json` contains them as `machine`. \
                      A figure that does not apply is absent",
            columns: machine,
        },
        DataFile {
            name: "trace.csv",
            of: "a driven run without `[trace]`",
            meaning: "The whole run, one row for every few blocks, 3000 at most",
            columns: overview,
        },
        DataFile {
            name: "trace.csv",
            of: "a driven run with `[trace]`",
            meaning: "The signals of `trace.signals`, one row for every `trace.every` samples from `trace.from_s` to \
                      `trace.to_s`; by `trace.format` also `trace.npy`, an array of records for NumPy, or `trace.parquet`",
            columns: signals(),
        },
        DataFile {
            name: "trace.csv",
            of: "a contact study",
            meaning: "The last periods, one row for each step of the method",
            columns: PERIODS.map(fixed).into(),
        },
        DataFile {
            name: "runs.csv",
            of: "a scene with `runs`",
            meaning: "One row for each run. After the seed, a column for each key of `[[vary]]` with the drawn value; after \
                      `locked`, one for each metric that any run has, empty if a run lacks it",
            columns: fields(&[
                ("run", "1", "Number of the run, from 1: `--run` with this number repeats it"),
                ("seed", "1", "Seed of the run"),
                ("locked", "1", "1 if the run reached a true lock, else 0"),
            ]),
        },
        DataFile {
            name: "stack.toml",
            of: "a design with piezoelectric rings",
            meaning: "Its equivalent circuit, with up to three further modes, as tables of a driven scene",
            columns: Vec::new(),
        },
        DataFile {
            name: "grid.csv",
            of: "a scene with `[grid]`",
            meaning: "One row for each point. Between its number and the hash, a column for each key and each metric; empty if \
                      the point lacks the metric",
            columns: fields(&[
                ("point", "1", "Number of the point, from 0; the last key changes fastest"),
                ("drive_hash", "", "Hash of every DAC code played; absent for a contact study"),
                ("fault_code", "1", "Fault that ended the run, or 0; absent for a contact study"),
                ("failure", "", "Reason that a point has no result"),
            ]),
        },
        DataFile {
            name: "report.html",
            of: "every run",
            meaning: "The report: tables, figures, all metrics and all inputs, in one self-contained page, with version, \
                      commit and command. It is identical, byte for byte, for every run of the same scene",
            columns: Vec::new(),
        },
    ]
}
