//! Columns of a friction measurement: their quantities, units and states.

use std::path::Path;

use crate::error::ImportError;
use crate::units::{Units, factor, numbers};
use columns::{Heading, Table, Unit, beginning};

/// Quantity of a column or of a part of a file name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    /// Time.
    Time,
    /// Displacement along the sliding.
    Displacement,
    /// Sliding speed.
    Velocity,
    /// Friction force; of the vibration ON or OFF if the name says so.
    Force(Option<bool>),
    /// Friction over normal force; of the vibration ON or OFF if the name says so.
    Mu(Option<bool>),
    /// Normal force.
    Normal,
    /// Vibration ON or OFF.
    State,
    /// Strength of the vibration: an amplitude, a voltage, a current, or a number.
    Level,
    /// Peak velocity of the vibration.
    Tip,
    /// Frequency of the vibration.
    Frequency,
}

impl Quantity {
    /// Returns the quantity of a name without its unit.
    pub(super) fn parse(name: &str) -> Option<Self> {
        let lower = name.to_lowercase().replace(['µ', 'μ'], "mu");
        let bare: String = lower.chars().filter(char::is_ascii_alphanumeric).collect();
        Some(match bare.as_str() {
            "t" | "time" | "zeit" => Quantity::Time,
            "x" | "s" | "displacement" | "position" | "slip" | "weg" => Quantity::Displacement,
            "v" | "velocity" | "speed" | "sliding" | "slidingspeed" | "slidingvelocity" | "beltspeed" => Quantity::Velocity,
            "f" | "ff" | "force" | "friction" | "frictionforce" | "ft" | "tangential" | "tangentialforce" => {
                Quantity::Force(None)
            }
            "mu" | "cof" | "frictioncoefficient" | "coefficientoffriction" => Quantity::Mu(None),
            "n" | "fn" | "normal" | "normalforce" | "load" => Quantity::Normal,
            "on" | "drive" | "vibration" | "ultrasound" | "state" | "onoff" | "us" => Quantity::State,
            "a" | "amp" | "amplitude" | "voltage" | "drivevoltage" | "u" | "current" | "level" | "drivelevel" => Quantity::Level,
            "tip" | "tipvelocity" | "tipspeed" | "vibrationvelocity" | "vibrationspeed" => Quantity::Tip,
            "freq" | "frequency" | "drivefrequency" => Quantity::Frequency,
            _ => {
                let (stem, on) = match bare.strip_suffix("off") {
                    Some(stem) => (stem, false),
                    None => (bare.strip_suffix("on")?, true),
                };
                match Self::parse(stem)? {
                    Quantity::Force(None) => Quantity::Force(Some(on)),
                    Quantity::Mu(None) => Quantity::Mu(Some(on)),
                    _ => return None,
                }
            }
        })
    }

    /// Returns the quantity of a heading. A state has no unit: with one, it is the strength of the
    /// vibration.
    fn from_heading(heading: &Heading) -> Option<Self> {
        match Self::parse(heading.name)? {
            Quantity::Level | Quantity::State if measures(heading, "m/s^2") => None,
            Quantity::State if heading.unit.is_some_and(|unit| Unit::parse(unit).is_some()) => Some(Quantity::Level),
            quantity => Some(quantity),
        }
    }

    /// Returns the SI unit; `None` for a state and a strength of the vibration.
    pub(super) fn base(self) -> Option<&'static str> {
        match self {
            Quantity::Time => Some("s"),
            Quantity::Displacement => Some("m"),
            Quantity::Velocity | Quantity::Tip => Some("m/s"),
            Quantity::Force(_) | Quantity::Normal => Some("N"),
            Quantity::Frequency => Some("Hz"),
            Quantity::Mu(_) => Some("1"),
            Quantity::State | Quantity::Level => None,
        }
    }
}

/// Returns `true` if the unit of a heading is one of this quantity.
fn measures(heading: &Heading, base: &str) -> bool {
    let units = heading.unit.zip(Unit::parse(base));
    units.and_then(|(unit, base)| Some(Unit::parse_like(unit, &base)?.measures_like(&base))).unwrap_or(false)
}

/// Returns the state of a word: `true` for ON.
pub(super) fn state(word: &str) -> Option<bool> {
    match word.to_lowercase().as_str() {
        "on" | "true" | "yes" | "1" => Some(true),
        "off" | "false" | "no" | "0" => Some(false),
        _ => None,
    }
}

/// Units of a ratio.
const RATIOS: [&str; 8] = ["", "1", "-", "n/n", "pa/pa", "dimensionless", "unitless", "none"];

/// Table with the quantities of its columns.
pub(super) struct Columns {
    pub(super) table: Table,
    pub(super) names: Vec<String>,
}

impl Columns {
    /// Parses the content of a file. `names` replaces its heading.
    pub(super) fn parse(bytes: &[u8], names: Option<&str>) -> Result<Self, ImportError> {
        let table = columns::parse(bytes, names)?;
        Ok(Columns { names: table.headings(), table })
    }

    /// Returns the heading of a column.
    pub(super) fn heading(&self, at: usize) -> Heading<'_> {
        Heading::new(&self.names[at], |name| Quantity::parse(name).is_some())
    }

    /// Returns the index of the first column of a quantity.
    pub(super) fn place(&self, wanted: Quantity) -> Option<usize> {
        self.places(wanted).first().copied()
    }

    /// Returns the indices of the columns of a quantity. `T [°C]` is not a time if there is
    /// `t [s]`.
    fn places(&self, wanted: Quantity) -> Vec<usize> {
        let mut places: Vec<usize> =
            (0..self.names.len()).filter(|at| Quantity::from_heading(&self.heading(*at)) == Some(wanted)).collect();
        if let Some(base) = wanted.base() {
            let fits = |at: &usize| self.heading(*at).unit.is_none() || measures(&self.heading(*at), base);
            if places.iter().any(fits) {
                places.retain(fits);
            }
        }
        places
    }

    /// Refuses two columns of one quantity.
    fn check_single(&self, wanted: Quantity) -> Result<(), ImportError> {
        match self.places(wanted)[..] {
            [first, second, ..] => {
                Err(ImportError::SameQuantity { first: self.names[first].clone(), second: self.names[second].clone() })
            }
            _ => Ok(()),
        }
    }

    /// Returns the values of a quantity in its SI unit; `None` if no column has it.
    pub(super) fn numbers(&self, wanted: Quantity, units: &Units) -> Result<Option<Vec<f64>>, ImportError> {
        let Some(at) = self.place(wanted) else { return Ok(None) };
        self.check_single(wanted)?;
        let heading = self.heading(at);
        let sign = if heading.negative { -1.0 } else { 1.0 };
        let scale = match wanted.base() {
            None => 1.0,
            // A ratio, also in percent.
            Some("1") => {
                let is_ratio = |unit: &&str| RATIOS.contains(&unit.to_lowercase().as_str());
                let unit = heading.unit.filter(|unit| !is_ratio(unit));
                0.01 * factor(&self.names[at], unit, "%")?.unwrap_or(100.0)
            }
            Some(base) => factor(&self.names[at], heading.unit, base)?
                .or_else(|| units.factor_to(base))
                .ok_or_else(|| unit_missing(format!("the column `{}`", self.names[at]), base))?,
        };
        Ok(Some(numbers(&self.table, at)?.into_iter().map(|value| sign * scale * value).collect()))
    }

    /// Returns the state of each row, `true` for ON; `None` if no column has it.
    pub(super) fn states(&self) -> Result<Option<Vec<bool>>, ImportError> {
        let all_words = |at: &usize| {
            let words = &self.table.columns[*at].words;
            words.len() == self.table.rows() && words.iter().all(|(_, word)| state(word).is_some())
        };
        let Some(at) = self.place(Quantity::State).or_else(|| (0..self.names.len()).find(all_words)) else { return Ok(None) };
        let column = &self.table.columns[at];
        let mut words = column.words.iter().peekable();
        let one = |(row, value): (usize, &f64)| {
            let word = words.next_if(|(at, _)| *at == row).map_or_else(|| value.to_string(), |(_, word)| word.clone());
            state(&word).ok_or_else(|| {
                let what = format!(
                    "the column `{}` is `{}`, not ON or OFF (or 1 or 0); correct the cell",
                    self.names[at],
                    beginning(&word)
                );
                ImportError::bad_row(&self.table, row, what)
            })
        };
        column.values.iter().enumerate().map(one).collect::<Result<_, _>>().map(Some)
    }

    /// Returns the error of a table whose columns do not suffice.
    pub(super) fn missing(&self, what: &str) -> ImportError {
        let names = self.names.iter().map(|name| beginning(name)).collect::<Vec<_>>().join("`, `");
        let seen = format!(
            "the columns are `{names}`: {what}. Known are t, x, v, F (friction), mu, N (normal force), state (ON or OFF), \
             amplitude or voltage, tip velocity and frequency; name the columns with `--columns`, such as \
             `--columns \"t [s], x [mm], F [N]\"`"
        );
        ImportError::UnknownForm { seen }
    }
}

/// Returns the error of a quantity without a unit.
pub(super) fn unit_missing(column: String, base: &str) -> ImportError {
    let help = format!(
        "write it in the heading or in `--columns`, such as `x [mm]`, `v [mm/s]`, `F [N]`, or give it with `--unit`, such as \
         `--unit {base}`"
    );
    ImportError::UnitMissing { column, help }
}

/// Returns the name of a file without its folder.
pub(super) fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}
