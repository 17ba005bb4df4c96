//! `sim-host link`: output, messages and exit codes.

use std::net::TcpListener;
use std::process::{Command, Stdio};

use serde_json::Value;

use super::{Folder, code, sim_host, stderr, stdout};

#[test]
fn a_script_answers_each_line_with_a_line_of_json() {
    let folder = Folder::new("link-script");
    let text =
        format!("scan -o \"{0}/scan\"\nexpect q > 60\nlock\nexpect locked = true\ncapture -o \"{0}\"\nstop\n", folder.text());
    let script = folder.write("rig.txt", &text);
    let output = sim_host(&["link", "sim:lock", "script", &script, "--format", "json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let lines: Vec<Value> = stdout(&output).lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect();
    let names: Vec<&str> = lines.iter().map(|line| line["command"].as_str().expect("a name")).collect();
    assert_eq!(names, ["scan", "expect", "lock", "expect", "capture", "stop"]);
    assert!(lines.iter().all(|line| line["done"] == true));
    assert!((lines[0]["series_resonance_hz"].as_f64().expect("a number") - 40_519.9).abs() < 2.0);
    assert!(folder.read("scan/admittance.svg").starts_with("<svg") && folder.read("capture.csv").lines().count() == 1025);
    // A repetition prints the same answers and nothing else.
    let again = sim_host(&["link", "sim:lock", "script", &script, "--format", "json"]);
    assert_eq!((stdout(&again), stderr(&again)), (stdout(&output), String::new()));
}

#[test]
fn the_first_line_that_fails_ends_a_script() {
    let folder = Folder::new("link-fails");
    let script = folder.write("rig.txt", "status\nexpect mode = run\nidentify\n");
    let output = sim_host(&["link", "sim:lock", "script", &script]);
    assert_eq!(code(&output), 1);
    assert!(stdout(&output).ends_with("> expect mode = run\n"), "{}", stdout(&output));
    assert!(stderr(&output).contains("rig.txt:2: mode is idle, expected = run"), "{}", stderr(&output));
}

#[test]
fn mistakes_have_their_messages_and_exit_codes() {
    let folder = Folder::new("link-mistakes");
    let wrong = folder.write("wrong.txt", "identify\nscna\n");
    let closed = TcpListener::bind("127.0.0.1:0").expect("a port").local_addr().expect("an address");
    let taken = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = taken.local_addr().expect("an address").to_string();
    let cases: [(&[&str], i32, &str); 12] = [
        (&["/dev/ttyNOT", "status"], 5, "there is no such port"),
        (&[&format!("tcp:{closed}"), "status"], 5, "nothing listens there"),
        (&["tcp:nowhere", "status"], 5, "expected `tcp:HOST:PORT`"),
        (&["sim:lokc", "status"], 3, "try `lock`"),
        (&["sim:contact", "status"], 3, "has no [controller]"),
        (&["/dev/ttyNOT", "status", "--seed", "3"], 2, "need sim:SCENE or board:SCENE"),
        (&["sim:lock", "script", &wrong], 3, "wrong.txt:2:1"),
        (&["sim:lock", "settings", "get", "limit.voltage_v"], 3, "did you mean `limits.voltage_v`?"),
        (&["sim:lock", "status", "--gdb", &port], 2, "--gdb need board:SCENE"),
        (&["board:dummy-load", "status", "--gdb", "nowhere"], 5, "this is not HOST:PORT"),
        (&["board:dummy-load", "status", "--gdb", &port], 5, "another program listens there"),
        (&["sim:lock", "drive", "--volts", "1", "--current", "1"], 2, "cannot be used with"),
    ];
    for (arguments, expected, part) in cases {
        if arguments[0].starts_with("board:") && !cfg!(feature = "board-model") {
            continue;
        }
        let output = sim_host(&[&["link"], arguments].concat());
        assert_eq!(code(&output), expected, "{arguments:?}\n{}", stderr(&output));
        assert!(stderr(&output).contains(part) && stdout(&output).is_empty(), "{arguments:?}\n{}", stderr(&output));
    }
}

#[test]
fn a_served_board_is_reached_over_tcp() {
    let mut server = Command::new(env!("CARGO_BIN_EXE_sim-host"))
        .args(["link", "sim:lock", "serve", "--listen", "127.0.0.1:0"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("a server");
    let mut address = String::new();
    std::io::BufRead::read_line(&mut std::io::BufReader::new(server.stdout.as_mut().expect("its output")), &mut address)
        .expect("an address");
    let output = sim_host(&["link", address.trim(), "scan", "--format", "json"]);
    server.kill().expect("an end");
    let _ = server.wait();
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let scan: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    assert!((scan["series_resonance_hz"].as_f64().expect("a number") - 40_519.9).abs() < 2.0, "{scan}");
}
