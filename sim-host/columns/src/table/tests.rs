use super::*;

fn values(text: &str) -> Vec<Vec<f64>> {
    read(text, None).unwrap_or_else(|error| panic!("{text}: {error}")).columns.into_iter().map(|column| column.values).collect()
}

/// Every combination of delimiter, decimal sign, heading, preamble, comments and line ends.
#[test]
fn all_forms_of_a_table_give_the_same_columns() {
    let delimiters =
        [(";", true), (";", false), ("\t", true), ("\t", false), (",", false), ("  ", true), (" ", false), (", ", false)];
    let heads: [&[&str]; 4] = [&["f [Hz]", "R [ohm]"], &["\"f [Hz]\"", "\"R [ohm]\""], &["f", "R"], &[]];
    let preambles = ["", "Oscilloscope X\nDate: 1 January\n\n", "# a remark\n! another\n", "Points,401,\n"];
    for (delimiter, comma) in delimiters {
        for head in
            heads.iter().filter(|head| delimiter.trim() != "" || !head.iter().any(|name| name.starts_with('f') && name.len() > 1))
        {
            for (preamble, end, trail) in preambles.iter().flat_map(|p| [(p, "\n", ""), (p, "\r\n", ""), (p, "\n", delimiter)]) {
                // Without a heading in between, such a line is a row with a word.
                if head.is_empty() && preamble.starts_with("Points") {
                    continue;
                }
                let join = |cells: &[&str]| cells.join(delimiter) + trail + end;
                let number = |text: &str| if comma { text.replace('.', ",") } else { text.to_owned() };
                let rows: String = [("40000.5", "1.25"), ("40001.5", "1.5"), ("40002.5", "-2e-3")]
                    .map(|(f, r)| join(&[&number(f), &number(r)]))
                    .concat();
                let units = if head.first() == Some(&"f") { join(&["Hz", "(ohm)"]) } else { String::new() };
                let text = format!("{preamble}{}{units}{rows}", if head.is_empty() { String::new() } else { join(head) });
                let table = read(&text, None).unwrap_or_else(|error| panic!("{text}: {error}"));
                assert_eq!(values(&text), [vec![40000.5, 40001.5, 40002.5], vec![1.25, 1.5, -2e-3]], "{text}");
                let names = if head.is_empty() { ["column 1", "column 2"] } else { ["f [Hz]", "R [ohm]"] };
                assert_eq!(table.headings(), names, "{text}");
            }
        }
    }
}

#[test]
fn commented_and_keysight_headings_are_read() {
    for text in ["# a remark\n# t [ms],U [V]\n0.5,1\n1.5,2\n", "#t [ms],U [V]\n# a remark\n0.5,1\n1.5,2\n"] {
        assert_eq!(values(text)[0], [0.5, 1.5]);
    }
    assert_eq!(read("x-axis,1\nsecond,Volt\n0.5,1\n1.5,2\n", None).unwrap().headings(), ["x-axis [second]", "1 [Volt]"]);
}

#[test]
fn quoted_decimal_commas_are_numbers() {
    let table = read("\"f [Hz]\",\"R [ohm]\"\n\"40000,5\",\"1,25\"\n\"40001,5\",\"2\"\n", None).unwrap();
    assert_eq!(
        (table.headings(), &table.columns[0].values),
        (vec!["f [Hz]".to_owned(), "R [ohm]".into()], &vec![40000.5, 40001.5])
    );
    assert_eq!(table.columns[1].values, [1.25, 2.0]);
    assert_eq!(values("metric,value\n# by hand\nq,65.5\n")[1], [65.5]);
}

#[test]
fn words_stay_in_their_column_and_empty_columns_are_left_out() {
    let table = read("t,mode,v,,\n0,Run,1,,\n1,Off,,,\n2,Run,9.9E37,,\n", None).unwrap();
    assert_eq!((table.headings(), table.rows()), (vec!["t".to_owned(), "mode".into(), "v".into()], 3));
    let bad = |at: usize| table.columns[at].numbers().unwrap_err();
    assert_eq!((bad(1).row, bad(1).what.as_str()), (0, "`Run`"));
    assert_eq!((bad(2).row, bad(2).what.as_str(), table.place(1)), (1, "empty", "line 3".to_owned()));
    assert_eq!(table.columns[2].words.len(), 2);
    assert!(read("f,z\n1,2\n2,9.91E37\n3,4\n", None).unwrap().columns[1].numbers().unwrap_err().what.contains("overflow"));
}

/// A line that is cut short, or has a word instead of all numbers, is never the end of the table.
#[test]
fn lines_that_break_a_table_are_named() {
    let error = |text: &str| read(text, None).unwrap_err();
    let rows: Vec<String> = (0..9).map(|n| format!("{n},{n}.5,{n}e3")).collect();
    for at in 0..9 {
        for broken in ["overload", "1.5,2", "1,2,3,4", "over,load,here"] {
            let mut rows = rows.clone();
            rows.insert(at, broken.to_owned());
            let found = read(&format!("a,b,c\n{}\n", rows.join("\n")), None);
            let names_line = matches!(&found, Err(error) if error.line() == Some(at + 2));
            // Words directly above the first row are a heading.
            assert!(names_line || at == 0 && !broken.starts_with('1'), "{broken} at {at}: {found:?}");
        }
    }
    assert_eq!(error(""), TableError::Empty);
    assert!(matches!(error("base = \"contact\"\nmu = high\n"), TableError::NoNumbers { .. }));
    let decimal = error("f [Hz],R [ohm]\n40000,5,1,25\n40001,5,1,5\n").to_string();
    assert!(decimal.contains("export with semicolons"), "{decimal}");
    let two = error("f,z\n1,2\n2,3\nf,z\n1,2\n2,3\n");
    assert_eq!(two, TableError::Interrupted { line: 4, begins: "f,z".to_owned() });
}

#[test]
fn given_names_replace_the_heading() {
    assert_eq!(read("1 2\n3 4\n", Some("t [s], v")).unwrap().headings(), ["t [s]", "v"]);
    assert!(matches!(read("1 2\n3 4\n", Some("t")), Err(TableError::Width { names: 1, columns: 2, .. })));
}

#[test]
fn commas_that_may_separate_thousands_are_refused() {
    for text in ["\"f [Hz]\",\"R [ohm]\"\n\"39,000\",\"3,012\"\n\"39,100\",\"3,010\"\n", "t [s];u [V]\n1,467;2\n1,468;3\n"] {
        let refused = read(text, None).unwrap_err();
        assert!(matches!(refused, TableError::Comma { line: 2, .. }), "{text}: {refused}");
    }
    // Points and commas are not both decimal signs.
    let mixed = "\"f [Hz]\",\"R [ohm]\",X\n\"39,5\",\"1,5\",0.5\n\"40,5\",\"1,5\",0.6\n";
    assert!(matches!(read(mixed, None), Err(TableError::Comma { line: 2, .. })));
    // One number shows that the comma is a decimal one.
    assert_eq!(values("t [s];u [V]\n0,467;2,000\n1,468;3,000\n"), [vec![0.467, 1.468], vec![2.0, 3.0]]);
    assert_eq!(values("t [s];u [V]\n1,25;2,000\n1,468;3,000\n")[0], [1.25, 1.468]);
}

#[test]
fn a_table_that_would_take_too_long_is_refused() {
    let refused = read(&"1\n".repeat(MAX_LINES + 1), None);
    assert_eq!(refused, Err(TableError::Long { lines: MAX_LINES + 1, most: MAX_LINES }));
}

#[test]
fn an_unknown_unit_below_names_is_not_a_name() {
    let headings = |text: &str| read(text, None).unwrap().headings();
    assert_eq!(headings("Timestamp,u\nticks,V\n0,1\n1,2\n"), ["Timestamp [ticks]", "u [V]"]);
    assert_eq!(headings("f,|Z|,theta\nkHz,furlong,deg\n39,1,2\n40,1,2\n"), ["f [kHz]", "|Z| [furlong]", "theta [deg]"]);
    assert_eq!(headings("Frequency (Hz)   Impedance (Ohm)\n39 1\n40 2\n"), ["Frequency (Hz)", "Impedance (Ohm)"]);
    // The names are below a line of the preamble.
    assert_eq!(headings("bench,run,three\nt,v,F\n0,1,2\n1,1,2\n"), ["t", "v", "F"]);
}
