//! Boards with a first stage, brought into each phase of an update.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use board::configure::load;
use board::{Board, BoardError, Options};
use firmware::board::command::{Command, Reply};
use firmware::board::link::encode;
use firmware::board::update::{CHUNK, UpdateReport, UpdateState, UpdateVerb};
use link::client::Client;
use link::port::Simulated;
use link::update_file::{identity_offset, pack};
use nucleo_g474re::slots::{STATE, STORE};
use scene::Driven;
use stm32g474::{Defect, FlashOperation, Ram, Rule, Verdict};
use update::identity::NAME;
use update::key::DEVELOPMENT_SEED;

use crate::campaign_error::CampaignError;

/// Longest start: a swap of 117 pages, a signature, and the swap back.
const STARTS_WITHIN: Duration = Duration::from_secs(40);
static STOP: AtomicBool = AtomicBool::new(false);
/// Word with which `embassy-boot` marks an update that is to be swapped in.
const MARK: [u8; 8] = [0xf0; 8];

/// First stage and image, and the update files of the image in two versions, 1.0.0 and 2.0.0.
#[derive(Clone, Debug)]
pub struct FieldImages {
    first_stage: Vec<u8>,
    elf: Vec<u8>,
    old: Vec<u8>,
    new: Vec<u8>,
}

impl FieldImages {
    /// Builds the images from the present source.
    pub fn built() -> Result<Self, crate::evidence::Error> {
        let [first_stage, elf] = pil::field_images()?;
        let read = |file| std::fs::read(file).map_err(CampaignError::Io);
        let (first_stage, elf) = (read(first_stage)?, read(elf)?);
        let [old, new] = [1, 2].map(|major| file(&elf, major));
        Ok(FieldImages { first_stage, old: old?, new: new?, elf })
    }

    /// Returns a board just after power-on, with the old image in its slot and the settings of a
    /// scene.
    fn power(&self, scene: &Driven, options: Options) -> Result<Board, BoardError> {
        Board::start_in_slot(&self.first_stage, &self.old, &self.elf, scene, options)
    }

    /// Returns the same board once the first stage has started the image.
    pub fn started(&self, scene: &Driven, options: Options) -> Result<Board, CampaignError> {
        let mut board = self.power(scene, options)?;
        started(&mut board)?;
        Ok(board)
    }
}

/// Packs an image as an update with another version, which is in a constant of its own.
fn file(elf: &[u8], major: u16) -> Result<Vec<u8>, CampaignError> {
    let mut elf = elf.to_vec();
    let at = identity_offset(&elf)? + NAME;
    elf[at..at + 6].copy_from_slice(&[major as u8, 0, 0, 0, 0, 0]);
    Ok(pack(&elf, Some(&DEVELOPMENT_SEED))?)
}

/// Phase of an update in which the power is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The image stores the first page of an update.
    Receiving,
    /// The image marks the update.
    Marking,
    /// The first stage swaps the images.
    Installing,
    /// The new image confirms itself.
    Confirming,
    /// The first stage restores the old image.
    Returning,
}

impl Phase {
    /// All phases, in the order of an update.
    pub const ALL: [Phase; 5] = [Phase::Receiving, Phase::Marking, Phase::Installing, Phase::Confirming, Phase::Returning];

    /// Returns a description.
    pub fn name(self) -> &'static str {
        match self {
            Phase::Receiving => "the image receives a page",
            Phase::Marking => "the image marks the update",
            Phase::Installing => "the first stage swaps the images",
            Phase::Confirming => "the new image confirms itself",
            Phase::Returning => "the first stage restores the old image",
        }
    }

    /// Returns `true` if this version may answer after a cut.
    fn allows(self, version: u16) -> bool {
        match self {
            Phase::Receiving | Phase::Returning => version == 1,
            // A cut just at the end leaves a complete swap without confirmation: the old image
            // returns.
            Phase::Marking | Phase::Installing | Phase::Confirming => version == 1 || version == 2,
        }
    }
}

/// Returns a board at the beginning of a phase, and the flash operations of the phase.
pub fn prepared(images: &FieldImages, phase: Phase) -> Result<(Board, Vec<FlashOperation>), CampaignError> {
    let mut board = powered(images)?;
    let blocks = |board: &Board| board.bench().samples();
    let waits = match phase {
        Phase::Installing => {
            mark(&mut board, images);
            None
        }
        Phase::Receiving => {
            started(&mut board)?;
            let mut client = client_of(board);
            client.1.connect()?;
            client.1.ask(Command::Update(UpdateVerb::Begin(images.new.len() as u32)))?;
            let session = client.1.session();
            board = released(client);
            let write = UpdateVerb::Write(0, rows(&images.new[..CHUNK]));
            send(&mut board, 900, session, Command::Update(write))?;
            Some(Duration::from_millis(30))
        }
        Phase::Marking => {
            started(&mut board)?;
            let session;
            (board, session) = complete(board, images)?;
            send(&mut board, 901, session, Command::Update(UpdateVerb::Install))?;
            Some(Duration::from_millis(60))
        }
        Phase::Confirming => {
            mark(&mut board, images);
            started(&mut board)?;
            let mut client = client_of(board);
            client.1.connect()?;
            let session = client.1.session();
            board = released(client);
            // The first command that is obeyed confirms; beginning a session is not a command.
            send(&mut board, 902, session, Command::Status)?;
            Some(Duration::from_millis(180))
        }
        Phase::Returning => {
            mark(&mut board, images);
            started(&mut board)?;
            // A reset before the new image has confirmed itself.
            let at = board.machine().cycle() + 1;
            board.inject(at, Defect::BrownOut { ram: Ram::Lost });
            while board.bench().resets.is_empty() {
                board.run_block()?;
            }
            None
        }
    };
    let mut ahead = board.clone();
    ahead.machine_mut().chip.record_flash();
    let (until, samples) = (waits.map(|time| ahead.now() + time), blocks(&ahead));
    while until.map_or(blocks(&ahead) == samples, |until| ahead.now() < until) {
        ahead.run_for(Duration::from_millis(1))?;
    }
    Ok((board, ahead.machine().chip.flash_operations().to_vec()))
}

/// Returns a board just after power-on, with the old image in its slot.
fn powered(images: &FieldImages) -> Result<Board, CampaignError> {
    let loaded = load("dummy-load", &[])?;
    let scene = loaded.scene.driven().ok_or(CampaignError::NotReached("a drive"))?;
    let mut board = images.power(&scene, Options::default())?;
    // A cut leaves damaged words in the flash; both images must tolerate them.
    board.machine_mut().chip.lint.set(Rule::EccDouble, Verdict::Collect);
    Ok(board)
}

/// Writes the new image into the store, and marks it.
fn mark(board: &mut Board, images: &FieldImages) {
    let memory = &mut board.machine_mut().memory;
    for (at, bytes) in [(STORE.start, images.new.as_slice()), (STATE.start, &MARK)] {
        if let Some(flash) = memory.get_mut(at, bytes.len()) {
            flash.copy_from_slice(bytes);
        }
    }
}

/// Runs until the image plays its first sample.
fn started(board: &mut Board) -> Result<(), CampaignError> {
    let until = board.now() + STARTS_WITHIN;
    while board.bench().samples() == 0 {
        board.run_for(Duration::from_millis(1))?;
        if board.now() > until {
            return Err(CampaignError::NotReached("a first sample"));
        }
    }
    Ok(())
}

type Connected = (Rc<RefCell<Board>>, Client);

fn client_of(board: Board) -> Connected {
    let board = Rc::new(RefCell::new(board));
    let client = Client::new(Box::new(Simulated::new("the modelled board", board.clone(), false)), &STOP, |_| ());
    (board, client)
}

fn released((board, _): Connected) -> Board {
    board.borrow().clone()
}

/// Sends a command without waiting for its answer.
fn send(board: &mut Board, sequence: u16, session: u32, command: Command) -> Result<(), CampaignError> {
    board.send(&encode(sequence, session, command).map_err(|_| CampaignError::NotReached("a frame"))?);
    Ok(())
}

/// Splits a chunk into the rows in which it is sent.
fn rows(piece: &[u8]) -> [[u8; 32]; CHUNK / 32] {
    core::array::from_fn(|row| core::array::from_fn(|n| piece.get(32 * row + n).copied().unwrap_or(0xff)))
}

/// Returns the board after it has received and checked an update, and the session of the sending
/// host.
fn complete(board: Board, images: &FieldImages) -> Result<(Board, u32), CampaignError> {
    let mut client = client_of(board);
    client.1.connect()?;
    client.1.ask(Command::Update(UpdateVerb::Begin(images.new.len() as u32)))?;
    for (n, piece) in images.new.chunks(CHUNK).enumerate() {
        client.1.ask(Command::Update(UpdateVerb::Write((n * CHUNK) as u32, rows(piece))))?;
    }
    client.1.ask(Command::Update(UpdateVerb::Check))?;
    let until = client.1.now() + STARTS_WITHIN;
    loop {
        match report(&mut client.1)?.state {
            UpdateState::Complete => {
                let session = client.1.session();
                return Ok((released(client), session));
            }
            UpdateState::Checking if client.1.now() < until => {}
            _ => return Err(CampaignError::NotReached("a checked update")),
        }
    }
}

fn report(client: &mut Client) -> Result<UpdateReport, CampaignError> {
    match client.ask(Command::Update(UpdateVerb::Report))? {
        Reply::Update(report) => Ok(report),
        _ => Err(CampaignError::NotReached("a report")),
    }
}

/// Cuts the power at a cycle, and returns the version that answers afterwards, or the failure.
pub fn version_after(board: Board, at: u64, phase: Phase) -> Result<u16, String> {
    let edges = board.bench().edges.len();
    let (board, version) = answered(board, at).map_err(|error| format!("cut at cycle {at}: {error}"))?;
    if board.bench().edges.len() > edges {
        return Err(format!("cut at cycle {at}: the amplifier was enabled"));
    }
    if phase.allows(version) { Ok(version) } else { Err(format!("cut at cycle {at}: version {version} answers")) }
}

fn answered(mut board: Board, at: u64) -> Result<(Board, u16), CampaignError> {
    let resets = board.bench().resets.len();
    board.inject(at, Defect::BrownOut { ram: Ram::Lost });
    while board.bench().resets.len() == resets {
        board.run_block()?;
    }
    board.bench_mut().to_host.clear();
    board.bench_mut().to_board.clear();
    let mut client = client_of(board);
    let until = client.1.now() + STARTS_WITHIN;
    while let Err(error) = client.1.connect() {
        if client.1.now() >= until {
            return Err(error.into());
        }
    }
    let version = report(&mut client.1)?.running.ok_or(CampaignError::NotReached("a version"))?[0];
    Ok((released(client), version))
}
