//! Quantity of a column of an analyser's table, from the words of its heading: a part of an
//! impedance, an admittance or a scattering parameter.

use columns::{Heading, Unit};

/// Complex quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Subject {
    /// Impedance.
    Impedance,
    /// Admittance.
    Admittance,
    /// Scattering parameter S11.
    Reflection,
    /// Scattering parameter S21.
    Transmission,
}

/// Part of a complex quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Magnitude.
    Size,
    /// Magnitude in dB.
    Db,
    /// Angle.
    Angle,
    /// Real part.
    Real,
    /// Imaginary part.
    Imaginary,
}

/// Quantity of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    /// Frequency.
    Frequency,
    /// Part of a complex quantity; an angle need not name the quantity.
    Of(Option<Subject>, Part),
}

/// Heading of a column with a known quantity.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Known {
    /// Heading as in the file.
    pub(crate) text: String,
    /// Quantity of the column.
    pub(crate) quantity: Quantity,
    /// Unit as in the heading, if it has one; it may be unknown.
    pub(crate) unit: Option<String>,
    /// `true` if the column has the other sign.
    pub(crate) negative: bool,
}

impl Quantity {
    /// Returns the SI unit; `None` for a ratio.
    pub(crate) fn base(self) -> Option<&'static str> {
        match self {
            Quantity::Frequency => Some("Hz"),
            Quantity::Of(_, Part::Angle) => Some("rad"),
            Quantity::Of(_, Part::Db) => Some("dB"),
            Quantity::Of(Some(Subject::Impedance), _) => Some("ohm"),
            Quantity::Of(Some(Subject::Admittance), _) => Some("S"),
            Quantity::Of(..) => None,
        }
    }
}

impl Known {
    /// Parses a heading; `None` if its quantity is unknown.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let parts = Heading::new(text, |name| quantity(name).is_some());
        let measures = |base: &str| Some(Unit::parse(parts.unit?)?.measures_like(&Unit::parse(base)?));
        // The unit may be the only sign of the part: `S11 [dB]`, `S11 (deg)`.
        let by_unit =
            if measures("dB") == Some(true) { Some(Part::Db) } else { (measures("rad") == Some(true)).then_some(Part::Angle) };
        let quantity = match (quantity(parts.name), by_unit) {
            (Some(Quantity::Of(subject, Part::Size)), Some(Part::Db)) => Quantity::Of(subject, Part::Db),
            (Some(quantity), _) => quantity,
            (None, Some(part)) => Quantity::Of(subject(parts.name), part),
            (None, None) => return None,
        };
        let unit = parts.unit.map(str::to_owned);
        Some(Known { text: text.trim().to_owned(), quantity, unit, negative: parts.negative })
    }
}

/// Words of a heading that name no quantity.
const IGNORED_WORDS: [&str; 12] =
    ["trace", "trc", "tr", "ch", "data", "measured", "identified", "true", "value", "channel", "of", "meas"];

/// Returns the words of a name in lower case.
fn words(name: &str) -> Vec<String> {
    let lower = name.to_lowercase();
    let words = lower.split(|c: char| !(c.is_alphanumeric() || c == '\'')).filter(|word| !word.is_empty());
    words
        // `Trace 1`, `Trc1` and `Ch2` count the traces.
        .filter(|word| word.parse::<u8>().is_err())
        .filter(|word| !IGNORED_WORDS.contains(&word.trim_end_matches(|c: char| c.is_ascii_digit())))
        .map(str::to_owned)
        .collect()
}

/// Returns the complex quantity that a name contains.
fn subject(name: &str) -> Option<Subject> {
    words(name).iter().find_map(|word| word_of_subject(word))
}

fn word_of_subject(word: &str) -> Option<Subject> {
    match word {
        "z" | "impedance" | "impedanz" => Some(Subject::Impedance),
        "y" | "admittance" | "admittanz" => Some(Subject::Admittance),
        "s11" | "gamma" | "γ" | "reflection" => Some(Subject::Reflection),
        "s21" | "transmission" => Some(Subject::Transmission),
        _ => None,
    }
}

fn word_of_part(word: &str) -> Option<Part> {
    match word {
        "mag" | "magnitude" | "abs" | "absolute" | "modulus" | "mod" | "lin" | "betrag" => Some(Part::Size),
        "db" | "log" | "logmag" => Some(Part::Db),
        "phase" | "ang" | "angle" | "arg" | "theta" | "θ" | "φ" | "phi" | "th" | "winkel" | "phasen" | "phaseangle" => {
            Some(Part::Angle)
        }
        "re" | "real" | "'" => Some(Part::Real),
        "im" | "imag" | "imaginary" | "''" => Some(Part::Imaginary),
        _ => None,
    }
}

/// Returns subject and part of a word that names both, as `rs`, `zmag`, `rez` or `z''`.
fn word_of_both(word: &str) -> Option<(Subject, Part)> {
    match word {
        "r" | "rs" | "esr" | "resistance" => return Some((Subject::Impedance, Part::Real)),
        "x" | "xs" | "reactance" => return Some((Subject::Impedance, Part::Imaginary)),
        "g" | "gp" | "conductance" => return Some((Subject::Admittance, Part::Real)),
        "b" | "bp" | "susceptance" => return Some((Subject::Admittance, Part::Imaginary)),
        _ => {}
    }
    ["z", "y", "s11", "s21"].into_iter().find_map(|name| {
        let rest = word.strip_prefix(name).or_else(|| word.strip_suffix(name))?;
        Some((word_of_subject(name)?, word_of_part(rest)?))
    })
}

/// Returns the quantity of a name without its unit.
fn quantity(name: &str) -> Option<Quantity> {
    let words = words(name);
    if let [only] = &words[..]
        && ["f", "freq", "frequency", "frequenz", "fréquence", "hz"].contains(&only.as_str())
    {
        return Some(Quantity::Frequency);
    }
    let (mut subject, mut part) = (None, name.contains('|').then_some(Part::Size));
    for word in &words {
        let (of, is) = match (word_of_subject(word), word_of_part(word)) {
            (None, None) => word_of_both(word).map(|(of, is)| (Some(of), Some(is)))?,
            found => found,
        };
        if subject.is_some_and(|subject| of.is_some_and(|of| of != subject)) {
            return None;
        }
        subject = subject.or(of);
        part = match (part, is) {
            (known, None) => known,
            // A logarithm is in dB for a scattering parameter only.
            (None, Some(Part::Db)) if word == "log" && matches!(subject, Some(Subject::Impedance | Subject::Admittance)) => {
                return None;
            }
            (None, is) => is,
            (Some(Part::Size), Some(Part::Db)) if word == "log" && name.contains('|') => return None,
            (Some(Part::Size), Some(Part::Db)) | (Some(Part::Db), Some(Part::Size)) => Some(Part::Db),
            (Some(known), Some(is)) if known == is => Some(is),
            _ => return None,
        };
    }
    match (subject, part) {
        (None, Some(Part::Angle)) => Some(Quantity::Of(None, Part::Angle)),
        (Some(Subject::Impedance | Subject::Admittance), None) => Some(Quantity::Of(subject, Part::Size)),
        (Some(_), Some(part)) => Some(Quantity::Of(subject, part)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_of_analysers_are_recognised() {
        use Part::*;
        use Subject::*;
        let of = |subject, part| Quantity::Of(Some(subject), part);
        let cases = [
            ("Frequency (Hz)", Quantity::Frequency, Some("Hz")),
            ("Freq[kHz]", Quantity::Frequency, Some("kHz")),
            ("frequency_mhz", Quantity::Frequency, Some("mhz")),
            ("|Z| [Ω]", of(Impedance, Size), Some("Ω")),
            ("Z (kOhm)", of(Impedance, Size), Some("kOhm")),
            ("Trace |Z| (Ohm)", of(Impedance, Size), Some("Ohm")),
            ("Impedance Magnitude [Ohm]", of(Impedance, Size), Some("Ohm")),
            ("Impedance Phase [deg]", of(Impedance, Angle), Some("deg")),
            ("Phase (deg)", Quantity::Of(None, Angle), Some("deg")),
            ("Trace θ (deg)", Quantity::Of(None, Angle), Some("deg")),
            ("θ/°", Quantity::Of(None, Angle), Some("°")),
            ("theta_rad", Quantity::Of(None, Angle), Some("rad")),
            ("Rs", of(Impedance, Real), None),
            ("Trace Xs (Ohm)", of(Impedance, Imaginary), Some("Ohm")),
            ("Z''", of(Impedance, Imaginary), None),
            ("G (mS)", of(Admittance, Real), Some("mS")),
            ("B [µS]", of(Admittance, Imaginary), Some("µS")),
            ("Re(S11)", of(Reflection, Real), None),
            ("S21(IMAG)", of(Transmission, Imaginary), None),
            ("S11 (dB)", of(Reflection, Db), Some("dB")),
            ("S11 Phase(deg)", of(Reflection, Angle), Some("deg")),
            ("S11 log mag", of(Reflection, Db), None),
            ("Trace 1: Impedance: Magnitude (Ω)", of(Impedance, Size), Some("Ω")),
            ("re:Trc1_S11", of(Reflection, Real), None),
        ];
        for (text, quantity, unit) in cases {
            let found = Known::parse(text).unwrap_or_else(|| panic!("{text}"));
            assert_eq!((found.quantity, found.unit.as_deref(), found.negative), (quantity, unit, false), "{text}");
        }
        let turned = Known::parse("-Im(Z)/Ohm").unwrap();
        assert_eq!((turned.quantity, turned.negative), (of(Impedance, Imaginary), true));
        for text in ["", "Date", "Marker", "log|Z|", "log|Z| [ohm]", "Cp", "S11", "status", "Z of Y", "Re Im Z"] {
            assert_eq!(Known::parse(text), None, "{text}");
        }
    }
}
