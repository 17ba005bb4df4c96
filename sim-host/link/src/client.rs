//! Asks a board and is answered.
//!
//! Every command carries a sequence number, and its answer the same. What does not come back in time, or comes damaged, is asked for again
//! with the same number, so that a late answer to the first copy is taken for what it is; answers with another number are not ours.
//!
//! [`Client::connect`] begins a session at the board, whose number every further command carries, and every answer: what an earlier client has left in a
//! buffer does not act, and is taken for no answer. Where another client has begun a session since, or the board was reset, it refuses what is of this one,
//! and the client ends with [`LinkError::Displaced`]; it does not take the board back. It begins another session by itself only where it has none: before the
//! first, and after a reset that it has ordered, whatever has become of that.
//!
//! **A command never acts twice because an answer was lost.** Most may be repeated: asking changes nothing, and an order that says how things
//! are to be (gate, amplitude, idle, a setting) says the same twice. Those that start something are an exception ([`starts`]): before such a
//! one is repeated the client asks which order the board has seen last; if that has changed, the first copy has arrived, and it is done.

mod line;

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use firmware::board::capture::{CaptureState, CaptureVerb};
use firmware::board::command::{Command, Identity, Reply};
use firmware::board::link::{self, NO_SESSION};
use firmware::seam::refusal::Refusal;
use firmware::seam::telemetry::Telemetry;

use crate::client::line::{Came, Line};
use crate::link_error::LinkError;
use crate::port::Port;

pub use line::Counts;

/// How long one copy of a command is waited for.
const PATIENCE: Duration = Duration::from_millis(250);
/// How long it is waited for once something has come damaged, which may have been the answer.
const AFTER_DAMAGE: Duration = Duration::from_millis(20);
/// Copies of a command that may stay without an answer before the link is given up.
const COPIES: u32 = 5;
/// Copies that may be answered by damaged frames: the board is there, and sooner or later a frame arrives whole.
const DAMAGED: u32 = 12;

/// Client of a board: sends commands and receives answers and telemetry.
pub struct Client {
    line: Line,
    sequence: u16,
    /// Who has answered.
    identity: Option<Identity>,
}

impl Client {
    /// A client at this port, which gives up when `stop` is set, and tells `note` what a user should know meanwhile.
    pub fn new(port: Box<dyn Port>, stop: &'static AtomicBool, note: fn(&str)) -> Self {
        Client { line: Line::new(port, stop, note), sequence: 0, identity: None }
    }

    /// Finds out who is there, and begins a session.
    pub fn connect(&mut self) -> Result<Identity, LinkError> {
        self.identity = None;
        self.line.session = NO_SESSION;
        self.line.raw.clear();
        // Ends whatever an earlier host has left unfinished.
        self.line.port.send(&[0]).map_err(|error| self.line.lost(error.to_string()))?;
        self.identify()
    }

    /// Announces an order to stop, by a frame outside of any session, which a board refuses. A served board knows by it that this client may take it from
    /// the client that holds it.
    pub fn announce_stop(&mut self) -> Result<(), LinkError> {
        let frame = link::encode(0, NO_SESSION, Command::Idle).map_err(|_| self.line.lost("no frame fits".into()))?;
        self.line.port.send(&frame).map_err(|error| self.line.lost(error.to_string()))
    }

    /// Asks the board for its identity, in a session of its own from now on.
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

    /// The session at the board; [`NO_SESSION`] before the client has connected.
    pub fn session(&self) -> u32 {
        self.line.session
    }

    /// Name of the port.
    pub fn port(&self) -> &str {
        self.line.port.name()
    }

    /// Time as it passes for the board.
    pub fn now(&self) -> Duration {
        self.line.port.now()
    }

    /// Says something to the user.
    pub fn note(&self, line: &str) {
        self.line.say(line);
    }

    /// Whether the board's time stands still while this program does something else.
    pub fn stands_still(&self) -> bool {
        self.line.port.stands_still()
    }

    /// How the link has done so far.
    pub fn counts(&self) -> Counts {
        self.line.counts
    }

    /// Asks, and gives the answer, whatever it is but a refusal.
    pub fn ask(&mut self, command: Command) -> Result<Reply, LinkError> {
        if self.line.session == NO_SESSION && !matches!(command, Command::Identify(_)) {
            self.connect()?;
        }
        if matches!(command, Command::Capture(CaptureVerb::Arm(_))) {
            // So that a capture which is not empty says that the order has arrived.
            self.order(Command::Capture(CaptureVerb::Disarm))?;
        }
        let before = if starts(&command) { self.order_seen()? } else { None };
        self.sequence = self.sequence.wrapping_add(1);
        self.line.counts.commands += 1;
        let answer = self.ask_as(self.sequence, command, before);
        if matches!(command, Command::Reset) && !matches!(answer, Err(LinkError::Refused { .. } | LinkError::Displaced { .. })) {
            // Whether its answer has come or not: it may have ended the session.
            self.line.session = NO_SESSION;
        }
        answer
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
        let until = self.line.port.now() + wait;
        loop {
            if let Some(report) = self.line.telemetry.pop_front() {
                return Ok(Some(report));
            }
            let now = self.line.port.now();
            if now >= until {
                return Ok(None);
            }
            // Answers to no command of this client are counted, and damage costs a report.
            if let Some(Came::Frame(_)) = self.line.receive(until - now)? {
                self.line.counts.late += 1;
            }
        }
    }

    /// Discards the telemetry that has not been taken.
    pub fn forget_telemetry(&mut self) {
        self.line.telemetry.clear();
    }

    fn ask_as(&mut self, sequence: u16, command: Command, before: Option<u32>) -> Result<Reply, LinkError> {
        let began = self.line.port.now();
        // A request for a session is of none, and is answered with its own number.
        let (session, answered) = match command {
            Command::Identify(nonce) => (NO_SESSION, nonce),
            _ => (self.line.session, self.line.session),
        };
        let frame = link::encode(sequence, session, command)
            .map_err(|_| LinkError::Usage(format!("`{}` does not fit into a frame", shown(&command))))?;
        let (mut silent, mut damaged) = (0, 0);
        while silent < COPIES && damaged < DAMAGED {
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
                Some(Came::Version(board)) => {
                    return Err(LinkError::Version { port: self.line.port.name().to_owned(), board, ours: link::VERSION });
                }
                Some(Came::Frame(frame)) => {
                    return match frame.body {
                        // An earlier copy has arrived: the session has ended with the reset.
                        Reply::Nak(Refusal::Session) if matches!(command, Command::Reset) && damaged > 0 => Ok(Reply::Ack),
                        Reply::Nak(Refusal::Session) => Err(LinkError::Displaced { port: self.line.port.name().to_owned() }),
                        Reply::Nak(refusal) => Err(LinkError::Refused { command: shown(&command), refusal }),
                        body => Ok(body),
                    };
                }
                Some(Came::Damage) => damaged += 1,
                Some(Came::Telemetry) | None => silent += 1,
            }
            if matches!(command, Command::Reset) && silent > 0 {
                // The board restarts, and answers to nothing for a while. A board that has restarted refuses a second copy.
                return Ok(Reply::Ack);
            }
        }
        let seconds = (self.line.port.now() - began).as_secs_f64();
        Err(self.silence(damaged > 0, seconds))
    }

    /// The answer with this number in this session, or what came instead of it; none in time.
    fn answer(&mut self, sequence: u16, session: u32) -> Result<Option<Came>, LinkError> {
        let mut until = self.line.port.now() + PATIENCE;
        let mut damaged = false;
        loop {
            let now = self.line.port.now();
            if now >= until {
                break;
            }
            match self.line.receive(until - now)? {
                Some(Came::Frame(frame)) if (frame.sequence, frame.session) == (sequence, session) => {
                    return Ok(Some(Came::Frame(frame)));
                }
                Some(Came::Frame(frame)) if frame.body != Reply::Nak(Refusal::Damaged) => self.line.counts.late += 1,
                // It may have been another frame, and the answer be on its way.
                Some(Came::Frame(_) | Came::Damage) => {
                    damaged = true;
                    until = until.min(self.line.port.now() + AFTER_DAMAGE);
                }
                Some(Came::Version(board)) => return Ok(Some(Came::Version(board))),
                Some(Came::Telemetry) | None => {}
            }
        }
        Ok(damaged.then_some(Came::Damage))
    }

    /// Whether a copy of a command that must not act twice has arrived. `before`: the order that the board had obeyed before.
    fn has_arrived(&mut self, command: &Command, before: Option<u32>) -> Result<bool, LinkError> {
        match command {
            Command::Capture(CaptureVerb::Arm(_)) => match self.ask(Command::Capture(CaptureVerb::State))? {
                Reply::Capture(report) => Ok(report.state != CaptureState::Empty),
                reply => Err(unexpected("capture", &reply)),
            },
            command if starts(command) => Ok(self.order_seen()? != before),
            _ => Ok(false),
        }
    }

    /// The order that the board's latest block has obeyed.
    fn order_seen(&mut self) -> Result<Option<u32>, LinkError> {
        Ok(self.status()?.map(|report| report.orders_sequence))
    }

    /// The error for a command without an answer.
    fn silence(&self, damaged: bool, seconds: f64) -> LinkError {
        let port = self.line.port.name().to_owned();
        match (self.identity, self.line.raw.count()) {
            (Some(_), _) if damaged => self.line.lost("every answer arrives damaged: look at cable, ground and baud rate".into()),
            (Some(_), _) => self.line.lost(format!("no answer to {COPIES} copies of a command in {seconds:.1} s")),
            (None, 0) => LinkError::Silent { port, tries: COPIES, seconds },
            (None, count) => LinkError::Stranger { port, count, bytes: self.line.raw.shown() },
        }
    }

    /// From now on Ctrl-C is not looked at: what is to be said before leaving is said.
    pub fn part(&mut self) {
        static NEVER: AtomicBool = AtomicBool::new(false);
        self.line.stop = &NEVER;
    }

    /// From now on this is looked at in place of what was.
    pub fn heed(&mut self, stop: &'static AtomicBool) {
        self.line.stop = stop;
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
