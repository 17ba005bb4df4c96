//! The prompt of `sim-host link PORT`: without a terminal, and at one.

use std::fs::File;
use std::io::{Read, Write};
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use super::{Folder, code, sim_host, stderr, stdout};

/// `sim-host` with these arguments, and lines on standard input.
fn asked(arguments: &[&str], lines: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_sim-host"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("sim-host starts");
    // One that leaves before the last line closes its end.
    let _ = child.stdin.take().expect("its input").write_all(lines.as_bytes());
    child.wait_with_output().expect("its output")
}

#[test]
fn lines_are_done_one_by_one_and_mistakes_have_their_caret() {
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
        "2 of 7 lines have failed",
    ] {
        assert!(err.contains(part), "{part}\n{err}");
    }
    assert_eq!(code(&asked(&["link", "sim:lock"], "status\n")), 0);
}

#[test]
fn a_lock_by_itself_says_what_becomes_of_the_drive() {
    let output = sim_host(&["link", "sim:lock", "lock"]);
    assert!(stdout(&output).contains("it falls silent now, with the end of this command"), "{}", stdout(&output));
    assert!(stderr(&output).contains("the drive is silent now"), "{}", stderr(&output));
    let stays = sim_host(&["link", "sim:lock", "lock", "--stay"]);
    assert!(stdout(&stays).contains("it ends with this program, which the board is a part of"), "{}", stdout(&stays));
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
    assert!(code(&refused) == 3 && stderr(&refused).contains("it has 8 bytes"), "{}", stderr(&refused));
    let other = sim_host(&["link", "/dev/ttyNOT", "status", "--flash", &flash]);
    assert!(code(&other) == 2 && stderr(&other).contains("--flash is of a simulated board"), "{}", stderr(&other));
}

/// A program at a terminal of its own.
struct AtTerminal {
    child: Child,
    keys: File,
    seen: Arc<Mutex<String>>,
    /// Bytes of it up to what was waited for last.
    read: usize,
}

impl AtTerminal {
    fn new(arguments: &[&str], state: &str) -> Self {
        use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
        let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
        grantpt(&ours).and_then(|()| unlockpt(&ours)).expect("a terminal");
        let name = ptsname(&ours, Vec::new()).expect("its name");
        let end = || File::options().read(true).write(true).open(name.to_str().expect("a path")).expect("its other end");
        // In a session of its own, so that the keys of this terminal signal it and nobody else.
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

    /// Types, and waits until this stands on the screen after it; without keys, after what was waited for last.
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

    /// Waits for the next prompt: keys that are typed before it are the terminal's, and Ctrl-D among them is lost.
    fn is_there(&mut self) {
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
fn at_a_terminal_words_are_completed_and_ctrl_c_silences_and_stays() {
    let folder = Folder::new("link-prompt");
    let mut prompt = AtTerminal::new(&["link", "sim:lock"], folder.text());
    prompt.is_there();
    // A word and its unit.
    prompt.types("settings set limits.vol\t", "limits.voltage_v <V>");
    prompt.types("3\r", "limits.voltage_v = 3");
    prompt.is_there();
    prompt.types("lo\t\r", "`stop` ends it");
    // The line above the prompt is renewed while nothing is typed.
    prompt.types("", "\x1b[1A");
    prompt.types("\x03", "the drive is silent");
    prompt.types("", "idle ");
    prompt.is_there();
    prompt.types("scna\r", "here");
    prompt.is_there();
    // While a command runs Ctrl-C is a signal; the second prompt afterwards is that of a session which goes on.
    prompt.types("monitor\r", "Hz");
    prompt.types("\x03", "the drive is silent");
    prompt.is_there();
    // The line before last, from the history.
    prompt.types("\x1b[A\x1b[A\r", "'scna'");
    prompt.is_there();
    prompt.types("\x04", "\x1b[?2004l");
    assert_eq!(prompt.child.wait().expect("its end").code(), Some(0), "{}", prompt.seen.lock().expect("the text"));
    assert!(folder.read("sonoglide/link-history").contains("monitor"));
}

#[test]
fn a_request_to_end_leaves_the_prompt_and_silences_the_drive() {
    let folder = Folder::new("link-prompt-ends");
    let mut prompt = AtTerminal::new(&["link", "sim:lock"], folder.text());
    prompt.types("lock\r", "`stop` ends it");
    prompt.is_there();
    let id = prompt.child.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &id]).status().is_ok_and(|status| status.success()));
    prompt.types("", "the drive is silent now");
    assert_eq!(prompt.child.wait().expect("its end").code(), Some(130));
}
