//! The page: the whole report in one HTML file.
//!
//! Style, script and data are in the file itself, and a policy in its head forbids the browser to
//! fetch anything else. Every text of the report is user input: it is escaped when it is inserted
//! into the markup. The data block for the script cannot contain the end of its own element.

use rayon::prelude::*;

use super::crash_section;
use super::draw::{self, Canvas};
use super::plot_data::{can_zoom, map_data, plot_data};
use super::prepare::{panel as lower, prepared};
use crate::TableBlock;
use crate::drawing::PictureFormat;
use crate::figure::{Figure, Report};

const STYLE: [&str; 2] = [include_str!("../../assets/uPlot.min.css"), include_str!("../../assets/report.css")];
const PLOT_LIBRARY: &str = include_str!("../../assets/uPlot.iife.min.js");
const PLOT_LICENSE: &str = include_str!("../../assets/uPlot.LICENSE");
const SCRIPT: &str = include_str!("../../assets/report.js");
const MAP_SCRIPT: &str = include_str!("../../assets/map.js");

/// Content security policy. Pictures may be part of the page, as for maps; pictures of other
/// origins are not loaded.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

/// Largest number of figures without a list of contents.
const MAX_FIGURES_WITHOUT_CONTENTS: usize = 6;

/// Returns the page as HTML; fails if a static picture cannot be drawn.
pub(super) fn page(report: &Report, formats: &[PictureFormat]) -> Result<String, String> {
    let title = escape(&report.title);
    let [library_style, own_style] = STYLE;
    let mut panels = report.figures.par_iter().map(|figure| panel(figure, formats)).collect::<Result<Vec<_>, _>>()?.into_iter();
    let body: String = [
        heading(report),
        tiles(&report.summary),
        // The answer and its figure come first, the reasons follow.
        panels.next().unwrap_or_default(),
        report.paragraphs.iter().map(|p| format!("<p class=\"prose\">{}</p>\n", prose(p))).collect(),
        report.crash.as_ref().map(crash_section::section).transpose()?.unwrap_or_default(),
        contents(&report.figures),
        report.tables.iter().map(table).collect(),
        panels.collect(),
        report.appendix.iter().map(table).collect(),
        footer(&report.footer),
        scripts(&report.figures)?,
    ]
    .concat();
    Ok(format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
         <title>{title}</title>\n<style>\n{library_style}\n{own_style}</style>\n</head>\n\
         <body>\n{body}</body>\n</html>\n"
    ))
}

/// Escapes text for markup and attribute values.
fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            other if is_forbidden(other) => safe.push('\u{fffd}'),
            other => safe.push(other),
        }
    }
    safe
}

/// Returns `true` for a character that XML does not allow, not even escaped.
pub(super) fn is_forbidden(letter: char) -> bool {
    letter.is_control() && !matches!(letter, '\t' | '\n' | '\r') || matches!(letter, '\u{fffe}' | '\u{ffff}')
}

/// Escapes a sentence; names between backticks are code.
fn prose(text: &str) -> String {
    let parts: Vec<String> = text.split('`').map(escape).collect();
    if parts.len().is_multiple_of(2) {
        return parts.join("`");
    }
    let code = |(at, part): (usize, &String)| if at % 2 == 1 { format!("<code>{part}</code>") } else { part.clone() };
    parts.iter().enumerate().map(code).collect()
}

/// Returns a text element, or nothing for an empty text.
fn element(open: &str, text: &str, close: &str) -> String {
    if text.is_empty() { String::new() } else { format!("{open}{}{close}\n", prose(text)) }
}

fn heading(report: &Report) -> String {
    let mut html = String::from("<header>\n");
    html += &element("<h1>", &report.title, "</h1>");
    html += &element("<p class=\"subtitle\">", &report.subtitle, "</p>");
    if report.interrupted {
        html += "<p class=\"banner\" role=\"status\">Interrupted: the run was stopped early. \
                 This report contains the results up to that point.</p>\n";
    }
    html + "</header>\n"
}

fn tiles(summary: &[(String, String)]) -> String {
    wrapped("<dl class=\"tiles\">\n", definitions(summary, result), "</dl>\n")
}

/// Returns a result, with its interval on a line of its own. A number and its unit stay together.
fn result(value: &str) -> String {
    let joined = |text: &str| {
        let is_unit = |word: &str| word != "to" && word.starts_with(|c: char| c.is_alphabetic() || c == '%');
        text.split(' ').fold(String::new(), |line, word| match line.chars().last() {
            None => word.to_owned(),
            Some(last) if last.is_ascii_digit() && is_unit(word) => format!("{line}\u{a0}{word}"),
            Some(_) => format!("{line} {word}"),
        })
    };
    match value.split_once(" (") {
        Some((value, rest)) => format!("{} <small>{}</small>", escape(&joined(value)), escape(&joined(&format!("({rest}")))),
        None => escape(&joined(value)),
    }
}

fn footer(entries: &[(String, String)]) -> String {
    wrapped("<footer>\n<dl>\n", definitions(entries, escape), "</dl>\n</footer>\n")
}

fn definitions(entries: &[(String, String)], shown: fn(&str) -> String) -> String {
    let pair = |(label, value): &(String, String)| format!("<div><dt>{}</dt><dd>{}</dd></div>\n", escape(label), shown(value));
    entries.iter().map(pair).collect()
}

fn wrapped(open: &str, content: String, close: &str) -> String {
    if content.is_empty() { content } else { [open, &content, close].concat() }
}

fn contents(figures: &[Figure]) -> String {
    if figures.len() <= MAX_FIGURES_WITHOUT_CONTENTS {
        return String::new();
    }
    let items: String =
        figures.iter().map(|f| format!("<li><a href=\"#{}\">{}</a></li>\n", escape(&f.id), escape(&f.title))).collect();
    format!("<nav aria-label=\"Figures\">\n<ol>\n{items}</ol>\n</nav>\n")
}

fn table(block: &TableBlock) -> String {
    let numeric: Vec<bool> = (0..block.header.len())
        .map(|column| {
            let mut cells = block.rows.iter().filter_map(|row| row.get(column)).peekable();
            cells.peek().is_some() && cells.all(|cell| is_number(cell))
        })
        .collect();
    let class = |column: usize, cell: &str| {
        if cell.starts_with("PASS") {
            " class=\"pass\""
        } else if cell.starts_with("MISS") {
            " class=\"miss\""
        } else if numeric.get(column) == Some(&true) {
            " class=\"number\""
        } else {
            ""
        }
    };
    let line = |tag: &str, cells: &[String]| {
        let scope = if tag == "th" { " scope=\"col\"" } else { "" };
        let cell = |(i, cell): (usize, &String)| format!("<{tag}{scope}{}>{}</{tag}>", class(i, cell), escape(cell));
        let cells: String = cells.iter().enumerate().map(cell).collect();
        format!("<tr>{cells}</tr>\n")
    };
    format!(
        "<section id=\"{}\">\n{}<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{}\"><table class=\"data\">\n<thead>\n{}</thead>\n\
         <tbody>\n{}</tbody>\n</table></div>\n{}</section>\n",
        escape(&block.id),
        element("<h2>", &block.title, "</h2>"),
        escape(&block.title),
        line("th", &block.header),
        block.rows.iter().map(|row| line("td", row)).collect::<String>(),
        element("<p class=\"caption\">", &block.caption, "</p>"),
    )
}

/// Returns `true` if a cell belongs in a column of numbers, which may also contain empty cells and
/// dashes.
fn is_number(cell: &str) -> bool {
    let unsigned = cell.trim_start_matches(['-', '+', '−', '±', '<', '>', '≤', '≥', '≈', '.', ' ']);
    unsigned.starts_with(|c: char| c.is_ascii_digit()) || matches!(cell, "" | "-" | "–" | "—")
}

fn panel(figure: &Figure, formats: &[PictureFormat]) -> Result<String, String> {
    let id = escape(&figure.id);
    let card = if can_zoom(figure) {
        let label = format!(" tabindex=\"0\" role=\"group\" aria-label=\"{}\"", escape(&figure.title));
        let below: String =
            (0..figure.panels.len()).map(|place| format!("<div id=\"plot-{id}-{}\"{label}></div>\n", place + 2)).collect();
        format!(
            "<div class=\"card\">\n<div id=\"plot-{id}\"{label}><noscript>This figure needs JavaScript; see \
             {id}.svg.</noscript></div>\n{below}<p class=\"hint\">{}Drag to zoom, double-click to reset; arrow \
             keys read values; click a name to hide its curve.</p>\n</div>\n",
            shading(figure)
        )
    } else {
        let shape = if figure.is_plane() { "card square" } else { "card" };
        let label = escape(&figure.title);
        let picture = draw::svg(figure, Canvas { untitled: true, ..Canvas::default() })?;
        let picture = format!("role=\"img\" aria-label=\"{label}\">\n{picture}</div>\n");
        let drawn = prepared(figure);
        match drawn.map.as_ref().filter(|_| figure.interactive) {
            Some(map) => format!(
                "<div class=\"card map\" tabindex=\"0\" role=\"group\" aria-label=\"{label}\">\n<div {picture}\
                 <output aria-live=\"polite\"></output>\n<p class=\"hint\"></p>\n\
                 <script type=\"application/json\">{}</script>\n</div>\n",
                map_data(&drawn, map).to_string().replace('<', "\\u003c")
            ),
            None => format!("<div class=\"{shape}\" {picture}"),
        }
    };
    let files: Vec<String> = formats
        .iter()
        .map(|format| format.ending())
        .chain(["csv"])
        .map(|kind| format!("<a href=\"{id}.{kind}\">{}</a>", kind.to_uppercase()))
        .collect();
    Ok(format!(
        "<figure id=\"{id}\">\n{}{card}<figcaption>\n<p>{}</p>\n\
         <span class=\"files\" title=\"Files next to this page\">{}</span>\n</figcaption>\n</figure>\n",
        element("<h2>", &figure.title, "</h2>"),
        prose(&figure.caption),
        files.join(" · "),
    ))
}

/// Returns the meaning of the shading, as an interval can be too narrow for its label.
fn shading(figure: &Figure) -> String {
    let mut labels: Vec<&str> = figure.shaded.iter().map(|s| s.label.as_str()).filter(|l| !l.is_empty()).collect();
    labels.sort_unstable();
    labels.dedup();
    wrapped("Shaded: ", escape(&labels.join(", ")), ". ")
}

/// Returns the plotting library, the data and the script, if any figure needs them.
fn scripts(figures: &[Figure]) -> Result<String, String> {
    let drawn: Vec<Figure> =
        figures.par_iter().filter(|figure| can_zoom(figure)).map(|figure| prepared(figure).into_owned()).collect();
    // Each plot of a figure, and the number of curves above it.
    let plots: Vec<(Figure, usize)> = drawn.into_iter().flat_map(plots).collect();
    let data: Vec<_> = plots.iter().map(|(figure, first)| plot_data(figure, *first)).collect();
    let reads_maps = figures.iter().any(|figure| figure.interactive && figure.map.is_some());
    let maps = if reads_maps { format!("<script>\n{MAP_SCRIPT}</script>\n") } else { String::new() };
    if data.is_empty() {
        return Ok(maps);
    }
    let json = serde_json::to_string(&data).map_err(|e| e.to_string())?.replace('<', "\\u003c");
    Ok(format!(
        "{maps}<script>/*\n{PLOT_LICENSE}*/\n{PLOT_LIBRARY}</script>\n\
         <script id=\"figure-data\" type=\"application/json\">{json}</script>\n\
         <script>\n{SCRIPT}</script>\n"
    ))
}

/// Returns the plots of a figure as figures, from top to bottom, each with the number of curves
/// above it.
fn plots(figure: Figure) -> Vec<(Figure, usize)> {
    let below: Vec<Figure> = (0..figure.panels.len()).map(|place| lower(&figure, place)).collect();
    let repeats: Vec<bool> = std::iter::once(false).chain(figure.panels.iter().map(|panel| panel.repeats)).collect();
    let mut first = 0;
    let counted = |(figure, repeats): (Figure, bool)| {
        let above = if repeats { 0 } else { first };
        first = if repeats { first } else { first + figure.series.len() };
        (figure, above)
    };
    std::iter::once(figure).chain(below).zip(repeats).map(counted).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{HeatMap, Series};

    const EVIL: &str = "</script><b onclick=\"x\">&'\u{1b}[2J\0";

    fn figure(interactive: bool) -> Figure {
        Figure {
            id: "one".into(),
            title: EVIL.into(),
            interactive,
            series: vec![Series { name: EVIL.into(), ..Series::default() }],
            ..Figure::default()
        }
    }

    #[test]
    fn hostile_text_is_escaped() {
        let report = Report {
            title: EVIL.into(),
            subtitle: EVIL.into(),
            summary: vec![(EVIL.into(), EVIL.into())],
            paragraphs: vec![EVIL.into()],
            tables: vec![TableBlock {
                id: EVIL.into(),
                header: vec![EVIL.into()],
                rows: vec![vec![EVIL.into()]],
                ..TableBlock::default()
            }],
            crash: None,
            figures: vec![figure(true)],
            appendix: Vec::new(),
            footer: vec![(EVIL.into(), EVIL.into())],
            interrupted: true,
        };
        let html = page(&report, &PictureFormat::ALL).unwrap();
        assert!(!html.contains("<b onclick") && !html.contains(is_forbidden) && html.contains("\u{fffd}[2J"));
        assert_eq!(html.matches("</script>").count(), 3);
    }

    #[test]
    fn the_library_comes_only_with_figures_that_need_it() {
        let with = |figure| {
            let report = Report { figures: vec![figure], ..Report::default() };
            page(&report, &PictureFormat::ALL).unwrap()
        };
        assert!(with(figure(true)).contains("uPlot="));
        assert!(!with(figure(false)).contains("<script"));
        assert!(with(figure(false)).contains("<svg "));
        let cells = HeatMap { columns: vec![vec![0.5; 2]; 2], label: EVIL.into(), ..HeatMap::default() };
        let map = with(Figure { map: Some(cells), ..figure(true) });
        assert!(map.contains("class=\"card map\"") && !map.contains("uPlot=") && map.matches("</script>").count() == 2);
    }

    /// The answer and its figure are before everything else.
    #[test]
    fn the_first_figure_follows_the_tiles() {
        let summary = vec![("ratio".to_owned(), "0.068 N (95 %: 0.061 to 0.129) (assumed)".to_owned())];
        let report =
            Report { summary, paragraphs: vec!["Reason `a<b`".into()], figures: vec![figure(false)], ..Report::default() };
        let html = page(&report, &PictureFormat::ALL).unwrap();
        let at = |text: &str| html.find(text).unwrap_or_else(|| panic!("{text}: {html}"));
        assert!(at("<dl class=\"tiles\">") < at("<figure") && at("<figure") < at("Reason"));
        at("0.068\u{a0}N <small>(95\u{a0}%: 0.061 to 0.129) (assumed)</small>");
        at("Reason <code>a&lt;b</code>");
    }

    #[test]
    fn columns_of_numbers_and_verdicts_are_marked() {
        let cells = |texts: [&str; 3]| texts.map(String::from).to_vec();
        let html = table(&TableBlock {
            header: cells(["Quantity", "Value", "Verdict"]),
            rows: vec![cells(["µ", "−0.1 N", "PASS"]), cells(["f", "", "MISS by 2 Hz"])],
            ..TableBlock::default()
        });
        assert!(html.contains("<th scope=\"col\" class=\"number\">Value</th>"));
        assert!(html.contains("<td class=\"number\">−0.1 N</td>"));
        assert!(html.contains("<td class=\"pass\">PASS</td>"));
        assert!(html.contains("<td class=\"miss\">MISS by 2 Hz</td>"));
        assert!(html.contains("<td>µ</td>"));
    }
}
