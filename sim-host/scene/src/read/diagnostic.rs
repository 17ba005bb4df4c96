//! Problems of a scene, shown in the style of a compiler: file, line, column, caret, expected value
//! and help.

use std::fmt;
use std::ops::Range;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use columns::visible_line as visible;

/// A text that problems refer to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Name for the user: a file, a built-in name, `<stdin>`, or `--set`.
    pub name: String,
    /// The text as read.
    pub text: String,
}

/// A range of bytes in one of the sources.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// Index of the source in [`Report::sources`].
    pub source: usize,
    /// Offset of the first byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl Place {
    /// Returns the place of `span` in source number `source`.
    pub fn new(source: usize, span: Range<usize>) -> Self {
        Self { source, start: span.start, end: span.end }
    }
}

/// A mistake in a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Place of the problem in its source.
    pub at: Place,
    /// Description of the mistake, in one line.
    pub message: String,
    /// Text at the caret: the expected value.
    pub label: String,
    /// Advice or further information.
    pub help: Option<String>,
}

impl Problem {
    /// Creates a problem without help.
    pub fn new(at: Place, message: impl Into<String>, label: impl Into<String>) -> Self {
        Self { at, message: message.into(), label: label.into(), help: None }
    }

    /// Adds the help text.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into().replace('\n', " "));
        self
    }
}

/// All problems of a scene, sorted by position.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    sources: Vec<Source>,
    problems: Vec<Problem>,
}

impl Report {
    /// Creates a report with the problems sorted by source and position.
    pub fn new(sources: Vec<Source>, mut problems: Vec<Problem>) -> Self {
        problems.sort_by(|a, b| a.at.cmp(&b.at));
        problems.dedup();
        Self { sources, problems }
    }

    /// Returns the texts that the problems refer to.
    pub fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// Returns the problems, sorted by position.
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// Returns the number of problems.
    pub fn count(&self) -> usize {
        self.problems.len()
    }

    /// Returns the report as text, with escape codes for a terminal if `color`.
    pub fn render(&self, color: bool) -> String {
        let renderer = if color { Renderer::styled() } else { Renderer::plain() };
        let mut out = String::new();
        for problem in &self.problems {
            out += &renderer.render(&[self.group(problem)]);
            out += "\n\n";
        }
        // The renderer replaces the escape characters of the source, but not all others.
        out.split('\u{1b}').map(columns::visible).collect::<Vec<_>>().join("\u{1b}") + &self.summary()
    }

    fn group<'a>(&'a self, problem: &'a Problem) -> Group<'a> {
        let mut group = Group::with_title(Level::ERROR.primary_title(visible(&problem.message)));
        if let Some(source) = self.sources.get(problem.at.source) {
            let span = within(&source.text, problem.at.start..problem.at.end);
            let caret = AnnotationKind::Primary.span(span).label(visible(&problem.label));
            group = group.element(Snippet::source(source.text.as_str()).path(visible(&source.name)).annotation(caret));
        }
        match &problem.help {
            Some(help) => group.element(Level::HELP.message(visible(help))),
            None => group,
        }
    }

    fn summary(&self) -> String {
        let counts = self.sources.iter().enumerate().filter_map(|(number, source)| {
            let count = self.problems.iter().filter(|p| p.at.source == number).count();
            let plural = if count == 1 { "" } else { "s" };
            (count > 0).then(|| format!("{count} problem{plural} in {}", visible(&source.name)))
        });
        counts.collect::<Vec<_>>().join(", ")
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

/// Moves the ends of a span to character boundaries of `text`, and its end to the end of the first
/// line: a table or string over several lines is marked in its first line only.
fn within(text: &str, span: Range<usize>) -> Range<usize> {
    let start = text.floor_char_boundary(span.start.min(text.len()));
    let end = text.ceil_char_boundary(span.end.clamp(start, text.len()));
    let line = text[start..end].find(['\r', '\n']).map_or(end, |length| start + length);
    start..line
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(text: &str, spans: &[(usize, usize)]) -> Report {
        let problems =
            spans.iter().map(|&(start, end)| Problem::new(Place { source: 0, start, end }, "wrong", "here").help("do this"));
        Report::new(vec![Source { name: "a.toml".into(), text: text.into() }], problems.collect())
    }

    #[test]
    fn problems_are_sorted_and_counted() {
        let shown = report("one\ntwo\nthree\n", &[(8, 13), (0, 3)]).render(false);
        let first = shown.find("a.toml:1:1").unwrap();
        let second = shown.find("a.toml:3:1").unwrap();
        assert!(first < second, "{shown}");
        assert!(shown.ends_with("2 problems in a.toml"), "{shown}");
    }

    #[test]
    fn any_span_of_any_text_is_shown() {
        for text in ["", "\n", "a", "ä\r\n\tö", "\u{feff}x = 1\r\n", "x = \"\u{1b}[31m\""] {
            for start in 0..text.len() + 3 {
                for end in 0..text.len() + 3 {
                    assert!(report(text, &[(start, end)]).render(true).contains("a.toml"));
                }
            }
        }
    }

    #[test]
    fn escape_codes_of_the_file_do_not_reach_the_terminal() {
        let mut report = report("x\u{1b}[31m = 1", &[(0, 6)]);
        report.problems[0].message = "unknown key `\u{1b}[31m`".into();
        report.sources[0] = Source { name: "\u{9b}a\n\u{1b}.toml".into(), text: "x\u{1b}[31m\u{9b}\u{202e} = 1".into() };
        let shown = report.render(false);
        assert!(!shown.contains(['\u{1b}', '\u{9b}', '\u{202e}']) && shown.contains("in \\u{9b}a\\n\\u{1b}.toml"), "{shown:?}");
    }
}
