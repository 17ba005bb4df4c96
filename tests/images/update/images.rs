//! The images, and boards that have them in their flash.

use std::cell::RefCell;
use std::io::Write as _;
use std::rc::Rc;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use board::configure::load;
use board::{Board, Options};
use firmware::board::command::{Command, Reply};
use firmware::board::link::VERSION;
use firmware::board::update::{CHUNK, UpdateReport, UpdateState, UpdateVerb};
use link::client::Client;
use link::link_error::LinkError;
use link::port::Simulated;
use link::update_file::{identity_offset, pack};
use nucleo_g474re::slots::{BOARD, ORIGIN};
use stm32g474::{Rule, Verdict};
use update::identity::{Identity, NAME, board as named};
use update::key::DEVELOPMENT_SEED;
use update::manifest::Manifest;

pub static STOP: AtomicBool = AtomicBool::new(false);

/// First stage and image as they are built, and the files of two updates of this image.
pub struct Images {
    pub first_stage: Vec<u8>,
    pub elf: Vec<u8>,
    /// Version 1.0.0 and version 2.0.0, by what the image says of itself.
    pub old: Vec<u8>,
    pub new: Vec<u8>,
}

/// The image with another version: it stands in a constant of its own.
pub fn with_version(elf: &[u8], major: u16) -> Vec<u8> {
    let mut elf = elf.to_vec();
    let at = identity_offset(elf.as_slice()).expect("it says what it is") + NAME;
    elf[at..at + 6].copy_from_slice(&[major as u8, 0, 0, 0, 0, 0]);
    elf
}

/// The images; none where they cannot be built, which has then been said.
pub fn images() -> Option<&'static Images> {
    static IMAGES: OnceLock<Images> = OnceLock::new();
    if let Some(reason) = pil::missing_to_build() {
        let text = format!("\nSKIPPED, field update of the image on a model of its part: {reason}\n");
        std::io::stderr().write_all(text.as_bytes()).expect("standard error");
        return None;
    }
    Some(IMAGES.get_or_init(|| {
        let [first_stage, elf] = pil::field_images().expect("they build").map(|file| std::fs::read(file).expect("readable"));
        let [old, new] = [1, 2].map(|major| pack(&with_version(&elf, major), Some(&DEVELOPMENT_SEED)).expect("an update"));
        Images { first_stage, elf, old, new }
    }))
}

/// A board with the old image in its slot that was just powered.
pub fn powered(images: &Images) -> Board {
    let loaded = load("dummy-load", &[]).expect("a built-in scene");
    let scene = loaded.scene.driven().expect("a driven scene");
    let options = Options::default();
    let mut board = Board::start_in_slot(&images.first_stage, &images.old, &images.elf, &scene, options).expect("it starts");
    // What a cut leaves is read as damaged: both images are to bear that.
    board.machine_mut().chip.lint.set(Rule::EccDouble, Verdict::Collect);
    board
}

/// A client of a board.
pub fn connected(board: Board) -> (Rc<RefCell<Board>>, Client) {
    let board = Rc::new(RefCell::new(board));
    let client = Client::new(Box::new(Simulated::new("board", board.clone(), false)), &STOP, |_| ());
    (board, client)
}

/// Waits until the board answers, at most so long.
pub fn answers(client: &mut Client, within: Duration) -> bool {
    let until = client.now() + within;
    while client.now() < until {
        if client.connect().is_ok() {
            return true;
        }
    }
    false
}

/// The state of the update.
pub fn report(client: &mut Client) -> UpdateReport {
    match client.ask(Command::Update(UpdateVerb::Report)).expect("an answer") {
        Reply::Update(report) => report,
        reply => panic!("{reply:?}"),
    }
}

/// An update that is right in all, whose image does nothing: it stands until the watchdog resets the part.
pub fn small() -> Vec<u8> {
    // The stack's top, the first instruction's address, and the other vectors; `B .`, a branch to itself.
    let mut image = vec![0; 512];
    image[..4].copy_from_slice(&0x2001_8000_u32.to_le_bytes());
    image[4..8].copy_from_slice(&(ORIGIN + 512 + 1).to_le_bytes());
    image.extend(0xe7fe_u16.to_le_bytes());
    image.resize(600, 0xff);
    let identity = Identity { board: named(BOARD), version: [3, 0, 0], protocol: VERSION };
    let manifest = Manifest::of(identity, ORIGIN, &image).signed_by(&DEVELOPMENT_SEED);
    [manifest.encode().as_slice(), &image].concat()
}

/// Sends an update, and has it checked where it was not refused before.
pub fn send(file: &[u8], client: &mut Client) -> Result<(), LinkError> {
    let refused = |reply: &Reply| matches!(reply, Reply::Update(report) if matches!(report.state, UpdateState::Refused(_)));
    if refused(&client.ask(Command::Update(UpdateVerb::Begin(file.len() as u32)))?) {
        return Ok(());
    }
    for (n, piece) in file.chunks(CHUNK).enumerate() {
        let mut chunk = [[0xff; 32]; CHUNK / 32];
        chunk.as_flattened_mut()[..piece.len()].copy_from_slice(piece);
        if refused(&client.ask(Command::Update(UpdateVerb::Write((n * CHUNK) as u32, chunk)))?) {
            return Ok(());
        }
    }
    client.ask(Command::Update(UpdateVerb::Check)).map(drop)
}
