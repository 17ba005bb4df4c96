//! File of an example: Touchstone and tables, with the formats, units and conventions of many
//! instruments.

use std::fmt::Write as _;

use num_complex::Complex64;

use super::random::Random;
use crate::admittance::coordinate::{Coordinate, Topology};
use crate::complex::{angle, size};
use crate::units::Units;

/// Number format of a Touchstone file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Numbers {
    RealImaginary,
    SizeAngle,
    DbAngle,
}

/// Format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    OnePort(Numbers),
    TwoPort(Numbers),
    TableImpedanceDegrees,
    TableImpedanceRadians,
    TableResistance,
    TableConductance,
    TableReflection,
    TableReflectionDb,
}

impl Form {
    pub(super) fn is_touchstone(self) -> bool {
        matches!(self, Form::OnePort(_) | Form::TwoPort(_))
    }

    pub(super) fn ending(self) -> &'static str {
        match self {
            Form::OnePort(_) => "s1p",
            Form::TwoPort(_) => "s2p",
            _ => "csv",
        }
    }

    pub(super) fn called(self) -> &'static str {
        match self {
            Form::OnePort(_) => "Touchstone, one port",
            Form::TwoPort(_) => "Touchstone, two ports",
            Form::TableImpedanceDegrees => "table of |Z| and degrees",
            Form::TableImpedanceRadians => "table of |Z| and radians",
            Form::TableResistance => "table of R and X",
            Form::TableConductance => "table of G and B",
            Form::TableReflection => "table of S11, parts",
            Form::TableReflectionDb => "table of S11, dB",
        }
    }
}

/// Draws a format; the more usual ones more often.
pub(super) fn form(random: &mut Random) -> Form {
    let numbers = random.one(&[Numbers::RealImaginary, Numbers::SizeAngle, Numbers::DbAngle]);
    random.one(&[
        Form::OnePort(numbers),
        Form::OnePort(numbers),
        Form::TwoPort(numbers),
        Form::TwoPort(numbers),
        Form::TableImpedanceDegrees,
        Form::TableImpedanceDegrees,
        Form::TableImpedanceRadians,
        Form::TableResistance,
        Form::TableConductance,
        Form::TableReflection,
        Form::TableReflectionDb,
    ])
}

/// Returns the text of a file, and the units that it does not name. `style`, from 0 to 1, chooses
/// between conventions; `down` reverses the sweep.
pub(super) fn written(
    form: Form,
    style: f64,
    down: bool,
    hz: &[f64],
    admittance: &[Complex64],
    coordinate: Coordinate,
) -> (Vec<u8>, Units) {
    let mut points: Vec<(f64, Complex64)> = hz.iter().copied().zip(admittance.iter().copied()).collect();
    if down {
        points.reverse();
    }
    match form {
        Form::OnePort(numbers) | Form::TwoPort(numbers) => {
            (touchstone(numbers, style, &points, coordinate, form).into_bytes(), Units::default())
        }
        _ => table(form, style, &points, coordinate),
    }
}

fn touchstone(numbers: Numbers, style: f64, points: &[(f64, Complex64)], coordinate: Coordinate, form: Form) -> String {
    let choices = [("Hz", 1.0), ("kHz", 1e3), ("MHz", 1e6), ("GHz", 1e9)];
    let (unit, factor) = choices[((style * 4.0) as usize).min(3)];
    let name = match numbers {
        Numbers::RealImaginary => "RI",
        Numbers::SizeAngle => "MA",
        Numbers::DbAngle => "DB",
    };
    let ohm = match coordinate {
        Coordinate::Scattering(_, ohm) => ohm,
        Coordinate::Immittance => 50.0,
    };
    let mut text = format!("! A synthetic sweep\n# {unit} S {name} R {ohm}\n");
    let pair = |value: Complex64| match numbers {
        Numbers::RealImaginary => format!("{:.9e} {:.9e}", value.re, value.im),
        Numbers::SizeAngle => format!("{:.9e} {:.7}", size(value), angle(value).to_degrees()),
        Numbers::DbAngle => format!("{:.8} {:.7}", 20.0 * libm::log10(size(value)), angle(value).to_degrees()),
    };
    for (hz, y) in points {
        let value = coordinate.of(*y);
        let _ = match (form, coordinate) {
            (Form::TwoPort(_), Coordinate::Scattering(topology, _)) => {
                let other = if topology == Topology::SeriesThrough { 1.0 - value } else { value - 1.0 };
                let (own, through) = (pair(other), pair(value));
                writeln!(text, "{:.12} {own} {through} {through} {own}", hz / factor)
            }
            _ => writeln!(text, "{:.12} {}", hz / factor, pair(value)),
        };
    }
    text
}

fn table(form: Form, style: f64, points: &[(f64, Complex64)], coordinate: Coordinate) -> (Vec<u8>, Units) {
    let customs = [
        (";", true, "f [kHz]", 1e3),
        (";", false, "Frequency (Hz)", 1.0),
        (",", false, "Freq(Hz)", 1.0),
        ("\t", true, "Frequenz / Hz", 1.0),
        ("\t", false, "frequency_khz", 1e3),
        (",", false, "Frequency", 1.0),
    ];
    let (delimiter, comma, frequency, factor) = customs[((style * 6.0) as usize).min(5)];
    // The fraction chooses independently of the integer part.
    let fine = (style * 6.0).fract();
    let (kilo, ohm) = if fine < 0.3 { (1e3, "kOhm") } else { (1.0, "ohm") };
    let milli = if fine < 0.5 { (1e-3, "mS") } else { (1.0, "S") };
    let named = fine < 0.8;
    let unit = |name: &str, unit: &str| if named { format!("{name} ({unit})") } else { name.to_owned() };
    let (first, second) = match form {
        Form::TableImpedanceDegrees => (unit("|Z|", ohm), unit("theta", "deg")),
        Form::TableImpedanceRadians => (unit("Z", ohm), "Phase (rad)".to_owned()),
        Form::TableResistance => (unit("Rs", ohm), unit("Xs", ohm)),
        Form::TableConductance => (unit("G", milli.1), unit("B", milli.1)),
        Form::TableReflectionDb => ("S11 (dB)".to_owned(), "S11 phase (deg)".to_owned()),
        _ => ("Re(S11)".to_owned(), "Im(S11)".to_owned()),
    };
    let mut text = String::new();
    if fine < 0.4 {
        text += "# A synthetic instrument\n# Date: 1.1.2000\n\n";
    }
    let _ = writeln!(text, "{frequency}{delimiter}{first}{delimiter}{second}");
    for (hz, y) in points {
        let (a, b) = match form {
            Form::TableImpedanceDegrees => (size(y.inv()) / kilo, angle(y.inv()).to_degrees()),
            Form::TableImpedanceRadians => (size(y.inv()) / kilo, angle(y.inv())),
            Form::TableResistance => (y.inv().re / kilo, y.inv().im / kilo),
            Form::TableConductance => (y.re / milli.0, y.im / milli.0),
            Form::TableReflectionDb => {
                let value = coordinate.of(*y);
                (20.0 * libm::log10(size(value)), angle(value).to_degrees())
            }
            _ => (coordinate.of(*y).re, coordinate.of(*y).im),
        };
        let line = format!("{:.6}{delimiter}{a:.8e}{delimiter}{b:.8e}", hz / factor);
        text += &if comma { line.replace('.', ",") } else { line };
        text.push('\n');
    }
    let names: &[&str] = match form {
        _ if named => &[],
        Form::TableConductance => &[milli.1],
        Form::TableReflection | Form::TableReflectionDb => &[],
        Form::TableImpedanceDegrees => &[ohm, "deg"],
        _ => &[ohm],
    };
    (text.into_bytes(), Units::parse(names.iter().copied()).unwrap_or_default())
}
