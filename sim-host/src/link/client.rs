//! Asks a board and is answered.
//!
//! Every command carries a sequence number, and its answer the same. What does not come back in time, or comes damaged, is asked for again
//! with the same number, so that a late answer to the first copy is taken for what it is; answers with another number are not ours.
//!
//! **A command never acts twice because an answer was lost.** Most may be repeated: asking changes nothing, and an order that says how things
//! are to be (gate, amplitude, idle, a setting) says the same twice. Those that start something are an exception ([`starts`]): before such a
//! one is repeated the client asks which order the board has seen last; if that has changed, the first copy has arrived, and it is done.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use firmware::command::{Command, Identity, Refusal, Reply};
use firmware::link::{self, Frame, FrameError, Receiver};
use firmware::telemetry::Telemetry;

use crate::link::link_error::LinkError;
use crate::link::port::Port;
use crate::link::raw_frame::RawFrame;

/// How long one copy of a command is waited for.
const PATIENCE: Duration = Duration::from_millis(250);
/// Copies that are sent of a command before the link is given up.
const COPIES: u32 = 5;
/// Attempts to open a lost port again, and the pause before each.
const REOPENINGS: u32 = 10;
const REOPEN_PAUSE: Duration = Duration::from_millis(300);
/// Longest stretch without a look at Ctrl-C.
const SLICE: Duration = Duration::from_millis(50);
/// Telemetry that is kept until somebody takes it.
const KEPT: usize = 4096;

/// The client.
pub struct Client {
    port: Box<dyn Port>,
    receiver: Receiver,
    raw: RawFrame,
    /// Bytes that have come and have not been looked at.
    came: VecDeque<u8>,
    sequence: u16,
    telemetry: VecDeque<(u16, Telemetry)>,
    /// Who has answered.
    identity: Option<Identity>,
    counts: Counts,
    stop: &'static AtomicBool,
    note: fn(&str),
}

/// How the link has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Commands sent, without copies.
    pub commands: u32,
    /// Copies of commands.
    pub repeated: u32,
    /// Frames that came damaged.
    pub damaged: u32,
    /// Answers to what is not asked any more.
    pub late: u32,
    /// Times that the port was opened again.
    pub reopened: u32,
}

/// What came.
enum Came {
    Frame(Frame<Reply>),
    /// A report, which was put with the others.
    Telemetry,
    /// What was sent, or what came, was damaged on the way.
    Damage,
    /// A whole frame of another protocol version.
    Version(u8),
}

impl Client {
    /// A client at this port, which gives up when `stop` is set, and tells `note` what a user should know meanwhile.
    pub fn new(port: Box<dyn Port>, stop: &'static AtomicBool, note: fn(&str)) -> Self {
        Client {
            port,
            receiver: Receiver::default(),
            raw: RawFrame::default(),
            came: VecDeque::new(),
            sequence: 0,
            telemetry: VecDeque::new(),
            identity: None,
            counts: Counts::default(),
            stop,
            note,
        }
    }

    /// Finds out who is there.
    pub fn connect(&mut self) -> Result<Identity, LinkError> {
        self.identity = None;
        // Ends whatever an earlier host has left unfinished.
        self.port.send(&[0]).map_err(|error| self.lost(error.to_string()))?;
        match self.ask(Command::Identify)? {
            Reply::Identity(identity) => {
                self.identity = Some(identity);
                Ok(identity)
            }
            reply => Err(unexpected("identify", &reply)),
        }
    }

    /// The port's name.
    pub fn port(&self) -> &str {
        self.port.name()
    }

    /// Time as it passes for the board.
    pub fn now(&self) -> Duration {
        self.port.now()
    }

    /// How the link has done so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Asks, and gives the answer, whatever it is but a refusal.
    pub fn ask(&mut self, command: Command) -> Result<Reply, LinkError> {
        let before = if starts(&command) { self.order_seen()? } else { None };
        self.sequence = self.sequence.wrapping_add(1);
        self.counts.commands += 1;
        self.ask_as(self.sequence, command, before)
    }

    /// Gives an order, which is acknowledged.
    pub fn order(&mut self, command: Command) -> Result<(), LinkError> {
        match self.ask(command)? {
            Reply::Ack => Ok(()),
            reply => Err(unexpected(&shown(&command), &reply)),
        }
    }

    /// The latest block's report; none before the board has played a block.
    pub fn status(&mut self) -> Result<Option<Telemetry>, LinkError> {
        match self.ask(Command::Status)? {
            Reply::Status(report) => Ok(report),
            reply => Err(unexpected("status", &reply)),
        }
    }

    /// The next report of the telemetry that comes by itself, with its frame's number; none within `wait`.
    pub fn telemetry(&mut self, wait: Duration) -> Result<Option<(u16, Telemetry)>, LinkError> {
        let until = self.port.now() + wait;
        loop {
            if let Some(report) = self.telemetry.pop_front() {
                return Ok(Some(report));
            }
            let now = self.port.now();
            if now >= until {
                return Ok(None);
            }
            // Answers to nobody are counted, and damage costs a report.
            if let Some(Came::Frame(_)) = self.receive(until - now)? {
                self.counts.late += 1;
            }
        }
    }

    /// Forgets the telemetry that nobody has taken.
    pub fn forget_telemetry(&mut self) {
        self.telemetry.clear();
    }

    fn ask_as(&mut self, sequence: u16, command: Command, before: Option<u32>) -> Result<Reply, LinkError> {
        let began = self.port.now();
        let frame = link::encode(sequence, command).map_err(|_| LinkError::Usage(format!("`{}` does not fit into a frame", shown(&command))))?;
        let mut damaged = false;
        for copy in 0..COPIES {
            if copy > 0 {
                self.counts.repeated += 1;
                if starts(&command) && self.order_seen()? != before {
                    return Ok(Reply::Ack);
                }
            }
            if let Err(error) = self.port.send(&frame) {
                self.reopen(&error.to_string())?;
                continue;
            }
            match self.answer(sequence)? {
                Some(Came::Version(board)) => {
                    return Err(LinkError::Version { port: self.port.name().to_owned(), board, ours: link::VERSION });
                }
                Some(Came::Frame(Frame { body: Reply::Nak(refusal), .. })) => {
                    return Err(LinkError::Refused { command: shown(&command), refusal });
                }
                Some(Came::Frame(frame)) => return Ok(frame.body),
                Some(Came::Damage) => damaged = true,
                Some(Came::Telemetry) | None => {}
            }
            if matches!(command, Command::Reset) {
                // A second copy would reset a board that has just begun.
                return Ok(Reply::Ack);
            }
        }
        let seconds = (self.port.now() - began).as_secs_f64();
        Err(self.silence(damaged, seconds))
    }

    /// The answer with this number, or what came instead of it; none in time.
    fn answer(&mut self, sequence: u16) -> Result<Option<Came>, LinkError> {
        let until = self.port.now() + PATIENCE;
        while self.port.now() < until {
            match self.receive(until - self.port.now())? {
                Some(Came::Frame(frame)) if frame.sequence == sequence => return Ok(Some(Came::Frame(frame))),
                Some(Came::Frame(Frame { body: Reply::Nak(Refusal::Damaged), .. })) => return Ok(Some(Came::Damage)),
                Some(Came::Frame(_)) => self.counts.late += 1,
                Some(Came::Telemetry) | None => {}
                Some(came) => return Ok(Some(came)),
            }
        }
        Ok(None)
    }

    /// The next frame.
    fn receive(&mut self, wait: Duration) -> Result<Option<Came>, LinkError> {
        let until = self.port.now() + wait;
        let mut version = None;
        loop {
            if self.stop.load(Ordering::Relaxed) {
                return Err(LinkError::Interrupted);
            }
            let now = self.port.now();
            if now >= until {
                return Ok(None);
            }
            let Some(byte) = self.came.pop_front() else {
                let mut bytes = [0; 256];
                match self.port.receive(&mut bytes, SLICE.min(until - now)) {
                    Ok(count) => self.came.extend(&bytes[..count]),
                    Err(error) => {
                        self.reopen(&error.to_string())?;
                        return Ok(None);
                    }
                }
                continue;
            };
            version = self.raw.take(byte).or(version);
            match self.receiver.take::<Reply>(byte) {
                None => {}
                Some(Ok(Frame { sequence, body: Reply::Telemetry(telemetry), .. })) => {
                    self.telemetry.drain(..(self.telemetry.len() + 1).saturating_sub(KEPT));
                    self.telemetry.push_back((sequence, telemetry));
                    return Ok(Some(Came::Telemetry));
                }
                Some(Ok(frame)) => return Ok(Some(Came::Frame(frame))),
                Some(Err(FrameError::Version(_))) => return Ok(Some(Came::Version(version.unwrap_or(0)))),
                Some(Err(FrameError::TooLong | FrameError::Damaged)) => {
                    self.counts.damaged += 1;
                    return Ok(Some(Came::Damage));
                }
                Some(Err(FrameError::Unknown(_))) => {
                    self.counts.damaged += 1;
                    (self.note)("the board says something that this program does not know: is it newer?");
                    return Ok(Some(Came::Damage));
                }
            }
        }
    }

    /// Opens the port again, and goes on as if nothing had been: what was under way is asked for again.
    fn reopen(&mut self, why: &str) -> Result<(), LinkError> {
        (self.note)(&format!("lost {}: {why}; trying to open it again", self.port.name()));
        let mut why = why.to_owned();
        for _ in 0..REOPENINGS {
            std::thread::sleep(REOPEN_PAUSE);
            if self.stop.load(Ordering::Relaxed) {
                return Err(LinkError::Interrupted);
            }
            match self.port.reopen() {
                Ok(()) => {
                    (self.note)(&format!("{} is back", self.port.name()));
                    self.receiver = Receiver::default();
                    self.came.clear();
                    self.counts.reopened += 1;
                    return Ok(());
                }
                Err(error) => why = error.to_string(),
            }
        }
        Err(self.lost(format!("{why} ({REOPENINGS} attempts)")))
    }

    /// The order that the board's latest block has obeyed.
    fn order_seen(&mut self) -> Result<Option<u32>, LinkError> {
        Ok(self.status()?.map(|report| report.orders_sequence))
    }

    fn lost(&self, why: String) -> LinkError {
        LinkError::Lost { port: self.port.name().to_owned(), why }
    }

    /// Why nobody answers.
    fn silence(&self, damaged: bool, seconds: f64) -> LinkError {
        let port = self.port.name().to_owned();
        match (self.identity, self.raw.count()) {
            (Some(_), _) if damaged => self.lost("every answer arrives damaged: look at cable, ground and baud rate".into()),
            (Some(_), _) => self.lost(format!("no answer to {COPIES} copies of a command in {seconds:.1} s")),
            (None, 0) => LinkError::Silent { port, tries: COPIES, seconds },
            (None, count) => LinkError::Stranger { port, count, bytes: self.raw.shown() },
        }
    }

    /// From now on Ctrl-C is not looked at: what is to be said before leaving is said.
    pub fn part(&mut self) {
        static NEVER: AtomicBool = AtomicBool::new(false);
        self.stop = &NEVER;
    }
}

/// Whether obeying this twice is not the same as obeying it once.
///
/// A run that runs already is left alone, but one that another order has ended meanwhile would begin again.
pub fn starts(command: &Command) -> bool {
    matches!(command, Command::Scan | Command::Run | Command::Calibrate)
}

/// A command as the protocol calls it, for messages: `settings store` is `Settings(Store)` there.
fn shown(command: &Command) -> String {
    let whole = format!("{command:?}");
    let words: Vec<&str> = whole.split(['(', ')', '{', ' ']).filter(|word| !word.is_empty()).take(2).collect();
    match words.as_slice() {
        [first, second] if second.chars().all(char::is_alphabetic) && *second != "None" && *second != "Some" => {
            format!("{first} {second}").to_lowercase()
        }
        [first, ..] => first.to_lowercase(),
        [] => whole,
    }
}

/// The answer to something else.
pub(super) fn unexpected(command: &str, reply: &Reply) -> LinkError {
    LinkError::Unexpected { command: command.to_owned(), reply: format!("{reply:?}").chars().take(120).collect() }
}
