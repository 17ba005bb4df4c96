//! Comparison in the summary: amplitude, matching and metrics of each case, for each matched
//! quantity.

use firmware::seam::fault::Fault;
use serde_json::{Map, Value, json};

use crate::study::comparison::{CaseResult, ComparisonResult, Matched, Standing};

/// Returns the comparison as JSON. A case that could not be matched has no metrics; one that would
/// need more than the allowed amplitude has the required one.
pub(super) fn json(result: &ComparisonResult) -> Value {
    let comparison = &result.comparison;
    let case = |case: &CaseResult| {
        let metrics: Map<String, Value> =
            comparison.metrics.iter().map(|name| (name.clone(), json!(case.metric(name)))).collect();
        let (off, needs, fault) = match case.standing {
            Standing::Equal { off } => (Some(off), None, None),
            Standing::Beyond { needs } => (None, Some(needs), None),
            Standing::Unmeasured { fault } => (None, None, fault.map(Fault::code)),
        };
        json!({
            "name": case.name, "amplitude": case.amplitude, "off": off, "needs": needs, "fault": fault, "metrics": metrics,
        })
    };
    let matched = |matched: &Matched| {
        let cases: Vec<Value> = matched.cases.iter().map(case).collect();
        json!({ "match": matched.equal, "metric": matched.equal.metric(), "target": matched.target, "cases": cases })
    };
    let matches: Vec<Value> = result.matches.iter().map(matched).collect();
    json!({
        "title": comparison.title, "amplitude_key": comparison.amplitude_key, "metrics": comparison.metrics, "matches": matches,
    })
}
