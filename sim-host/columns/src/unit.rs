//! Units of measurement: in the names of keys, as `speed_m_per_s`, and as people write them, as
//! `mm/s`, `msec` or `kΩ`.
//!
//! An unknown unit is never replaced by another one: all results would be wrong.

/// A unit of measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// Symbol, for example `m/s`.
    pub symbol: String,
    /// Factor to the base unit; `None` if it may be milli or mega (`mohm`).
    scale: Option<f64>,
    dimension: String,
}

/// Acceleration of gravity as in the scenes, m/s^2.
const G_M_PER_S2: f64 = 9.81;
/// Weight of a kilogram, N (the standard gravity of ISO 80000-3).
const KILOGRAM_FORCE_N: f64 = 9.80665;
/// Units in keys: spelling, symbol, base unit, and factor to the base unit.
const UNITS: &[(&str, &str, &str, f64)] = &[
    ("s", "s", "s", 1.0),
    ("sec", "s", "s", 1.0),
    ("seconds", "s", "s", 1.0),
    ("min", "min", "s", 60.0),
    ("hz", "Hz", "Hz", 1.0),
    ("rpm", "rpm", "Hz", 1.0 / 60.0),
    ("v", "V", "V", 1.0),
    ("volts", "V", "V", 1.0),
    ("vpp", "V peak to peak", "V", 0.5),
    ("a", "A", "A", 1.0),
    ("app", "A peak to peak", "A", 0.5),
    ("a2", "A^2", "A^2", 1.0),
    ("k", "K", "K", 1.0),
    ("n", "N", "N", 1.0),
    ("m", "m", "m", 1.0),
    ("m15", "m^1.5", "m^1.5", 1.0),
    ("kg", "kg", "kg", 1.0),
    ("nm", "N m", "N m", 1.0),
    ("n_s", "N s", "N s", 1.0),
    ("kg_m2", "kg m^2", "kg m^2", 1.0),
    ("f", "F", "F", 1.0),
    ("h", "H", "H", 1.0),
    ("ohm", "ohm", "ohm", 1.0),
    ("ohms", "ohm", "ohm", 1.0),
    ("w", "W", "W", 1.0),
    ("j", "J", "J", 1.0),
    ("lsb", "LSB", "LSB", 1.0),
    ("turns", "turns", "turns", 1.0),
    ("deg", "degrees", "turns", 1.0 / 360.0),
    ("rad", "rad", "turns", 0.5 / std::f64::consts::PI),
];

/// Units that people write in addition: spelling, symbol, base unit, and factor to the base unit.
const WRITTEN: &[(&str, &str, &str, f64)] = &[
    ("secs", "s", "s", 1.0),
    ("second", "s", "s", 1.0),
    ("mins", "min", "s", 60.0),
    ("minute", "min", "s", 60.0),
    ("minutes", "min", "s", 60.0),
    ("hr", "h", "s", 3600.0),
    ("hour", "h", "s", 3600.0),
    ("hours", "h", "s", 3600.0),
    ("hertz", "Hz", "Hz", 1.0),
    ("volt", "V", "V", 1.0),
    ("amp", "A", "A", 1.0),
    ("amps", "A", "A", 1.0),
    ("ampere", "A", "A", 1.0),
    ("newton", "N", "N", 1.0),
    ("newtons", "N", "N", 1.0),
    ("kgf", "kgf", "N", KILOGRAM_FORCE_N),
    ("gf", "gf", "N", 1e-3 * KILOGRAM_FORCE_N),
    ("lbf", "lbf", "N", 0.453_592_37 * KILOGRAM_FORCE_N),
    ("meter", "m", "m", 1.0),
    ("metre", "m", "m", 1.0),
    ("meters", "m", "m", 1.0),
    ("metres", "m", "m", 1.0),
    ("micron", "um", "m", 1e-6),
    ("microns", "um", "m", 1e-6),
    ("in", "in", "m", 0.0254),
    ("inch", "in", "m", 0.0254),
    ("inches", "in", "m", 0.0254),
    ("ft", "ft", "m", 0.3048),
    ("mps", "m/s", "m/s", 1.0),
    ("m_s", "m/s", "m/s", 1.0),
    ("degree", "degrees", "turns", 1.0 / 360.0),
    ("degrees", "degrees", "turns", 1.0 / 360.0),
    ("mdeg", "mdeg", "turns", 1e-3 / 360.0),
    ("mrad", "mrad", "turns", 0.5e-3 / std::f64::consts::PI),
    ("radian", "rad", "turns", 0.5 / std::f64::consts::PI),
    ("radians", "rad", "turns", 0.5 / std::f64::consts::PI),
    ("siemens", "S", "S", 1.0),
    ("mho", "S", "S", 1.0),
    ("db", "dB", "dB", 1.0),
    ("%", "%", "1", 0.01),
];

/// SI prefixes; those of keys are in lower case.
const PREFIXES: &[(&str, f64)] =
    &[("p", 1e-12), ("n", 1e-9), ("u", 1e-6), ("m", 1e-3), ("c", 1e-2), ("k", 1e3), ("M", 1e6), ("g", 1e9)];
/// Names of prefixes that people write, and the prefixes.
const PREFIX_NAMES: &[(&str, &str)] =
    &[("pico", "p"), ("nano", "n"), ("micro", "u"), ("milli", "m"), ("centi", "c"), ("kilo", "k"), ("mega", "M"), ("meg", "M")];

impl Unit {
    /// Parses a unit as people write it: `mm/s`, `kN`, `m/s²`, `msec`, `mS`, or in the notation of
    /// keys, `mm_per_s`. Upper and lower case distinguish s from S, and milli from mega if both
    /// occur: `mohm`, `MOHM` and `MN` are ambiguous.
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.trim().replace("_per_", "/").replace('⁻', "-").replace('¹', "1");
        // `mm·s⁻¹`, `m s^-2`.
        if let Some((above, below)) = [("s^-1", "s"), ("s-1", "s"), ("s-²", "s²"), ("s^-2", "s²"), ("s-2", "s²")]
            .into_iter()
            .find_map(|(end, below)| Some((text.strip_suffix(end)?.trim_end_matches([' ', '·', '*', '.']), below)))
        {
            return Self::parse(&format!("{above}/{below}"));
        }
        match text.replace(['^', ' '], "").as_str() {
            "m/s2" | "m/s²" => return Some(simple("m/s^2", "m/s^2", 1.0)),
            "mm/s2" | "mm/s²" => return Some(simple("mm/s^2", "m/s^2", 1e-3)),
            "g" | "g0" | "G" => return Some(simple("g", "m/s^2", G_M_PER_S2)),
            _ => {}
        }
        match text.split_once('/') {
            None => cased(&text),
            Some(("" | "1", below)) => Some(simple("1", "1", 1.0).over(&cased_denominator(below)?)),
            Some((above, below)) => Some(cased(above)?.over(&cased_denominator(below)?)),
        }
    }

    /// Parses a unit of the quantity that `base` measures. If there is none, another quantity is
    /// returned. Headings in capitals or in lower case do not distinguish s from S.
    pub fn parse_like(text: &str, base: &Unit) -> Option<Self> {
        let first = Self::parse(text);
        let others = || [text.to_lowercase(), text.trim().replace('s', "S")].into_iter().filter_map(|text| Self::parse(&text));
        let fits = |unit: &Unit| unit.measures_like(base);
        first.clone().filter(fits).or_else(|| others().find(fits)).or(first)
    }

    /// Returns the factor from this unit to another of the same quantity; `None` if it is unknown.
    pub fn factor_to(&self, other: &Self) -> Option<f64> {
        (self.dimension == other.dimension).then_some(self.scale? / other.scale?)
    }

    /// Returns `true` if both measure the same quantity.
    pub fn measures_like(&self, other: &Self) -> bool {
        self.dimension == other.dimension
    }

    /// Returns `true` if the unit may be milli or mega.
    pub fn is_ambiguous(&self) -> bool {
        self.scale.is_none()
    }

    /// Returns this unit over another.
    fn over(self, below: &Unit) -> Self {
        Unit {
            symbol: format!("{}/{}", self.symbol, below.symbol),
            scale: self.scale.zip(below.scale).map(|(above, below)| above / below),
            dimension: format!("{}/{}", self.dimension, below.dimension),
        }
    }
}

/// Splits a key into the name of a quantity and its unit, if the key ends in one.
pub fn split(key: &str) -> (&str, Option<Unit>) {
    let cuts = key.match_indices('_').filter(|(at, _)| *at > 0);
    cuts.filter_map(|(at, _)| Some((&key[..at], Some(named(&key[at + 1..])?)))).next().unwrap_or((key, None))
}

/// Returns the unit with this spelling, in the notation of keys: `m_per_s`.
fn named(name: &str) -> Option<Unit> {
    let (above, below) = match name.strip_prefix("per_") {
        Some(below) => (None, Some(below)),
        None => name.split_once("_per_").map_or((Some(name), None), |(above, below)| (Some(above), Some(below))),
    };
    // In a key, `pa` is the pascal; picoamperes are written `pA`.
    let one = |above: &str| if above == "pa" { Some(simple("Pa", "Pa", 1.0)) } else { single(above, false) };
    let above = above.map_or_else(|| Some(simple("1", "1", 1.0)), one)?;
    match below {
        // In a denominator, `h` is the hour and not the henry.
        Some("h") => Some(above.over(&simple("h", "s", 3600.0))),
        Some(below) => Some(above.over(&single(below, false)?)),
        None => Some(above),
    }
}

fn cased_denominator(text: &str) -> Option<Unit> {
    if text.trim() == "h" { Some(simple("h", "s", 3600.0)) } else { cased(text) }
}

/// Returns the unit of a text without a denominator, whose case may have a meaning.
fn cased(text: &str) -> Option<Unit> {
    let text = text.trim();
    let lower = text.to_lowercase().replace(['µ', 'μ'], "u").replace('ω', "ohm").replace('°', "deg").replace(['*', ' ', '·'], "");
    let unit = match text {
        "nm" => simple("nm", "m", 1e-9),
        // German; in lower case it may be the gon.
        "Grad" => simple("degrees", "turns", 1.0 / 360.0),
        _ => match lower
            .strip_suffix('s')
            .filter(|prefix| text.ends_with('S') && (prefix.is_empty() || text.starts_with(char::is_lowercase)))
        {
            Some(prefix) if prefix.len() <= 1 => single(&format!("{prefix}siemens"), true)?,
            _ => single(&lower, true)?,
        },
    };
    let is_milli = unit.scale.is_none() || unit.scale == Some(1e-3) && unit.dimension == "N" && unit.symbol == "mN";
    if !is_milli {
        return Some(unit);
    }
    let (first, rest) = text.split_at_checked(1)?;
    let mixed = |wanted: fn(char) -> bool| rest.contains(|c: char| wanted(c) || "Ωω".contains(c));
    let scale = match first {
        "m" if mixed(char::is_uppercase) || unit.dimension == "N" => Some(1e-3),
        "M" if mixed(char::is_lowercase) => Some(1e6),
        _ => None,
    };
    Some(Unit { symbol: format!("{first}{}", unit.dimension), scale, ..unit })
}

/// Returns the unit with this spelling in lower case, with a prefix if it has one; also those of
/// [`WRITTEN`] and [`PREFIX_NAMES`] if `written`.
fn single(name: &str, written: bool) -> Option<Unit> {
    let find = |name: &str| UNITS.iter().chain(if written { WRITTEN } else { &[] }).find(|(spelling, ..)| *spelling == name);
    if let Some((_, symbol, base, scale)) = find(name) {
        return Some(simple(symbol, base, *scale));
    }
    // A prefix belongs to a base unit; in a key, only to its symbol.
    let coherent = |stem: &str| {
        find(stem).filter(|(spelling, _, base, scale)| *scale == 1.0 && (written || spelling.eq_ignore_ascii_case(base)))
    };
    let long =
        PREFIX_NAMES.iter().filter(|_| written).find_map(|(long, prefix)| Some((*prefix, coherent(name.strip_prefix(long)?)?)));
    let short = || PREFIXES.iter().find_map(|(prefix, _)| Some((*prefix, coherent(name.strip_prefix(prefix)?)?)));
    let is_short = long.is_none();
    let (prefix, (_, symbol, base, _)) = long.or_else(short)?;
    let scale = PREFIXES.iter().find(|(known, _)| *known == prefix)?.1;
    Some(match (prefix, *base) {
        // No transducer is driven at millihertz.
        ("m", "Hz") => simple("MHz", base, 1e6),
        ("m", "ohm") if is_short => Unit { symbol: name.to_owned(), scale: None, dimension: (*base).to_owned() },
        ("g", _) => simple(&format!("G{symbol}"), base, scale),
        _ => simple(&format!("{prefix}{symbol}"), base, scale),
    })
}

fn simple(symbol: &str, base: &str, scale: f64) -> Unit {
    Unit { symbol: symbol.to_owned(), scale: Some(scale), dimension: base.to_owned() }
}

/// Parses a frequency in hertz, also with a prefix and the unit, such as `40k` or `40kHz`; `None`
/// if it is not a number.
pub fn hertz(text: &str) -> Option<f64> {
    let text = text.trim();
    let text = ["Hz", "hz", "HZ"].iter().find_map(|unit| text.strip_suffix(unit)).unwrap_or(text).trim_end();
    let (number, factor) = match text.strip_suffix(['k', 'K', 'M']) {
        Some(number) => (number, if text.ends_with('M') { 1e6 } else { 1e3 }),
        None => (text, 1.0),
    };
    number.trim_end().parse::<f64>().ok().filter(|hz| hz.is_finite()).map(|hz| factor * hz)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factor(from: &str, to: &str) -> Option<f64> {
        let ((stem, from), (other, to)) = (split(from), split(to));
        assert_eq!(stem, other);
        from?.factor_to(&to?)
    }

    #[test]
    fn units_convert() {
        let near = |from, to, expected: f64| {
            let factor = factor(from, to).unwrap();
            assert!((factor / expected - 1.0).abs() < 1e-12, "{from} -> {to}: {factor}");
        };
        near("speed_mm_per_s", "speed_m_per_s", 1e-3);
        near("speed_km_per_h", "speed_m_per_s", 1.0 / 3.6);
        near("frequency_khz", "frequency_hz", 1e3);
        near("frequency_mhz", "frequency_hz", 1e6);
        near("duration_ms", "duration_s", 1e-3);
        near("belt_stop_s", "belt_stop_ms", 1e3);
        near("phase_trim_deg", "phase_trim_turns", 1.0 / 360.0);
        near("amplitude_vpp", "amplitude_v", 0.5);
        near("stiffness_n_per_um", "stiffness_n_per_m", 1e6);
        assert_eq!(factor("rm_mohm", "rm_ohm"), None);
        assert_eq!(factor("speed_mm", "speed_m_per_s"), None);
    }

    #[test]
    fn names_without_units_stay_whole() {
        for key in ["nominal_q", "mu", "adc_bits", "edge_cycles", "min", "s", "_s", "", "ä_ö"] {
            assert_eq!(split(key), (key, None));
        }
        assert_eq!(split("rate_per_s").0, "rate");
        assert_eq!(split("rate_per_s").1.unwrap().symbol, "1/s");
        assert_eq!(split("damping_n_s_per_m").1.unwrap().symbol, "N s/m");
    }
}
