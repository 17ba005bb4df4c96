//! Prompt of `sim-host link PORT`, with and without a terminal.

use std::fs::File;
use std::io::{Read, Write};
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use super::{Folder, code, sim_host, stderr, stdout};

/// Runs `sim-host` with these arguments and lines on standard input.
fn asked(arguments: &[&str], lines: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_sim-host"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("sim-host starts");
    // A program that ends before the last line closes its standard input.
    let _ = child.stdin.take().expect("its input").write_all(lines.as_bytes());
    child.wait_with_output().expect("its output")
}

#[test]
fn lines_run_in_order_and_errors_show_a_caret() {
    let output =
        asked(&["link", "sim:lock"], "scan\nexpect q > 60\nscna\nlock\nsettings get limit.voltage_v\nhelp drive\nexit\nstatus\n");
    let (out, err) = (stdout(&output), stderr(&output));
    assert_eq!(code(&output), 1, "{err}");
    for part in ["> scan\n", "q is 64.", "`stop` ends it", "--volts <V>"] {
        assert!(out.contains(part), "{part}\n{out}");
    }
    assert!(!out.contains("> status"), "{out}");
    for part in [
        "<prompt>:1:1",
        "^^^^ here",
        "'scan'",
        "did you mean `limits.voltage_v`?",
        "the drive is silent now",
        "2 of 7 lines failed",
    ] {
        assert!(err.contains(part), "{part}\n{err}");
    }
    assert_eq!(code(&asked(&["link", "sim:lock"], "status\n")), 0);
}

#[test]
fn a_single_lock_command_reports_the_end_of_its_drive() {
    let output = sim_host(&["link", "sim:lock", "lock"]);
    assert!(stdout(&output).contains("it stops now, at the end of this command"), "{}", stdout(&output));
    assert!(stderr(&output).contains("the drive is silent now"), "{}", stderr(&output));
    let stays = sim_host(&["link", "sim:lock", "lock", "--stay"]);
    assert!(stdout(&stays).contains("it ends with this program, which contains the board"), "{}", stdout(&stays));
}

#[test]
fn a_simulated_board_keeps_its_flash_in_a_file() {
    let folder = Folder::new("link-flash");
    let flash = format!("{}/board.flash", folder.text());
    let get = |more: &[&str]| {
        let output = sim_host(&[&["link", "sim:lock", "settings", "get", "limits.voltage_v", "--format", "json"], more].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        stdout(&output)
    };
    let fresh = get(&["--flash", &flash]);
    assert_eq!(fresh, get(&[]));
    let stored = asked(&["link", "sim:lock", "--flash", &flash], "settings set limits.voltage_v 3.5\nsettings store\n");
    assert_eq!(code(&stored), 0, "{}", stderr(&stored));
    assert!(get(&["--flash", &flash]).contains("3.5") && get(&[]) == fresh);
    folder.write("board.flash", "no flash");
    let refused = sim_host(&["link", "sim:lock", "status", "--flash", &flash]);
    assert!(code(&refused) == 3 && stderr(&refused).contains("has 8 bytes"), "{}", stderr(&refused));
    let other = sim_host(&["link", "/dev/ttyNOT", "status", "--flash", &flash]);
    assert!(code(&other) == 2 && stderr(&other).contains("--flash needs sim:SCENE"), "{}", stderr(&other));
}

/// Program with its own terminal.
struct AtTerminal {
    child: Child,
    keys: File,
    seen: Arc<Mutex<String>>,
    /// Number of bytes up to the end of the last match.
    read: usize,
}

impl AtTerminal {
    fn new(arguments: &[&str], state: &str) -> Self {
        use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
        let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
        grantpt(&ours).and_then(|()| unlockpt(&ours)).expect("a terminal");
        let name = ptsname(&ours, Vec::new()).expect("its name");
        let end = || File::options().read(true).write(true).open(name.to_str().expect("a path")).expect("its other end");
        // In its own session, so that the keys of this terminal signal only this program.
        let child = Command::new("setsid")
            .args(["--ctty", env!("CARGO_BIN_EXE_sim-host")])
            .args(arguments)
            .env("XDG_STATE_HOME", state)
            .env("TERM", "xterm")
            .stdin(end())
            .stdout(end())
            .stderr(end())
            .spawn()
            .expect("`setsid` starts");
        let keys = File::from(ours);
        let mut screen = keys.try_clone().expect("a second handle");
        let seen = Arc::new(Mutex::new(String::new()));
        let shown = Arc::clone(&seen);
        thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(count) = screen.read(&mut bytes) {
                shown.lock().expect("the text").push_str(&String::from_utf8_lossy(&bytes[..count]));
            }
        });
        AtTerminal { child, keys, seen, read: 0 }
    }

    /// Types, and waits until `until` appears on the screen after it; without keys, after the last
    /// match.
    fn types(&mut self, keys: &str, until: &str) {
        let before = if keys.is_empty() { self.read } else { self.seen.lock().expect("the text").len() };
        self.keys.write_all(keys.as_bytes()).expect("typed");
        let began = Instant::now();
        loop {
            let seen = self.seen.lock().expect("the text").clone();
            if let Some(at) = seen[before..].find(until) {
                self.read = before + at + until.len();
                return;
            }
            assert!(began.elapsed() < Duration::from_secs(60), "{keys:?}: no {until:?} in\n{seen}");
            thread::sleep(Duration::from_millis(10));
        }
    }

    /// Waits for the next prompt: the terminal handles keys that come before it, and loses Ctrl-D.
    fn wait_for_prompt(&mut self) {
        self.types("", "sim:lock> ");
    }
}

impl Drop for AtTerminal {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_terminal_completes_words_and_ctrl_c_silences() {
    let folder = Folder::new("link-prompt");
    let mut prompt = AtTerminal::new(&["link", "sim:lock"], folder.text());
    prompt.wait_for_prompt();
    // A word and its unit.
    prompt.types("settings set limits.vol\t", "limits.voltage_v <V>");
    prompt.types("3\r", "limits.voltage_v = 3");
    prompt.wait_for_prompt();
    prompt.types("lo\t\r", "`stop` ends it");
    // The line above the prompt is updated while nothing is typed.
    prompt.types("", "\x1b[1A");
    prompt.types("\x03", "the drive is silent");
    prompt.types("", "idle ");
    prompt.wait_for_prompt();
    prompt.types("scna\r", "here");
    prompt.wait_for_prompt();
    // While a command runs, Ctrl-C is a signal; the next prompt shows that the session continues.
    prompt.types("monitor\r", "Hz");
    prompt.types("\x03", "the drive is silent");
    prompt.wait_for_prompt();
    // The line before the last one, from the history.
    prompt.types("\x1b[A\x1b[A\r", "'scna'");
    prompt.wait_for_prompt();
    prompt.types("\x04", "\x1b[?2004l");
    assert_eq!(prompt.child.wait().expect("its end").code(), Some(0), "{}", prompt.seen.lock().expect("the text"));
    assert!(folder.read("sonoglide/link-history").contains("monitor"));
}

#[test]
fn sigterm_ends_the_prompt_and_silences_the_drive() {
    let folder = Folder::new("link-prompt-ends");
    let mut prompt = AtTerminal::new(&["link", "sim:lock"], folder.text());
    prompt.types("lock\r", "`stop` ends it");
    prompt.wait_for_prompt();
    let id = prompt.child.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &id]).status().is_ok_and(|status| status.success()));
    prompt.types("", "the drive is silent now");
    assert_eq!(prompt.child.wait().expect("its end").code(), Some(130));
}
