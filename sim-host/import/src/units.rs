//! Units that a heading does not give: from an option, or inferred if only one makes sense.

use crate::error::ImportError;
use crate::heading::{Dimension, Heading, Quantity, Unit, unit};

/// Smallest series resonance that a scene can have, Hz. A frequency without a unit must be in the
/// same range.
const MIN_RESONANCE_HZ: f64 = 100.0;
/// Largest series resonance that a scene can have, Hz.
const MAX_RESONANCE_HZ: f64 = 450e3;
/// Units that a frequency can have.
const FREQUENCIES: [(&str, f64); 4] = [("Hz", 1.0), ("kHz", 1e3), ("MHz", 1e6), ("GHz", 1e9)];
/// Smallest maximum of angles in radians. The angle of a capacitor is close to a quarter turn.
const MIN_RADIANS: f64 = 1.0;
/// Largest maximum of angles that are taken as radians: half a turn.
const MAX_RADIANS: f64 = 3.15;
/// Maximum of angles above which they cannot be radians.
const IMPOSSIBLE_RADIANS: f64 = 6.3;
/// Largest angle in degrees.
const MAX_DEGREES: f64 = 360.0;

/// Units given by option, at most one per dimension.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Units(Vec<Unit>);

impl Units {
    /// Parses units by their names, such as `khz`, `ohm`, `mS`, `deg`.
    ///
    /// # Errors
    /// Returns an error for a name that is not a unit, or for the second unit of a dimension.
    pub fn parse<'a>(names: impl IntoIterator<Item = &'a str>) -> Result<Self, String> {
        let mut units: Vec<Unit> = Vec::new();
        for name in names {
            let unit =
                unit(name).ok_or_else(|| format!("`{name}` is not a unit; known are Hz, ohm, S with a prefix, deg, rad"))?;
            if units.iter().any(|known| known.dimension == unit.dimension) {
                return Err(format!("`{name}` is the second unit of its kind"));
            }
            units.push(unit);
        }
        Ok(Units(units))
    }

    fn get(&self, dimension: Dimension) -> Option<Unit> {
        self.0.iter().find(|unit| unit.dimension == dimension).copied()
    }
}

/// Converts a column to the SI unit, in place. Adds a remark if the unit was inferred.
pub(crate) fn to_si(heading: &Heading, values: &mut [f64], units: &Units, remarks: &mut Vec<String>) -> Result<(), ImportError> {
    let dimension = heading.quantity.dimension();
    let factor = match heading.unit.or(units.get(dimension)) {
        Some(unit) => unit.factor,
        None => found(heading, values, remarks)?,
    };
    values.iter_mut().for_each(|value| *value *= factor);
    Ok(())
}

/// Infers the factor of a column without a unit.
fn found(heading: &Heading, values: &[f64], remarks: &mut Vec<String>) -> Result<f64, ImportError> {
    let column = format!("the column `{}`", heading.text);
    match heading.quantity {
        Quantity::Frequency => {
            let (least, most) = values.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), &f| (least.min(f), most.max(f)));
            let fits = |factor: &f64| most * factor >= MIN_RESONANCE_HZ && least * factor <= MAX_RESONANCE_HZ;
            let fitting: Vec<_> = FREQUENCIES.iter().filter(|(_, factor)| fits(factor)).collect();
            match fitting[..] {
                [&(name, factor)] => {
                    remarks.push(format!("{column} has no unit: only {name} gives plausible frequencies of a transducer"));
                    Ok(factor)
                }
                _ => {
                    let names: Vec<_> = fitting.iter().map(|(name, _)| *name).collect();
                    let meant = if names.is_empty() { "none of Hz to GHz gives frequencies from 100 Hz to 450 kHz" } else { "" };
                    let meant = if meant.is_empty() { format!("it may be {}", names.join(" or ")) } else { meant.to_owned() };
                    Err(ImportError::UnitMissing {
                        column,
                        help: format!("{meant}; give it with `--unit`, such as `--unit khz`"),
                    })
                }
            }
        }
        Quantity::Angle => {
            let largest = values.iter().fold(0.0_f64, |most, angle| most.max(angle.abs()));
            if largest > IMPOSSIBLE_RADIANS && largest <= MAX_DEGREES {
                remarks.push(format!("{column} has no unit: angles up to {largest} are degrees"));
                Ok(std::f64::consts::PI / 180.0)
            } else if (MIN_RADIANS..=MAX_RADIANS).contains(&largest) {
                remarks
                    .push(format!("{column} has no unit: angles up to {largest} are radians; a capacitance has a quarter turn"));
                Ok(1.0)
            } else {
                Err(ImportError::AngleDoubtful { column, largest })
            }
        }
        _ if heading.quantity.dimension() == Dimension::None => Ok(1.0),
        Quantity::Conductance | Quantity::Susceptance | Quantity::Admittance => {
            Err(ImportError::UnitMissing { column, help: "give it with `--unit`, such as `--unit s` or `--unit ms`".into() })
        }
        _ => {
            Err(ImportError::UnitMissing { column, help: "give it with `--unit`, such as `--unit ohm` or `--unit kohm`".into() })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heading::heading;

    fn converted(name: &str, values: &[f64], units: &[&str]) -> Result<Vec<f64>, String> {
        let units = Units::parse(units.iter().copied())?;
        let mut values = values.to_vec();
        let heading = heading(name).ok_or("unknown")?;
        to_si(&heading, &mut values, &units, &mut Vec::new()).map_err(|error| error.to_string())?;
        Ok(values)
    }

    #[test]
    fn the_only_plausible_frequency_unit_is_inferred() {
        assert_eq!(converted("f", &[39e3, 41e3], &[]), Ok(vec![39e3, 41e3]));
        assert_eq!(converted("f", &[39.0, 41.0], &[]), Ok(vec![39e3, 41e3]));
        assert!(converted("f", &[150.0, 300.0], &[]).is_err_and(|error| error.contains("Hz or kHz")));
        assert_eq!(converted("f", &[150.0, 300.0], &["khz"]), Ok(vec![150e3, 300e3]));
    }

    #[test]
    fn degrees_and_radians_are_distinguished_or_refused() {
        let quarter = std::f64::consts::FRAC_PI_2;
        assert_eq!(converted("theta", &[-90.0, 80.0], &[]).map(|values| (values[0] + quarter).abs() < 1e-12), Ok(true));
        assert_eq!(converted("theta", &[-1.55, 1.2], &[]), Ok(vec![-1.55, 1.2]));
        assert!([[-0.4, 0.4], [-4.0, 2.0]].iter().all(|angles| converted("theta", angles, &[]).is_err()));
        assert_eq!(converted("theta", &[-0.4, 0.4], &["rad"]), Ok(vec![-0.4, 0.4]));
    }

    #[test]
    fn an_impedance_without_a_unit_is_refused() {
        assert!(converted("|Z|", &[1.0], &[]).is_err_and(|error| error.starts_with("unit missing: the column `|Z|`")));
    }
}
