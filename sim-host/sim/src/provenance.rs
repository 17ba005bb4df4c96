//! Provenance of a result: command, commit and date, which the program knows and a study does not.

/// Provenance of a report in addition to the scene and its seed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Provenance {
    /// Command that reproduces the report.
    pub command: Option<String>,
    /// Commit of the program's source.
    pub commit: Option<String>,
    /// Date of the run. A report is identical for every run, and does not contain it.
    pub date: Option<String>,
}

impl Provenance {
    /// Returns the footer of a report: labels and values.
    pub fn footer(&self) -> Vec<(String, String)> {
        let version = ("sim-host", Some(crate::VERSION.to_owned()));
        let known = [version, ("commit", self.commit.clone()), ("command", self.command.clone())];
        known.into_iter().filter_map(|(label, value)| Some((label.to_owned(), value?))).collect()
    }
}

/// Formats a command for a shell: words with special characters are quoted.
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
    fn commands_are_quoted_for_a_shell() {
        let words = ["sim-host", "run", "my scene.toml", "--set", "trace.signals=[\"friction_n\"]", "it's", ""];
        assert_eq!(command_line(words), r#"sim-host run 'my scene.toml' --set 'trace.signals=["friction_n"]' 'it'\''s' ''"#);
    }

    #[test]
    fn unknown_provenance_is_omitted() {
        let labels = |of: &Provenance| of.footer().into_iter().map(|(label, _)| label).collect::<Vec<_>>();
        assert_eq!(labels(&Provenance::default()), ["sim-host"]);
        let known = Provenance { commit: Some("1a2b".into()), ..Provenance::default() };
        assert_eq!(labels(&known), ["sim-host", "commit"]);
    }
}
