//! Shell completions and manual pages, generated from the command line.

use std::fs;
use std::path::Path;

use clap_complete::Shell;

use super::{Exit, print};

/// Name of the program.
const NAME: &str = "sim-host";

/// Prints the completions for a shell.
pub(super) fn completions(shell: Shell) -> anyhow::Result<Exit> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut super::command(), NAME, &mut text);
    print(&String::from_utf8(text)?)
}

/// Prints the manual page of the program, or writes it and one page per command into a folder.
pub(super) fn manual(dir: Option<&Path>) -> anyhow::Result<Exit> {
    let Some(dir) = dir else {
        let mut text = Vec::new();
        clap_mangen::Man::new(super::command()).render(&mut text)?;
        return print(&String::from_utf8(text)?);
    };
    fs::create_dir_all(dir)?;
    clap_mangen::generate_to(super::command(), dir)?;
    Ok(Exit::Done)
}
