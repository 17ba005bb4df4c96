//! Parameters of the board by name, with their values as text.

use firmware::board::command::{Command, Reply, Verb};
use firmware::board::parameters::{PARAMETERS, ParameterReport};
use firmware::seam::config::{Parameter, Range};

use crate::client::{Client, unexpected};
use crate::link_error::LinkError;
use crate::number_with_unit::{number_in, split};
use scene::nearest::{listed, nearest};
use scene::schema::unit_of;

/// Returns the parameter with this name.
pub fn parameter(name: &str) -> Result<&'static Parameter, LinkError> {
    PARAMETERS.iter().find(|parameter| parameter.name == name).ok_or_else(|| {
        let names = || PARAMETERS.iter().map(|parameter| parameter.name);
        // A name without its group is only suggested, not accepted.
        let ends: Vec<&str> = names().filter(|known| known.rsplit('.').next() == Some(name)).collect();
        let similar = if ends.is_empty() { nearest(name, names()) } else { ends };
        let hint = match similar.as_slice() {
            [] => "`settings get` lists all settings".to_owned(),
            similar => format!("did you mean {}?", listed(similar.iter().take(3).copied(), "or")),
        };
        LinkError::Input(format!("there is no setting `{name}`; {hint}"))
    })
}

/// Returns the parameters of this group, or the one with this name.
pub fn named(name: &str) -> Result<Vec<&'static Parameter>, LinkError> {
    let is_of_group = |parameter: &&Parameter| parameter.name.split_once('.').is_some_and(|(group, _)| group == name);
    let group: Vec<&Parameter> = PARAMETERS.iter().filter(is_of_group).collect();
    if group.is_empty() { parameter(name).map(|parameter| vec![parameter]) } else { Ok(group) }
}

/// Requests the board's report of a parameter.
pub fn report(parameter: &Parameter, client: &mut Client) -> Result<ParameterReport, LinkError> {
    match client.ask(Command::Settings(Verb::Get(parameter.key)))? {
        Reply::Parameter(report) => Ok(report),
        reply => Err(unexpected("settings get", &reply)),
    }
}

/// Reads the value of a parameter from text: a number, also with a unit, or one of its names.
pub fn read(parameter: &Parameter, text: &str) -> Result<f32, LinkError> {
    let (place, wanted) = match parameter.range {
        Range::Choice(names) => {
            (names.iter().position(|name| *name == text).map(|place| place as f32), listed(names.iter().copied(), "or"))
        }
        _ => (None, "a number, or `none` for a setting that may be absent".to_owned()),
    };
    let plain = || match text {
        "none" => Some(f32::INFINITY),
        text => text.parse().ok(),
    };
    if let Some(number) = place.or_else(plain) {
        return Ok(number);
    }
    let refused = match unit_of(parameter.name).filter(|_| split(text).is_some()).map(|unit| number_in(text, &unit)) {
        Some(Ok(number)) => return Ok(number as f32),
        Some(Err(why)) => format!("{}: {why}", parameter.name),
        None => format!("{} must be {wanted}, not `{text}`", parameter.name),
    };
    Err(LinkError::Usage(refused))
}

/// Returns a parameter's value as text.
pub fn shown(parameter: &Parameter, value: f32) -> String {
    match parameter.range {
        // A fractional value has no name.
        Range::Choice(names) => match names.iter().zip(0_u8..).find(|(_, place)| f32::from(*place) == value) {
            Some((name, _)) => (*name).to_owned(),
            None => number(value),
        },
        _ => number(value),
    }
}

fn number(value: f32) -> String {
    match value {
        // Negative infinity is not `none`.
        f32::INFINITY => "none".into(),
        _ if value.is_infinite() || value == 0.0 || (1e-3..1e6).contains(&value.abs()) => value.to_string(),
        _ => format!("{value:e}"),
    }
}

/// Returns the permitted values of a parameter as text.
pub fn range(parameter: &Parameter, min: f32, max: f32) -> String {
    match (parameter.range, max) {
        (Range::Choice(names), _) => listed(names.iter().copied(), "or"),
        (_, max) if min == max => "fixed by the image".into(),
        (_, max) if max.is_infinite() => format!("{} and more", number(min)),
        _ => format!("{} to {}", number(min), number(max)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_formatted() {
        let current = parameter("limits.current_a").unwrap();
        let shown = |min, max| range(current, min, max);
        assert_eq!(
            (shown(0.001, f32::INFINITY), shown(1e-12, 1e-3), shown(2.0, 2.0)),
            ("0.001 and more".into(), "1e-12 to 0.001".into(), "fixed by the image".into())
        );
        assert_eq!(range(parameter("burst.edge").unwrap(), 0.0, 2.0), "`hard`, `soft` or `boost`");
    }

    #[test]
    fn a_formatted_value_is_parsed_as_the_same_value() {
        for name in ["limits.power_w", "burst.edge", "friction.enabled"] {
            let parameter = parameter(name).unwrap();
            for value in [f32::INFINITY, f32::NEG_INFINITY, 0.0, 0.7, 1.0, -1.0, 300.0] {
                assert_eq!(read(parameter, &shown(parameter, value)).unwrap(), value, "{name}");
            }
        }
    }

    #[test]
    fn a_value_is_a_number_or_a_name() {
        let edge = parameter("burst.edge").unwrap();
        assert_eq!(["hard", "boost", "1", "7"].map(|text| read(edge, text).unwrap()), [0.0, 2.0, 1.0, 7.0]);
        assert_eq!(shown(edge, 2.0), "boost");
        assert_eq!(read(edge, "soft ").unwrap_err().to_string(), "burst.edge must be `hard`, `soft` or `boost`, not `soft `");
        let voltage = parameter("limits.voltage_v").unwrap();
        assert_eq!(["3.5", "3.5V", "3500 mV"].map(|text| read(voltage, text).unwrap()), [3.5; 3]);
        let current = read(voltage, "2A").unwrap_err().to_string();
        assert!(current.starts_with("limits.voltage_v: `A` is not a unit of this quantity"), "{current}");
        let limit = parameter("limits.power_w").unwrap();
        assert_eq!(["none", "1e2"].map(|text| read(limit, text).unwrap()), [f32::INFINITY, 100.0]);
        let refused = read(limit, "much").unwrap_err().to_string();
        assert_eq!(refused, "limits.power_w must be a number, or `none` for a setting that may be absent, not `much`");
    }
}
