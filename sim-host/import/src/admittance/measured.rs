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
use crate::heading::{Heading, Quantity, heading};
use crate::rows::means;
use crate::touchstone::{self, Parameters, Touchstone};
use crate::traces;
use crate::units::to_si;
use delimited::{decode, file};

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
        let text = decode(bytes);
        let small = name.to_lowercase();
        let ports = ["s1p", "s2p"].iter().position(|end| small.ends_with(&format!(".{end}"))).map(|at| at + 1);
        if ports.is_some() || touchstone::looks_like(&text) {
            from_touchstone(touchstone::read(&text, ports)?, options)
        } else {
            from_table(&text, options)
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

fn from_table(text: &str, options: &Options) -> Result<Measured, ImportError> {
    let columns = options.columns.as_deref();
    let table = match traces::joined(text, columns)? {
        Some(table) => table,
        None => delimited::read(text, columns)?,
    };
    let mut remarks = vec![format!("A table with {}", table.found)];
    let Some(names) = &table.header else {
        let seen = format!(
            "a table of {} columns without a heading; name them with `--columns`, such as `--columns \"f [Hz], |Z| [ohm], theta \
             [deg]\"`",
            table.columns.len()
        );
        return Err(ImportError::UnknownForm { seen });
    };
    let known: Vec<Option<Heading>> = names.iter().map(|name| heading(name)).collect();
    let column = |quantity: Quantity| {
        known.iter().position(|heading| heading.as_ref().is_some_and(|heading| heading.quantity == quantity))
    };
    let mut take = |quantity: Quantity| -> Result<Option<Vec<f64>>, ImportError> {
        let Some(at) = column(quantity) else { return Ok(None) };
        let mut values = table.columns[at].clone();
        if let Some(heading) = &known[at] {
            to_si(heading, &mut values, &options.units, &mut remarks)?;
        }
        Ok(Some(values))
    };
    let unknown = |what: &str| {
        let seen = format!(
            "the columns are `{}`: {what}. Known are f with |Z| and theta, |Y| and theta, R and X, G and B, or S11 as real and \
             imaginary part, or as magnitude or dB and phase; name the columns with `--columns`, such as `--columns \"f [Hz], \
             |Z| [ohm], theta [deg]\"`",
            names.iter().map(|name| delimited::beginning(name)).collect::<Vec<_>>().join("`, `")
        );
        Err(ImportError::UnknownForm { seen })
    };
    let has = |quantity| column(quantity).is_some();
    use Quantity::{
        Admittance, Angle, Conductance, Frequency, Impedance, Reactance, Resistance, ScatteringDb, ScatteringImaginary,
        ScatteringReal, ScatteringSize, Susceptance,
    };
    let Some(hz) = take(Frequency)? else { return unknown("no column is the frequency") };
    let pair = [
        (Resistance, Reactance),
        (Conductance, Susceptance),
        (ScatteringReal, ScatteringImaginary),
        (Impedance, Angle),
        (Admittance, Angle),
        (ScatteringSize, Angle),
        (ScatteringDb, Angle),
    ];
    let Some((first, second)) = pair.into_iter().find(|(first, second)| has(*first) && has(*second)) else {
        return unknown("no two of them form a complex number");
    };
    let (Some(a), Some(b)) = (take(first)?, take(second)?) else { return unknown("no two of them form a complex number") };
    let values: Vec<Complex64> = a
        .iter()
        .zip(&b)
        .map(|(&a, &b)| match first {
            Resistance | Conductance | ScatteringReal => Complex64::new(a, b),
            ScatteringDb => polar(libm::exp10(a.min(400.0) / 20.0), b),
            _ => polar(a, b),
        })
        .collect();
    remarks.push(format!("Columns `{}` and `{}`", named(&known, column(first)), named(&known, column(second))));
    match first {
        Conductance | Admittance => Measured::new(&table.lines, hz, &values, Coordinate::Immittance, remarks),
        Resistance | Impedance => {
            let values: Vec<_> = values.iter().map(|z| z.inv()).collect();
            Measured::new(&table.lines, hz, &values, Coordinate::Immittance, remarks)
        }
        _ => {
            let topology = options.topology.unwrap_or(Topology::OnePort);
            Measured::new(&table.lines, hz, &values, Coordinate::Scattering(topology, options.z0_ohm), remarks)
        }
    }
}

/// Returns the heading of a column as in the file.
fn named(known: &[Option<Heading>], at: Option<usize>) -> &str {
    at.and_then(|at| known[at].as_ref()).map_or("", |heading| &heading.text)
}
