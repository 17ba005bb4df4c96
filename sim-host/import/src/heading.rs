//! Recognition of column headings: the quantity that an analyser's name stands for, and the unit.

/// Quantity of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    /// Frequency.
    Frequency,
    /// Magnitude of the impedance.
    Impedance,
    /// Magnitude of the admittance.
    Admittance,
    /// Angle of impedance, admittance or reflection.
    Angle,
    /// Series resistance, the real part of the impedance.
    Resistance,
    /// Series reactance, the imaginary part of the impedance.
    Reactance,
    /// Parallel conductance, the real part of the admittance.
    Conductance,
    /// Parallel susceptance, the imaginary part of the admittance.
    Susceptance,
    /// Real part of a scattering parameter.
    ScatteringReal,
    /// Imaginary part of a scattering parameter.
    ScatteringImaginary,
    /// Magnitude of a scattering parameter in dB.
    ScatteringDb,
    /// Magnitude of a scattering parameter.
    ScatteringSize,
}

/// Dimension of a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dimension {
    /// Frequency in Hz.
    Frequency,
    /// Impedance in ohm.
    Impedance,
    /// Admittance in S.
    Admittance,
    /// Angle in rad.
    Angle,
    /// Number without a unit.
    None,
}

/// Unit of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unit {
    /// Dimension of the unit.
    pub(crate) dimension: Dimension,
    /// Factor to the SI unit.
    pub(crate) factor: f64,
}

/// Heading of a column.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Heading {
    /// Heading as in the file.
    pub(crate) text: String,
    /// Quantity of the column.
    pub(crate) quantity: Quantity,
    /// Unit, if the heading has one.
    pub(crate) unit: Option<Unit>,
}

impl Quantity {
    /// Returns the dimension of the quantity.
    pub(crate) fn dimension(self) -> Dimension {
        match self {
            Quantity::Frequency => Dimension::Frequency,
            Quantity::Impedance | Quantity::Resistance | Quantity::Reactance => Dimension::Impedance,
            Quantity::Admittance | Quantity::Conductance | Quantity::Susceptance => Dimension::Admittance,
            Quantity::Angle => Dimension::Angle,
            _ => Dimension::None,
        }
    }
}

/// Returns the unit with this name, such as `kHz`, `Ω`, `mS` or `deg`. The case of a prefix is
/// ignored if only one prefix makes sense.
pub(crate) fn unit(name: &str) -> Option<Unit> {
    let name = name.trim();
    let small = name.to_lowercase();
    let of = |dimension, factor| Some(Unit { dimension, factor });
    match small.as_str() {
        "deg" | "degree" | "degrees" | "°" | "grad" => return of(Dimension::Angle, std::f64::consts::PI / 180.0),
        "rad" | "radian" | "radians" => return of(Dimension::Angle, 1.0),
        _ => {}
    }
    let (stem, dimension) = ["hz", "ohms", "ohm", "ω", "siemens", "s"].into_iter().find_map(|end| {
        let stem = small.strip_suffix(end)?;
        let dimension = match end {
            "hz" => Dimension::Frequency,
            "siemens" | "s" => Dimension::Admittance,
            _ => Dimension::Impedance,
        };
        Some((stem.trim(), dimension))
    })?;
    // Milli and mega differ only in case; a frequency in mHz and an admittance in MS do not occur.
    let mega = dimension == Dimension::Frequency || dimension == Dimension::Impedance && name.starts_with('M');
    let factor = match stem {
        "" => 1.0,
        "k" | "kilo" => 1e3,
        "g" | "giga" if dimension == Dimension::Frequency => 1e9,
        "m" if mega => 1e6,
        "meg" | "mega" => 1e6,
        "m" | "milli" => 1e-3,
        "µ" | "μ" | "u" | "micro" => 1e-6,
        "n" | "nano" => 1e-9,
        _ => return None,
    };
    of(dimension, factor)
}

/// Parses a heading; `None` if it is unknown.
pub(crate) fn heading(text: &str) -> Option<Heading> {
    let (name, given) = split(text);
    let by_unit = || given.filter(|unit| unit.dimension == Dimension::Angle).map(|_| Quantity::Angle);
    let quantity = quantity(&name).or_else(by_unit)?;
    Some(Heading { text: text.trim().to_owned(), quantity, unit: given.filter(|unit| unit.dimension == quantity.dimension()) })
}

/// Splits a heading into name and unit: `f [Hz]`, `R (ohm)`, `G/mS`, `theta_deg`, `Phase, degrees`.
fn split(text: &str) -> (String, Option<Unit>) {
    let text = text.trim().trim_matches('"').trim();
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}')] {
        if let Some((name, rest)) = text.rsplit_once(open)
            && let Some((inside, _)) = rest.split_once(close)
            && let Some(unit) = unit(inside)
        {
            return (name.trim().to_owned(), Some(unit));
        }
    }
    for sign in ['/', '_', ',', ' ', '-'] {
        if let Some((name, last)) = text.rsplit_once(sign)
            && !name.trim().is_empty()
            && let Some(unit) = unit(last)
        {
            return (name.trim().to_owned(), Some(unit));
        }
    }
    (text.to_owned(), None)
}

/// Returns the quantity of a name without its unit.
fn quantity(name: &str) -> Option<Quantity> {
    let small = name.to_lowercase();
    let bare: String = small.chars().filter(|c| c.is_alphanumeric() || "|'θφ".contains(*c)).collect();
    let scattering = ["s11", "s21", "gamma", "γ"].iter().any(|known| bare.contains(known));
    let has = |words: &[&str]| words.iter().any(|word| bare.contains(word));
    if scattering {
        return if has(&["ang", "phase", "arg", "deg", "rad"]) {
            Some(Quantity::Angle)
        } else if has(&["real", "re"]) {
            Some(Quantity::ScatteringReal)
        } else if has(&["imag", "im"]) {
            Some(Quantity::ScatteringImaginary)
        } else if has(&["db", "logmag"]) {
            Some(Quantity::ScatteringDb)
        } else {
            (has(&["mag", "abs", "lin"]) || bare.contains('|')).then_some(Quantity::ScatteringSize)
        };
    }
    Some(match bare.as_str() {
        "f" | "freq" | "frequency" | "frequenz" | "fréquence" | "hz" => Quantity::Frequency,
        "|z|" | "z" | "zabs" | "absz" | "zmag" | "magz" | "zmagnitude" | "impedance" | "impedanz" | "|impedance|" | "zmod" => {
            Quantity::Impedance
        }
        "|y|" | "y" | "yabs" | "absy" | "ymag" | "magy" | "admittance" | "admittanz" => Quantity::Admittance,
        "θ" | "φ" | "theta" | "thetaz" | "thetay" | "phase" | "phi" | "phasez" | "zphase" | "phasey" | "yphase" | "angle"
        | "argz" | "argy" | "anglez" | "zangle" | "zarg" | "thz" | "phasen" | "winkel" | "phaseangle" => Quantity::Angle,
        "r" | "rs" | "rez" | "zre" | "zreal" | "realz" | "z'" | "resistance" | "esr" => Quantity::Resistance,
        "x" | "xs" | "imz" | "zim" | "zimag" | "imagz" | "z''" | "reactance" => Quantity::Reactance,
        "g" | "gp" | "rey" | "yre" | "yreal" | "realy" | "conductance" => Quantity::Conductance,
        "b" | "bp" | "imy" | "yim" | "yimag" | "imagy" | "susceptance" => Quantity::Susceptance,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_of_analysers_are_recognised() {
        let cases = [
            ("Frequency (Hz)", Quantity::Frequency, Some(1.0)),
            ("Freq[kHz]", Quantity::Frequency, Some(1e3)),
            ("frequency_mhz", Quantity::Frequency, Some(1e6)),
            ("|Z| [Ω]", Quantity::Impedance, Some(1.0)),
            ("Z (kOhm)", Quantity::Impedance, Some(1e3)),
            ("Phase (deg)", Quantity::Angle, Some(std::f64::consts::PI / 180.0)),
            ("θ/°", Quantity::Angle, Some(std::f64::consts::PI / 180.0)),
            ("theta_rad", Quantity::Angle, Some(1.0)),
            ("Rs", Quantity::Resistance, None),
            ("G (mS)", Quantity::Conductance, Some(1e-3)),
            ("B [µS]", Quantity::Susceptance, Some(1e-6)),
            ("Re(S11)", Quantity::ScatteringReal, None),
            ("S11 imag", Quantity::ScatteringImaginary, None),
            ("S11 (dB)", Quantity::ScatteringDb, None),
        ];
        for (text, quantity, factor) in cases {
            let found = heading(text).unwrap_or_else(|| panic!("{text}"));
            assert_eq!((found.quantity, found.unit.map(|unit| unit.factor)), (quantity, factor), "{text}");
        }
        assert!(["", "Date", "Marker", "Cp"].iter().all(|text| heading(text).is_none()));
    }

    #[test]
    fn milli_and_mega_are_distinguished() {
        let factor = |name| unit(name).map(|unit| unit.factor);
        assert_eq!((factor("mS"), factor("MHz"), factor("mOhm"), factor("MOhm")), (Some(1e-3), Some(1e6), Some(1e-3), Some(1e6)));
    }
}
