//! Touchstone files, versions 1 and 2, with one or two ports.
//!
//! The option line is `# <frequency unit> <parameter> <format> R <ohm>`; the default is
//! `# GHz S MA R 50`. Comments begin with `!`. Version 2 has keywords in brackets. Source: IBIS
//! Open Forum, Touchstone File Format Specification, versions 1.1, 2.0 and 2.1.
//!
//! **Reference.** Version 1 normalises Z, Y, H and G by the reference resistance. Version 2 gives
//! them in ohm and siemens, and may have a reference of its own for each port.
//! All parameters of two ports are converted to scattering parameters.

mod options;
mod two_port;

use num_complex::Complex64;

use self::options::{Format, Kind, Options, Order, keyword, option_line, resistance};
use self::two_port::scattering;
use crate::complex::polar;
use crate::error::ImportError;
use columns::{beginning, is_overflow, number};

/// Content of a file with one or two ports.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Touchstone {
    /// Number of the line of each point, from 1.
    pub(crate) lines: Vec<usize>,
    /// Frequencies of the points, Hz.
    pub(crate) hz: Vec<f64>,
    /// Parameters of the file.
    pub(crate) parameters: Parameters,
    /// Reference resistance of scattering parameters, ohm.
    pub(crate) ohm: f64,
    /// Properties of the file, one sentence each.
    pub(crate) remarks: Vec<String>,
}

/// Parameters of each point.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Parameters {
    /// Reflection of one port, or S11, S21, S12, S22 of two.
    Scattering(Vec<Vec<Complex64>>),
    /// Admittance of one port, S.
    Admittance(Vec<Complex64>),
}

/// Numbers of a line, with its number.
type Row = (usize, Vec<f64>);

/// Returns `true` if a text is Touchstone: after comments and blank lines, the first line is the
/// keyword of version 2, or begins with `#` and names a frequency unit or a parameter format.
pub(crate) fn looks_like(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('!')).peekable();
    if lines.peek().is_some_and(|line| line.to_lowercase().starts_with("[version]")) {
        return true;
    }
    let words = lines.find_map(|line| line.strip_prefix('#').or((!line.starts_with('[')).then_some("")));
    let words = words.unwrap_or_default().to_uppercase();
    let words: Vec<&str> = words.split_whitespace().collect();
    let known = |word: &&str| ["HZ", "KHZ", "MHZ", "GHZ"].contains(word);
    let format = |word: &&str| ["RI", "MA", "DB"].contains(word);
    (words.iter().any(known) || words.first() == Some(&"S")) && words.iter().any(format)
}

fn bad(line: usize, what: impl Into<String>) -> ImportError {
    ImportError::BadLine { line, what: what.into() }
}

/// Reads a file. `ports` is the number of ports by the name of the file.
pub(crate) fn read(text: &str, ports: Option<usize>) -> Result<Touchstone, ImportError> {
    let mut options = Options::default();
    let mut rows: Vec<Row> = Vec::new();
    let (mut has_options, mut in_information, mut in_reference) = (false, false, false);
    let mut remarks = Vec::new();
    let mut reference: Option<Vec<f64>> = None;
    for (at, line) in text.lines().enumerate() {
        let line_number = at + 1;
        let bare = line.split('!').next().unwrap_or_default().trim();
        let mut values = bare;
        if let Some((name, value)) = bare.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
            let name = name.trim().to_lowercase();
            in_information = name == "begin information" || in_information && name != "end information";
            if in_information || name == "end information" {
                continue;
            }
            options.has_keywords = true;
            in_reference = name == "reference";
            match name.as_str() {
                "end" => break,
                "noise data" => {
                    remarks.push(format!("The noise data from line {line_number} on are not used"));
                    break;
                }
                "reference" => {
                    reference = Some(Vec::new());
                    values = value.trim();
                }
                _ => {
                    keyword(&name, value.trim(), line_number, &mut options)?;
                    continue;
                }
            }
        }
        if in_information || values.is_empty() {
            continue;
        }
        if let Some(words) = values.strip_prefix('#') {
            if !has_options {
                option_line(words, line_number, &mut options)?;
            }
            has_options = true;
            continue;
        }
        let number = |field: &str| {
            number(field, false).ok_or_else(|| {
                let what = match is_overflow(field) {
                    true => "is the overflow value of an instrument; delete the line, or measure again with another range",
                    false => "is not a number; a Touchstone line contains numbers separated by blanks",
                };
                bad(line_number, format!("`{}` {what}", beginning(field)))
            })
        };
        let numbers = values.split_whitespace().map(number).collect::<Result<Vec<f64>, _>>()?;
        match reference.as_mut().filter(|_| in_reference) {
            Some(reference) => {
                for ohm in numbers {
                    reference.push(resistance(Some(ohm), line_number)?);
                }
            }
            None => rows.push((line_number, numbers)),
        }
    }
    if !has_options && !rows.is_empty() {
        let seen = "Touchstone without its option line; add one with unit, parameters and format, such as `# Hz S RI R 50`";
        return Err(ImportError::UnknownForm { seen: seen.into() });
    }
    options.ohm = reference.unwrap_or(options.ohm);
    let width = width(&rows, ports, &options, &mut remarks)?;
    let numbers = points(&rows, width, &options, &mut remarks)?;
    converted(&numbers, width, &options, remarks)
}

/// Returns the count of numbers in a point: the keyword decides, then the first line, then the name
/// of the file.
fn width(rows: &[Row], ports: Option<usize>, options: &Options, remarks: &mut Vec<String>) -> Result<usize, ImportError> {
    let unknown = |seen: String| Err(ImportError::UnknownForm { seen });
    let Some((_, first)) = rows.first() else { return unknown("Touchstone without a line of numbers".into()) };
    let seen = match first.len() {
        // The lines of a point on several lines differ.
        3 if ports.is_none() || rows.get(1).is_none_or(|(_, second)| second.len() == 3) => Some(1),
        9 => Some(2),
        _ => None,
    };
    let found = match (options.ports, seen.or(ports)) {
        (Some(ports), _) | (None, Some(ports)) => ports,
        (None, None) => {
            let known = "numbers per line; known are one port (3 numbers) and two ports (9)";
            return unknown(format!("Touchstone with {} {known}", first.len()));
        }
    };
    if let Some(name) = ports.filter(|name| *name != found) {
        remarks.push(format!("The file has {found} port(s), although its name ends with .s{name}p"));
    }
    if let Some(count) = Some(options.ohm.len()).filter(|count| *count > 1 && *count != found || *count == 0) {
        return unknown(format!("Touchstone with {count} reference resistance(s) for {found} port(s)"));
    }
    match found {
        1 if matches!(options.kind, Kind::H | Kind::G) => unknown("H or G parameters of one port; they need two".into()),
        1 => Ok(3),
        2 if options.order == Order::Triangle => Ok(7),
        2 => Ok(9),
        other => unknown(format!("Touchstone with {other} ports; known are one and two")),
    }
}

/// Splits the rows into points, each of which begins a line. Noise parameters of version 1 are left
/// out: they have five numbers and begin at a frequency that is not above the last one.
fn points(rows: &[Row], width: usize, options: &Options, remarks: &mut Vec<String>) -> Result<Vec<Row>, ImportError> {
    let mut points: Vec<Row> = Vec::new();
    let mut rows = rows.iter().peekable();
    while let Some((line, numbers)) = rows.next() {
        let is_noise = points.last().is_some_and(|(_, last)| numbers.len() == 5 && numbers[0] <= last[0]);
        if is_noise && width == 9 && !options.has_keywords {
            remarks.push(format!("The noise parameters from line {line} on are not used"));
            break;
        }
        let mut point = numbers.clone();
        while width > 3
            && point.len() < width
            && let Some((_, more)) = rows.next()
        {
            point.extend(more);
        }
        if point.len() != width {
            let end = if rows.peek().is_none() && point.len() < width { "the file ends within a point: " } else { "" };
            return Err(bad(*line, format!("{end}{} of {width} numbers; a number is missing or added", numbers.len())));
        }
        points.push((*line, point));
    }
    match options.points {
        Some((stated, line)) if stated != points.len() => {
            Err(bad(line, format!("[Number of Frequencies] is {stated}, but the file has {} points", points.len())))
        }
        _ => Ok(points),
    }
}

/// Converts the numbers of all points to parameters.
fn converted(rows: &[Row], width: usize, options: &Options, mut remarks: Vec<String>) -> Result<Touchstone, ImportError> {
    let ohm = options.ohm[0];
    let references = [ohm, options.ohm[options.ohm.len() - 1]];
    let is_normalised = !options.has_keywords;
    let values = rows.iter().map(|(_, point)| {
        point[1..].chunks_exact(2).map(|pair| complex(pair[0], pair[1], options.format)).collect::<Vec<Complex64>>()
    });
    let parameters = if width == 3 {
        let values = values.map(|value| value[0]);
        let unit = if is_normalised { ohm } else { 1.0 };
        match options.kind {
            Kind::Z => Parameters::Admittance(values.map(|z| (unit * z).inv()).collect()),
            Kind::Y => Parameters::Admittance(values.map(|y| y / unit).collect()),
            _ => Parameters::Scattering(vec![values.collect()]),
        }
    } else {
        let mut all = vec![Vec::new(); 4];
        for (own, (line, _)) in values.zip(rows) {
            let matrix = match options.order {
                Order::Column => [[own[0], own[2]], [own[1], own[3]]],
                Order::Row => [[own[0], own[1]], [own[2], own[3]]],
                Order::Triangle => [[own[0], own[1]], [own[1], own[2]]],
            };
            let [[s11, s12], [s21, s22]] = scattering(matrix, options.kind, references, is_normalised);
            for (list, value) in all.iter_mut().zip([s11, s21, s12, s22]) {
                if !value.norm_sqr().is_finite() {
                    return Err(bad(*line, "the parameters have no finite scattering parameters"));
                }
                list.push(value);
            }
        }
        Parameters::Scattering(all)
    };
    let format = match options.format {
        Format::RealImaginary => "real and imaginary parts",
        Format::SizeAngle => "magnitude and degrees",
        Format::DbAngle => "dB and degrees",
    };
    let version = if options.has_keywords { 2 } else { 1 };
    let (ports, kind) = (if width == 3 { 1 } else { 2 }, options.kind);
    let reference = options.ohm.iter().map(f64::to_string).collect::<Vec<_>>().join(" and ");
    remarks.insert(0, format!("Touchstone {version}, {ports} port(s), {kind:?} parameters as {format}, {reference} ohm"));
    let (lines, hz) = rows.iter().map(|(line, point)| (*line, point[0] * options.factor)).unzip();
    Ok(Touchstone { lines, hz, parameters, ohm, remarks })
}

fn complex(first: f64, second: f64, format: Format) -> Complex64 {
    match format {
        Format::RealImaginary => Complex64::new(first, second),
        Format::SizeAngle => polar(first, second.to_radians()),
        Format::DbAngle => polar(libm::exp10(first.min(400.0) / 20.0), second.to_radians()),
    }
}

#[cfg(test)]
mod tests;
