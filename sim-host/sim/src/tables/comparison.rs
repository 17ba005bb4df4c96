//! Tables of a comparison: one for each matched quantity.

use super::number;
use crate::study::Study;
use crate::study::comparison::{CaseResult, ComparisonResult, Matched, Standing};
use report::TableBlock;
use scene::Equal;
use scene::schema::last_name;

/// Returns the tables.
pub(super) fn tables(study: &Study) -> Vec<TableBlock> {
    let host = if study.run().is_some() { " with the controller on the host (SIL)" } else { "" };
    let tables = |result: &ComparisonResult| result.matches.iter().map(|matched| table(result, matched, host)).collect();
    study.comparison.as_ref().map_or_else(Vec::new, tables)
}

fn table(result: &ComparisonResult, matched: &Matched, host: &str) -> TableBlock {
    let comparison = &result.comparison;
    let header = ["case", last_name(&comparison.amplitude_key)].into_iter().chain(comparison.metrics.iter().map(String::as_str));
    let row = |case: &CaseResult| {
        let cells = comparison.metrics.iter().map(|name| case.metric(name).map_or_else(|| "–".to_owned(), number));
        [case.name.clone(), amplitude(case, matched.equal)].into_iter().chain(cells).collect()
    };
    TableBlock {
        id: format!("comparison-{}", matched.equal.name()),
        title: format!("{}, at equal {}", comparison.title, matched.equal.name()),
        caption: format!("{}; each case is a separate run{host}", equality(matched)),
        header: header.map(str::to_owned).collect(),
        rows: matched.cases.iter().map(row).collect(),
    }
}

/// Returns the amplitude, or the reason that there is none.
fn amplitude(case: &CaseResult, equal: Equal) -> String {
    match case.standing {
        Standing::Equal { .. } => number(case.amplitude),
        // A reduction saturates, so that its slope does not lead to the target.
        Standing::Beyond { .. } if equal == Equal::Reduction => format!("more than {}", number(case.amplitude)),
        Standing::Beyond { needs } => format!("needs {}, at most {}", number(needs), number(case.amplitude)),
        Standing::Unmeasured { fault: Some(fault) } => format!("fault {}: {fault:?} at {}", fault.code(), number(case.amplitude)),
        Standing::Unmeasured { fault: None } => "cannot be matched".to_owned(),
    }
}

/// Describes the matched quantity and its accuracy.
fn equality(matched: &Matched) -> String {
    let (Some(metric), Some(target)) = (matched.equal.metric(), matched.target) else {
        return match matched.equal {
            Equal::Peak => "Equal commanded peak".to_owned(),
            Equal::Reduction => "The first case has no reduction, so no case is matched to it".to_owned(),
            _ => "The first case cannot be measured, so no case is matched to it".to_owned(),
        };
    };
    let off = |case: &CaseResult| match case.standing {
        Standing::Equal { off } => Some(off.abs()),
        _ => None,
    };
    let worst = matched.cases.iter().filter_map(off).fold(0.0, f64::max);
    format!("{metric} equals {}, its value in the first case, within {worst:.1e} (relative)", number(target))
}
