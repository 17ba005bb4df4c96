//! Client of a board: sends commands and receives their answers.
//!
//! A command and its answer carry the same sequence number. If the answer is late or damaged, the
//! command is repeated with the same number, so that a late answer to the first copy is accepted.
//! Answers with another number are ignored.
//!
//! [`Client::connect`] begins a session at the board. Every later command and answer carries its
//! number. Bytes that an earlier client has left in a buffer therefore have no effect. If another
//! client has begun a session since, or if the board was reset, the board refuses the commands of
//! this client, which ends with [`LinkError::Displaced`] and does not take the board back. The
//! client begins another session by itself only if it has none: before the first one, and after a
//! reset that it has ordered, for any result of that order.
//!
//! **A command never acts twice because an answer was lost.** Most commands may be repeated: a
//! request changes nothing, and an order that sets a state (gate, amplitude, idle, a setting) sets
//! the same state twice. Commands that start something are an exception ([`starts`]). Before such a
//! command is repeated, the client reads the number of the last order that the board has obeyed. If
//! it has changed, the first copy has arrived, and the command is complete.

mod line;

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use firmware::board::capture::{CaptureState, CaptureVerb};
use firmware::board::command::{Command, Identity, Reply};
use firmware::board::link::{self, NO_SESSION};
use firmware::seam::refusal::Refusal;
use firmware::seam::telemetry::Telemetry;

use crate::client::line::{Line, Received};
use crate::link_error::LinkError;
use crate::port::Port;

pub use line::Counts;

/// Time to wait for the answer to one copy of a command.
const ANSWER_TIMEOUT: Duration = Duration::from_millis(250);
/// Time to wait after a damaged frame, which may have been the answer.
const DAMAGE_TIMEOUT: Duration = Duration::from_millis(20);
/// Number of unanswered copies of a command after which the link counts as lost.
const MAX_UNANSWERED_COPIES: u32 = 5;
/// Number of copies with a damaged answer after which the link counts as lost. It is larger than
/// [`MAX_UNANSWERED_COPIES`]: the board is present, and sooner or later an intact frame arrives.
const MAX_DAMAGED_COPIES: u32 = 12;

/// Client of a board: sends commands and receives answers and telemetry.
pub struct Client {
    line: Line,
    sequence: u16,
    /// Identity of the board; none before it has answered.
    identity: Option<Identity>,
}

impl Client {
    /// Creates a client at this port. It gives up when `stop` is set, and passes messages for the
    /// user to `note`.
    pub fn new(port: Box<dyn Port>, stop: &'static AtomicBool, note: fn(&str)) -> Self {
        Client { line: Line::new(port, stop, note), sequence: 0, identity: None }
    }

    /// Identifies the board and begins a session.
    pub fn connect(&mut self) -> Result<Identity, LinkError> {
        self.identity = None;
        self.line.session = NO_SESSION;
        self.line.raw.clear();
        // Terminates a frame that an earlier host has left incomplete.
        self.line.port.send(&[0]).map_err(|error| self.line.lost(error.to_string()))?;
        self.identify()
    }

    /// Announces an order to stop, by a frame outside any session, which a board refuses. After
    /// this frame a served board lets this client replace the client that holds it.
    pub fn announce_stop(&mut self) -> Result<(), LinkError> {
        let frame = link::encode(0, NO_SESSION, Command::Idle).map_err(|_| self.line.lost("the frame is too long".into()))?;
        self.line.port.send(&frame).map_err(|error| self.line.lost(error.to_string()))
    }

    /// Requests the identity of the board and begins a new session.
    pub fn identify(&mut self) -> Result<Identity, LinkError> {
        let nonce = self.line.port.nonce();
        match self.ask(Command::Identify(nonce))? {
            Reply::Identity(identity) => {
                self.identity = Some(identity);
                self.line.session = identity.session;
                Ok(identity)
            }
            reply => Err(unexpected("identify", &reply)),
        }
    }

    /// Returns the number of the session; [`NO_SESSION`] before the client has connected.
    pub fn session(&self) -> u32 {
        self.line.session
    }

    /// Returns the name of the port.
    pub fn port(&self) -> &str {
        self.line.port.name()
    }

    /// Returns the time of the board's clock.
    pub fn now(&self) -> Duration {
        self.line.port.now()
    }

    /// Passes a message to the user.
    pub fn note(&self, line: &str) {
        self.line.say(line);
    }

    /// Returns `true` if the board's time stops while this program does something else.
    pub fn stands_still(&self) -> bool {
        self.line.port.stands_still()
    }

    /// Returns the counts of commands and errors so far.
    pub fn counts(&self) -> Counts {
        self.line.counts
    }

    /// Sends a command and returns the answer. A refusal is an error.
    pub fn ask(&mut self, command: Command) -> Result<Reply, LinkError> {
        if self.line.session == NO_SESSION && !matches!(command, Command::Identify(_)) {
            self.connect()?;
        }
        if matches!(command, Command::Capture(CaptureVerb::Arm(_))) {
            // Afterwards a capture that is not empty shows that the order has arrived.
            self.order(Command::Capture(CaptureVerb::Disarm))?;
        }
        let before = if starts(&command) { self.latest_order()? } else { None };
        self.sequence = self.sequence.wrapping_add(1);
        self.line.counts.commands += 1;
        let answer = self.ask_as(self.sequence, command, before);
        if matches!(command, Command::Reset) && !matches!(answer, Err(LinkError::Refused { .. } | LinkError::Displaced { .. })) {
            // With or without an answer, the reset may have ended the session.
            self.line.session = NO_SESSION;
        }
        answer
    }

    /// Gives an order that is acknowledged.
    pub fn order(&mut self, command: Command) -> Result<(), LinkError> {
        match self.ask(command)? {
            Reply::Ack => Ok(()),
            reply => Err(unexpected(&shown(&command), &reply)),
        }
    }

    /// Requests the report of the latest block; none before the board has played a block.
    pub fn status(&mut self) -> Result<Option<Telemetry>, LinkError> {
        match self.ask(Command::Status)? {
            Reply::Status(report) => Ok(report),
            reply => Err(unexpected("status", &reply)),
        }
    }

    /// Returns the next report of the periodic telemetry, with the number of its frame; `None` if
    /// no report arrives within `wait`.
    pub fn telemetry(&mut self, wait: Duration) -> Result<Option<(u16, Telemetry)>, LinkError> {
        let until = self.line.port.now() + wait;
        loop {
            if let Some(report) = self.line.telemetry.pop_front() {
                return Ok(Some(report));
            }
            let now = self.line.port.now();
            if now >= until {
                return Ok(None);
            }
            // Unexpected answers are only counted, and a damaged frame loses a report.
            if let Some(Received::Frame(_)) = self.line.receive(until - now)? {
                self.line.counts.late += 1;
            }
        }
    }

    /// Discards telemetry reports that have not been read.
    pub fn discard_telemetry(&mut self) {
        self.line.telemetry.clear();
    }

    fn ask_as(&mut self, sequence: u16, command: Command, before: Option<u32>) -> Result<Reply, LinkError> {
        let began = self.line.port.now();
        // A request for a session is outside any session; its answer carries the nonce.
        let (session, answered) = match command {
            Command::Identify(nonce) => (NO_SESSION, nonce),
            _ => (self.line.session, self.line.session),
        };
        let frame = link::encode(sequence, session, command)
            .map_err(|_| LinkError::Usage(format!("`{}` does not fit into a frame", shown(&command))))?;
        let (mut silent, mut damaged) = (0, 0);
        while silent < MAX_UNANSWERED_COPIES && damaged < MAX_DAMAGED_COPIES {
            if silent + damaged > 0 {
                self.line.counts.repeated += 1;
                if self.has_arrived(&command, before)? {
                    return Ok(Reply::Ack);
                }
            }
            if let Err(error) = self.line.port.send(&frame) {
                self.line.reopen(&error.to_string())?;
                silent += 1;
                continue;
            }
            match self.answer(sequence, answered)? {
                Some(Received::Version(board)) => {
                    return Err(LinkError::Version { port: self.line.port.name().to_owned(), board, ours: link::VERSION });
                }
                Some(Received::Frame(frame)) => {
                    return match frame.body {
                        // An earlier copy has arrived: the reset has ended the session.
                        Reply::Nak(Refusal::Session) if matches!(command, Command::Reset) && damaged > 0 => Ok(Reply::Ack),
                        Reply::Nak(Refusal::Session) => Err(LinkError::Displaced { port: self.line.port.name().to_owned() }),
                        Reply::Nak(refusal) => Err(LinkError::Refused { command: shown(&command), refusal }),
                        body => Ok(body),
                    };
                }
                Some(Received::Damage) => damaged += 1,
                Some(Received::Telemetry) | None => silent += 1,
            }
            if matches!(command, Command::Reset) && silent > 0 {
                // The board restarts and does not answer for a while. After the restart it refuses
                // a second copy.
                return Ok(Reply::Ack);
            }
        }
        let seconds = (self.line.port.now() - began).as_secs_f64();
        Err(self.silence(damaged > 0, seconds))
    }

    /// Waits for the answer with this number in this session, or a frame that replaces it; `None`
    /// after the timeout.
    fn answer(&mut self, sequence: u16, session: u32) -> Result<Option<Received>, LinkError> {
        let mut until = self.line.port.now() + ANSWER_TIMEOUT;
        let mut damaged = false;
        loop {
            let now = self.line.port.now();
            if now >= until {
                break;
            }
            match self.line.receive(until - now)? {
                Some(Received::Frame(frame)) if (frame.sequence, frame.session) == (sequence, session) => {
                    return Ok(Some(Received::Frame(frame)));
                }
                Some(Received::Frame(frame)) if frame.body != Reply::Nak(Refusal::Damaged) => self.line.counts.late += 1,
                // The damaged frame may have been another one, and the answer may still arrive.
                Some(Received::Frame(_) | Received::Damage) => {
                    damaged = true;
                    until = until.min(self.line.port.now() + DAMAGE_TIMEOUT);
                }
                Some(Received::Version(board)) => return Ok(Some(Received::Version(board))),
                Some(Received::Telemetry) | None => {}
            }
        }
        Ok(damaged.then_some(Received::Damage))
    }

    /// Returns `true` if a copy of a command that must not act twice has arrived. `before` is the
    /// last order that the board had obeyed before the command.
    fn has_arrived(&mut self, command: &Command, before: Option<u32>) -> Result<bool, LinkError> {
        match command {
            Command::Capture(CaptureVerb::Arm(_)) => match self.ask(Command::Capture(CaptureVerb::State))? {
                Reply::Capture(report) => Ok(report.state != CaptureState::Empty),
                reply => Err(unexpected("capture", &reply)),
            },
            command if starts(command) => Ok(self.latest_order()? != before),
            _ => Ok(false),
        }
    }

    /// Returns the number of the order that the board obeyed in its latest block.
    fn latest_order(&mut self) -> Result<Option<u32>, LinkError> {
        Ok(self.status()?.map(|report| report.orders_sequence))
    }

    /// Returns the error for a command without an answer.
    fn silence(&self, damaged: bool, seconds: f64) -> LinkError {
        let port = self.line.port.name().to_owned();
        match (self.identity, self.line.raw.count()) {
            (Some(_), _) if damaged => self.line.lost("every answer arrives damaged: check cable, ground and baud rate".into()),
            (Some(_), _) => self.line.lost(format!("no answer to {MAX_UNANSWERED_COPIES} copies of a command in {seconds:.1} s")),
            (None, 0) => LinkError::Silent { port, tries: MAX_UNANSWERED_COPIES, seconds },
            (None, count) => LinkError::Stranger { port, count, bytes: self.line.raw.shown() },
        }
    }

    /// Ignores Ctrl-C from now on, so that the last commands before leaving are sent.
    pub fn ignore_ctrl_c(&mut self) {
        static NEVER: AtomicBool = AtomicBool::new(false);
        self.line.stop = &NEVER;
    }

    /// Watches this stop flag from now on, instead of the earlier one.
    pub fn heed(&mut self, stop: &'static AtomicBool) {
        self.line.stop = stop;
    }
}

/// Returns `true` if a command starts a scan, run or calibration, so that a repetition of it could
/// start the drive again.
///
/// A repeated order does not change a run that is still active. If another order has ended the run
/// meanwhile, the repetition would restart it.
pub fn starts(command: &Command) -> bool {
    matches!(command, Command::Scan | Command::Run | Command::Calibrate)
}

/// Returns the protocol's name of a command, for messages: `settings store` is `Settings(Store)`
/// there.
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

/// Returns the error for an answer of the wrong kind.
pub(super) fn unexpected(command: &str, reply: &Reply) -> LinkError {
    LinkError::Unexpected { command: command.to_owned(), reply: format!("{reply:?}").chars().take(120).collect() }
}
