//! A user's stay at a board: waits without the board thinking that its host has gone, and leaves the drive as the user wants it left.

use std::path::{Path, PathBuf};
use std::time::Duration;

use firmware::board::command::{Command, Identity};
use firmware::board::stored_state::StoredState;
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use serde_json::Value;

use crate::answer::Answer;
use crate::client::Client;
use crate::link_error::LinkError;
use crate::parameter::{parameter, report};
use crate::scale::Scale;
use crate::words;
use sim::output::{Folder, OutputError, Owner};
use sim::provenance::Provenance;

/// How often a message keeps the board from missing its host while that waits, s; at least, and at most.
const KEEP_ALIVE: (f64, f64) = (2e-3, 0.2);
/// Messages within the host timeout.
const SIGNS: f64 = 5.0;
/// How often work beside the board is polled.
const LOOK: Duration = Duration::from_millis(10);
/// How often silence is ordered again.
const SILENCES: u32 = 3;

/// Options of a session as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SessionOptions {
    /// Host timeout: how long the board may drive without a message from its host, s; `None`: the board's own setting; 0: for ever.
    pub host_timeout_s: Option<f32>,
    /// The drive goes on when the session ends.
    pub stay: bool,
}

/// A session with one board: it keeps the board's host timeout from running out, and silences the drive at its end.
pub struct Session {
    /// Client that the session speaks through.
    pub client: Client,
    /// Identity of the connected board.
    pub identity: Identity,
    options: SessionOptions,
    /// The host timeout in force, s.
    host_timeout_s: f32,
    /// How often the board is to receive a message.
    keep_alive: Duration,
    /// The user has ordered the drive on.
    driving: bool,
    /// The board sends telemetry by itself.
    streams: bool,
    /// No further command comes: what drives then is left as the options say.
    pub ends_with_command: bool,
    /// The last command's answer.
    pub last: Answer,
    /// What watches the session while it waits.
    pub live: Live,
    /// Where the reports of this session come from.
    pub provenance: Provenance,
    /// Files that the session reads, such as the scene of a simulated board: no command replaces them.
    pub inputs: Vec<PathBuf>,
    /// The scale of the board's codes, once it has been read.
    pub(super) scale: Option<Scale>,
}

impl Session {
    /// Connects, and says how patient the board is to be.
    pub fn begin(mut client: Client, options: SessionOptions) -> Result<Self, LinkError> {
        let identity = client.connect()?;
        let mut session = Session {
            client,
            identity,
            options,
            host_timeout_s: 0.0,
            keep_alive: Duration::from_secs_f64(KEEP_ALIVE.1),
            driving: false,
            streams: false,
            ends_with_command: false,
            last: Answer::default(),
            live: Live::default(),
            provenance: Provenance::default(),
            inputs: Vec::new(),
            scale: None,
        };
        session.agree_on_host_timeout()?;
        Ok(session)
    }

    /// Opens the folder of a command's result, if one is given.
    pub fn folder(&self, command: &str, dir: Option<&Path>) -> Result<Option<Folder>, OutputError> {
        dir.map(|dir| Folder::open(dir, Owner::new(&format!("link {command}"), &self.inputs))).transpose()
    }

    /// Agrees with the board on the host timeout, and on how often it must receive a message. A drive that another host has chosen to leave on is
    /// not cut short by a client that only reads.
    pub fn agree_on_host_timeout(&mut self) -> Result<(), LinkError> {
        let configured = report(parameter("link.patience_s")?, &mut self.client)?;
        if matches!(
            configured.stored,
            StoredState::Partly
                | StoredState::Refused
                | StoredState::Damaged
                | StoredState::Version(_)
                | StoredState::OneCopy
                | StoredState::Unfinished
        ) {
            // All further commands meet other settings than were stored.
            self.client.note(&words::stored(configured.stored));
        }
        let requested_s = if self.options.stay { Some(0.0) } else { self.options.host_timeout_s };
        let host_timeout_s = requested_s.unwrap_or(configured.acts);
        self.host_timeout_s = host_timeout_s;
        let silent = self.client.status()?.is_none_or(|report| matches!(report.mode, Mode::Idle | Mode::Fault));
        if silent || requested_s.is_some() {
            self.client.order(Command::Patience(host_timeout_s))?;
        }
        if host_timeout_s > 0.0 {
            self.keep_alive = Duration::from_secs_f64((f64::from(host_timeout_s) / SIGNS).clamp(KEEP_ALIVE.0, KEEP_ALIVE.1));
        }
        Ok(())
    }

    /// Called before the drive is ordered on: the drive, and with it the host timeout, belong to this session from now on.
    pub fn begins_to_drive(&mut self) -> Result<(), LinkError> {
        self.driving = true;
        self.client.order(Command::Patience(self.host_timeout_s))
    }

    /// The drive is silent.
    pub fn is_silent(&mut self) {
        self.driving = false;
    }

    /// What becomes of a drive that a command leaves on.
    pub fn what_becomes_of_it(&self) -> &'static str {
        match (self.ends_with_command, self.options.stay) {
            (_, true) if self.client.stands_still() => "it ends with this program, which the board is a part of, or by `stop`",
            (_, true) => "it goes on when this program ends (--stay); `stop` ends it",
            (true, false) => {
                "it falls silent now, with the end of this command; `--stay` leaves it on, and at the prompt or in a script it goes on"
            }
            (false, false) => "`stop` ends it",
        }
    }

    /// Whether the user has ordered the drive on.
    pub fn is_driving(&self) -> bool {
        self.driving
    }

    /// Leaves: the drive falls silent if this user has ordered it on, unless it is to stay. Says what it does now.
    pub fn leave(&mut self) -> Result<Option<&'static str>, LinkError> {
        self.client.part();
        // Whether it succeeds or not, it is not tried again.
        let driving = std::mem::take(&mut self.driving);
        let said = match (driving, self.options.stay) {
            (false, _) => None,
            (true, true) => Some("the drive goes on (--stay); `stop` ends it"),
            (true, false) => {
                self.silence()?;
                Some("the drive is silent now")
            }
        };
        self.stream(0)?;
        Ok(said)
    }

    /// Orders silence, more than once where the board has no room for the order.
    fn silence(&mut self) -> Result<(), LinkError> {
        let mut ordered = self.client.order(Command::Idle);
        for _ in 0..SILENCES {
            if ordered.is_ok() {
                break;
            }
            ordered = self.client.order(Command::Idle);
        }
        ordered
    }

    /// The latest block's report, as soon as there is one.
    pub fn status(&mut self) -> Result<Telemetry, LinkError> {
        let until = self.client.now() + self.keep_alive;
        loop {
            match self.client.status()? {
                Some(report) => return Ok(report),
                None if self.client.now() >= until => {
                    let why = "the board has not played a block yet: its converters stand still. Power it off and on, and look at `fault log`";
                    return Err(LinkError::Failed(why.into()));
                }
                None => {}
            }
        }
    }

    /// Waits while telemetry is received and the host timeout is served.
    pub fn wait(&mut self, time: Duration) -> Result<(), LinkError> {
        self.watch(time, 0, |_| None::<()>).map(drop)
    }

    /// Does some work that takes a while, with the board looked after meanwhile.
    pub fn meanwhile<T: Send>(&mut self, work: impl FnOnce() -> T + Send) -> Result<T, LinkError> {
        if self.client.stands_still() {
            return Ok(work());
        }
        std::thread::scope(|threads| {
            let work = threads.spawn(work);
            let mut looked_after = Ok(());
            while !work.is_finished() && looked_after.is_ok() {
                looked_after = self.client.status().map(drop);
                let until = self.client.now() + self.keep_alive;
                while !work.is_finished() && self.client.now() < until {
                    std::thread::sleep(LOOK.min(self.keep_alive));
                }
            }
            // Whatever the board does, the work is done to its end.
            let done = work.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            looked_after.map(|()| done)
        })
    }

    /// Looks at reports, one every so many blocks and as the line carries, until `look` has seen enough; `None`: not in time. Zero: no
    /// telemetry, only what a sign of life brings.
    pub fn watch<T>(
        &mut self,
        at_most: Duration,
        every: u32,
        mut look: impl FnMut(&Telemetry) -> Option<T>,
    ) -> Result<Option<T>, LinkError> {
        self.stream(every)?;
        let until = self.client.now() + at_most;
        let seen = self.look_until(until, every, &mut look);
        if seen.is_ok() {
            self.stream(0)?;
        }
        seen
    }

    /// Telemetry every so many blocks from now on, or none.
    fn stream(&mut self, every: u32) -> Result<(), LinkError> {
        if every > 0 || self.streams {
            self.client.order(Command::TelemetryEvery(every))?;
        }
        self.streams = every > 0;
        self.client.forget_telemetry();
        Ok(())
    }

    fn look_until<T>(
        &mut self,
        until: Duration,
        every: u32,
        look: &mut impl FnMut(&Telemetry) -> Option<T>,
    ) -> Result<Option<T>, LinkError> {
        let mut alive = self.client.now() + self.keep_alive;
        loop {
            let now = self.client.now();
            if now >= until {
                return Ok(None);
            }
            let wait = until.min(alive).saturating_sub(now);
            let report = self.client.telemetry(wait)?.map(|(_, report)| report);
            if let Some(seen) = report.as_ref().filter(|_| every > 0).and_then(&mut *look) {
                return Ok(Some(seen));
            }
            if self.client.now() >= alive {
                alive = self.client.now() + self.keep_alive;
                if let Some(seen) = self.client.status()?.as_ref().and_then(&mut *look) {
                    return Ok(Some(seen));
                }
            }
        }
    }

    /// Fails if the board has.
    pub fn check(&mut self, report: &Telemetry) -> Result<(), LinkError> {
        match report.fault {
            Some(fault) if report.mode == Mode::Fault => {
                self.driving = false;
                Err(LinkError::Failed(format!("the drive is muted: {}", words::fault(fault))))
            }
            _ => Ok(()),
        }
    }

    /// What the board's codes are worth.
    pub fn scale(&mut self) -> Result<Scale, LinkError> {
        let scale = match self.scale {
            Some(scale) => scale,
            None => Scale::ask(&self.identity.converters, &mut self.client)?,
        };
        self.scale = Some(scale);
        Ok(scale)
    }
}

impl Drop for Session {
    /// Nothing that this program fails by leaves a drive behind.
    fn drop(&mut self) {
        if self.driving && !self.options.stay {
            self.client.part();
            let _ = self.silence();
        }
    }
}

/// Callbacks for the progress of a command.
#[derive(Clone, Copy, Default)]
pub struct Live {
    /// Called with the line of each stage.
    pub stage: Option<fn(&str)>,
    /// Called with each report: a line, and fields.
    pub report: Option<fn(&str, &Value)>,
}

impl Live {
    /// Calls back that a stage has begun.
    pub fn stage(&self, line: &str) {
        self.stage.into_iter().for_each(|call| call(line));
    }

    /// Calls back with a report.
    pub fn report(&self, line: &str, fields: impl FnOnce() -> Value) {
        if let Some(call) = self.report {
            call(line, &fields());
        }
    }
}
