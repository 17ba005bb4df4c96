//! A board that drives, with which every run begins.

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
/// Longest time until it has locked.
const LOCKS_WITHIN: Duration = Duration::from_millis(300);
/// Time for which it drives before the snapshot: by then it has measured the clamped branch at the
/// lock point.
const SETTLES: Duration = Duration::from_millis(30);
static NEVER: AtomicBool = AtomicBool::new(false);

/// Findings that the defects raise by themselves, so that the program cannot avoid them. Every
/// other finding ends a run.
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
    /// Frequency that it reports, Hz.
    pub frequency_hz: f32,
}

/// Boots a board with the dummy load and lets it identify the load, lock and drive, as after `run`
/// in `sim-host link`.
pub fn driving(elf: &[u8]) -> Result<Snapshot, CampaignError> {
    let loaded = load(SCENE, &[])?;
    let scene = loaded.scene.driven().ok_or(CampaignError::Scene)?;
    let mut board = Board::start(elf, &scene, Options::default())?;
    for rule in RAISED {
        board.machine_mut().chip.lint.set(rule, Verdict::Collect);
    }
    let mut host = Host::new(board);
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
    /// Connects a host to a board.
    pub fn new(board: Board) -> Self {
        let board = Rc::new(RefCell::new(Limited { board, until: Duration::MAX }));
        let client = Client::new(Box::new(Simulated::new("board", board.clone(), false)), &NEVER, |_| ());
        Host { board, client }
    }

    /// Returns the board.
    pub fn release(self) -> Result<Board, CampaignError> {
        drop(self.client);
        Rc::into_inner(self.board).map(|limited| limited.into_inner().board).ok_or(CampaignError::Scene)
    }

    /// Returns the time since power-on.
    pub fn now(&self) -> Duration {
        self.client.now()
    }

    /// Lets the board run.
    pub fn run_for(&mut self, time: Duration) -> Result<(), CampaignError> {
        Ok(self.board.borrow_mut().board.run_for(time)?)
    }

    /// Sends a command and waits for its answer, at most for `within`; after a reset of the board,
    /// in a new session.
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

    /// Borrows the board.
    pub fn board(&self) -> Ref<'_, Board> {
        Ref::map(self.board.borrow(), |limited| &limited.board)
    }

    /// Returns the fault in the last unsolicited telemetry.
    pub fn last_telemetry(&mut self) -> Option<Fault> {
        self.board.borrow_mut().until = self.now() + Duration::from_millis(10);
        let mut fault = None;
        while let Ok(Some((_, report))) = self.client.telemetry(Duration::from_millis(4)) {
            fault = report.fault;
        }
        fault
    }

    /// Requests the report of the latest block.
    pub fn status(&mut self, within: Duration) -> Result<Option<Telemetry>, CampaignError> {
        match self.ask(Command::Status, within)? {
            Reply::Status(report) => Ok(report),
            _ => Ok(None),
        }
    }

    /// Requests the latest fault of the log, and the cause of the last start.
    pub fn faults(&mut self, within: Duration) -> Result<Option<FaultReport>, CampaignError> {
        match self.ask(Command::Faults(0), within)? {
            Reply::Faults(report) => Ok(Some(report)),
            _ => Ok(None),
        }
    }
}
