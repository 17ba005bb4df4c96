//! What a prompt knows of its commands: which words may come next, with their units, and what they mean. The commands are those of a script, read by the
//! same parser; who edits the line is not here.

use clap::{Arg, Command};
use firmware::board::parameters::PARAMETERS;
use firmware::seam::config::{Parameter, Range};
use scene::schema::unit_of;

use crate::script::grammar;

/// Words that only a prompt has, and what they do.
pub const OWN: [(&str, &str); 2] =
    [("help", "What there is to say; `help COMMAND`: how to say it"), ("exit", "Leave, as Ctrl-D does; the drive falls silent")];
/// Words of a script that are no commands of a board.
const OF_SCRIPTS: [(&str, &str); 1] = [("expect", "Check the last answer: `expect NAME OP VALUE [+- TOLERANCE]`")];

/// A word that may come next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Candidate {
    /// The word.
    pub word: String,
    /// What it is: a meaning, or a unit.
    pub meaning: String,
}

/// The words that may stand at the end of a line, and where the present beginning of that word is.
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

/// What the value of a setting is, where the line ends after its name: its unit, and its names or its default range.
pub fn hint(line: &str) -> Option<String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let ["settings", "set", name] = words[..] else { return None };
    let parameter = PARAMETERS.iter().find(|parameter| parameter.name == name).filter(|_| line.ends_with(' '))?;
    Some(match parameter.range {
        Range::Choice(names) => names.join(" | "),
        _ => format!("<{}>", unit(parameter)),
    })
}

/// The table of commands, or how one is said. None where there is no such command.
pub fn help(command: Option<&str>) -> Option<String> {
    let grammar = grammar();
    if let Some(name) = command {
        let mut found = grammar.get_subcommands().find(|known| known.get_name() == name)?.clone();
        return Some(found.render_help().to_string());
    }
    let commands = grammar.get_subcommands().map(|command| (command.get_name().to_owned(), about(command)));
    let others = OF_SCRIPTS.into_iter().chain(OWN).map(|(name, meaning)| (name.to_owned(), meaning.to_owned()));
    Some(commands.chain(others).map(|(name, meaning)| format!("  {name:11} {meaning}\n")).collect())
}

/// The words that may follow others.
fn following(before: &[&str]) -> Vec<Candidate> {
    let grammar = grammar();
    match before {
        [] => {
            let others = OF_SCRIPTS.into_iter().chain(OWN).map(|(word, meaning)| candidate(word, meaning));
            subcommands(&grammar).into_iter().chain(others).collect()
        }
        ["help"] => subcommands(&grammar),
        ["settings", "get" | "set"] => PARAMETERS.iter().map(|parameter| candidate(parameter.name, &unit(parameter))).collect(),
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
            // The value of an option, where it is one of a few words.
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

/// The names that the value of a setting has.
fn names_of(name: &str) -> Vec<Candidate> {
    let found = PARAMETERS.iter().find(|parameter| parameter.name == name);
    match found.map(|parameter| parameter.range) {
        Some(Range::Choice(names)) => names.iter().map(|name| candidate(name, "")).collect(),
        _ => Vec::new(),
    }
}

/// Unit of a setting; `1` of a ratio or a count.
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
    fn commands_options_settings_and_their_names_are_completed() {
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
    fn settings_have_their_units() {
        let of = |line: &str| candidates(line).1.into_iter().map(|found| found.meaning).collect::<Vec<_>>();
        assert_eq!(of("settings get limits.voltage_v"), ["V"]);
        assert_eq!(hint("settings set limits.voltage_v ").as_deref(), Some("<V>"));
        assert!(hint("settings set burst.edge ").is_some_and(|names| names.contains("boost")));
        assert_eq!(hint("settings set limits.voltage_v"), None);
    }

    #[test]
    fn help_is_made_of_the_commands_themselves() {
        let all = help(None).expect("a table");
        assert!(grammar().get_subcommands().all(|command| all.contains(command.get_name())), "{all}");
        assert!(help(Some("drive")).expect("help").contains("--volts") && help(Some("drvie")).is_none());
    }
}
