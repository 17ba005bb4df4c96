//! Touchstone files, version 1 (and the data of version 2): `.s1p` and `.s2p`.
//!
//! The option line is `# <frequency unit> <parameter> <format> R <ohm>`; the default is
//! `# GHz S MA R 50` (Touchstone File Format Specification, version 1.1, IBIS Open Forum). Comments
//! begin with `!`. A line of a two-port file contains S11, S21, S12, S22 in this order.

use num_complex::Complex64;

use crate::complex::polar;
use crate::error::ImportError;
use columns::{beginning, number};

/// Content of a file with one or two ports.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Touchstone {
    /// Number of the line of each point, from 1.
    pub(crate) lines: Vec<usize>,
    /// Frequencies of the points, Hz.
    pub(crate) hz: Vec<f64>,
    /// Parameters of each pair of ports: one, or four.
    pub(crate) parameters: Vec<Vec<Complex64>>,
    /// Kind of the parameters.
    pub(crate) kind: Kind,
    /// Reference resistance, ohm.
    pub(crate) ohm: f64,
    /// Description of the option line.
    pub(crate) found: String,
}

/// Kind of the parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Scattering parameters.
    S,
    /// Impedances relative to the reference resistance.
    Z,
    /// Admittances relative to the reference conductance.
    Y,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    RealImaginary,
    SizeAngle,
    DbAngle,
}

/// Option line of a file.
struct Options {
    factor: f64,
    kind: Kind,
    format: Format,
    ohm: f64,
}

/// Returns `true` if a text is Touchstone by its option line: after comments and blank lines, the
/// first line begins with `#` and names a frequency unit or a parameter format.
pub(crate) fn looks_like(text: &str) -> bool {
    let line = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('!') && !line.starts_with('['));
    let words = line.and_then(|line| line.strip_prefix('#')).map(str::to_uppercase).unwrap_or_default();
    let words: Vec<&str> = words.split_whitespace().collect();
    let known = |word: &&str| ["HZ", "KHZ", "MHZ", "GHZ"].contains(word);
    let format = |word: &&str| ["RI", "MA", "DB"].contains(word);
    (words.iter().any(known) || words.first() == Some(&"S")) && words.iter().any(format)
}

/// Reads a file with this number of ports; `None` determines it from the first line.
pub(crate) fn read(text: &str, ports: Option<usize>) -> Result<Touchstone, ImportError> {
    let mut options = None;
    let mut numbers: Vec<(usize, f64)> = Vec::new();
    let mut width = None;
    for (at, line) in text.lines().enumerate() {
        let line_number = at + 1;
        let bare = line.split('!').next().unwrap_or_default().trim();
        if bare.is_empty() || bare.starts_with('[') {
            // Keywords of version 2. The sweep ends at `[End]` or the noise data.
            if ["[end]", "[noise data]"].contains(&bare.to_lowercase().as_str()) {
                break;
            }
            continue;
        }
        if let Some(words) = bare.strip_prefix('#') {
            if options.is_none() {
                options = Some(option_line(words, line_number)?);
            }
            continue;
        }
        let fields: Vec<&str> = bare.split_whitespace().collect();
        width.get_or_insert(fields.len());
        for field in fields {
            let Some(value) = number(field, false) else {
                let what =
                    format!("`{}` is not a number; a Touchstone line contains numbers separated by blanks", beginning(field));
                return Err(ImportError::BadLine { line: line_number, what });
            };
            numbers.push((line_number, value));
        }
    }
    let options = options.unwrap_or(Options { factor: 1e9, kind: Kind::S, format: Format::SizeAngle, ohm: 50.0 });
    let width = match (ports, width) {
        (Some(1), _) | (None, Some(3)) => 3,
        (Some(2), _) | (None, Some(9)) => 9,
        (_, None) => return Err(ImportError::UnknownForm { seen: "Touchstone without a line of numbers".into() }),
        (_, Some(other)) => {
            let seen = format!("Touchstone with {other} numbers per line; known are one port (3 numbers) and two ports (9)");
            return Err(ImportError::UnknownForm { seen });
        }
    };
    points(&numbers, width, &options)
}

/// Splits the numbers into points.
fn points(numbers: &[(usize, f64)], width: usize, options: &Options) -> Result<Touchstone, ImportError> {
    if let Some((line, _)) = numbers.last().filter(|_| !numbers.len().is_multiple_of(width)) {
        let rest = numbers.len() % width;
        let what = format!(
            "the file ends within a point: {rest} of {width} numbers; a line is cut short, or the number of ports is different"
        );
        return Err(ImportError::BadLine { line: *line, what });
    }
    let mut file = Touchstone {
        lines: Vec::new(),
        hz: Vec::new(),
        parameters: vec![Vec::new(); (width - 1) / 2],
        kind: options.kind,
        ohm: options.ohm,
        found: String::new(),
    };
    for point in numbers.chunks_exact(width) {
        if let Some((line, _)) = point.iter().find(|(line, _)| *line != point[0].0).filter(|_| width == 3) {
            let what = "a point is split over two lines, as if a number were missing or added".to_owned();
            return Err(ImportError::BadLine { line: *line, what });
        }
        file.lines.push(point[0].0);
        file.hz.push(point[0].1 * options.factor);
        for (parameter, pair) in file.parameters.iter_mut().zip(point[1..].chunks_exact(2)) {
            parameter.push(complex(pair[0].1, pair[1].1, options.format));
        }
    }
    let format = match options.format {
        Format::RealImaginary => "real and imaginary parts",
        Format::SizeAngle => "magnitude and degrees",
        Format::DbAngle => "dB and degrees",
    };
    file.found = format!("Touchstone, {} port(s), {format}, {} ohm", if width == 3 { 1 } else { 2 }, options.ohm);
    Ok(file)
}

fn complex(first: f64, second: f64, format: Format) -> Complex64 {
    match format {
        Format::RealImaginary => Complex64::new(first, second),
        Format::SizeAngle => polar(first, second.to_radians()),
        Format::DbAngle => polar(libm::exp10(first.min(400.0) / 20.0), second.to_radians()),
    }
}

fn option_line(words: &str, line: usize) -> Result<Options, ImportError> {
    let mut options = Options { factor: 1e9, kind: Kind::S, format: Format::SizeAngle, ohm: 50.0 };
    let upper = words.to_uppercase();
    let mut words = upper.split_whitespace();
    while let Some(word) = words.next() {
        match word {
            "HZ" => options.factor = 1.0,
            "KHZ" => options.factor = 1e3,
            "MHZ" => options.factor = 1e6,
            "GHZ" => options.factor = 1e9,
            "S" => options.kind = Kind::S,
            "Z" => options.kind = Kind::Z,
            "Y" => options.kind = Kind::Y,
            "RI" => options.format = Format::RealImaginary,
            "MA" => options.format = Format::SizeAngle,
            "DB" => options.format = Format::DbAngle,
            "R" => match words.next().and_then(|ohm| number(ohm, false)).filter(|ohm| (1e-3..=1e6).contains(ohm)) {
                Some(ohm) => options.ohm = ohm,
                None => {
                    let what = "the option line has no reference resistance after `R`".to_owned();
                    return Err(ImportError::BadLine { line, what });
                }
            },
            other => {
                let what =
                    format!("the option line contains `{}`; known are Hz to GHz, S, Z, Y, RI, MA, DB, R", beginning(other));
                return Err(ImportError::BadLine { line, what });
            }
        }
    }
    Ok(options)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_formats_give_the_same_number() {
        let of = |text: &str| read(text, Some(1)).unwrap();
        let ri = of("! a VNA\n# Hz S RI R 50\n40000 0 -0.5\n");
        let ma = of("# kHz S MA R 50\n40 0.5 -90 ! remark\n");
        let db = of("# MHz S DB R 75\n0.04 -6.020599913279624 -90\n");
        for file in [&ma, &db] {
            assert!((file.hz[0] - 40e3).abs() < 1e-9 && (file.parameters[0][0] - ri.parameters[0][0]).norm_sqr() < 1e-24);
        }
        assert_eq!(db.ohm, 75.0);
    }

    #[test]
    fn the_default_is_gigahertz_magnitude_and_angle() {
        let file = read("0.00004 0.5 -90\n", Some(1)).unwrap();
        assert!((file.hz[0] - 40e3).abs() < 1e-9 && file.parameters[0][0].im == -0.5);
    }

    #[test]
    fn a_truncated_line_is_reported() {
        let error = read("# Hz S RI\n1 2 3\n2 3\n", Some(1)).unwrap_err().to_string();
        assert!(error.starts_with("line 3: the file ends within a point"), "{error}");
        let error = read("# Hz S RI\n1 2 3\n2 3 x\n", Some(1)).unwrap_err().to_string();
        assert!(error.starts_with("line 3: `x` is not a number"), "{error}");
    }

    #[test]
    fn two_ports_are_recognised_by_nine_numbers() {
        let file = read("# Hz S RI R 50\n1 2 3 4 5 6 7\n8 9\n", Some(2)).unwrap();
        assert_eq!((file.parameters.len(), file.parameters[1][0]), (4, Complex64::new(4.0, 5.0)));
        assert!(looks_like("! x\n\n# hz s ri r 50\n") && !looks_like("# f [Hz], R [ohm]\n"));
    }
}
