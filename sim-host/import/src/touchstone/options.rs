//! Option line and keywords of a Touchstone file.

use crate::error::ImportError;
use columns::{beginning, number};

use super::bad;

/// Kind of the parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    S,
    Z,
    Y,
    H,
    G,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    RealImaginary,
    SizeAngle,
    DbAngle,
}

/// Order of the four parameters of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    Column,
    Row,
    /// One parameter for 21 and 12.
    Triangle,
}

/// Option line and keywords of a file.
pub(super) struct Options {
    pub(super) factor: f64,
    pub(super) kind: Kind,
    pub(super) format: Format,
    /// Reference resistance of each port, ohm; that of the last applies to further ports.
    pub(super) ohm: Vec<f64>,
    /// `true` for version 2.
    pub(super) has_keywords: bool,
    pub(super) ports: Option<usize>,
    pub(super) order: Order,
    /// Stated number of points and its line.
    pub(super) points: Option<(usize, usize)>,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            factor: 1e9,
            kind: Kind::S,
            format: Format::SizeAngle,
            ohm: vec![50.0],
            has_keywords: false,
            ports: None,
            order: Order::Column,
            points: None,
        }
    }
}

/// Applies a keyword of version 2.
pub(super) fn keyword(name: &str, value: &str, line: usize, options: &mut Options) -> Result<(), ImportError> {
    let small = value.to_lowercase();
    let count = || value.parse::<usize>().map_err(|_| bad(line, format!("[{name}] has no number, but `{}`", beginning(value))));
    match (name, small.as_str()) {
        ("version", version) if version.starts_with("2.") => {}
        ("number of ports", _) => options.ports = Some(count()?),
        ("number of frequencies", _) => options.points = Some((count()?, line)),
        ("two-port data order", "21_12") if options.order != Order::Triangle => options.order = Order::Column,
        ("two-port data order", "12_21") if options.order != Order::Triangle => options.order = Order::Row,
        ("matrix format", "lower" | "upper") => options.order = Order::Triangle,
        ("matrix format", "full") | ("two-port data order", "21_12" | "12_21") => {}
        ("number of noise frequencies" | "network data", _) => {}
        ("mixed-mode order", _) => {
            return Err(bad(line, "[Mixed-Mode Order]: mixed-mode parameters are not supported; export single-ended ones"));
        }
        ("version" | "two-port data order" | "matrix format", _) => {
            return Err(bad(line, format!("[{name}] has the unknown value `{}`", beginning(value))));
        }
        _ => return Err(bad(line, format!("the keyword [{}] is unknown", beginning(name)))),
    }
    Ok(())
}

/// Checks a reference resistance, ohm.
pub(super) fn resistance(ohm: Option<f64>, line: usize) -> Result<f64, ImportError> {
    ohm.filter(|ohm| (1e-3..=1e6).contains(ohm))
        .ok_or_else(|| bad(line, "the reference resistance must be a number from 0.001 to 1e6 ohm"))
}

/// Applies the option line.
pub(super) fn option_line(words: &str, line: usize, options: &mut Options) -> Result<(), ImportError> {
    let upper = words.to_uppercase();
    let mut words = upper.split_whitespace().peekable();
    while let Some(word) = words.next() {
        match word {
            "HZ" => options.factor = 1.0,
            "KHZ" => options.factor = 1e3,
            "MHZ" => options.factor = 1e6,
            "GHZ" => options.factor = 1e9,
            "S" => options.kind = Kind::S,
            "Z" => options.kind = Kind::Z,
            "Y" => options.kind = Kind::Y,
            "H" => options.kind = Kind::H,
            "G" => options.kind = Kind::G,
            "RI" => options.format = Format::RealImaginary,
            "MA" => options.format = Format::SizeAngle,
            "DB" => options.format = Format::DbAngle,
            "R" => {
                let mut ohm = vec![resistance(words.next().and_then(|word| number(word, false)), line)?];
                while let Some(further) = words.peek().and_then(|word| number(word, false)) {
                    ohm.push(resistance(Some(further), line)?);
                    words.next();
                }
                options.ohm = ohm;
            }
            other => {
                let known = "known are Hz to GHz, S, Z, Y, H, G, RI, MA, DB, R";
                return Err(bad(line, format!("the option line contains `{}`; {known}", beginning(other))));
            }
        }
    }
    Ok(())
}
