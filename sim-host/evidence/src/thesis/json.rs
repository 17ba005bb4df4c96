//! Results as JSON.

use serde_json::{Map, Value, json};

use super::claim::Check;
use super::{Findings, Verdict};

/// Returns claims with verdicts and numbers, contradictions, and open choices.
pub fn summary(findings: &Findings) -> Value {
    let check = |check: &Check| json!({ "condition": check.condition, "holds": check.holds, "numbers": numbers(&check.numbers) });
    let claims: Vec<Value> = findings
        .claims
        .iter()
        .map(|claim| {
            json!({
                "id": claim.id,
                "section": claim.section,
                "claim": claim.says,
                "verdict": claim.verdict(),
                "holds_if": claim.conditions(true),
                "fails_if": claim.conditions(false),
                "checks": claim.checks.iter().map(check).collect::<Vec<_>>(),
            })
        })
        .collect();
    let errata: Vec<Value> = findings
        .errata
        .iter()
        .map(|erratum| {
            json!({
                "id": erratum.id,
                "places": erratum.places,
                "printed": erratum.printed,
                "instead": erratum.instead,
                "shown": erratum.evidence.holds,
                "condition": erratum.evidence.condition,
                "numbers": numbers(&erratum.evidence.numbers),
            })
        })
        .collect();
    let open: Vec<Value> = findings
        .choices
        .iter()
        .map(|choice| json!({ "open": choice.what, "here": choice.here, "numbers": numbers(&choice.numbers) }))
        .collect();
    let count = |verdict: Verdict| findings.count(verdict);
    json!({
        "reproduced": count(Verdict::Reproduced),
        "conditional": count(Verdict::Conditional),
        "refuted": count(Verdict::Refuted),
        "claims": claims,
        "contradictions": errata,
        "open": open,
        "figures": findings.figures.iter().map(|figure| figure.id.as_str()).collect::<Vec<_>>(),
    })
}

/// Maps numbers by name; appends its index to a repeated name.
fn numbers(numbers: &[(String, f64)]) -> Value {
    let mut map = Map::new();
    for (index, (name, value)) in numbers.iter().enumerate() {
        let key = if map.contains_key(name) { format!("{name} #{index}") } else { name.clone() };
        map.insert(key, json!(value));
    }
    Value::Object(map)
}
