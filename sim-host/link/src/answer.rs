//! Answers to commands: lines of text for a reader, and fields for programs.

use serde_json::{Map, Value, json};

use crate::link_error::LinkError;
use crate::refusal;

/// Answer to a command, as text and as fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    /// Name of the command.
    pub command: String,
    /// Text for a reader, in lines.
    pub text: String,
    /// Fields for programs and for `expect`: the names contain the unit, the values are in SI
    /// units.
    pub fields: Map<String, Value>,
}

impl Answer {
    /// Creates an empty answer to this command.
    pub fn to(command: &str) -> Self {
        Answer { command: command.to_owned(), ..Answer::default() }
    }

    /// Adds a line.
    pub fn line(mut self, line: impl AsRef<str>) -> Self {
        self.text += line.as_ref();
        self.text.push('\n');
        self
    }

    /// Adds a field.
    pub fn field(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.fields.insert(name.to_owned(), value.into());
        self
    }

    /// Returns the answer as one line of JSON.
    pub fn json(&self) -> String {
        let mut line = json!({ "command": self.command, "done": true });
        if let Some(object) = line.as_object_mut() {
            object.extend(self.fields.clone());
        }
        line.to_string()
    }
}

/// Returns the failure of a command as one line of JSON.
pub fn failure(command: &str, error: &LinkError) -> String {
    let refusal = if let LinkError::Refused { refusal, .. } = error.cause() { Some(refusal::name(*refusal)) } else { None };
    json!({ "command": command, "done": false, "error": error.to_string(), "refusal": refusal }).to_string()
}

/// Converts a number of the firmware to the shortest decimal number that is the same `f32`.
pub fn short(value: f32) -> Value {
    value.to_string().parse::<f64>().map_or(Value::Null, Value::from)
}

/// Formats a quantity with a prefix and its unit, to four digits.
pub fn quantity(value: f64, unit: &str) -> String {
    const PREFIXES: [(f64, &str); 8] =
        [(1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "u"), (1e-9, "n"), (1e-12, "p"), (1e-15, "f")];
    if value == 0.0 || !value.is_finite() {
        return format!("{value} {unit}");
    }
    let (scale, prefix) = PREFIXES.into_iter().find(|(scale, _)| value.abs() >= 0.99995 * scale).unwrap_or(PREFIXES[7]);
    // Rounded before the decimals are chosen, so that 99.996 is 100.0 and not 100.00.
    let scaled: f64 = format!("{:.3e}", value / scale).parse().unwrap_or(value / scale);
    let decimals = 3 - scaled.abs().log10().floor().clamp(0.0, 3.0) as usize;
    format!("{scaled:.decimals$} {prefix}{unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_have_a_prefix_and_four_digits() {
        let shown: Vec<String> = [(300e-9, "F"), (3.08, "ohm"), (7.916e-4, "H"), (0.0, "V"), (12_345.0, "V"), (99.996e-3, "A")]
            .map(|(value, unit)| quantity(value, unit))
            .into();
        assert_eq!(shown, ["300.0 nF", "3.080 ohm", "791.6 uH", "0 V", "12.35 kV", "100.0 mA"]);
    }

    #[test]
    fn an_f32_is_written_with_its_shortest_digits() {
        assert_eq!(short(0.1).to_string(), "0.1");
        assert_eq!(short(f32::NAN), Value::Null);
    }
}
