//! Page `docs/metrics-and-files.md`.

use std::fmt::Write as _;

use super::{Column, FIGURES, files};
use scene::metrics::{METRICS, RENAMED, Sign, Window};

const HEAD: &str = "\
# Metrics and files

Every number and file that a run writes into its folder (`sim-host run SCENE -o DIR`).
`sim-host explain friction_ratio` prints the entry of one metric, and so for a file, column or figure.
[Scene keys](scene-keys.md) lists the inputs, [faults](faults.md) the codes in `fault_code` and `limit_code`.

Numbers are in SI units unless the name states another; a name ends with its unit.
CSV files have a header line, commas, and enough digits to read back the same number.
A value that is not finite is an empty cell.

Results of your own runs are yours.
Data published by the project are licensed under CC-BY-4.0 ([LICENSE-DATA](../LICENSE-DATA)).
";

/// Returns the page, in Markdown.
pub fn page() -> String {
    let mut page = HEAD.to_owned();
    metrics(&mut page);
    page += "\n## Files\n";
    for file in files() {
        let _ = write!(page, "\n### `{}` of {}\n\n{}.\n", file.name, file.of, file.meaning.replace(". ", ".\n"));
        if !file.columns.is_empty() {
            page += "\n| name | unit | meaning |\n|---|---|---|\n";
            for Column { name, unit, meaning } in &file.columns {
                let _ = writeln!(page, "| `{name}` | {unit} | {meaning} |");
            }
        }
    }
    page += "\n## Figures\n\nEach figure is written as `ID.svg`, `ID.png` and `ID.csv`, or in the formats given by `--figure-format` \
             ([figures.md](figures.md)).\nCurves over the same x are columns of one table, after x.\n\
             Curves over different x are listed \
             one after another, with the name of the curve in the first column.\nA band has two additional columns, `_lower` and \
             `_upper`.\nA scene has only the figures and columns that apply to it.\n\n\
             | ID | x | columns | shows |\n|---|---|---|---|\n";
    for figure in FIGURES {
        let columns: Vec<String> = figure.columns.iter().map(|column| format!("`{column}`")).collect();
        let _ = writeln!(page, "| `{}` | {} | {} | {} |", figure.id, figure.x, columns.join(" "), figure.meaning);
    }
    page
}

fn metrics(page: &mut String) {
    *page += "\n## Metrics\n\nA name has the same meaning in every scene.\nA run has only the metrics that apply to its scene; the \
              others are absent, never zero.\nFor several runs, `NAME` is the median, \
              `NAME_p95` the value that 95 % of the runs do \
              not exceed, `NAME_max` the largest, and `NAME_low95` and `NAME_high95` the ends of the interval that contains \
              95 % of them; a missing time counts as infinite.\n\n\
              | name | unit | sign | measured | meaning |\n|---|---|---|---|---|\n";
    for metric in METRICS {
        let sign = match metric.sign {
            Sign::Magnitude => "",
            Sign::Signed => "±",
            Sign::Error => "± 0",
            Sign::Flag => "0, 1",
            Sign::Code => "code",
            Sign::Count => "count",
        };
        let _ =
            writeln!(page, "| `{}` | {} | {sign} | {} | {} |", metric.name, metric.unit, metric.window.name(), metric.meaning);
    }
    *page += "\n| sign | values |\n|---|---|\n";
    let signs = [
        ("(none)", Sign::Magnitude),
        ("±", Sign::Signed),
        ("± 0", Sign::Error),
        ("0, 1", Sign::Flag),
        ("code", Sign::Code),
        ("count", Sign::Count),
    ];
    for (shown, sign) in signs {
        let _ = writeln!(page, "| {shown} | {} |", sign.meaning());
    }
    *page += "\n| measured | interval |\n|---|---|\n";
    for window in Window::ALL {
        let _ = writeln!(page, "| {} | {} |", window.name(), window.meaning());
    }
    *page += "\n| former name | present name |\n|---|---|\n";
    for (former, present) in RENAMED {
        let _ = writeln!(page, "| `{former}`, if a run has no metric of that name | `{present}` |");
    }
}

#[cfg(test)]
mod tests {
    /// `UPDATE_DOCS=1 cargo test docs -- --include-ignored` regenerates the page.
    #[test]
    fn docs_of_the_data_are_generated_from_its_tables() {
        report::docs::page("metrics-and-files.md", &super::page());
    }
}
