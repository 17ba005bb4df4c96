//! Session of a user with a board. It keeps the host timeout of the board from expiring, and stops
//! the drive at its end unless the user has chosen otherwise.

use std::path::{Path, PathBuf};
use std::time::Duration;

use firmware::board::command::{Command, Identity};
use firmware::board::stored_state::StoredState;
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use serde_json::Value;

use crate::answer::Answer;
use crate::client::Client;
use crate::files::ResultFolder;
use crate::link_error::LinkError;
use crate::parameter::{parameter, report};
use crate::scale::Scale;
use crate::words;
use sim::provenance::Provenance;

/// Shortest time between messages that keep the host timeout from expiring, s.
const MIN_KEEP_ALIVE_S: f64 = 2e-3;
/// Longest time between such messages, s.
const MAX_KEEP_ALIVE_S: f64 = 0.2;
/// Number of messages within the host timeout.
const MESSAGES_PER_TIMEOUT: f64 = 5.0;
/// Polling interval for the end of work on another thread.
const POLL_INTERVAL: Duration = Duration::from_millis(10);
/// Number of repeats of a failed order to stop.
const STOP_REPEATS: u32 = 3;

/// Options of a session.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SessionOptions {
    /// Host timeout, s: longest time for which the board drives without a message from its host.
    /// `None` means the setting of the board, 0 no timeout.
    pub host_timeout_s: Option<f32>,
    /// `true` if the drive continues when the session ends.
    pub stay: bool,
}

/// Session with one board. It serves the board's host timeout and stops the drive at its end.
pub struct Session {
    /// Client of the board.
    pub client: Client,
    /// Identity of the connected board.
    pub identity: Identity,
    options: SessionOptions,
    /// Active host timeout, s.
    host_timeout_s: f32,
    /// Longest time between messages to the board.
    keep_alive: Duration,
    /// `true` if the user has started the drive.
    driving: bool,
    /// `true` if the board sends periodic telemetry.
    streams: bool,
    /// `true` if no further command follows, so that the session ends after this one.
    pub ends_with_command: bool,
    /// Answer to the last command.
    pub last: Answer,
    /// Callbacks for progress.
    pub live: Live,
    /// Provenance for the reports of this session.
    pub provenance: Provenance,
    /// Files that the session reads, such as the scene of a simulated board. No command overwrites
    /// them.
    pub inputs: Vec<PathBuf>,
    /// Scale of the board's codes, once it has been read.
    pub(super) scale: Option<Scale>,
}

impl Session {
    /// Connects, and sets the host timeout.
    pub fn begin(mut client: Client, options: SessionOptions) -> Result<Self, LinkError> {
        let identity = client.connect()?;
        let mut session = Session {
            client,
            identity,
            options,
            host_timeout_s: 0.0,
            keep_alive: Duration::from_secs_f64(MAX_KEEP_ALIVE_S),
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
    pub fn folder(&self, command: &str, dir: Option<&Path>) -> Result<Option<ResultFolder>, LinkError> {
        dir.map(|dir| ResultFolder::open(command, dir, &self.inputs)).transpose()
    }

    /// Agrees with the board on the host timeout, and on the interval of the messages. A client
    /// that only reads does not end a drive that another host has left running.
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
            // All later commands act on other settings than the stored ones.
            self.client.note(&words::stored(configured.stored));
        }
        let requested_s = if self.options.stay { Some(0.0) } else { self.options.host_timeout_s };
        let host_timeout_s = requested_s.unwrap_or(configured.acts);
        self.set_host_timeout(host_timeout_s);
        let silent = self.client.status()?.is_none_or(|report| matches!(report.mode, Mode::Idle | Mode::Fault));
        if silent || requested_s.is_some() {
            self.client.order(Command::Patience(host_timeout_s))?;
        }
        Ok(())
    }

    /// Lowers the host timeout of the drives of this session to at most `bound_s`, also if the
    /// board's setting is longer or has none.
    pub fn bound_host_timeout(&mut self, bound_s: f32) {
        if self.host_timeout_s == 0.0 || self.host_timeout_s > bound_s {
            self.options.host_timeout_s = Some(bound_s);
            self.set_host_timeout(bound_s);
        }
    }

    fn set_host_timeout(&mut self, host_timeout_s: f32) {
        self.host_timeout_s = host_timeout_s;
        if host_timeout_s > 0.0 {
            self.keep_alive = Duration::from_secs_f64(
                (f64::from(host_timeout_s) / MESSAGES_PER_TIMEOUT).clamp(MIN_KEEP_ALIVE_S, MAX_KEEP_ALIVE_S),
            );
        }
    }

    /// Sets the host timeout before a command starts the drive, which belongs to this session from
    /// now on.
    pub fn begin_drive(&mut self) -> Result<(), LinkError> {
        self.driving = true;
        self.client.order(Command::Patience(self.host_timeout_s))
    }

    /// Records that the drive is silent.
    pub fn mark_silent(&mut self) {
        self.driving = false;
    }

    /// Describes the end of a drive that a command leaves running.
    pub fn end_of_drive(&self) -> &'static str {
        match (self.ends_with_command, self.options.stay) {
            (_, true) if self.client.stands_still() => "it ends with this program, which contains the board, or by `stop`",
            (_, true) => "it continues when this program ends (--stay); `stop` ends it",
            (true, false) => {
                "it stops now, at the end of this command; `--stay` keeps it running, as does the prompt or a script until it \
                 ends"
            }
            (false, false) => "`stop` ends it",
        }
    }

    /// Returns `true` if the user has started the drive.
    pub fn is_driving(&self) -> bool {
        self.driving
    }

    /// Ends the session: stops the drive if this user has started it, unless `stay` is set. Returns
    /// a message about the drive.
    pub fn leave(&mut self) -> Result<Option<&'static str>, LinkError> {
        self.client.ignore_ctrl_c();
        // Even if the stop fails, it is not repeated when the session is dropped.
        let driving = std::mem::take(&mut self.driving);
        let said = match (driving, self.options.stay) {
            (false, _) => None,
            (true, true) => Some("the drive continues (--stay); `stop` ends it"),
            (true, false) => {
                self.order_stop()?;
                Some("the drive is silent now")
            }
        };
        self.stream(0)?;
        Ok(said)
    }

    /// Orders the drive to stop, and repeats the order if the board refuses it.
    fn order_stop(&mut self) -> Result<(), LinkError> {
        let mut ordered = self.client.order(Command::Idle);
        for _ in 0..STOP_REPEATS {
            if ordered.is_ok() {
                break;
            }
            ordered = self.client.order(Command::Idle);
        }
        ordered
    }

    /// Returns the report of the latest block, and waits for the first one after a start.
    pub fn status(&mut self) -> Result<Telemetry, LinkError> {
        let until = self.client.now() + self.keep_alive;
        loop {
            match self.client.status()? {
                Some(report) => return Ok(report),
                None if self.client.now() >= until => {
                    let why = "the board has not played a block yet: its converters have stopped. \
                        Power it off and on, then read `fault log`";
                    return Err(LinkError::Failed(why.into()));
                }
                None => {}
            }
        }
    }

    /// Waits, while telemetry is received and the host timeout is served.
    pub fn wait(&mut self, time: Duration) -> Result<(), LinkError> {
        self.watch(time, 0, |_| None::<()>).map(drop)
    }

    /// Does some work of this program while the host timeout is served. Where there are no threads,
    /// the board waits for the work.
    pub fn meanwhile<T: Send>(&mut self, work: impl FnOnce() -> T + Send) -> Result<T, LinkError> {
        if self.client.stands_still() || cfg!(target_family = "wasm") {
            return Ok(work());
        }
        std::thread::scope(|threads| {
            let work = threads.spawn(work);
            let mut looked_after = Ok(());
            while !work.is_finished() && looked_after.is_ok() {
                looked_after = self.client.status().map(drop);
                let until = self.client.now() + self.keep_alive;
                while !work.is_finished() && self.client.now() < until {
                    std::thread::sleep(POLL_INTERVAL.min(self.keep_alive));
                }
            }
            // The work is completed even if the link fails.
            let done = work.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            looked_after.map(|()| done)
        })
    }

    /// Passes reports to `look` until it returns a value, or `None` after `at_most`. The board
    /// sends a report every `every` blocks, as far as the line permits. With zero it sends none,
    /// and `look` only gets the answers to the messages that serve the host timeout.
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

    /// Requests telemetry every `every` blocks from now on; zero ends it.
    fn stream(&mut self, every: u32) -> Result<(), LinkError> {
        if every > 0 || self.streams {
            self.client.order(Command::TelemetryEvery(every))?;
        }
        self.streams = every > 0;
        self.client.discard_telemetry();
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
            report.iter().for_each(|report| self.live.telemetry(self.client.now(), report));
            if let Some(seen) = report.as_ref().filter(|_| every > 0).and_then(&mut *look) {
                return Ok(Some(seen));
            }
            if self.client.now() >= alive {
                alive = self.client.now() + self.keep_alive;
                let report = self.client.status()?;
                report.iter().for_each(|report| self.live.telemetry(self.client.now(), report));
                if let Some(seen) = report.as_ref().and_then(&mut *look) {
                    return Ok(Some(seen));
                }
            }
        }
    }

    /// Returns an error if the board has a fault.
    pub fn check(&mut self, report: &Telemetry) -> Result<(), LinkError> {
        match report.fault {
            Some(fault) if report.mode == Mode::Fault => {
                self.driving = false;
                Err(LinkError::Failed(format!("the drive is muted: {}", words::fault(fault))))
            }
            _ => Ok(()),
        }
    }

    /// Returns the scale of the board's codes.
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
    /// Stops the drive if the program fails.
    fn drop(&mut self) {
        if self.driving && !self.options.stay {
            self.client.ignore_ctrl_c();
            let _ = self.order_stop();
        }
    }
}

/// Callbacks for the progress of a command.
#[derive(Clone, Copy, Default)]
pub struct Live {
    /// Called with a line at the beginning of each stage.
    pub stage: Option<fn(&str)>,
    /// Called with each report of a monitor, as a line and as fields.
    pub report: Option<fn(&str, &Value)>,
    /// Called with each report of the board during a command or a wait, and its time since the port
    /// was opened.
    pub telemetry: Option<fn(Duration, &Telemetry)>,
}

impl Live {
    /// Reports that a stage has begun.
    pub fn stage(&self, line: &str) {
        self.stage.into_iter().for_each(|call| call(line));
    }

    /// Passes on a report of the board.
    fn telemetry(&self, time: Duration, report: &Telemetry) {
        self.telemetry.into_iter().for_each(|call| call(time, report));
    }

    /// Passes on a report of a monitor.
    pub fn report(&self, line: &str, fields: impl FnOnce() -> Value) {
        if let Some(call) = self.report {
            call(line, &fields());
        }
    }
}
