//! Block of the command-line page with the help of every command.

use super::*;

/// Returns the lines of `sim-host COMMAND -h`. A command of a board gets a port.
fn help_of(command: &[String]) -> Vec<String> {
    let port = ["sim:lock".to_owned()];
    let port = if command.len() > 1 && command[0] == "link" { &port[..] } else { &[] };
    let words = command.iter().take(1).chain(port).chain(command.iter().skip(1));
    let output = Command::new(env!("CARGO_BIN_EXE_sim-host")).args(words).arg("-h").output().expect("sim-host starts");
    String::from_utf8_lossy(&output.stdout).lines().map(|line| line.trim_end().to_owned()).collect()
}

/// Returns the subcommands that a help lists: the lines of its sections other than these.
fn subcommands(help: &[String]) -> Vec<String> {
    let mut is_list = false;
    let mut found = Vec::new();
    for line in help {
        if !line.starts_with(' ') {
            let other = ["Usage", "Arguments:", "Options:", "Examples:", "Exit codes"];
            is_list = line.ends_with(':') && !other.iter().any(|title| line.starts_with(title));
        } else if is_list && line.starts_with("  ") && !line.starts_with("   ") {
            found.extend(line.split_whitespace().next().map(str::to_owned));
        }
    }
    found.retain(|name| name != "help");
    found
}

/// Appends the help of a command and its subcommands, without the options of its parent.
fn append(page: &mut String, command: &[String], parent: &[String]) {
    let help = help_of(command);
    // The columns of both may differ.
    let plain = |line: &String| line.split_whitespace().collect::<Vec<_>>().join(" ");
    let known: Vec<String> = parent.iter().map(plain).collect();
    let is_own =
        |line: &&String| !line.trim_start().starts_with('-') || !(line.contains("-h, --help") || known.contains(&plain(line)));
    let lines = help.iter().take_while(|line| !line.starts_with("Exit codes")).filter(is_own).map(String::as_str);
    // A line of the usage is not a command to run.
    let text = lines.collect::<Vec<_>>().join("\n").replace("\n       sim-host ", "\nor:    sim-host ");
    let text = text.replace("Options:\n\n", "");
    let text = text.trim().trim_end_matches("Options:").trim_end();
    let title = format!("sim-host {}", command.join(" ")).replace("link ", "link PORT ");
    page.push_str(&format!("### {}\n\n```text\n{text}\n```\n\n", title.trim()));
    for name in subcommands(&help) {
        append(page, &[command, &[name]].concat(), &help);
    }
}

/// `UPDATE_DOCS=1 cargo test docs -- --include-ignored` regenerates the block.
#[test]
fn docs_of_the_commands_are_generated_from_their_help() {
    let mut page = String::new();
    append(&mut page, &[], &[]);
    report::docs::block("command-line.md", "sim-host COMMAND -h", &page);
}
