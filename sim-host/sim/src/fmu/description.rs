//! Description of a unit, `modelDescription.xml`.

use std::fmt::Write;

use scene::load::Loaded;

use super::{Causality, Kind, Value, Variable, scene_text, token, variables};

/// Name of the library in a unit.
pub const MODEL_IDENTIFIER: &str = "sonoglide";

/// Base units of the symbols.
const UNITS: [(&str, &str); 5] = [
    ("V", r#"kg="1" m="2" s="-3" A="-1""#),
    ("N", r#"kg="1" m="1" s="-2""#),
    ("m/s", r#"m="1" s="-1""#),
    ("W", r#"kg="1" m="2" s="-3""#),
    ("Hz", r#"s="-1""#),
];

/// Returns the description of a scene as a unit; `None` unless the firmware drives it.
pub fn description(loaded: &Loaded, kind: Kind) -> Option<String> {
    let scene = loaded.scene.driven()?;
    let (variables, text) = (variables(&scene, kind), scene_text(loaded));
    let (step_s, version) = (kind.step_s(&scene), env!("CARGO_PKG_VERSION"));
    let (name, title, token) = (escaped(&loaded.name), escaped(&loaded.scene.title), token(&text, kind));
    let mut xml = format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="{name}" instantiationToken="{token}" description="{title}" generationTool="Sonoglide {version}" variableNamingConvention="flat">
  <CoSimulation modelIdentifier="{MODEL_IDENTIFIER}" canHandleVariableCommunicationStepSize="false" fixedInternalStepSize="{step_s}"/>
  <UnitDefinitions>
"#
    );
    let used = |symbol: &str| variables.iter().any(|variable| variable.unit == symbol);
    for (symbol, base) in UNITS.iter().filter(|(symbol, _)| used(symbol)) {
        let _ = writeln!(xml, r#"    <Unit name="{symbol}"><BaseUnit {base}/></Unit>"#);
    }
    let stop_s = loaded.scene.duration_s;
    let _ = write!(
        xml,
        r#"    <Unit name="s"><BaseUnit s="1"/></Unit>
  </UnitDefinitions>
  <LogCategories><Category name="error"/></LogCategories>
  <DefaultExperiment startTime="0" stopTime="{stop_s}" stepSize="{step_s}"/>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous" unit="s"/>
"#
    );
    variables.iter().for_each(|variable| xml += &element(variable));
    xml += "  </ModelVariables>\n  <ModelStructure>\n";
    let outputs = || variables.iter().filter(|variable| variable.causality == Causality::Output);
    for part in ["Output", "InitialUnknown"] {
        for variable in outputs() {
            let _ = writeln!(xml, r#"    <{part} valueReference="{}"/>"#, variable.reference);
        }
    }
    xml += "  </ModelStructure>\n</fmiModelDescription>\n";
    Some(xml)
}

/// Returns the element of a variable.
fn element(variable: &Variable) -> String {
    let Variable { name, reference, causality, unit, start, meaning } = variable;
    let is_input = *causality == Causality::Input;
    let causality = if is_input { "input" } else { "output" };
    let (kind, begin, content) = match start {
        Value::Float(value) => ("Float64", value.to_string(), String::new()),
        Value::Integer(value) => ("Int32", value.to_string(), String::new()),
        Value::Boolean(value) => ("Boolean", value.to_string(), String::new()),
        Value::Unsigned(value) => ("UInt64", value.to_string(), String::new()),
        Value::Codes(codes) => {
            let all: Vec<String> = codes.iter().map(u16::to_string).collect();
            ("UInt16", all.join(" "), format!(r#"<Dimension start="{}"/>"#, codes.len()))
        }
    };
    let variability = if matches!(start, Value::Float(_)) { "continuous" } else { "discrete" };
    // The start of an output is computed.
    let begin = if is_input { format!(r#" start="{begin}""#) } else { String::new() };
    let unit = if unit.is_empty() { String::new() } else { format!(r#" unit="{unit}""#) };
    let meaning = escaped(meaning);
    let head = format!(
        r#"    <{kind} name="{name}" valueReference="{reference}" causality="{causality}" variability="{variability}"{unit}{begin} description="{meaning}""#
    );
    if content.is_empty() { format!("{head}/>\n") } else { format!("{head}>{content}</{kind}>\n") }
}

/// Returns a text for an attribute of XML.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            letter if letter.is_control() => escaped.push(' '),
            letter => escaped.push(letter),
        }
    }
    escaped
}
