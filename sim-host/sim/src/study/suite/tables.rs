//! Tables of a suite.

use super::{CaseResult, SuiteResult, TargetResult};
use crate::instruments::friction_switch::Step;
use report::statistics::percentile;
use report::{TableBlock, verdict};
use scene::suite::{Column, STEPS, Statistic, SuiteTable};

impl SuiteResult<'_> {
    /// Returns the targets and the tables of the suite.
    pub fn tables(&self) -> Vec<TableBlock> {
        let own = &self.suite.suite.table;
        let default = if own.is_empty() { self.default_tables() } else { Vec::new() };
        let mut tables = vec![self.targets()];
        tables.extend(own.iter().chain(&default).enumerate().map(|(number, table)| self.table(number, table)));
        tables.retain(|table| !table.rows.is_empty());
        tables
    }

    /// Returns the commands that run each case alone.
    pub fn commands(&self) -> TableBlock {
        let row = |case: &CaseResult| vec![case.case.name.clone(), format!("`{}`", case.case.command)];
        TableBlock::new("commands", "Command of each case", "", &["case", "command"], self.cases.iter().map(row).collect())
    }

    fn targets(&self) -> TableBlock {
        let row = |judged: &TargetResult| {
            let worst =
                judged.worst.as_ref().map_or_else(String::new, |(case, value)| format!("{} ({case})", number(*value, None)));
            let mut missed: Vec<&str> =
                judged.missed.iter().filter_map(|name| self.case(name)).map(|case| case.case.base.as_str()).collect();
            missed.dedup();
            let missed = if missed.is_empty() { String::new() } else { format!(" in {}", missed.join("; ")) };
            let verdict = format!("{}{missed}", verdict(judged.holds()));
            vec![judged.metric.clone(), judged.limit.clone(), judged.cases.to_string(), worst, verdict, judged.source.clone()]
        };
        let header = ["metric", "target", "cases", "worst", "", "source"];
        let judged = self.judged.iter().filter(|judged| judged.cases > 0);
        TableBlock::new("targets", "Targets", "", &header, judged.map(row).collect())
    }

    fn table(&self, number: usize, table: &SuiteTable) -> TableBlock {
        let of = self.cases.iter().filter(|case| table.groups.is_empty() || table.groups.contains(&case.case.group));
        let row = |case: &CaseResult| {
            let cells = table.column.iter().map(|column| cell(case, column));
            std::iter::once(case.case.name.clone()).chain(cells).collect()
        };
        let header: Vec<&str> = std::iter::once("case").chain(table.column.iter().map(|column| column.title.as_str())).collect();
        TableBlock::new(&format!("table-{}", number + 1), &table.title, &table.caption, &header, of.map(row).collect())
    }

    /// Returns the default tables: for every group, the metrics of its targets.
    fn default_tables(&self) -> Vec<SuiteTable> {
        let mut groups: Vec<&String> = self.cases.iter().map(|case| &case.case.group).collect();
        groups.dedup();
        let column = |metric: &String| Column {
            title: metric.clone(),
            metrics: vec![metric.clone()],
            show: vec![Statistic::Median],
            scale: 1.0,
            digits: None,
        };
        let table = |group: &String| {
            let mut metrics: Vec<&String> = self.suite.suite.target.iter().map(|target| &target.metric).collect();
            metrics.sort();
            metrics.dedup();
            SuiteTable {
                title: if group.is_empty() { "Cases".to_owned() } else { group.clone() },
                groups: vec![group.clone()],
                caption: String::new(),
                column: metrics.into_iter().map(column).collect(),
            }
        };
        groups.into_iter().map(table).collect()
    }
}

fn cell(case: &CaseResult, column: &Column) -> String {
    let one = |metric: &String| -> Vec<String> {
        if metric == STEPS {
            return case.steps.iter().map(step).collect();
        }
        let shown = |statistic: &Statistic| {
            let value = match statistic {
                Statistic::Median => case.value(metric),
                Statistic::P95 => case.value(&format!("{metric}_p95")),
                Statistic::Max => case.value(&format!("{metric}_max")),
                Statistic::P5 => Some(percentile(&case.sorted(metric), 0.05)).filter(|value| !value.is_nan()),
                Statistic::Values => {
                    let mut values: Vec<String> =
                        case.sorted(metric).into_iter().map(|value| number(Some(column.scale * value), column.digits)).collect();
                    values.dedup();
                    return values.join(" or ");
                }
            };
            number(value.map(|value| column.scale * value), column.digits)
        };
        column.show.iter().map(shown).collect()
    };
    column.metrics.iter().flat_map(one).collect::<Vec<_>>().join(", ")
}

/// Formats a set point of the friction ratio with the error of the true ratio; for a refused one,
/// with limit and ratio.
fn step(step: &Step) -> String {
    match step.is_refused() {
        true => format!("{:.3}: limit {}, {:.3}", step.set_point, step.limit, step.truth),
        false => format!("{:.3}: {:+.4}", step.set_point, step.error()),
    }
}

/// Formats a number with this number of decimals, or with three significant digits; whole numbers
/// have no decimals.
fn number(value: Option<f64>, digits: Option<u32>) -> String {
    let Some(value) = value else { return "–".to_owned() };
    if !value.is_finite() {
        return "never".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let places = match (digits, value.abs()) {
        (Some(digits), _) => digits as usize,
        (None, size) if value.fract() == 0.0 && size < 1e9 => 0,
        (None, size) if size > 0.0 && size < 1e-3 => return format!("{value:.1e}"),
        (None, size) if size < 1.0 => 3,
        (None, size) if size < 100.0 => 2,
        (None, _) => 0,
    };
    let text = format!("{value:.places$}");
    // A value that rounds to zero has no sign.
    if text.trim_start_matches(['-', '0', '.']).is_empty() { text.trim_start_matches('-').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let shown = [0.0, 1000.0, 0.1234, 12.345, 123.4, -0.04].map(|value| number(Some(value), None));
        assert_eq!(shown, ["0", "1000", "0.123", "12.35", "123", "-0.040"]);
        let shown = [Some(-0.04), Some(0.0), None, Some(f64::INFINITY)].map(|value| number(value, Some(1)));
        assert_eq!(shown, ["0.0", "0", "–", "never"]);
    }
}
