//! Files with two traces. Analysers like the 4294A write one table below the other, each with the
//! frequencies.
//!
//! ```text
//! "TRACE: A"
//! "Frequency"    "Data Trace Real"    "Data Trace Imag"
//! 3.9E+04        8.1E+01              0.0E+00
//! ...
//! "TRACE: B"
//! ...
//! ```
//!
//! The quantities of the traces depend on settings of the instrument. `--columns` or the line
//! `"MEASURE PARAMETER: IMPEDANCE MAG PHASE (DEG)"` gives them.

use columns::Table;

use crate::error::ImportError;

/// Returns the indices of the lines that begin trace A and trace B.
fn marks(lines: &[&str]) -> Option<(usize, usize)> {
    let mark = |name: &str| {
        lines.iter().position(|line| line.trim().trim_matches('"').trim().eq_ignore_ascii_case(&format!("TRACE: {name}")))
    };
    mark("A").zip(mark("B"))
}

/// Returns the names of frequency and traces from the line that names the measured parameter.
fn parameters(lines: &[&str]) -> Option<String> {
    let named = |line: &&str| line.trim().trim_matches('"').to_uppercase().strip_prefix("MEASURE PARAMETER:").map(str::to_owned);
    let text = lines.iter().find_map(named)?;
    let has = |word: &str| text.contains(word);
    let (letter, unit) = match (has("IMPEDANCE") || has("Z"), has("ADMITTANCE") || has("Y")) {
        (true, false) => ('Z', "ohm"),
        (false, true) => ('Y', "S"),
        _ => return None,
    };
    let angle = if has("RAD") { "rad" } else { "deg" };
    match (has("MAG") && has("PHASE"), has("REAL") && has("IMAG")) {
        (true, false) => Some(format!("f [Hz], |{letter}| [{unit}], phase {letter} [{angle}]")),
        (false, true) => Some(format!("f [Hz], Re {letter} [{unit}], Im {letter} [{unit}]")),
        _ => None,
    }
}

/// Joins the two traces in one table of frequency, trace A and trace B; `None` if the text has
/// another format.
///
/// # Errors
/// Returns [`ImportError`] if the traces do not fit together, or if their quantities are not given.
pub(crate) fn joined(text: &str, columns: Option<&str>) -> Result<Option<Table>, ImportError> {
    let lines: Vec<&str> = text.lines().collect();
    let Some((a, b)) = marks(&lines) else { return Ok(None) };
    let Some(columns) = columns.map(str::to_owned).or_else(|| parameters(&lines)) else {
        let seen = "a file with two traces, A and B, which does not name their quantities; name frequency and traces with \
                    `--columns`, such as `--columns \"f [Hz], |Z| [ohm], theta [deg]\"`";
        return Err(ImportError::UnknownForm { seen: seen.to_owned() });
    };
    let header: Vec<String> = columns.split(',').map(|name| name.trim().to_owned()).collect();
    if header.len() != 3 {
        let seen = format!(
            "a file with two traces, but `--columns` names {} columns; name the frequency, trace A and trace B",
            header.len()
        );
        return Err(ImportError::UnknownForm { seen });
    }
    // Line numbers are kept: the lines of the other trace are replaced by empty ones.
    let part = |from: usize, to: usize| -> Result<Table, ImportError> {
        let kept = lines.iter().enumerate().map(|(at, line)| if (from..to).contains(&at) { *line } else { "" });
        Ok(columns::read(&kept.collect::<Vec<_>>().join("\n"), None)?)
    };
    let end = |from: usize, other: usize| if other > from { other } else { lines.len() };
    let (one, other) = (part(a + 1, end(a, b))?, part(b + 1, end(b, a))?);
    let mut numbers = Vec::new();
    for table in [&one, &other] {
        let columns = (0..table.columns.len()).map(|at| crate::units::numbers(table, at)).collect::<Result<Vec<_>, _>>()?;
        // The imaginary part of a real trace is zero.
        if let Some(row) = columns.get(2).and_then(|imaginary| imaginary.iter().position(|value| *value != 0.0)) {
            let what = "the trace is complex: set the format of both traces to real numbers, and export them again".to_owned();
            return Err(ImportError::bad_row(table, row, what));
        }
        numbers.push(columns);
    }
    let (hz, again) = (&numbers[0][0], &numbers[1][0]);
    if let Some(row) = (0..hz.len().max(again.len())).find(|row| hz.get(*row) != again.get(*row)) {
        let line = other.lines.get(row).or(one.lines.get(row)).copied().unwrap_or(b + 1);
        return Err(ImportError::BadLine { line, what: "trace B has other frequencies than trace A".to_owned() });
    }
    let [a, b] = [&one, &other].map(|table| table.columns.get(1).cloned().unwrap_or_default());
    Ok(Some(Table {
        names: Some(header),
        lines: one.lines,
        columns: vec![one.columns[0].clone(), a, b],
        found: format!("{}, in two traces", one.found),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "\"4294A\"\n\"TITLE: a\"\n\n\"TRACE: A\"\n\"Frequency\"\t\"Data Trace Real\"\t\"Data Trace Imag\"\n4.0E+04\t80.5\t0.0\n4.1E+04\t90.5\t0.0\n\n\"TRACE: B\"\n\"Frequency\"\t\"Data Trace Real\"\t\"Data Trace Imag\"\n4.0E+04\t-80\t0.0\n4.1E+04\t-70\t0.0\n";
    const NAMES: Option<&str> = Some("f [Hz], |Z| [ohm], theta [deg]");

    #[test]
    fn two_traces_are_joined_in_one_table() {
        let table = joined(FILE, NAMES).unwrap().unwrap();
        let values: Vec<_> = table.columns.into_iter().map(|column| column.values).collect();
        assert_eq!(values, [vec![4e4, 4.1e4], vec![80.5, 90.5], vec![-80.0, -70.0]]);
        let (head, rest) = FILE.split_once("\"TRACE: A\"").unwrap();
        let (first, second) = rest.split_once("\"TRACE: B\"").unwrap();
        let turned = format!("{head}\"TRACE: B\"{second}\n\"TRACE: A\"{first}");
        assert_eq!(joined(&turned, NAMES).unwrap().unwrap().columns[1].values, [80.5, 90.5]);
        let named = |parameter: &str| joined(&FILE.replace("TITLE: a", &format!("MEASURE PARAMETER: {parameter}")), None);
        let names = named("IMPEDANCE MAG PHASE (DEG)").unwrap().unwrap().names.unwrap();
        assert_eq!(names, ["f [Hz]", "|Z| [ohm]", "phase Z [deg]"]);
        assert!(named("Ls-Q").is_err());
        assert_eq!((table.lines, joined("f,z\n1,2\n2,3\n", None).unwrap()), (vec![6, 7], None));
    }

    #[test]
    fn inconsistent_traces_are_refused_with_the_line() {
        let error = |file: &str, names| joined(file, names).unwrap_err().to_string();
        assert!(error(FILE, None).contains("does not name their quantities"));
        assert!(error(FILE, Some("f [Hz], |Z| [ohm]")).contains("`--columns` names 2"));
        assert!(
            error(&FILE.replace("4.1E+04\t-70", "4.2E+04\t-70"), NAMES).starts_with("line 12: trace B has other frequencies")
        );
        assert!(error(&FILE.replace("90.5\t0.0", "90.5\t1.0"), NAMES).starts_with("line 7: the trace is complex"));
        assert!(error(&FILE.replace("4.1E+04\t90.5\t0.0\n", ""), NAMES).contains("trace B has other frequencies"));
    }
}
