//! Tables for the terminal.

use comfy_table::{Cell, ColumnConstraint, Table, presets};

use report::TableBlock;

/// Widest column of prose.
const WIDEST: u16 = 44;

/// A table as text, with its title above and its caption below.
pub(super) fn render(block: &TableBlock, color: bool) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_BORDERS_ONLY);
    table.set_header(&block.header);
    for row in &block.rows {
        table.add_row(row.iter().map(|cell| coloured(cell, color)));
    }
    for column in table.column_iter_mut() {
        column.set_constraint(ColumnConstraint::UpperBoundary(comfy_table::Width::Fixed(WIDEST)));
    }
    if !color {
        table.force_no_tty();
    } else {
        table.enforce_styling();
    }
    let caption = if block.caption.is_empty() { String::new() } else { format!("{}\n", block.caption) };
    format!("{}\n{table}\n{caption}\n", block.title)
}

fn coloured(cell: &str, color: bool) -> Cell {
    match cell {
        "PASS" if color => Cell::new(cell).fg(comfy_table::Color::Green),
        "MISS" if color => Cell::new(cell).fg(comfy_table::Color::Red),
        _ => Cell::new(cell),
    }
}
