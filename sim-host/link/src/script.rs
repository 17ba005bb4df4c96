//! Scripts: one command per line, for automated tests of a board.
//!
//! ```text
//! # a comment
//! scan
//! expect series_resonance_hz = 40400 +- 2
//! drive --volts 3
//! wait 0.2
//! ! settings store        # must be refused while the drive is on
//! ```
//!
//! All lines are read before the first is executed: a script with a mistake does nothing. The first
//! line that fails ends the script. A line after `!` must fail.

use std::ops::Range;
use std::time::Duration;

use clap::error::{ContextKind, ContextValue};
use clap::{Parser, Subcommand};

use crate::answer::Answer;
use crate::commands::{Order, seconds};
use crate::expect::Expect;
use crate::link_error::LinkError;
use crate::number_with_unit::belong_together;
use crate::session::Session;
use scene::diagnostic::{Place, Problem, Report, Source};

/// Script of commands, waits and expectations.
#[derive(Clone, Debug)]
pub struct Script {
    name: String,
    lines: Vec<Line>,
}

/// Line of a script with a command.
#[derive(Clone, Debug)]
pub struct Line {
    /// Number of the line, from one.
    pub number: usize,
    /// Text of the line, without its comment.
    pub text: String,
    /// `true` if the command must fail.
    fails: bool,
    step: Step,
}

#[derive(Clone, Debug)]
enum Step {
    Order(Box<Order>),
    Wait(Duration),
    Expect(Expect),
}

/// Returns the grammar of a line as a clap command.
pub(crate) fn grammar() -> clap::Command {
    <Words as clap::CommandFactory>::command().name("link")
}

#[derive(Parser)]
#[command(no_binary_name = true, disable_help_flag = true, disable_help_subcommand = true)]
struct Words {
    #[command(subcommand)]
    step: Word,
}

#[derive(Subcommand)]
enum Word {
    #[command(flatten)]
    Order(Order),
    /// Wait for a number of seconds.
    Wait {
        #[arg(value_parser = seconds)]
        time: f64,
    },
}

impl Script {
    /// Reads a script. `name` is its name in messages.
    pub fn parse(name: &str, text: &str) -> Result<Self, LinkError> {
        let (mut lines, mut problems) = (Vec::new(), Vec::new());
        let mut start = 0;
        for (n, whole) in text.split_inclusive('\n').enumerate() {
            let code = before_comment(whole).trim_end();
            match line(n + 1, code) {
                Ok(found) => lines.extend(found),
                Err((at, message, help)) => {
                    let problem = Problem::new(Place::new(0, start + at.start..start + at.end), message, "here");
                    problems.push(match help {
                        Some(help) => problem.help(help),
                        None => problem,
                    });
                }
            }
            start += whole.len();
        }
        if problems.is_empty() {
            return Ok(Script { name: name.to_owned(), lines });
        }
        Err(LinkError::Script(Report::new(vec![Source { name: name.to_owned(), text: text.to_owned() }], problems)))
    }

    /// Returns `true` if the script contains no command.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// Returns the commands to the board.
    pub fn orders(&self) -> impl Iterator<Item = &Order> {
        self.lines.iter().filter_map(|line| if let Step::Order(order) = &line.step { Some(&**order) } else { None })
    }

    /// Runs the script, and calls `report` with each line and its result. Ends with the first line
    /// that fails.
    pub fn run(
        &self,
        session: &mut Session,
        mut report: impl FnMut(&Line, &Result<Answer, LinkError>) -> Result<(), LinkError>,
    ) -> Result<(), LinkError> {
        for line in &self.lines {
            let mut done = match &line.step {
                Step::Order(order) => order.run(session),
                Step::Wait(time) => session.wait(*time).map(|()| Answer::to("wait").field("s", time.as_secs_f64())),
                Step::Expect(expect) => expect.judge(&session.last),
            };
            if line.fails {
                done = opposite(done);
                session.last = done.as_ref().cloned().unwrap_or_default();
            }
            report(line, &done)?;
            if let Err(error) = done {
                return Err(LinkError::At { place: format!("{}:{}", self.name, line.number), error: Box::new(error) });
            }
        }
        Ok(())
    }
}

impl Line {
    /// Returns the name of the line's command.
    pub fn name(&self) -> &'static str {
        match &self.step {
            Step::Order(order) => order.name(),
            Step::Wait(_) => "wait",
            Step::Expect(_) => "expect",
        }
    }
}

/// Inverts the result of a line that must fail. A lost link and Ctrl-C remain errors.
fn opposite(done: Result<Answer, LinkError>) -> Result<Answer, LinkError> {
    match done {
        Ok(answer) => Err(LinkError::Failed(format!("`{}` should have failed but succeeded", answer.command))),
        Err(error) if error.is_lost() || matches!(error, LinkError::Interrupted) => Err(error),
        Err(error) => {
            let refusal = if let LinkError::Refused { refusal, .. } = &error { crate::refusal::name(*refusal) } else { "failed" };
            Ok(Answer::to("!").line(format!("as expected: {error}")).field("refusal", refusal).field("error", error.to_string()))
        }
    }
}

/// Mistake in a line: its place, a message, and a hint.
type Mistake = (Range<usize>, String, Option<String>);

fn line(number: usize, text: &str) -> Result<Option<Line>, Mistake> {
    let mut words = words(text)?;
    let fails = words.first().is_some_and(|(word, _)| word == "!");
    if fails {
        words.remove(0);
    }
    let end = text.len()..text.len();
    let Some((first, _)) = words.first() else {
        return if fails { Err((end, "a command is missing after `!`".into(), None)) } else { Ok(None) };
    };
    let is_expectation = first == "expect";
    if !is_expectation {
        words = words.into_iter().fold(Vec::new(), join);
    }
    let step = if is_expectation {
        let rest: Vec<&str> = words[1..].iter().map(|(word, _)| word.as_str()).collect();
        let expect = Expect::parse(&rest).map_err(|(place, why)| {
            let at = words.get(place + 1).map_or(end, |(_, at)| at.clone());
            (at, why, None)
        })?;
        Step::Expect(expect)
    } else {
        let parsed = Words::try_parse_from(words.iter().map(|(word, _)| word)).map_err(|error| mistake(&error, &words, text))?;
        match parsed.step {
            Word::Order(order) => Step::Order(Box::new(order)),
            Word::Wait { time } => Step::Wait(Duration::from_secs_f64(time)),
        }
    };
    Ok(Some(Line { number, text: text.trim().to_owned(), fails, step }))
}

/// Returns a line without its comment. A `#` within quotes does not begin a comment.
fn before_comment(line: &str) -> &str {
    let mut quoted = false;
    let comment = line.find(|letter| {
        quoted ^= letter == '"';
        letter == '#' && !quoted
    });
    &line[..comment.unwrap_or(line.len())]
}

/// Splits a line into words with their places. Quotes keep spaces in a word.
fn words(text: &str) -> Result<Vec<(String, Range<usize>)>, Mistake> {
    let mut words: Vec<(String, Range<usize>)> = Vec::new();
    let (mut open, mut quoted) = (false, None);
    for (n, letter) in text.char_indices() {
        match letter {
            '"' if quoted.is_some() => quoted = None,
            '"' => {
                quoted = Some(n);
                if !open {
                    words.push((String::new(), n..n));
                    open = true;
                }
            }
            letter if letter.is_whitespace() && quoted.is_none() => open = false,
            letter => {
                if !open {
                    words.push((String::new(), n..n));
                    open = true;
                }
                if let Some((word, _)) = words.last_mut() {
                    word.push(letter);
                }
            }
        }
        if let Some((_, at)) = words.last_mut().filter(|_| open) {
            at.end = n + letter.len_utf8();
        }
    }
    match quoted {
        Some(at) => Err((at..at + 1, "this quote is not closed".into(), None)),
        None => Ok(words),
    }
}

/// Appends a word; a unit joins the number before it.
fn join(mut words: Vec<(String, Range<usize>)>, (word, at): (String, Range<usize>)) -> Vec<(String, Range<usize>)> {
    match words.last_mut().filter(|(last, _)| belong_together(last, &word)) {
        Some((number, place)) => {
            *number += &word;
            place.end = at.end;
        }
        None => words.push((word, at)),
    }
    words
}

/// Converts an error of clap to a mistake at the word that it refuses.
fn mistake(error: &clap::Error, words: &[(String, Range<usize>)], text: &str) -> Mistake {
    let context = |kind: ContextKind| match error.get(kind) {
        Some(ContextValue::String(word)) => Some(word.clone()),
        _ => None,
    };
    let whole = text.len() - text.trim_start().len()..text.len();
    let kinds = [ContextKind::InvalidValue, ContextKind::InvalidSubcommand, ContextKind::InvalidArg];
    let at = kinds.into_iter().filter_map(context).find_map(|wrong| {
        let is_it = |word: &str| word == wrong || wrong.split([' ', '=']).next() == Some(word);
        words.iter().find(|(word, _)| is_it(word)).map(|(_, at)| at.clone())
    });
    let rendered = error.render().to_string();
    let mut paragraphs = rendered.split("\n\n");
    let message = paragraphs.next().unwrap_or_default().trim_start_matches("error: ");
    let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
    let help = paragraphs
        .find_map(|text| text.trim().strip_prefix("tip: ").map(|tip| tip.split_whitespace().collect::<Vec<_>>().join(" ")));
    (at.unwrap_or(whole), message, help)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mistakes(text: &str) -> String {
        match Script::parse("rig.txt", text) {
            Err(LinkError::Script(report)) => report.render(false),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn comments_are_skipped_and_quotes_keep_spaces() {
        let script = Script::parse("rig.txt", "# a rig\n\nscan -o \"my folder\" # loop\n! settings store\nwait 0.5\n").unwrap();
        let lines: Vec<(usize, &str, &str)> =
            script.lines.iter().map(|line| (line.number, line.name(), line.text.as_str())).collect();
        assert_eq!(lines, [(3, "scan", "scan -o \"my folder\""), (4, "settings", "! settings store"), (5, "wait", "wait 0.5")]);
        assert!(script.lines[1].fails && !script.lines[0].fails);
    }

    #[test]
    fn all_mistakes_are_reported_with_line_and_caret() {
        let text = mistakes("identify\nscna\ndrive --volts much\n  expect q ~ 3\nwait\nscan -o \"x\n!\n");
        for part in [
            "rig.txt:2:1",
            "a similar subcommand exists: 'scan'",
            "rig.txt:3:15",
            "expected volts, such as 2, 2V or 500mV",
            "rig.txt:4:12",
            "one of = != < <= > >= is required here",
            "rig.txt:5:1",
            "rig.txt:6:9",
            "this quote is not closed",
            "rig.txt:7:2",
            "6 problems in rig.txt",
        ] {
            assert!(text.contains(part), "{part}\n{text}");
        }
        assert!(text.contains("^^^^ here"), "{text}");
    }
}
