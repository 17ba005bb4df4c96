//! `docs/data.md`.

use std::fmt::Write as _;

use firmware::seam::fault::{Fault, Limit};

use super::{Column, FIGURES, files};
use scene::metrics::{METRICS, RENAMED, Sign, Window};

const HEAD: &str = "\
# Data of a run

What a run leaves in its folder (`sim-host run SCENE -o DIR`), and what each number in it means. This page is generated from the tables that the program itself reads:
metrics from `sim-host/scene/src/metrics/table.rs`, files from `sim-host/sim/src/data.rs`, faults and limits from `firmware/src/seam/fault.rs`. `UPDATE_DOCS=1 cargo test docs -- --include-ignored`
regenerates it. `sim-host explain` answers from the same tables; [settings.md](settings.md) lists the keys of the controller.

Numbers are in SI units unless a name says otherwise; the unit is the end of a name. CSV files have a head line, commas, and as many digits as it takes to read the same number back; a value that is
not finite is an empty cell.

Results of your own runs are yours. Data that the project itself publishes are licensed under CC-BY-4.0 ([LICENSE-DATA](../LICENSE-DATA)).
";

/// The page, in Markdown.
pub fn page() -> String {
    let mut page = HEAD.to_owned();
    metrics(&mut page);
    page += "\n## Files\n";
    for file in files() {
        let _ = write!(page, "\n### `{}` of {}\n\n{}.\n", file.name, file.of, file.meaning);
        if !file.columns.is_empty() {
            page += "\n| name | unit | meaning |\n|---|---|---|\n";
            for Column { name, unit, meaning } in &file.columns {
                let _ = writeln!(page, "| `{name}` | {unit} | {meaning} |");
            }
        }
    }
    page += "\n## Figures\n\nEach figure leaves `ID.svg`, `ID.png` and `ID.csv`, or the formats that `--figure-format` asks for ([figures.md](figures.md)). Curves over the same x are columns of one table, after x; curves over different x stand below one \
             another, with the name of the column in the first one. A band has two columns more, `_lower` and `_upper`. A scene has the figures and columns that mean something in it.\n\n\
             | ID | x | columns | shows |\n|---|---|---|---|\n";
    for figure in FIGURES {
        let columns: Vec<String> = figure.columns.iter().map(|column| format!("`{column}`")).collect();
        let _ = writeln!(page, "| `{}` | {} | {} | {} |", figure.id, figure.x, columns.join(" "), figure.meaning);
    }
    page += "\n## Faults\n\nA fault mutes the drive, and stays until it is cleared.\n\n| number | fault | raised when | remedy |\n|---|---|---|---|\n";
    for &fault in Fault::ALL {
        let _ = writeln!(page, "| {} | {} | {} | {} |", fault.code(), fault.called(), fault.meaning(), fault.remedy());
    }
    page += "\n## Limits\n\nA limit states why the drive delivers less than its set point.\n\n| number | limit | remedy |\n|---|---|---|\n";
    for &limit in Limit::ALL {
        let _ = writeln!(page, "| {} | {} | {} |", limit.code(), limit.meaning(), limit.remedy());
    }
    page
}

fn metrics(page: &mut String) {
    *page += "\n## Metrics\n\nA name means one thing in every scene. A run has the metrics that mean something in its scene; the others are absent, never zero. Of several runs, `NAME` is the median, \
              `NAME_p95` the value that 95 % of the runs do not exceed, and `NAME_max` the largest; a run that lacks a time counts as infinite.\n\n\
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
    *page += "\n| measured | over |\n|---|---|\n";
    for window in Window::ALL {
        let _ = writeln!(page, "| {} | {} |", window.name(), window.meaning());
    }
    *page += "\n| former name | now |\n|---|---|\n";
    for (former, present) in RENAMED {
        let _ = writeln!(page, "| `{former}`, where a run has none of that name | `{present}` |");
    }
}

#[cfg(test)]
mod tests {
    /// `UPDATE_DOCS=1 cargo test docs -- --include-ignored` regenerates the page.
    #[test]
    fn docs_of_the_data_are_generated_from_its_tables() {
        report::docs::page("data.md", &super::page());
    }
}
