//! Page `docs/faults.md`.

use std::fmt::Write as _;

use firmware::seam::fault::{Fault, Limit};

use crate::explain::note;

const HEAD: &str = "\
# Faults and limits

A fault mutes the drive and remains until `sim-host link PORT fault clear`.
A limit lowers the drive or keeps it below its set point, and ends by itself.
[Troubleshooting](troubleshooting.md) starts from the symptom; this page starts from the number.

`sim-host link PORT fault log` lists the last faults of a board, with frequency, drive, voltage and current at each.
`sim-host run` prints the fault that ended a run, and the metrics `fault_code` and `limit_code` hold the numbers.
`sim-host explain 22` prints the entry of one number.
Each example shows its fault or limit in simulation.

## Status LED

The LED at pin PA9 of the board shows the state, and the number of a fault: a long flash (0.5 s) for each ten, then a short one (0.1 s) for each unit.

| state | LED |
|---|---|
| idle | a flash of 50 ms every 2 s |
| drives, in any stage | on |
| fault | its number, then a pause of 1.2 s: 32 is three long and two short flashes |

## Faults by number

| number | fault | long | short |
|---|---|---|---|
";

/// Appends the entry of a fault or limit.
fn entry(page: &mut String, kind: &str, code: u8, (called, meaning, remedy): (&str, &str, &str)) {
    let [cause, check, command] = note(code);
    let _ = write!(page, "\n### {kind} {code}\n\n**{called}**: {}\n\n", meaning.replace(". ", ".\n"));
    let example = if command.is_empty() { String::new() } else { format!("`sim-host {command}`") };
    for (label, text) in [("Likely cause", cause), ("Check", check), ("Remedy", remedy), ("Example", &example)] {
        if !text.is_empty() {
            let _ = writeln!(page, "* {label}: {text}");
        }
    }
}

/// Returns the page, in Markdown.
pub fn faults_page() -> String {
    let mut page = HEAD.to_owned();
    for &fault in Fault::ALL {
        let code = fault.code();
        let _ = writeln!(page, "| [{code}](#fault-{code}) | {} | {} | {} |", fault.called(), code / 10, code % 10);
    }
    page += "\n## Limits by number\n\n| number | limit |\n|---|---|\n";
    for &limit in Limit::ALL {
        let _ = writeln!(page, "| [{0}](#limit-{0}) | {1} |", limit.code(), limit.called());
    }
    page += "\n## Each fault\n";
    for &fault in Fault::ALL {
        entry(&mut page, "Fault", fault.code(), (fault.called(), fault.meaning(), fault.remedy()));
    }
    page += "\n## Each limit\n";
    for &limit in Limit::ALL {
        entry(&mut page, "Limit", limit.code(), (limit.called(), limit.meaning(), limit.remedy()));
    }
    page
}

#[cfg(test)]
mod tests {
    /// `UPDATE_DOCS=1 cargo test docs -- --include-ignored` regenerates the page.
    #[test]
    fn docs_of_the_faults_are_generated_from_their_tables() {
        report::docs::page("faults.md", &super::faults_page());
    }
}
