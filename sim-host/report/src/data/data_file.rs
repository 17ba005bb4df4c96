//! The numbers of a figure as CSV.
//!
//! Every sample is written, even if the picture was thinned, with enough digits to read the same
//! number back. A value that is not finite is an empty cell.

use std::io::Write;

use crate::figure::{Figure, HeatMap, Style};

/// Writes the figure's series.
///
/// Series over the same x share one table: x first, then a column for each. Series over different x
/// are written one below the other, with the name of the series in the first column. A map is a
/// table with a line for each of its columns: the middle in x, then the values, with the middle in
/// y as the heading.
pub(crate) fn write(figure: &Figure, target: impl Write) -> csv::Result<()> {
    let mut out = csv::Writer::from_writer(target);
    if let Some(map) = &figure.map {
        write_map(figure, map, &mut out)?;
    } else if let Some(x) = shared_x(figure) {
        write_wide(figure, x, &mut out)?;
    } else {
        write_long(figure, &mut out)?;
    }
    out.flush()?;
    Ok(())
}

/// Returns the x that all series share.
fn shared_x(figure: &Figure) -> Option<&[f64]> {
    let mut series = figure.all_series();
    let first = series.next()?;
    (figure.along.is_none() && series.all(|s| s.x == first.x)).then_some(&first.x)
}

fn write_wide<W: Write>(figure: &Figure, x: &[f64], out: &mut csv::Writer<W>) -> csv::Result<()> {
    let mut header = vec![column_name(&figure.x.label)];
    let mut columns = vec![x];
    for series in figure.all_series() {
        header.push(text_cell(&series.csv_column));
        if let Style::Band { .. } = series.style {
            header.extend(["lower", "upper"].map(|edge| format!("{}_{edge}", series.csv_column)));
        }
        columns.extend(series.columns());
    }
    out.write_record(&header)?;
    for row in 0..x.len() {
        out.write_record(columns.iter().map(|column| cell(column[row])))?;
    }
    Ok(())
}

fn write_long<W: Write>(figure: &Figure, out: &mut csv::Writer<W>) -> csv::Result<()> {
    let along = figure.along.as_ref();
    let mut header = vec!["series".into()];
    header.extend(along.map(|along| along.csv_column.clone()));
    // Plots below have another quantity in this column, identified by the name of the series.
    let y = if figure.panels.is_empty() { column_name(&figure.y.label) } else { "value".into() };
    header.extend([column_name(&figure.x.label), y]);
    let banded = figure.all_series().any(|s| matches!(s.style, Style::Band { .. }));
    if banded {
        header.extend(["lower".into(), "upper".into()]);
    }
    out.write_record(&header)?;
    for (place, series) in figure.all_series().enumerate() {
        let columns = series.columns();
        for (row, &x) in series.x.iter().enumerate() {
            let mut record = vec![text_cell(&series.csv_column)];
            record.extend(along.map(|along| cell(along.values[place][row])));
            record.push(cell(x));
            record.extend(columns.iter().map(|column| cell(column[row])));
            record.resize(header.len(), String::new());
            out.write_record(&record)?;
        }
    }
    Ok(())
}

fn write_map<W: Write>(figure: &Figure, map: &HeatMap, out: &mut csv::Writer<W>) -> csv::Result<()> {
    let (columns, rows) = map.size();
    // Six digits: the middles are computed, and their last digits are rounding errors.
    let middle = |(from, to): (f64, f64), log: bool, n: usize, of: usize| {
        let part = (n as f64 + 0.5) / of as f64;
        let value = if log { from * (to / from).powf(part) } else { from + (to - from) * part };
        cell(format!("{value:.5e}").parse().unwrap_or(value))
    };
    let headings = (0..rows).map(|row| format!("{}_at_{}", map.csv_column, middle(map.y, figure.y.log, row, rows)));
    out.write_record(std::iter::once(column_name(&figure.x.label)).chain(headings))?;
    for (index, values) in map.columns.iter().enumerate() {
        out.write_record(std::iter::once(middle(map.x, figure.x.log, index, columns)).chain(values.iter().copied().map(cell)))?;
    }
    Ok(())
}

fn cell(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() {
        String::new()
    } else if size == 0.0 || (1e-5..1e15).contains(&size) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// Returns a text as a cell that no spreadsheet evaluates as a formula.
pub fn text_cell(text: &str) -> String {
    let is_formula = text.starts_with(['=', '+', '-', '@']) && text.parse::<f64>().is_err();
    format!("{}{text}", if is_formula { "'" } else { "" })
}

/// Converts an axis label to a column name: `time [ms]` becomes `time_ms`.
fn column_name(label: &str) -> String {
    let mut name = String::new();
    for letter in label.chars() {
        match letter {
            'µ' | 'μ' => name.push('u'),
            'Ω' | '\u{2126}' => name.push_str("ohm"),
            '°' => name.push_str("deg"),
            '%' => name.push_str("percent"),
            '/' => name.push_str("_per_"),
            '²' => name.push('2'),
            '³' => name.push('3'),
            _ if letter.is_alphanumeric() => name.extend(letter.to_lowercase()),
            _ => name.push('_'),
        }
    }
    let words: Vec<&str> = name.split('_').filter(|word| !word.is_empty()).collect();
    words.join("_")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{Along, Axis, Panel, Series};

    fn text(series: Vec<Series>) -> String {
        let figure = Figure {
            x: Axis { label: "time [ms]".into(), ..Axis::default() },
            y: Axis { label: "force [µN]".into(), ..Axis::default() },
            series,
            ..Figure::default()
        };
        let mut bytes = Vec::new();
        write(&figure, &mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    fn series(column: &str, x: &[f64], y: &[f64]) -> Series {
        Series { csv_column: column.into(), x: x.into(), y: y.into(), ..Series::default() }
    }

    #[test]
    fn one_x_gives_one_table() {
        let mut banded = series("b", &[0.0, 0.5], &[f64::NAN, 1e-9]);
        banded.style = Style::Band { lower: vec![-1.0, 0.0], upper: vec![1.0, 2.0] };
        assert_eq!(
            text(vec![series("a_n", &[0.0, 0.5], &[1.0, 0.1]), banded]),
            "time_ms,a_n,b,b_lower,b_upper\n0,1,,-1,1\n0.5,0.1,1e-9,0,2\n"
        );
    }

    #[test]
    fn a_map_is_a_table_of_its_middles() {
        let map = HeatMap {
            x: (0.0, 0.3),
            y: (0.0, 100.0),
            columns: vec![vec![-1.0, -2.0], vec![-3.5, f64::NAN], vec![0.0, 1.0]],
            csv_column: "power_db".into(),
            ..HeatMap::default()
        };
        let figure = Figure { x: Axis { label: "time [ms]".into(), ..Axis::default() }, map: Some(map), ..Figure::default() };
        let mut bytes = Vec::new();
        write(&figure, &mut bytes).unwrap();
        assert_eq!(
            String::from_utf8(bytes).unwrap(),
            "time_ms,power_db_at_25,power_db_at_75\n0.05,-1,-2\n0.15,-3.5,\n0.25,0,1\n"
        );
    }

    #[test]
    fn different_x_give_a_long_table() {
        assert_eq!(
            text(vec![series("a", &[0.0], &[1.0]), series("b", &[2.0], &[3.0])]),
            "series,time_ms,force_un\na,0,1\nb,2,3\n"
        );
    }

    #[test]
    fn the_quantity_along_a_locus_is_a_column() {
        let figure = Figure {
            x: Axis { label: "conductance [S]".into(), ..Axis::default() },
            y: Axis { label: "susceptance [S]".into(), ..Axis::default() },
            series: vec![series("a", &[0.5], &[1.0]), series("b", &[0.5], &[2.0])],
            along: Some(Along { csv_column: "frequency_hz".into(), values: vec![vec![40e3], vec![41e3]] }),
            ..Figure::default()
        };
        let mut bytes = Vec::new();
        write(&figure, &mut bytes).unwrap();
        assert_eq!(
            String::from_utf8(bytes).unwrap(),
            "series,frequency_hz,conductance_s,susceptance_s\na,40000,0.5,1\nb,41000,0.5,2\n"
        );
    }

    #[test]
    fn panels_are_columns_of_the_same_table() {
        let panels = vec![Panel { series: vec![series("b_n", &[0.0], &[2.0])], ..Panel::default() }];
        let figure = Figure {
            x: Axis { label: "time [s]".into(), ..Axis::default() },
            series: vec![series("a_v", &[0.0], &[1.0])],
            panels,
            ..Figure::default()
        };
        let mut bytes = Vec::new();
        write(&figure, &mut bytes).unwrap();
        assert_eq!(String::from_utf8(bytes).unwrap(), "time_s,a_v,b_n\n0,1,2\n");
    }

    #[test]
    fn texts_are_not_formulas() {
        assert_eq!(text(vec![series("=1+1", &[0.0], &[-1.0])]), "time_ms,'=1+1\n0,-1\n");
        assert_eq!(["+a", "@b", "-1e3", "-c", "d"].map(text_cell), ["'+a", "'@b", "-1e3", "'-c", "d"]);
    }

    #[test]
    fn labels_become_column_names() {
        assert_eq!(column_name("sliding speed [m/s]"), "sliding_speed_m_per_s");
        assert_eq!(column_name("Re Y [1/Ω]"), "re_y_1_per_ohm");
    }
}
