//! A board that drives, from which every run begins.

use std::cell::{Ref, RefCell};
use std::io;
use std::rc::Rc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use board::configure::load;
use board::{Board, Options};
use firmware::board::command::{Command, Reply};
use firmware::board::fault_log::FaultReport;
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use link::client::Client;
use link::link_error::LinkError;
use link::port::{InProcess, Simulated};
use stm32g474::{Rule, Verdict};

use super::limits::HOST_S;
use crate::campaign_error::CampaignError;

/// The scene: the dummy load of `docs/board.md`.
const SCENE: &str = "dummy-load";
/// The longest that it may take to lock.
const LOCKS_WITHIN: Duration = Duration::from_millis(300);
/// How long it drives before the snapshot is taken: the clamped branch has been measured at the lock point by then.
const SETTLES: Duration = Duration::from_millis(30);
static NEVER: AtomicBool = AtomicBool::new(false);

/// What a program can do nothing about: the defects raise these by themselves. Every other finding ends a run.
const RAISED: [Rule; 7] = [
    Rule::EccDouble,
    Rule::AdcOverrun,
    Rule::AdcTriggerLost,
    Rule::AdcTriggerMargin,
    Rule::DacUnderrun,
    Rule::DmaError,
    Rule::UartLost,
];

/// A board that drives.
pub struct Snapshot {
    /// The board.
    pub board: Board,
    /// The frequency that it reports, Hz.
    pub frequency_hz: f32,
}

/// Boots a board with the dummy load, and lets it find it, lock and drive; `sim-host link` would say `run`.
pub fn driving(elf: &[u8]) -> Result<Snapshot, CampaignError> {
    let loaded = load(SCENE, &[])?;
    let scene = loaded.scene.driven().ok_or(CampaignError::Scene)?;
    let mut board = Board::start(elf, &scene, Options::default())?;
    for rule in RAISED {
        board.machine_mut().chip.lint.set(rule, Verdict::Collect);
    }
    let mut host = Host::of(board);
    host.ask(Command::Patience(HOST_S as f32), LOCKS_WITHIN)?;
    host.ask(Command::Run, LOCKS_WITHIN)?;
    let until = host.now() + LOCKS_WITHIN;
    while !host.status(LOCKS_WITHIN)?.is_some_and(|report| report.mode == Mode::Run && report.locked) {
        if host.now() > until {
            return Err(CampaignError::NoLock(LOCKS_WITHIN));
        }
        host.run_for(Duration::from_millis(1))?;
    }
    let settled = host.now() + SETTLES;
    loop {
        let report = host.status(LOCKS_WITHIN)?;
        if host.now() >= settled {
            let report = report.ok_or(CampaignError::NoLock(LOCKS_WITHIN))?;
            return Ok(Snapshot { board: host.release()?, frequency_hz: report.frequency.0 });
        }
    }
}

/// A host at the serial line of a board.
pub struct Host {
    board: Rc<RefCell<Limited>>,
    client: Client,
}

/// A board whose time is limited while the client waits for it.
struct Limited {
    board: Board,
    until: Duration,
}

impl InProcess for Limited {
    fn send(&mut self, bytes: &[u8]) {
        self.board.send(bytes);
    }

    fn waiting(&self) -> usize {
        self.board.bench().to_board.len()
    }

    fn receive(&mut self, into: &mut [u8]) -> usize {
        self.board.receive(into)
    }

    fn now(&self) -> Duration {
        self.board.now()
    }

    fn block(&mut self) -> io::Result<()> {
        if self.board.now() >= self.until {
            return Err(io::ErrorKind::TimedOut.into());
        }
        self.board.run_block().map_err(io::Error::other)
    }
}

impl Host {
    /// A host at this board.
    pub fn of(board: Board) -> Self {
        let board = Rc::new(RefCell::new(Limited { board, until: Duration::MAX }));
        let client = Client::new(Box::new(Simulated::new("board", board.clone(), false)), &NEVER, |_| ());
        Host { board, client }
    }

    /// Gives the board back.
    pub fn release(self) -> Result<Board, CampaignError> {
        drop(self.client);
        Rc::into_inner(self.board).map(|limited| limited.into_inner().board).ok_or(CampaignError::Scene)
    }

    /// Time since the power came.
    pub fn now(&self) -> Duration {
        self.client.now()
    }

    /// Lets the board run.
    pub fn run_for(&mut self, time: Duration) -> Result<(), CampaignError> {
        Ok(self.board.borrow_mut().board.run_for(time)?)
    }

    /// Asks, and waits for an answer for so long; in another session where the board was reset.
    pub fn ask(&mut self, command: Command, within: Duration) -> Result<Reply, CampaignError> {
        let until = self.now() + within;
        self.board.borrow_mut().until = until;
        match self.client.ask(command) {
            Err(LinkError::Displaced { .. }) => {
                self.client.connect()?;
                Ok(self.client.ask(command)?)
            }
            answer => Ok(answer?),
        }
    }

    /// The board.
    pub fn board(&self) -> Ref<'_, Board> {
        Ref::map(self.board.borrow(), |limited| &limited.board)
    }

    /// The fault of the last telemetry that came by itself.
    pub fn last_telemetry(&mut self) -> Option<Fault> {
        self.board.borrow_mut().until = self.now() + Duration::from_millis(10);
        let mut fault = None;
        while let Ok(Some((_, report))) = self.client.telemetry(Duration::from_millis(4)) {
            fault = report.fault;
        }
        fault
    }

    /// The report of the latest block.
    pub fn status(&mut self, within: Duration) -> Result<Option<Telemetry>, CampaignError> {
        match self.ask(Command::Status, within)? {
            Reply::Status(report) => Ok(report),
            _ => Ok(None),
        }
    }

    /// The latest fault of the log, and what started the board.
    pub fn faults(&mut self, within: Duration) -> Result<Option<FaultReport>, CampaignError> {
        match self.ask(Command::Faults(0), within)? {
            Reply::Faults(report) => Ok(Some(report)),
            _ => Ok(None),
        }
    }
}
