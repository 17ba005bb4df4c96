//! Tables: plain text cells, shown in a terminal, in Markdown and in the page.

/// A table of text cells.
///
/// A column whose cells all start like a number is aligned to the right; a cell that begins with
/// `PASS` or `MISS` is coloured.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TableBlock {
    /// Anchor of the table in the page.
    pub id: String,
    /// Heading of the table.
    pub title: String,
    /// Explanation for the reader.
    pub caption: String,
    /// Column headings, with units.
    pub header: Vec<String>,
    /// Rows of cells, each as long as the header.
    pub rows: Vec<Vec<String>>,
}

impl TableBlock {
    /// Creates a table of these cells.
    pub fn new(id: &str, title: &str, caption: impl Into<String>, header: &[impl ToString], rows: Vec<Vec<String>>) -> Self {
        let header = header.iter().map(ToString::to_string).collect();
        TableBlock { id: id.into(), title: title.into(), caption: caption.into(), header, rows }
    }

    /// Returns the table as a section of Markdown: heading, cells, caption. A table without a title
    /// has no heading.
    pub fn markdown(&self) -> String {
        let escaped = |cells: &[String]| cells.iter().map(|cell| cell.replace('|', "\\|")).collect::<Vec<_>>();
        let line = |cells: &[String]| format!("| {} |\n", escaped(cells).join(" | "));
        let heading = if self.title.is_empty() { String::new() } else { format!("### {}\n\n", self.title) };
        let rule = "|---".repeat(self.header.len());
        let rows: String = self.rows.iter().map(|row| line(row)).collect();
        let caption = if self.caption.is_empty() { String::new() } else { format!("\n{}\n", self.caption) };
        format!("{heading}{}{rule}|\n{rows}{caption}", line(&self.header))
    }

    /// Returns the table as text for a terminal, with its title above and its caption below.
    /// Control characters in its texts are escaped.
    #[cfg(feature = "terminal")]
    pub fn terminal(&self, color: bool) -> String {
        use columns::visible;
        use comfy_table::{Cell, Color, ColumnConstraint, Table, Width, presets};
        /// Widest column of prose.
        const MAX_WIDTH: u16 = 44;
        let coloured = |cell: &String| match cell.as_str() {
            "PASS" if color => Cell::new(cell).fg(Color::Green),
            "MISS" if color => Cell::new(cell).fg(Color::Red),
            _ => Cell::new(visible(cell)),
        };
        let mut table = Table::new();
        table.load_style(presets::UTF8_BORDERS_ONLY);
        table.set_header(self.header.iter().map(|heading| visible(heading)));
        for row in &self.rows {
            table.add_row(row.iter().map(coloured));
        }
        for column in table.column_iter_mut() {
            column.set_constraint(ColumnConstraint::UpperBoundary(Width::Fixed(MAX_WIDTH)));
        }
        if color {
            table.enforce_styling();
        } else {
            table.force_no_tty();
        }
        let caption = if self.caption.is_empty() { String::new() } else { format!("{}\n", visible(&self.caption)) };
        format!("{}\n{table}\n{caption}\n", visible(&self.title))
    }
}

/// Returns the cell for a target that is reached or missed.
pub fn verdict(holds: bool) -> &'static str {
    if holds { "PASS" } else { "MISS" }
}

/// Returns tables as sections of Markdown, one after the other.
pub fn markdown(tables: &[TableBlock]) -> String {
    tables.iter().map(TableBlock::markdown).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_in_a_cell_does_not_end_it() {
        let table = TableBlock::new("t", "T", "C.", &["a", "b"], vec![vec!["|x|".to_owned(), "1".to_owned()]]);
        assert_eq!(table.markdown(), "### T\n\n| a | b |\n|---|---|\n| \\|x\\| | 1 |\n\nC.\n");
    }
    #[cfg(feature = "terminal")]
    #[test]
    fn only_own_escape_codes_reach_the_terminal() {
        let hostile = "a\u{1b}]0;b\u{202e}";
        let rows = vec![vec![hostile.to_owned(), "PASS".to_owned()]];
        let text = TableBlock::new("t", hostile, hostile, &[hostile, "b"], rows).terminal(true);
        assert!(!text.contains("\u{1b}]") && !text.contains('\u{202e}') && text.contains("\u{1b}["), "{text:?}");
        assert_eq!(text.matches("\\u{1b}]0;b\\u{202e}").count(), 4, "{text:?}");
    }
}
