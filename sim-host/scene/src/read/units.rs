//! Units in key names: `speed_m_per_s` is a speed in m/s.
//!
//! A key in another unit is the most likely mistake. Accepting it silently would make all results
//! wrong.

/// A unit of measurement.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Unit {
    /// Symbol, for example `m/s`.
    pub(crate) symbol: String,
    /// Factor to the base unit, `None` if the name is ambiguous (`mohm`).
    scale: Option<f64>,
    dimension: String,
}

impl Unit {
    /// Creates a unit from its symbol, its factor to the base unit, and the base unit.
    pub(crate) fn new(symbol: &str, scale: f64, dimension: &str) -> Self {
        Unit { symbol: symbol.to_owned(), scale: Some(scale), dimension: dimension.to_owned() }
    }

    /// Returns the factor from this unit to another of the same quantity.
    pub(crate) fn factor_to(&self, other: &Self) -> Option<f64> {
        (self.dimension == other.dimension).then_some(self.scale? / other.scale?)
    }

    /// Returns `true` if both measure the same quantity.
    pub(crate) fn measures_like(&self, other: &Self) -> bool {
        self.dimension == other.dimension
    }
}

/// Units: spelling, symbol, base unit, and factor to the base unit.
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

/// SI prefixes as they appear in lower-case keys.
const PREFIXES: &[(&str, f64)] = &[("p", 1e-12), ("n", 1e-9), ("u", 1e-6), ("m", 1e-3), ("c", 1e-2), ("k", 1e3), ("g", 1e9)];

/// Splits a key into the name of a quantity and its unit, if the key ends in one.
pub(crate) fn split(key: &str) -> (&str, Option<Unit>) {
    let cuts = key.match_indices('_').filter(|(at, _)| *at > 0);
    cuts.filter_map(|(at, _)| Some((&key[..at], Some(unit(&key[at + 1..])?)))).next().unwrap_or((key, None))
}

/// Returns the unit with this spelling, in the notation of keys: `m_per_s`.
pub(crate) fn named(spelling: &str) -> Option<Unit> {
    unit(spelling)
}

fn unit(name: &str) -> Option<Unit> {
    let (above, below) = match name.strip_prefix("per_") {
        Some(below) => (None, Some(below)),
        None => name.split_once("_per_").map_or((Some(name), None), |(above, below)| (Some(above), Some(below))),
    };
    let above = above.map_or_else(|| Some(simple("1", "1", 1.0)), single)?;
    let Some(below) = below.map(denominator) else { return Some(above) };
    let below = below?;
    Some(Unit {
        symbol: format!("{}/{}", above.symbol, below.symbol),
        scale: above.scale.zip(below.scale).map(|(above, below)| above / below),
        dimension: format!("{}/{}", above.dimension, below.dimension),
    })
}

/// Returns the unit of a denominator, in which `h` is the hour and not the henry.
fn denominator(name: &str) -> Option<Unit> {
    if name == "h" { Some(simple("h", "s", 3600.0)) } else { single(name) }
}

fn single(name: &str) -> Option<Unit> {
    let find = |name: &str| UNITS.iter().find(|(spelling, ..)| *spelling == name);
    if let Some((_, symbol, base, scale)) = find(name) {
        return Some(simple(symbol, base, *scale));
    }
    let (prefix, scale) = PREFIXES.iter().find(|(prefix, _)| name.starts_with(prefix))?;
    let (_, symbol, base, _) =
        find(name.strip_prefix(prefix)?).filter(|(spelling, _, base, _)| spelling.eq_ignore_ascii_case(base))?;
    Some(match (*prefix, *base) {
        // No transducer is driven at millihertz.
        ("m", "Hz") => simple("MHz", base, 1e6),
        ("m", "ohm") => Unit { symbol: name.to_owned(), scale: None, dimension: (*base).to_owned() },
        ("g", _) => simple(&format!("G{symbol}"), base, *scale),
        _ => simple(&format!("{prefix}{symbol}"), base, *scale),
    })
}

fn simple(symbol: &str, base: &str, scale: f64) -> Unit {
    Unit { symbol: symbol.to_owned(), scale: Some(scale), dimension: base.to_owned() }
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
