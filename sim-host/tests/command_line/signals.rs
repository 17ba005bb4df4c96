//! Clients of a served board: the drive is silenced at any end of its client, unless it was told to
//! stay on; one client holds the board.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::{Folder, code, sim_host, stderr, stdout};

/// Default host timeout of a simulated board, s.
const TIMEOUT_S: f64 = 1.0;

/// Process that is killed at the end of its test.
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

    /// Reads lines until one contains `part`.
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

    /// Waits for the end and returns the exit code; `None` if a signal killed the process.
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

/// Starts a server of a simulated board and returns its address.
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

/// Leaves the board without a host until it has stopped the drive itself. Polls rarely, because
/// each poll is a message of a host.
fn wait_for_host_timeout(address: &str) {
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
    panic!("the drive stays on without a host");
}

/// Returns `true` if a closing terminal ends the processes of these tests. They inherit an ignored
/// SIGHUP, as under `nohup`, and then outlive the terminal.
fn hangs_up() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    let hangs_up = ignored.is_none_or(|signals| signals & 1 == 0);
    if !hangs_up {
        let _ = writeln!(std::io::stderr(), "SKIPPED: SIGHUP is ignored here");
    }
    hangs_up
}

#[test]
fn a_signal_silences_the_drive_before_the_client_ends() {
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
        // A line of a script is printed when it is done: a long one is recognised by the line
        // before.
        client.until(if on.starts_with('>') { "> status" } else { on });
        client.signal(signal);
        assert_eq!(client.end(), Some(130), "{arguments:?} {signal}");
        assert_eq!(mode(&address), "idle", "{arguments:?} {signal}");
    }
}

#[test]
fn two_hang_ups_of_a_terminal_silence_the_drive() {
    if !hangs_up() {
        return;
    }
    let (_server, address) = served();
    let mut client = client(&address, &["drive", "--host-timeout", "0"]);
    client.until("the drive is on");
    client.signal("HUP");
    client.signal("CONT");
    // The client may have ended already, so that the signal fails.
    let _ = Command::new("kill").args(["-HUP", &client.child.id().to_string()]).stderr(Stdio::null()).status();
    assert_eq!(client.end(), Some(130));
    assert_eq!(mode(&address), "idle");
}

#[test]
fn the_board_detects_a_killed_or_stopped_client() {
    let (_server, address) = served();
    let mut killed = client(&address, &["drive"]);
    killed.until("the drive is on");
    killed.signal("KILL");
    assert_eq!(killed.end(), None);
    wait_for_host_timeout(&address);

    // A connection that stays open without messages, as with a pulled cable.
    let mut still = client(&address, &["drive"]);
    still.until("the drive is on");
    let mut stopped = false;
    for attempt in 0..5 {
        still.signal("STOP");
        std::thread::sleep(Duration::from_secs_f64(TIMEOUT_S * f64::from(2 << attempt)));
        still.signal("CONT");
        // Reports from before the stop may arrive first.
        stopped = (0..5).any(|_| still.until("motional").contains("fault 12"));
        if stopped {
            break;
        }
    }
    assert!(stopped, "the drive stays on without a host");
}

#[test]
fn a_second_client_is_refused_with_the_holders_address() {
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
    // The first client is not disturbed and ends as usual; then the next one is served.
    (0..3).for_each(|_| drop(first.until(" locked")));
    first.signal("TERM");
    assert_eq!((first.end(), mode(&address).as_str()), (Some(130), "idle"));
}

/// Opens a connection to a served board without sending anything.
fn silent(address: &str) -> TcpStream {
    TcpStream::connect(address.trim_start_matches("tcp:")).expect("a connection")
}

#[test]
fn stop_is_accepted_from_any_client() {
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
    // Also while a client holds the board that has sent nothing.
    let _holder = silent(&address);
    std::thread::sleep(Duration::from_millis(100));
    answer(&address, &["stop"]);
}

#[test]
fn an_idle_client_loses_the_board_and_a_prompt_keeps_it() {
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
    // Neither the board nor its server has lost the host.
    assert!(prompt.until("mode ").contains("run"));
    drop(keys);
    assert_eq!(prompt.end(), Some(0));
}

#[test]
fn a_server_recovers_from_missing_file_descriptors() {
    let line = format!("ulimit -n 12; exec \"{}\" link sim:lock serve", env!("CARGO_BIN_EXE_sim-host"));
    let (_server, address) = served_by(Command::new("sh").args(["-c", &line]));
    let many = [(); 16].map(|()| silent(&address));
    std::thread::sleep(Duration::from_millis(300));
    drop(many);
    assert_eq!(mode(&address), "idle");
}

#[test]
fn remote_addresses_need_allow_remote() {
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
fn a_drive_continues_only_with_stay() {
    let (_server, address) = served();
    answer(&address, &["drive", "--stay"]);
    std::thread::sleep(Duration::from_secs_f64(2.0 * TIMEOUT_S));
    assert_eq!(mode(&address), "run");
    // A client that only watches leaves the drive on, even if it is killed.
    let mut watches = client(&address, &["monitor", "--every", "0.05"]);
    watches.until(" locked");
    watches.signal("TERM");
    assert_eq!((watches.end(), mode(&address).as_str()), (Some(130), "run"));
    // A client that drives takes over, and the board detects its loss.
    let mut killed = client(&address, &["drive"]);
    killed.until("the drive is on");
    killed.signal("KILL");
    assert_eq!(killed.end(), None);
    wait_for_host_timeout(&address);
}

#[cfg(target_os = "linux")]
#[test]
fn a_client_under_nohup_outlives_its_terminal() {
    let (_server, address) = served();
    let line = format!("trap '' HUP; exec \"{}\" link {address} drive", env!("CARGO_BIN_EXE_sim-host"));
    let mut client = Running::new(Command::new("sh").args(["-c", &line]));
    client.until("the drive is on");
    client.signal("HUP");
    // It continues to watch.
    (0..3).for_each(|_| drop(client.until(" locked")));
    client.signal("TERM");
    assert_eq!(client.end(), Some(130));
    assert_eq!(mode(&address), "idle");
}

#[test]
fn a_flood_of_bytes_does_not_delay_the_board() {
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
