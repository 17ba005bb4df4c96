//! Completion and help for a prompt: the next possible words with their units and meanings. The
//! commands are those of a script, read by the same parser. The line editor is elsewhere.

use clap::{Arg, Command};
use firmware::board::parameters::PARAMETERS;
use firmware::seam::config::{Parameter, Range};
use scene::schema::unit_of;

use crate::script::grammar;

/// Words that exist only at a prompt, with their meanings.
pub const PROMPT_WORDS: [(&str, &str); 2] =
    [("help", "List the commands; `help COMMAND` explains one"), ("exit", "Leave, like Ctrl-D; the drive stops")];
/// Words of a script that are not commands to a board.
const SCRIPT_WORDS: [(&str, &str); 1] = [("expect", "Check the last answer: `expect NAME OP VALUE [+- TOLERANCE]`")];

/// Candidate for the next word.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Candidate {
    /// The word.
    pub word: String,
    /// Meaning or unit of the word.
    pub meaning: String,
}

/// Returns the candidates for the last word of a line, and the index at which that word begins.
pub fn candidates(line: &str) -> (usize, Vec<Candidate>) {
    let start = line.rfind(char::is_whitespace).map_or(0, |space| space + line[space..].chars().next().map_or(1, char::len_utf8));
    let mut before: Vec<&str> = line[..start].split_whitespace().collect();
    if before.first() == Some(&"!") {
        before.remove(0);
    }
    let beginning = &line[start..];
    let mut all = following(&before);
    all.retain(|candidate| candidate.word.starts_with(beginning) && (!beginning.is_empty() || !candidate.word.starts_with("--")));
    (start, all)
}

/// Returns a hint for a line that ends after the name of a setting: the unit of its value, or its
/// permitted names.
pub fn hint(line: &str) -> Option<String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let ["settings", "set", name] = words[..] else { return None };
    let parameter = PARAMETERS.iter().find(|parameter| parameter.name == name).filter(|_| line.ends_with(' '))?;
    Some(match parameter.range {
        Range::Choice(names) => names.join(" | "),
        _ => format!("<{}>", unit(parameter)),
    })
}

/// Returns the table of commands, or the help of one command; `None` if there is no such command.
pub fn help(command: Option<&str>) -> Option<String> {
    let grammar = grammar();
    if let Some(name) = command {
        let mut found = grammar.get_subcommands().find(|known| known.get_name() == name)?.clone();
        return Some(found.render_help().to_string());
    }
    let commands = grammar.get_subcommands().map(|command| (command.get_name().to_owned(), about(command)));
    let others = SCRIPT_WORDS.into_iter().chain(PROMPT_WORDS).map(|(name, meaning)| (name.to_owned(), meaning.to_owned()));
    Some(commands.chain(others).map(|(name, meaning)| format!("  {name:11} {meaning}\n")).collect())
}

/// Returns the words that may follow others.
fn following(before: &[&str]) -> Vec<Candidate> {
    let grammar = grammar();
    match before {
        [] => {
            let others = SCRIPT_WORDS.into_iter().chain(PROMPT_WORDS).map(|(word, meaning)| candidate(word, meaning));
            subcommands(&grammar).into_iter().chain(others).collect()
        }
        ["help"] => subcommands(&grammar),
        ["settings", "get" | "list" | "set"] => {
            PARAMETERS.iter().map(|parameter| candidate(parameter.name, &unit(parameter))).collect()
        }
        ["settings", "set", name] => names_of(name),
        words => {
            let deepest = words.iter().try_fold(&grammar, |command, word| match command.find_subcommand(word) {
                Some(found) => Ok(found),
                None => Err(command),
            });
            let command = match deepest {
                Ok(command) | Err(command) => command,
            };
            let last = words.last().and_then(|word| word.strip_prefix("--"));
            // An option that takes one of a few words.
            if let Some(argument) = last.and_then(|name| command.get_arguments().find(|known| known.get_long() == Some(name)))
                && argument.get_action().takes_values()
            {
                return values(argument);
            }
            let places = command.get_arguments().filter(|argument| argument.is_positional()).flat_map(values);
            let options = command.get_arguments().filter_map(|argument| {
                let meaning = argument.get_help().map_or_else(String::new, ToString::to_string);
                Some(candidate(&format!("--{}", argument.get_long()?), &meaning))
            });
            subcommands(command).into_iter().chain(places).chain(options).collect()
        }
    }
}

fn candidate(word: &str, meaning: &str) -> Candidate {
    Candidate { word: word.to_owned(), meaning: meaning.to_owned() }
}

fn about(command: &Command) -> String {
    command.get_about().map_or_else(String::new, ToString::to_string)
}

fn subcommands(command: &Command) -> Vec<Candidate> {
    command.get_subcommands().map(|known| candidate(known.get_name(), &about(known))).collect()
}

fn values(argument: &Arg) -> Vec<Candidate> {
    let meaning = |value: &clap::builder::PossibleValue| value.get_help().map_or_else(String::new, ToString::to_string);
    argument.get_possible_values().iter().map(|value| candidate(value.get_name(), &meaning(value))).collect()
}

/// Returns the names that the value of a setting can have.
fn names_of(name: &str) -> Vec<Candidate> {
    let found = PARAMETERS.iter().find(|parameter| parameter.name == name);
    match found.map(|parameter| parameter.range) {
        Some(Range::Choice(names)) => names.iter().map(|name| candidate(name, "")).collect(),
        _ => Vec::new(),
    }
}

/// Returns the unit of a setting; `1` for a ratio or a count.
fn unit(parameter: &Parameter) -> String {
    if matches!(parameter.range, Range::Choice(_)) {
        "name".into()
    } else {
        unit_of(parameter.name).unwrap_or_else(|| "1".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<String> {
        candidates(line).1.into_iter().map(|candidate| candidate.word).collect()
    }

    #[test]
    fn commands_options_and_settings_are_completed() {
        assert_eq!(words("sc"), ["scan"]);
        assert_eq!(words("! sc"), ["scan"]);
        assert!(words("").iter().any(|word| word == "exit") && words("").iter().any(|word| word == "lock"));
        assert_eq!(words("help loc"), ["lock"]);
        assert_eq!(words("drive --v"), ["--volts"]);
        assert_eq!(words("settings st"), ["store"]);
        assert!(words("settings ").iter().all(|word| !word.starts_with("--")));
        assert_eq!(words("settings set limits.vol"), ["limits.voltage_v"]);
        assert_eq!(words("settings set burst.edge b"), ["boost"]);
        assert!(words("capture --trigger l").contains(&"locked".to_owned()), "{:?}", words("capture --trigger l"));
        assert_eq!(words("scna"), Vec::<String>::new());
        assert_eq!(candidates("settings set limits.vol").0, "settings set ".len());
    }

    #[test]
    fn settings_are_completed_with_their_units() {
        let of = |line: &str| candidates(line).1.into_iter().map(|found| found.meaning).collect::<Vec<_>>();
        assert_eq!(of("settings get limits.voltage_v"), ["V"]);
        assert_eq!(hint("settings set limits.voltage_v ").as_deref(), Some("<V>"));
        assert!(hint("settings set burst.edge ").is_some_and(|names| names.contains("boost")));
        assert_eq!(hint("settings set limits.voltage_v"), None);
    }

    #[test]
    fn help_lists_every_command() {
        let all = help(None).expect("a table");
        assert!(grammar().get_subcommands().all(|command| all.contains(command.get_name())), "{all}");
        assert!(help(Some("drive")).expect("help").contains("--volts") && help(Some("drvie")).is_none());
    }
}
