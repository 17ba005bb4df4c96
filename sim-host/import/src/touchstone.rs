//! Touchstone files, versions 1 and 2, with one or two ports.
//!
//! The option line is `# <frequency unit> <parameter> <format> R <ohm>`; the default is
//! `# GHz S MA R 50`. Comments begin with `!`. Version 2 has keywords in brackets. Source: IBIS
//! Open Forum, Touchstone File Format Specification, versions 1.1, 2.0 and 2.1.
//!
//! **Reference.** Version 1 normalises Z, Y, H and G by the reference resistance. Version 2 gives
//! them in ohm and siemens, and may have a reference of its own for each port.
//!
//! **Two ports.** All parameters are converted to scattering parameters against the reference of
//! port 1. With voltages `v` and currents `i` into the ports, they are a relation `P v + Q i = 0`:
//!
//! ```text
//! Z  v = Z i     H  (v1, i2) = H (i1, v2)
//! Y  i = Y v     G  (i1, v2) = G (v1, i2)
//! v = d (a + b),  i = (a - b) / d,  d = sqrt R:   (P d - Q / d) b = -(P d + Q / d) a
//! ```

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

/// Kind of the parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    S,
    Z,
    Y,
    H,
    G,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    RealImaginary,
    SizeAngle,
    DbAngle,
}

/// Order of the four parameters of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    Column,
    Row,
    /// One parameter for 21 and 12.
    Triangle,
}

/// Option line and keywords of a file.
struct Options {
    factor: f64,
    kind: Kind,
    format: Format,
    /// Reference resistance of each port, ohm; that of the last applies to further ports.
    ohm: Vec<f64>,
    /// `true` for version 2.
    has_keywords: bool,
    ports: Option<usize>,
    order: Order,
    /// Stated number of points and its line.
    points: Option<(usize, usize)>,
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
    let mut options = Options {
        factor: 1e9,
        kind: Kind::S,
        format: Format::SizeAngle,
        ohm: vec![50.0],
        has_keywords: false,
        ports: None,
        order: Order::Column,
        points: None,
    };
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
                let what = "is not a number; a Touchstone line contains numbers separated by blanks";
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

/// Matrix of two ports.
type Matrix = [[Complex64; 2]; 2];

/// Returns the scattering parameters of two ports against the reference of port 1, not finite if
/// there are none. `ohm` contains the references of the ports, ohm.
fn scattering(own: Matrix, kind: Kind, ohm: [f64; 2], is_normalised: bool) -> Matrix {
    const ONE: Complex64 = Complex64::ONE;
    const ZERO: Complex64 = Complex64::ZERO;
    let [[a, b], [c, d]] = own;
    let (p, q) = match kind {
        Kind::S => return renormalised(own, ohm),
        Kind::Z => ([[ONE, ZERO], [ZERO, ONE]], [[-a, -b], [-c, -d]]),
        Kind::Y => (own, [[-ONE, ZERO], [ZERO, -ONE]]),
        Kind::H => ([[ONE, -b], [ZERO, -d]], [[-a, ZERO], [-c, ONE]]),
        Kind::G => ([[-a, ZERO], [-c, ONE]], [[ONE, -b], [ZERO, -d]]),
    };
    // Normalised parameters belong to ports with a reference of one.
    let root = if is_normalised { 1.0 } else { ohm[0].sqrt() };
    let term = |row: usize, column: usize, sign: f64| p[row][column] * root + sign * q[row][column] / root;
    let [left, right] = [-1.0, 1.0].map(|sign| [0, 1].map(|row| [0, 1].map(|column| term(row, column, sign))));
    let determinant = left[0][0] * left[1][1] - left[0][1] * left[1][0];
    let inverse = [[left[1][1], -left[0][1]], [-left[1][0], left[0][0]]];
    let entry = |row: usize, column: usize| -(inverse[row][0] * right[0][column] + inverse[row][1] * right[1][column]);
    let found = [0, 1].map(|row| [0, 1].map(|column| entry(row, column) / determinant));
    if is_normalised { renormalised(found, ohm) } else { found }
}

/// Converts scattering parameters so that port 2 has the reference of port 1.
fn renormalised([[s11, s12], [s21, s22]]: Matrix, ohm: [f64; 2]) -> Matrix {
    let step = (ohm[0] - ohm[1]) / (ohm[0] + ohm[1]);
    let [back, through] = [step, (1.0 - step * step).sqrt()].map(|part| part / (1.0 - step * s22));
    [[s11 + s12 * s21 * back, s12 * through], [s21 * through, (s22 - step) / (1.0 - step * s22)]]
}

fn complex(first: f64, second: f64, format: Format) -> Complex64 {
    match format {
        Format::RealImaginary => Complex64::new(first, second),
        Format::SizeAngle => polar(first, second.to_radians()),
        Format::DbAngle => polar(libm::exp10(first.min(400.0) / 20.0), second.to_radians()),
    }
}

/// Applies a keyword of version 2.
fn keyword(name: &str, value: &str, line: usize, options: &mut Options) -> Result<(), ImportError> {
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

fn resistance(ohm: Option<f64>, line: usize) -> Result<f64, ImportError> {
    ohm.filter(|ohm| (1e-3..=1e6).contains(ohm))
        .ok_or_else(|| bad(line, "the reference resistance must be a number from 0.001 to 1e6 ohm"))
}

fn option_line(words: &str, line: usize, options: &mut Options) -> Result<(), ImportError> {
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

#[cfg(test)]
mod tests {
    use super::*;

    const OHM: [f64; 2] = [75.0, 20.0];
    const FORMATS: [Format; 3] = [Format::RealImaginary, Format::SizeAngle, Format::DbAngle];

    /// Returns the matrix of two ports, `gain` is Z12 over Z21.
    fn matrix(kind: Kind, gain: f64, [r1, r2]: [f64; 2]) -> Matrix {
        let [a, c, d] = [(140.0, 37.0), (110.0, 25.0), (118.0, -15.0)].map(|(re, im)| Complex64::new(re, im));
        let b = gain * c;
        let z = [[a, b], [c, d]];
        let det = a * d - b * c;
        match kind {
            Kind::Z => z,
            Kind::Y => [[d / det, -b / det], [-c / det, a / det]],
            Kind::H => [[det / d, b / d], [-c / d, d.inv()]],
            Kind::G => [[a.inv(), -b / a], [c / a, det / a]],
            Kind::S => {
                let whole = (a + r1) * (d + r2) - b * c;
                let through = 2.0 * (r1 * r2).sqrt() / whole;
                [[((a - r1) * (d + r2) - b * c) / whole, b * through], [c * through, ((a + r1) * (d - r2) - b * c) / whole]]
            }
        }
    }

    /// Version, order of the parameters, and triangle of the matrix.
    type Variant = (u32, Option<&'static str>, Option<&'static str>);

    /// Returns a file with one point.
    fn file(kind: Kind, gain: f64, format: Format, (version, order, triangle): Variant) -> String {
        let [r1, r2] = OHM;
        let root = (r1 * r2).sqrt();
        let unit = match kind {
            _ if version == 2 => [[1.0; 2]; 2],
            Kind::S => [[1.0; 2]; 2],
            Kind::Z => [[r1, root], [root, r2]],
            Kind::Y => [[1.0 / r1, 1.0 / root], [1.0 / root, 1.0 / r2]],
            Kind::H => [[r1, root / r2], [root / r2, 1.0 / r2]],
            Kind::G => [[1.0 / r1, root / r1], [root / r1, r2]],
        };
        let own = matrix(kind, gain, OHM);
        let pair = |(row, column): (usize, usize)| {
            let value = own[row][column] / unit[row][column];
            let (size, degrees) = (value.norm_sqr().sqrt(), crate::complex::angle(value).to_degrees());
            match format {
                Format::RealImaginary => format!("{:e} {:e}", value.re, value.im),
                Format::SizeAngle => format!("{size:e} {degrees:e}"),
                Format::DbAngle => format!("{:e} {degrees:e}", 20.0 * size.log10()),
            }
        };
        let places: &[(usize, usize)] = match (triangle, order) {
            (Some("Lower"), _) => &[(0, 0), (1, 0), (1, 1)],
            (Some(_), _) => &[(0, 0), (0, 1), (1, 1)],
            (None, Some("12_21")) => &[(0, 0), (0, 1), (1, 0), (1, 1)],
            _ => &[(0, 0), (1, 0), (0, 1), (1, 1)],
        };
        let name = match format {
            Format::RealImaginary => "ri",
            Format::SizeAngle => "MA",
            Format::DbAngle => "dB",
        };
        let data: String = places.iter().map(|place| pair(*place) + "\n").collect();
        if version == 1 {
            return format!("! x\n# kHz {kind:?} {name} R {r1} {r2}\n40 {data}30 1 2 3 4\n");
        }
        let order = order.map(|order| format!("[Two-Port Data Order] {order}\n")).unwrap_or_default();
        let triangle = triangle.map(|triangle| format!("[MATRIX format] {triangle} ! half\n")).unwrap_or_default();
        format!(
            "[Version] 2.1\n{triangle}[Reference] {r1} ! x\n {r2}\n# kHz {kind:?} {name} R 33\n[Begin Information]\n[Owner] 7\n\
             [End Information]\n[number of ports] 2\n{order}[Number of Frequencies] 1\n[Number of Noise Frequencies] 1\n\
             [Network Data]\n40 {data}[Noise Data]\n30 1 2 3 4\n[End]\n1 2 3\n"
        )
    }

    #[test]
    fn every_version_parameter_format_and_order_gives_the_same_two_ports() {
        const VARIANTS: [Variant; 6] = [
            (1, None, None),
            (2, None, None),
            (2, Some("21_12"), None),
            (2, Some("12_21"), None),
            (2, None, Some("Lower")),
            (2, None, Some("upper")),
        ];
        for kind in [Kind::S, Kind::Z, Kind::Y, Kind::H, Kind::G] {
            for (format, variant) in FORMATS.into_iter().flat_map(|format| VARIANTS.map(|variant| (format, variant))) {
                let gain = if variant.2.is_some() { 1.0 } else { 1.5 };
                if gain == 1.0 && matches!(kind, Kind::H | Kind::G) {
                    continue;
                }
                let text = file(kind, gain, format, variant);
                let found = read(&text, Some(2)).unwrap_or_else(|error| panic!("{text}{error}"));
                let Parameters::Scattering(s) = &found.parameters else { panic!("{found:?}") };
                let [[s11, s12], [s21, s22]] = matrix(Kind::S, gain, [OHM[0]; 2]);
                let far = s.iter().zip([s11, s21, s12, s22]).map(|(found, expected)| (found[0] - expected).norm_sqr());
                assert!(far.fold(0.0, f64::max) < 1e-22 && (found.hz[0] - 40e3).abs() < 1e-9, "{text}{found:?}");
                assert_eq!((found.hz.len(), found.ohm, found.remarks.len()), (1, OHM[0], 2), "{text}");
            }
        }
    }

    #[test]
    fn one_port_parameters_are_normalised_in_version_1_only() {
        for (version, unit) in [("", 50.0), ("[Version] 2.0\n[Number of Ports] 1\n[Network Data]\n", 1.0)] {
            for (kind, value) in [("Z", 400.0 / unit), ("Y", 2.5e-3 * unit)] {
                let file = read(&format!("{version}# Hz {kind} RI R 50\n40000 {value} 0\n"), Some(1)).unwrap();
                let Parameters::Admittance(y) = &file.parameters else { panic!("{file:?}") };
                assert!((y[0] - 2.5e-3).norm_sqr() < 1e-30, "{version} {kind} {y:?}");
            }
        }
    }

    #[test]
    fn the_message_names_the_wrong_line() {
        let nine = "1 2 3 4 5 6 7 8 9\n";
        for (text, begins) in [
            ("# Hz S RI\n1 2 3\n2 3\n", "line 3: the file ends within a point: 2 of 3 numbers"),
            ("# Hz S RI\n1 2 3\n2 3\n3 4 5\n4 5 6\n", "line 3: 2 of 3 numbers; a number is missing"),
            ("# Hz S RI\n1 2 3\n2 3 4 5\n", "line 3: 4 of 3 numbers"),
            ("# Hz S RI\n1 2 3\n2 3 x\n", "line 3: `x` is not a number"),
            (&format!("{nine}2 2 3 4 5 6 7 8\n3{nine}"), "line 2: 8 of 9 numbers"),
            ("# Hz T RI\n1 2 3\n", "line 1: the option line contains `T`"),
            ("# Hz S RI R\n1 2 3\n", "line 1: the reference resistance"),
            ("[Version] 3.0\n", "line 1: [version] has the unknown value `3.0`"),
            ("[Version] 2.0\n[Colour] red\n", "line 2: the keyword [colour] is unknown"),
            ("[Version] 2.0\n[Mixed-Mode Order] D2,1\n", "line 2: [Mixed-Mode Order]"),
            ("[Version] 2.0\n[Number of Frequencies] 2\n[Network Data]\n1 2 3\n", "line 2: [Number of Frequencies] is 2"),
            ("[Version] 2.0\n[Number of Ports] 4\n[Network Data]\n1 2 3\n", "unknown format: Touchstone with 4 ports"),
            ("[Version] 2.0\n[Reference] 50 75\n[Network Data]\n1 2 3\n", "unknown format: Touchstone with 2 reference"),
            ("# Hz H RI R 50\n1 2 3\n", "unknown format: H or G parameters of one port"),
        ] {
            let error = read(text, None).unwrap_err().to_string();
            assert!(error.starts_with(begins), "{error}");
        }
    }

    #[test]
    fn content_and_not_the_name_decides_the_number_of_ports() {
        let file = read("0.00004 0.5 -90\n", Some(2)).unwrap();
        assert!((file.hz[0] - 40e3).abs() < 1e-9, "{file:?}");
        assert!(matches!(&file.parameters, Parameters::Scattering(s) if s[0][0].im == -0.5), "{file:?}");
        let file = read("# Hz S RI R 50\n1 2 3 4 5 6 7 8 9\n", Some(1)).unwrap();
        assert!(matches!(&file.parameters, Parameters::Scattering(s) if s[1][0] == Complex64::new(4.0, 5.0)), "{file:?}");
        assert!(file.remarks[1].starts_with("The file has 2 port(s), although its name ends with .s1p"), "{file:?}");
        assert!(looks_like("! x\n\n# hz s ri r 50\n") && looks_like("[Version] 2.0\n") && !looks_like("# f [Hz], R [ohm]\n"));
    }
}
