//! `sim-host explain`.

use super::{Exit, mistake};
use scene::nearest::listed;
use sim::explain::{explain, list};

/// Prints the meaning of a word; without a word, a list of everything that can be explained.
pub(super) fn run(word: &str) -> anyhow::Result<Exit> {
    if word.is_empty() {
        return super::print(&list());
    }
    match explain(word) {
        Ok(said) => super::print(&format!("{}\n", said.join("\n\n"))),
        Err(near) => {
            let meant = listed(near.iter().map(String::as_str), "or");
            let meant =
                if near.is_empty() { "`sim-host explain` lists all names".to_owned() } else { format!("did you mean {meant}?") };
            Err(mistake(Exit::Input, format!("unknown name `{word}`; {meant}")))
        }
    }
}
