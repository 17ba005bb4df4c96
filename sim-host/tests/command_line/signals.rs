//! Clients of a served board: whatever ends one that drives, the drive falls silent, unless it was ordered to go on; and who may hold the board.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::{Folder, code, sim_host, stderr, stdout};

/// How long a board may be without its host, s: what a simulated board is built with.
const TIMEOUT_S: f64 = 1.0;

/// A process that does not outlive its test.
struct Running {
    child: Child,
    lines: BufReader<ChildStdout>,
}

impl Running {
    fn new(command: &mut Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().expect("a process");
        let lines = BufReader::new(child.stdout.take().expect("its output"));
        Running { child, lines }
    }

    /// Reads lines until one has this in it.
    fn until(&mut self, part: &str) -> String {
        loop {
            let mut line = String::new();
            assert!(self.lines.read_line(&mut line).expect("text") > 0, "it ends before `{part}`");
            if line.contains(part) {
                return line;
            }
        }
    }

    fn signal(&self, name: &str) {
        let sent = Command::new("kill").args([&format!("-{name}"), &self.child.id().to_string()]).status();
        assert!(sent.expect("`kill` starts").success(), "{name}");
    }

    /// Its exit code; none where a signal has ended it.
    fn end(&mut self) -> Option<i32> {
        self.child.wait().expect("an end").code()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A simulated board that is served to others, and its address.
fn served() -> (Running, String) {
    served_by(program().args(["link", "sim:lock", "serve"]))
}

fn served_by(command: &mut Command) -> (Running, String) {
    let mut server = Running::new(command);
    let address = server.until("tcp:").trim().to_owned();
    (server, address)
}

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_sim-host"))
}

fn client(address: &str, arguments: &[&str]) -> Running {
    Running::new(program().args(["link", address]).args(arguments))
}

fn answer(address: &str, arguments: &[&str]) -> Value {
    let output = sim_host(&[&["link", address], arguments, &["--format", "json"]].concat());
    assert_eq!(code(&output), 0, "{arguments:?}: {}", stderr(&output));
    serde_json::from_str(stdout(&output).lines().last().expect("an answer")).expect("JSON")
}

fn mode(address: &str) -> String {
    answer(address, &["status"])["mode"].as_str().expect("a mode").to_owned()
}

/// Leaves the board without a host until it has stopped the drive by itself. It is asked seldom: who asks is a host.
fn stops_by_itself(address: &str) {
    for attempt in 0..5 {
        std::thread::sleep(Duration::from_secs_f64(TIMEOUT_S * f64::from(2 << attempt)));
        let status = answer(address, &["status"]);
        if status["mode"] == "fault" {
            assert_eq!(status["fault"], 12, "{status}");
            answer(address, &["fault", "clear"]);
            return;
        }
        assert_eq!(status["mode"], "run", "{status}");
    }
    panic!("the drive goes on without a host");
}

/// Whether a terminal that closes ends what the tests start. What ignores hang-ups, as under `nohup`, hands that on, and its clients outlive the terminal.
fn hangs_up() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    let hangs_up = ignored.is_none_or(|signals| signals & 1 == 0);
    if !hangs_up {
        let _ = writeln!(std::io::stderr(), "SKIPPED, hang-ups: they are ignored here");
    }
    hangs_up
}

#[test]
fn a_client_that_is_asked_to_end_silences_the_drive_first() {
    let folder = Folder::new("signals");
    let holds = folder.write("holds.txt", "lock\nstatus\nwait 1000\n");
    let bursts = folder.write("bursts.txt", "lock\nstatus\nburst --on 1000 --off 1\n");
    let watches = folder.write("watches.txt", "drive\nmonitor --every 0.05\n");
    let cases: [(&[&str], &str, &str); 6] = [
        (&["drive"], "the drive is on", "INT"),
        (&["drive", "--volts", "2"], "the drive is on", "TERM"),
        (&["drive", "--host-timeout", "0"], "the drive is on", "HUP"),
        (&["script", &holds], "> wait", "TERM"),
        (&["script", &bursts], "> burst", "HUP"),
        (&["script", &watches], " locked", "TERM"),
    ];
    let (_server, address) = served();
    let hangs_up = hangs_up();
    for (arguments, on, signal) in cases.into_iter().filter(|(.., signal)| hangs_up || *signal != "HUP") {
        let mut client = client(&address, arguments);
        // A line of a script is shown when it is done: those that take long are known by the line before.
        client.until(if on.starts_with('>') { "> status" } else { on });
        client.signal(signal);
        assert_eq!(client.end(), Some(130), "{arguments:?} {signal}");
        assert_eq!(mode(&address), "idle", "{arguments:?} {signal}");
    }
}

#[test]
fn a_terminal_that_closes_hangs_up_twice_and_the_drive_is_silenced_all_the_same() {
    if !hangs_up() {
        return;
    }
    let (_server, address) = served();
    let mut client = client(&address, &["drive", "--host-timeout", "0"]);
    client.until("the drive is on");
    client.signal("HUP");
    client.signal("CONT");
    // By now it may have ended in order, and cannot be signalled any more.
    let _ = Command::new("kill").args(["-HUP", &client.child.id().to_string()]).stderr(Stdio::null()).status();
    assert_eq!(client.end(), Some(130));
    assert_eq!(mode(&address), "idle");
}

#[test]
fn a_client_that_is_killed_or_stands_still_is_missed_by_the_board() {
    let (_server, address) = served();
    let mut killed = client(&address, &["drive"]);
    killed.until("the drive is on");
    killed.signal("KILL");
    assert_eq!(killed.end(), None);
    stops_by_itself(&address);

    // A connection that stays open and says nothing, as that of a pulled cable.
    let mut still = client(&address, &["drive"]);
    still.until("the drive is on");
    let mut stopped = false;
    for attempt in 0..5 {
        still.signal("STOP");
        std::thread::sleep(Duration::from_secs_f64(TIMEOUT_S * f64::from(2 << attempt)));
        still.signal("CONT");
        // What was measured before it stood still may come first.
        stopped = (0..5).any(|_| still.until("motional").contains("fault 12"));
        if stopped {
            break;
        }
    }
    assert!(stopped, "the drive goes on without a host");
}

#[test]
fn a_second_client_is_told_who_holds_the_board_and_changes_nothing() {
    let (_server, address) = served();
    let mut first = client(&address, &["drive"]);
    first.until("the drive is on");
    for order in [&["lock"][..], &["status"], &["settings", "clear"]] {
        let began = Instant::now();
        let output = sim_host(&[&["link", &address], order].concat());
        assert_eq!(code(&output), 5, "{}", stderr(&output));
        assert!(
            stderr(&output).contains("the client at 127.0.0.1:") && stderr(&output).contains("holds the board"),
            "{}",
            stderr(&output)
        );
        assert!(began.elapsed() < Duration::from_secs(3));
    }
    // The first one drives on, and ends as it would alone; then the next is served.
    (0..3).for_each(|_| drop(first.until(" locked")));
    first.signal("TERM");
    assert_eq!((first.end(), mode(&address).as_str()), (Some(130), "idle"));
}

/// A connection to a served board over which nothing is sent.
fn silent(address: &str) -> TcpStream {
    TcpStream::connect(address.trim_start_matches("tcp:")).expect("a connection")
}

#[test]
fn stop_is_taken_from_anyone_whoever_holds_the_board() {
    let (_server, address) = served();
    let mut still = client(&address, &["drive", "--host-timeout", "0"]);
    still.until("the drive is on");
    still.signal("STOP");
    let others = [(); 5].map(|()| silent(&address));
    let began = Instant::now();
    answer(&address, &["stop"]);
    assert!(began.elapsed() < Duration::from_secs(5), "{:?}", began.elapsed());
    drop(others);
    assert_eq!(mode(&address), "idle");
    still.signal("CONT");
    assert_eq!(still.end(), Some(5), "another client has taken the board");
    // A holder that has never spoken, too.
    let _holder = silent(&address);
    std::thread::sleep(Duration::from_millis(100));
    answer(&address, &["stop"]);
}

#[test]
fn a_silent_client_loses_the_board_and_a_prompt_keeps_it() {
    let (_server, address) = served_by(program().args(["link", "sim:lock", "serve", "--idle-limit", "2"]));
    let _holder = silent(&address);
    std::thread::sleep(Duration::from_millis(100));
    let status = || code(&sim_host(&["link", &address, "status"]));
    assert_eq!(status(), 5);
    std::thread::sleep(Duration::from_secs(3));
    let mut prompt = Running::new(program().args(["link", &address]).stdin(Stdio::piped()));
    let mut keys = prompt.child.stdin.take().expect("its input");
    keys.write_all(b"lock\n").expect("a line");
    prompt.until("> lock");
    std::thread::sleep(Duration::from_secs(3));
    assert_eq!(status(), 5);
    keys.write_all(b"status\n").expect("a line");
    prompt.until("> status");
    // Neither the board nor its server has missed the host.
    assert!(prompt.until("mode ").contains("run"));
    drop(keys);
    assert_eq!(prompt.end(), Some(0));
}

#[test]
fn a_server_without_file_descriptors_serves_on() {
    let line = format!("ulimit -n 12; exec \"{}\" link sim:lock serve", env!("CARGO_BIN_EXE_sim-host"));
    let (_server, address) = served_by(Command::new("sh").args(["-c", &line]));
    let many = [(); 16].map(|()| silent(&address));
    std::thread::sleep(Duration::from_millis(300));
    drop(many);
    assert_eq!(mode(&address), "idle");
}

#[test]
fn only_who_allows_it_listens_to_other_machines() {
    let serve = ["link", "sim:lock", "serve", "--listen", "0.0.0.0:0"];
    let gdb = ["link", "board:dummy-load", "status", "--gdb", "0.0.0.0:0"];
    for arguments in [&serve[..], &gdb].into_iter().take(1 + usize::from(cfg!(feature = "board-model"))) {
        let output = Command::new("timeout").args(["20", env!("CARGO_BIN_EXE_sim-host")]).args(arguments).output();
        let output = output.expect("`timeout` starts");
        assert!(code(&output) == 2 && stderr(&output).contains("`--allow-remote`"), "{}", stderr(&output));
    }
    let mut child =
        program().args(serve).arg("--allow-remote").stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("it starts");
    let mut warning = String::new();
    BufReader::new(child.stderr.take().expect("its messages")).read_line(&mut warning).expect("text");
    child.kill().and_then(|()| child.wait()).expect("an end");
    assert!(warning.starts_with("warning: other machines can reach 0.0.0.0:0"), "{warning}");
}

#[test]
fn a_drive_goes_on_only_where_that_is_chosen() {
    let (_server, address) = served();
    answer(&address, &["drive", "--stay"]);
    std::thread::sleep(Duration::from_secs_f64(2.0 * TIMEOUT_S));
    assert_eq!(mode(&address), "run");
    // Who looks on leaves it as it is, by whatever it is ended.
    let mut watches = client(&address, &["monitor", "--every", "0.05"]);
    watches.until(" locked");
    watches.signal("TERM");
    assert_eq!((watches.end(), mode(&address).as_str()), (Some(130), "run"));
    // Who drives takes it over, and is missed.
    let mut killed = client(&address, &["drive"]);
    killed.until("the drive is on");
    killed.signal("KILL");
    assert_eq!(killed.end(), None);
    stops_by_itself(&address);
}

#[cfg(target_os = "linux")]
#[test]
fn a_client_that_was_started_to_outlive_its_terminal_does() {
    let (_server, address) = served();
    let line = format!("trap '' HUP; exec \"{}\" link {address} drive", env!("CARGO_BIN_EXE_sim-host"));
    let mut client = Running::new(Command::new("sh").args(["-c", &line]));
    client.until("the drive is on");
    client.signal("HUP");
    // It watches on.
    (0..3).for_each(|_| drop(client.until(" locked")));
    client.signal("TERM");
    assert_eq!(client.end(), Some(130));
    assert_eq!(mode(&address), "idle");
}

#[test]
fn a_client_that_sends_faster_than_the_wire_does_not_keep_the_board_from_its_time() {
    let (_server, address) = served();
    answer(&address, &["drive", "--stay"]);
    let before = answer(&address, &["status"])["block"].as_u64().expect("a block");
    let mut flood = TcpStream::connect(address.trim_start_matches("tcp:")).expect("a connection");
    flood.set_write_timeout(Some(Duration::from_millis(200))).expect("a timeout");
    let began = Instant::now();
    while began.elapsed() < Duration::from_secs(1) {
        let _ = flood.write(&[0x55; 4096]);
    }
    drop(flood);
    let after = answer(&address, &["status"])["block"].as_u64().expect("a block");
    assert!(after > before + 1000, "{before} {after}");
}
