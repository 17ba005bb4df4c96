//! Generated files: each version, parameter, format and order gives the same two ports.

use super::options::{Format, Kind};
use super::two_port::Matrix;
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
        (&format!("# Hz S RI\n{nine}2 2 3 4 5 6 7 8\n3{nine}"), "line 3: 8 of 9 numbers"),
        (nine, "unknown format: Touchstone without its option line"),
        ("# Hz T RI\n1 2 3\n", "line 1: the option line contains `T`"),
        ("# Hz S RI R\n1 2 3\n", "line 1: the reference resistance"),
        ("[Version] 3.0\n", "line 1: [version] has the unknown value `3.0`"),
        ("[Version] 2.0\n[Colour] red\n", "line 2: the keyword [colour] is unknown"),
        ("[Version] 2.0\n[Mixed-Mode Order] D2,1\n", "line 2: [Mixed-Mode Order]"),
        ("[Version] 2.0\n# Hz S RI\n[Number of Frequencies] 2\n[Network Data]\n1 2 3\n", "line 3: [Number of Frequencies] is 2"),
        ("[Version] 2.0\n# Hz S RI\n[Number of Ports] 4\n[Network Data]\n1 2 3\n", "unknown format: Touchstone with 4 ports"),
        ("[Version] 2.0\n# Hz S RI\n[Reference] 50 75\n[Network Data]\n1 2 3\n", "unknown format: Touchstone with 2 reference"),
        ("# Hz H RI R 50\n1 2 3\n", "unknown format: H or G parameters of one port"),
    ] {
        let error = read(text, None).unwrap_err().to_string();
        assert!(error.starts_with(begins), "{error}");
    }
}

#[test]
fn content_and_not_the_name_decides_the_number_of_ports() {
    let file = read("#\n0.00004 0.5 -90\n", Some(2)).unwrap();
    assert!((file.hz[0] - 40e3).abs() < 1e-9, "{file:?}");
    assert!(matches!(&file.parameters, Parameters::Scattering(s) if s[0][0].im == -0.5), "{file:?}");
    let file = read("# Hz S RI R 50\n1 2 3 4 5 6 7 8 9\n", Some(1)).unwrap();
    assert!(matches!(&file.parameters, Parameters::Scattering(s) if s[1][0] == Complex64::new(4.0, 5.0)), "{file:?}");
    assert!(file.remarks[1].starts_with("The file has 2 port(s), although its name ends with .s1p"), "{file:?}");
    assert!(looks_like("! x\n\n# hz s ri r 50\n") && looks_like("[Version] 2.0\n") && !looks_like("# f [Hz], R [ohm]\n"));
}
