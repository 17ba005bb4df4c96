//! Shell completions and manual pages.

use std::io::Write as _;

use super::{Folder, code, sim_host, stderr, stdout};

#[test]
fn completions_and_manual_pages_know_all_commands() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let text = stdout(&sim_host(&["completions", shell]));
        assert!(["sweep", "advise", "no-report"].iter().all(|word| text.contains(word)), "{shell}: {text}");
    }
    assert!(stderr(&sim_host(&["completions", "bsh"])).contains("bash"));
    assert!(stdout(&sim_host(&["man"])).contains(".TH sim-host 1"));
    let folder = Folder::new("man");
    assert_eq!(code(&sim_host(&["man", "-o", folder.text()])), 0);
    assert!(folder.read("sim-host-run.1").contains("sim\\-host run lock"));
}

/// Checks the syntax of the bash script: a user would meet an error at every start of a shell.
#[test]
#[cfg(unix)]
fn completions_for_bash_can_be_read() {
    use std::process::{Command, Stdio};
    let folder = Folder::new("completions");
    let file = folder.write("completions.bash", &stdout(&sim_host(&["completions", "bash"])));
    match Command::new("bash").args(["-n", &file]).stderr(Stdio::inherit()).status() {
        Ok(status) => assert!(status.success()),
        Err(_) => writeln!(std::io::stderr(), "SKIPPED: bash is not installed").expect("standard error"),
    }
}
