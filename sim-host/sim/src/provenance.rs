//! Where a report comes from, as far as a program knows and a study does not: the command, the commit, the date.

/// What a report says of its origin beside the scene and its seed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Provenance {
    /// The command that makes it again.
    pub command: Option<String>,
    /// The commit that the program was built from.
    pub commit: Option<String>,
    /// When it was made.
    pub date: Option<String>,
}

impl Provenance {
    /// What stands at the foot of a report: label and value.
    pub fn footer(&self) -> Vec<(String, String)> {
        let version = ("sim-host", Some(crate::VERSION.to_owned()));
        let known = [version, ("commit", self.commit.clone()), ("date", self.date.clone()), ("command", self.command.clone())];
        known.into_iter().filter_map(|(label, value)| Some((label.to_owned(), value?))).collect()
    }
}

/// A command as a shell reads it back: words with anything but plain characters are quoted.
pub fn command_line<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,+%@".contains(c);
    let quoted = |word: &str| {
        if !word.is_empty() && word.chars().all(plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', "'\\''")) }
    };
    words.into_iter().map(quoted).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_read_back_as_they_were() {
        let words = ["sim-host", "run", "my scene.toml", "--set", "trace.signals=[\"friction_n\"]", "it's", ""];
        assert_eq!(command_line(words), r#"sim-host run 'my scene.toml' --set 'trace.signals=["friction_n"]' 'it'\''s' ''"#);
    }

    #[test]
    fn what_is_not_known_is_not_said() {
        let labels = |of: &Provenance| of.footer().into_iter().map(|(label, _)| label).collect::<Vec<_>>();
        assert_eq!(labels(&Provenance::default()), ["sim-host"]);
        let known = Provenance { commit: Some("1a2b".into()), ..Provenance::default() };
        assert_eq!(labels(&known), ["sim-host", "commit"]);
    }
}
