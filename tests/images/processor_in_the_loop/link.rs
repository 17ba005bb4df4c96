//! Commands to a complete board under QEMU, over its UART.

use std::io::{Read as _, Write as _};
use std::time::{Duration, Instant};

use ::link::emulated_board::EmulatedBoard;
use firmware::board::capture::{Arm, CaptureState, CaptureVerb, PARTS, Trigger};
use firmware::board::command::{Command, Reply, Verb};
use firmware::board::link::{self, Frame, NO_SESSION, Receiver};
use firmware::board::start::Start;
use firmware::board::stored_state::StoredState;
use firmware::seam::block::Gate;
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use firmware::seam::refusal::Refusal;
use pil::link_image;

use super::{is_there, scene};

/// Largest number of blocks until an answer.
const ANSWERS_WITHIN: u32 = 20;

/// Host of an emulated board.
struct Host {
    board: EmulatedBoard,
    receiver: Receiver,
    sequence: u16,
    session: u32,
}

impl Host {
    /// Starts the board of a scene. Returns `None` after a message if this is not possible.
    fn start(name: &str) -> Option<Self> {
        if !is_there("link in the loop") {
            return None;
        }
        let scene = scene(name);
        let image = link_image().expect("the image builds");
        let board = EmulatedBoard::start(&image, &scene.driven().expect("a driven scene"), 0).expect("QEMU starts");
        let mut host = Host { board, receiver: Receiver::default(), sequence: 0, session: NO_SESSION };
        host.connect();
        Some(host)
    }

    /// Plays a block, and returns the received frames.
    fn block(&mut self) -> Vec<Frame<Reply>> {
        self.board.block().expect("QEMU runs");
        let mut bytes = [0; 4096];
        let count = self.board.read(&mut bytes).expect("a serial port");
        bytes[..count].iter().filter_map(|&byte| self.receiver.take(byte)).map(|frame| frame.expect("a whole frame")).collect()
    }

    /// Begins a session.
    fn connect(&mut self) {
        let Reply::Identity(identity) = self.ask(Command::Identify(7)) else { panic!("no identity") };
        self.session = identity.session;
    }

    /// Sends a command and returns its answer.
    fn ask(&mut self, command: Command) -> Reply {
        self.sequence += 1;
        let frame = link::encode(self.sequence, self.session, command).expect("the frame fits");
        self.board.write_all(&frame).expect("a serial port");
        for _ in 0..ANSWERS_WITHIN {
            let answer = self.block().into_iter().find(|frame| frame.sequence == self.sequence);
            if let Some(frame) = answer {
                return frame.body;
            }
        }
        panic!("no answer to {command:?}")
    }

    fn mode(&mut self) -> (Mode, bool, Option<Fault>) {
        match self.ask(Command::Status) {
            Reply::Status(Some(report)) => (report.mode, report.locked, report.fault),
            other => panic!("{other:?}"),
        }
    }

    /// Plays until the state fulfils a condition. Panics if this takes longer than `within`.
    fn until(&mut self, is_so: impl Fn((Mode, bool, Option<Fault>)) -> bool, within: Duration) {
        let until = self.board.now() + within;
        loop {
            let mode = self.mode();
            if is_so(mode) {
                return;
            }
            assert!(self.board.now() < until, "{mode:?} after {within:?}");
            (0..30).for_each(|_| drop(self.block()));
        }
    }
}

#[test]
fn a_board_scans_locks_bursts_and_captures_over_its_uart() {
    let began = Instant::now();
    let Some(mut host) = Host::start("lock") else { return };
    assert_eq!(host.mode(), (Mode::Idle, false, None));
    assert!(!host.board.pins().enable);

    assert_eq!(host.ask(Command::Scan), Reply::Ack);
    assert!(host.board.pins().enable);
    host.until(|(mode, ..)| mode == Mode::Scan || mode == Mode::Clamped, Duration::from_millis(20));
    host.until(|(mode, ..)| mode == Mode::Idle, Duration::from_millis(300));
    let Reply::Resonances(found) = host.ask(Command::Resonances) else { panic!("no resonances") };
    let chosen = found.found[usize::from(found.chosen.expect("a resonance"))].expect("the chosen resonance is in the list");
    assert!((chosen.hz - 40_520.0).abs() < 3.0 && (chosen.q - 64.6).abs() < 1.0, "{chosen:?}");

    assert_eq!(host.ask(Command::Gate(Gate::Off)), Reply::Ack);
    assert_eq!(host.ask(Command::Run), Reply::Ack);
    host.until(|(mode, locked, _)| mode == Mode::Run && locked, Duration::from_millis(300));

    // A burst, recorded from its first sample.
    let arm = Arm { trigger: Trigger::On, before: 256, lane: 0 };
    assert_eq!(host.ask(Command::Capture(CaptureVerb::Arm(arm))), Reply::Ack);
    (0..20).for_each(|_| drop(host.block()));
    assert_eq!(host.ask(Command::Gate(Gate::On)), Reply::Ack);
    let report = (0..100).find_map(|_| match host.ask(Command::Capture(CaptureVerb::State)) {
        Reply::Capture(report) => (report.state == CaptureState::Full).then_some(report),
        other => panic!("{other:?}"),
    });
    let report = report.expect("a full capture");
    let (mut drive, mut volts) = (Vec::new(), Vec::new());
    for part in 0..PARTS {
        let Reply::Captured(part) = host.ask(Command::Capture(CaptureVerb::Read(part))) else { panic!("no part {part}") };
        drive.extend(part.drive);
        volts.extend(part.v);
    }
    let front_end = host.board.config().front_end.clone();
    let swing = |codes: &[u16], mid: u16| codes.iter().map(|&code| code.abs_diff(mid)).max().unwrap_or(0);
    let before = usize::from(report.before);
    assert_eq!(before, 256);
    assert_eq!(swing(&drive[..before], front_end.drive_mid_code), 0, "silent before the burst");
    assert!(swing(&drive[before..], front_end.drive_mid_code) > 50 && swing(&volts[before..], front_end.sense_mid_code) > 50);

    // Settings can be changed only in silence, and they survive a reset.
    assert_eq!(host.ask(Command::Settings(Verb::Store)), Reply::Nak(Refusal::Driving));
    assert_eq!(host.ask(Command::Reset), Reply::Nak(Refusal::Driving));
    assert_eq!(host.ask(Command::Idle), Reply::Ack);
    host.until(|(mode, ..)| mode == Mode::Idle, Duration::from_millis(50));
    // The drive that ends is queued, and fades.
    (0..4).for_each(|_| drop(host.block()));
    assert!(!host.board.pins().enable);
    // Key 15: `tracking.nominal_q`.
    assert_eq!(host.ask(Command::Settings(Verb::Set(15, 61.0))), Reply::Ack);
    assert_eq!(host.ask(Command::Settings(Verb::Store)), Reply::Ack);
    assert_eq!(host.ask(Command::Reset), Reply::Ack);
    assert_eq!(host.board.resets(), 1);
    // The reset has ended the session.
    assert_eq!(host.ask(Command::Run), Reply::Nak(Refusal::Session));
    host.connect();
    let Reply::Parameter(report) = host.ask(Command::Settings(Verb::Get(15))) else { panic!("no parameter") };
    assert_eq!((report.acts, report.stored), (61.0, StoredState::Stored));
    let Reply::Faults(log) = host.ask(Command::Faults(0)) else { panic!("no fault log") };
    assert_eq!((log.count, log.last_run), (0, Start::Ordered));

    // The watchdog was fed, and the emergency stop works.
    assert!(host.board.pins().fed > 0 && !host.board.pins().failed);
    assert_eq!(host.ask(Command::Run), Reply::Ack);
    host.until(|(mode, ..)| mode == Mode::SelfTest, Duration::from_millis(20));
    host.board.press_stop(true);
    host.block();
    assert!(!host.board.pins().enable);
    host.until(|(_, _, fault)| fault == Some(Fault::EmergencyStop), Duration::from_millis(5));
    println!("{} simulated in {:?}", host.board.now().as_secs_f64(), began.elapsed());
}

#[test]
fn a_dialogue_over_the_uart_is_the_same_every_time() {
    let once = || {
        let mut host = Host::start("lock")?;
        assert_eq!(host.ask(Command::TelemetryEvery(7)), Reply::Ack);
        assert_eq!(host.ask(Command::Scan), Reply::Ack);
        (0..500).for_each(|_| drop(host.block()));
        Some((host.mode(), host.board.now(), host.board.rig().hash()))
    };
    assert_eq!(once(), once());
}
