//! Measured sweeps: from the text of a file to admittances over frequency, in the coordinates of
//! the instrument.

use std::ops::Range;
use std::path::Path;

use num_complex::Complex64;

use super::coordinate::{Coordinate, Topology};
use super::fixture::Fixture;
use super::options::Options;
use super::sweep;
use super::topology;
use crate::complex::polar;
use crate::error::ImportError;
use crate::quantity::{Known, Part, Quantity, Subject};
use crate::rows::means;
use crate::touchstone::{self, Parameters, Touchstone};
use crate::traces;
use crate::units::{numbers, to_si};
use columns::{Table, file};

/// Usual reference resistance of scattering parameters, ohm.
const Z0_OHM: f64 = 50.0;
/// Largest number of lines of a preamble.
const MAX_PREAMBLE_LINES: usize = 200;
/// Minimum number of points of a measured series next to a computed one.
const MIN_SERIES_POINTS: usize = 12;

/// Sweep of a transducer's admittance over frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Frequencies, Hz, in ascending order.
    pub hz: Vec<f64>,
    /// Admittance of the transducer at each frequency, S.
    pub admittance: Vec<Complex64>,
    /// Admittance as measured, including the fixture, S.
    pub seen: Vec<Complex64>,
    /// Network between transducer and instrument at each frequency; empty without a correction.
    pub fixture: Vec<Fixture>,
    /// Quantity that the instrument reads.
    pub coordinate: Coordinate,
    /// Inferred properties of the file, one sentence each.
    pub remarks: Vec<String>,
}

impl Measured {
    /// Reads the sweep of a file.
    ///
    /// # Errors
    /// Returns [`ImportError`], with the line or value that shows the reason.
    pub fn read(path: &Path, options: &Options) -> Result<Self, ImportError> {
        let bytes =
            file::read(path, file::MAX_DATA_BYTES).map_err(|source| ImportError::Unreadable { path: path.to_owned(), source })?;
        Self::parse(&path.to_string_lossy(), &bytes, options)
    }

    /// Parses the content of a file with this name.
    ///
    /// # Errors
    /// Returns [`ImportError`], as [`Measured::read`] does.
    pub fn parse(name: &str, bytes: &[u8], options: &Options) -> Result<Self, ImportError> {
        let small = name.to_lowercase();
        let ending = small.rsplit_once('.').and_then(|(_, end)| end.strip_prefix('s')?.strip_suffix('p')?.parse::<u32>().ok());
        if let Some(count) = ending.filter(|count| *count > 2) {
            return Err(ImportError::UnknownForm { seen: format!("Touchstone with {count} ports; known are one and two") });
        }
        let ports = ["s1p", "s2p"].iter().position(|end| small.ends_with(&format!(".{end}"))).map(|at| at + 1);
        let text = columns::text(bytes);
        match text {
            Ok(text) if ports.is_some() || touchstone::looks_like(&text) => {
                from_touchstone(touchstone::read(&text, ports)?, options)
            }
            _ => from_table(bytes, text.ok().as_deref(), options),
        }
    }

    /// Returns the instrument's reading for an admittance of the transducer at a point of the
    /// sweep, and its derivative by that admittance.
    pub(crate) fn reading(&self, at: usize, admittance: Complex64) -> (Complex64, Complex64) {
        let (seen, slope) = self.fixture.get(at).map_or((admittance, 1.0.into()), |fixture| fixture.seen(admittance));
        (self.coordinate.of(seen), self.coordinate.slope(seen) * slope)
    }

    /// Returns the readings of the instrument.
    pub(super) fn readings(&self) -> Vec<Complex64> {
        self.seen.iter().map(|y| self.coordinate.of(*y)).collect()
    }

    /// Returns the means of frequency and admittance over bins of rows, with the fixtures of their
    /// middles.
    pub(super) fn averaged(&self, bins: &[Range<usize>]) -> Self {
        let middle = |bin: &Range<usize>| self.fixture.get(bin.start.midpoint(bin.end)).copied();
        let [admittance, seen] = [&self.admittance, &self.seen].map(|values| means(values, bins));
        let fixture = bins.iter().filter_map(middle).collect();
        Measured { hz: means(&self.hz, bins), admittance, seen, fixture, coordinate: self.coordinate, remarks: Vec::new() }
    }

    /// Creates a sweep in order of frequency. The readings of an immittance are admittances.
    fn new(
        lines: &[usize],
        hz: Vec<f64>,
        readings: &[Complex64],
        coordinate: Coordinate,
        remarks: Vec<String>,
    ) -> Result<Self, ImportError> {
        let mut admittance = Vec::with_capacity(hz.len());
        for (reading, line) in readings.iter().zip(lines) {
            let y = if coordinate == Coordinate::Immittance { *reading } else { coordinate.admittance(*reading) };
            if y == Complex64::ZERO {
                return Err(ImportError::BadLine { line: *line, what: "an admittance of zero has no angle".into() });
            }
            // Extreme values would overflow later.
            let size = y.re.abs().max(y.im.abs());
            if size.is_nan() || size >= 1e12 {
                let what = format!("the value {reading} has no finite admittance, as for an ideal short or open");
                return Err(ImportError::BadLine { line: *line, what });
            }
            admittance.push(y);
        }
        sweep::ordered(lines, Measured { hz, seen: admittance.clone(), admittance, fixture: Vec::new(), coordinate, remarks })
    }
}

fn from_touchstone(file: Touchstone, options: &Options) -> Result<Measured, ImportError> {
    let mut remarks = file.remarks;
    let (coordinate, readings) = match &file.parameters {
        Parameters::Admittance(admittance) => (Coordinate::Immittance, admittance),
        Parameters::Scattering(parameters) => {
            let topology = match (options.topology, parameters.len()) {
                (Some(Topology::OnePort) | None, 1) => Topology::OnePort,
                (Some(given), 1) => {
                    let why = format!("a one-port file has no S21, which {given:?} needs");
                    return Err(ImportError::TopologyDoubtful { why });
                }
                (Some(given), _) => given,
                (None, _) => topology::found(parameters, &mut remarks)?,
            };
            (Coordinate::Scattering(topology, file.ohm), &parameters[usize::from(topology != Topology::OnePort)])
        }
    };
    Measured::new(&file.lines, file.hz, readings, coordinate, remarks)
}

/// Reads a table: text, or the bytes of another format.
fn from_table(bytes: &[u8], text: Option<&str>, options: &Options) -> Result<Measured, ImportError> {
    let columns = options.columns.as_deref();
    let traces = text.map_or(Ok(None), |text| traces::joined(text, columns))?;
    let table = traces.map_or_else(|| columns::parse(bytes, columns), Ok)?;
    let mut remarks = vec![format!("A table with {}", table.found)];
    let table = one_series(table, &mut remarks);
    let Some(names) = &table.names else {
        let seen = format!(
            "a table of {} columns without a heading; name them with `--columns`, such as `--columns \"f [Hz], |Z| [ohm], theta \
             [deg]\"`",
            table.columns.len()
        );
        return Err(ImportError::UnknownForm { seen });
    };
    let known: Vec<Option<Known>> = names.iter().map(|name| Known::parse(name)).collect();
    let column = |quantity: Quantity| {
        let has = |at: &usize| known[*at].as_ref().is_some_and(|known| known.quantity == quantity);
        // A column of few points next to curves has many empty cells.
        let is_sparse = |at: &usize| 2 * table.columns[*at].filled() < table.rows();
        (0..names.len()).filter(has).min_by_key(|at| (is_sparse(at), is_computed(&names[*at])))
    };
    // Two measured columns of one quantity cannot both be right.
    let twin = |at: usize| {
        let same = |other: &usize| {
            *other != at && known[*other].as_ref().map(|known| known.quantity) == known[at].as_ref().map(|known| known.quantity)
        };
        let counts = |other: &usize| !is_computed(&names[*other]) && 2 * table.columns[*other].filled() >= table.rows();
        (0..names.len()).filter(same).find(counts)
    };
    let mut take = |at: usize| -> Result<Vec<f64>, ImportError> {
        let mut values = numbers(&table, at)?;
        if let Some(known) = &known[at] {
            to_si(known, &mut values, &options.units, &mut remarks)?;
        }
        Ok(values)
    };
    let unknown = |what: &str| {
        let seen = format!(
            "the columns are `{}`: {what}. Known are f with |Z| and theta, |Y| and theta, R and X, G and B, or S11 or S21 as real \
             and imaginary part, or as magnitude or dB and phase; name the columns with `--columns`, such as `--columns \"f [Hz], \
             |Z| [ohm], theta [deg]\"`",
            names.iter().map(|name| columns::beginning(name)).collect::<Vec<_>>().join("`, `")
        );
        Err(ImportError::UnknownForm { seen })
    };
    let Some(at) = column(Quantity::Frequency) else { return unknown("no column is the frequency") };
    let frequency = at;
    let hz = take(at)?;
    // Both parts are of the same quantity; an angle that names none belongs to the first magnitude.
    let pairs = [(Part::Real, Part::Imaginary), (Part::Size, Part::Angle), (Part::Db, Part::Angle)];
    let subjects = [Subject::Impedance, Subject::Admittance, Subject::Reflection, Subject::Transmission];
    let pair =
        pairs.into_iter().flat_map(|pair| subjects.map(|subject| (pair, subject))).find_map(|((first, second), subject)| {
            let other = column(Quantity::Of(Some(subject), second));
            let own = column(Quantity::Of(Some(subject), first))?;
            // An angle that names no quantity belongs to a magnitude before it.
            let is_size = |at: &usize| {
                matches!(known[*at].as_ref().map(|known| known.quantity), Some(Quantity::Of(_, Part::Size | Part::Db)))
            };
            let is_own = |at: &usize| own < *at || !(0..*at).any(|at| is_size(&at));
            let any = || (second == Part::Angle).then(|| column(Quantity::Of(None, second)).filter(is_own)).flatten();
            Some((subject, first, own, other.or_else(any)?))
        });
    let Some((subject, part, first, second)) = pair else { return unknown("no two of them form a complex number") };
    if let Some((at, other)) = [frequency, first, second].into_iter().find_map(|at| Some((at, twin(at)?))) {
        return Err(ImportError::SameQuantity { first: names[at].clone(), second: names[other].clone() });
    }
    let (a, b) = (take(first)?, take(second)?);
    if let Some(row) = a.iter().position(|size| part == Part::Size && *size < 0.0) {
        return Err(ImportError::bad_row(&table, row, format!("the magnitude `{}` is negative", names[first])));
    }
    let values = a.iter().zip(&b).map(|(&a, &b)| match part {
        Part::Real => Complex64::new(a, b),
        Part::Db => polar(libm::exp10(a.min(400.0) / 20.0), b),
        _ => polar(a, b),
    });
    let values: Vec<Complex64> = values.collect();
    if let Some(row) = values.iter().position(|z| subject == Subject::Impedance && *z == Complex64::ZERO) {
        let what = format!("the impedance of `{}` and `{}` is 0, as of an ideal short", names[first], names[second]);
        return Err(ImportError::bad_row(&table, row, what));
    }
    let values = values.into_iter();
    let values: Vec<Complex64> = if subject == Subject::Impedance { values.map(|z| z.inv()).collect() } else { values.collect() };
    let computed =
        if [first, second].iter().any(|at| is_computed(&names[*at])) { ", which are computed and not measured" } else { "" };
    remarks.push(format!("Columns `{}` and `{}`{computed}", names[first], names[second]));
    let left_out: Vec<&str> = (0..names.len())
        .filter(|at| known[*at].is_none() && !table.columns[*at].words.is_empty())
        .map(|at| names[at].as_str())
        .collect();
    if !left_out.is_empty() {
        remarks.push(format!("Left out, because they are words: `{}`", left_out.join("`, `")));
    }
    let lines = if table.lines.is_empty() { (1..=hz.len()).collect() } else { table.lines.clone() };
    let coordinate = match subject {
        Subject::Impedance | Subject::Admittance => Coordinate::Immittance,
        _ => {
            let stated = text.and_then(reference_ohm).filter(|ohm| (ohm / Z0_OHM - 1.0).abs() > 1e-3);
            if let Some(ohm) = stated.filter(|_| options.z0_ohm.is_none()) {
                let seen = format!(
                    "the text above the table states a reference of {ohm} ohm; confirm it with `--z0 {ohm}`, or give another"
                );
                return Err(ImportError::UnknownForm { seen });
            }
            let z0_ohm = options.z0_ohm.unwrap_or(Z0_OHM);
            remarks.push(format!("Relative to {z0_ohm} ohm (`--z0`)"));
            Coordinate::Scattering(connection(subject, options.topology)?, z0_ohm)
        }
    };
    Measured::new(&lines, hz, &values, coordinate, remarks)
}

/// Returns `true` for a column that our own tables compute next to a measured one.
fn is_computed(name: &str) -> bool {
    name.contains("_true") || name.contains("_identified")
}

/// Returns the reference impedance in the text above a table, such as `Reference impedance: 75
/// ohm`.
fn reference_ohm(text: &str) -> Option<f64> {
    text.lines().take(MAX_PREAMBLE_LINES).find_map(|line| {
        let line = line.to_lowercase();
        let names = ["reference impedance", "system impedance", "reference resistance"];
        let rest = names.iter().find_map(|name| line.split_once(name))?.1;
        let number = rest[..rest.find("ohm").or_else(|| rest.find('ω'))?].trim_end();
        let (number, factor) = number.strip_suffix('k').map_or((number, 1.0), |number| (number.trim_end(), 1e3));
        let last = number.rsplit(|c: char| !(c.is_ascii_digit() || "+-.e".contains(c))).next()?;
        last.parse::<f64>().ok().map(|ohm| factor * ohm).filter(|ohm| *ohm > 0.0)
    })
}

/// Returns the rows of one series of a table with several, as our figures have: the measured series
/// if a circuit can be fitted to it, otherwise the longest.
fn one_series(table: Table, remarks: &mut Vec<String>) -> Table {
    let Some(at) = table.headings().iter().position(|name| name.eq_ignore_ascii_case("series")) else { return table };
    let mut series: Vec<(&str, Vec<usize>)> = Vec::new();
    for (row, name) in &table.columns[at].words {
        match series.iter_mut().find(|(known, _)| known == name) {
            Some((_, rows)) => rows.push(*row),
            None => series.push((name, vec![*row])),
        }
    }
    let is_measured = |(name, rows): &&(&str, Vec<usize>)| name.contains("measured") && rows.len() >= MIN_SERIES_POINTS;
    let longest = || series.iter().max_by_key(|(_, rows)| rows.len());
    let Some(one) = series.iter().find(is_measured).or_else(longest) else { return table };
    let computed = if one.0.contains("measured") { "" } else { ", which is computed and not measured" };
    remarks.push(format!("The series `{}` of {}{computed}", columns::beginning(one.0), series.len()));
    table.selected(&one.1)
}

/// Returns the connection in which a scattering parameter was measured.
fn connection(subject: Subject, given: Option<Topology>) -> Result<Topology, ImportError> {
    let doubtful = |why: &str| Err(ImportError::TopologyDoubtful { why: why.to_owned() });
    match (subject, given) {
        (Subject::Transmission, None) => doubtful("the table has S21, the transmission between two ports"),
        (Subject::Transmission, Some(Topology::OnePort)) => doubtful("the table has S21, which is not measured at one port"),
        (Subject::Transmission, Some(through)) => Ok(through),
        (_, None | Some(Topology::OnePort)) => Ok(Topology::OnePort),
        (_, Some(_)) => doubtful("the table has S11, the reflection at one port, but the connection needs S21"),
    }
}
