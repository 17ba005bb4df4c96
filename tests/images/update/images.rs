//! Images, and boards that have them in their flash.

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

/// First stage and image as built, and the files of two updates of this image.
pub struct Images {
    pub first_stage: Vec<u8>,
    pub elf: Vec<u8>,
    /// Update to version 1.0.0, according to the identity in the image.
    pub old: Vec<u8>,
    /// Update to version 2.0.0.
    pub new: Vec<u8>,
}

/// Changes the version of the image, which is a constant in it.
pub fn with_version(elf: &[u8], major: u16) -> Vec<u8> {
    let mut elf = elf.to_vec();
    let at = identity_offset(elf.as_slice()).expect("the image has an identity") + NAME;
    elf[at..at + 6].copy_from_slice(&[major as u8, 0, 0, 0, 0, 0]);
    elf
}

/// Returns the images, or `None` after a message if they cannot be built.
pub fn images() -> Option<&'static Images> {
    static IMAGES: OnceLock<Images> = OnceLock::new();
    if let Some(reason) = pil::missing_to_build() {
        let text = format!("\nSKIPPED, field update of the image on a model of its microcontroller: {reason}\n");
        std::io::stderr().write_all(text.as_bytes()).expect("standard error");
        return None;
    }
    Some(IMAGES.get_or_init(|| {
        let [first_stage, elf] =
            pil::field_images().expect("the images build").map(|file| std::fs::read(file).expect("readable"));
        let [old, new] = [1, 2].map(|major| pack(&with_version(&elf, major), Some(&DEVELOPMENT_SEED)).expect("an update"));
        Images { first_stage, elf, old, new }
    }))
}

/// Returns a board with the old image in its slot, just after power-on.
pub fn powered(images: &Images) -> Board {
    let loaded = load("dummy-load", &[]).expect("a built-in scene");
    let scene = loaded.scene.driven().expect("a driven scene");
    let options = Options::default();
    let mut board =
        Board::start_in_slot(&images.first_stage, &images.old, &images.elf, &scene, options).expect("the board starts");
    // Words cut by a power failure read as damaged, which both images must tolerate.
    board.machine_mut().chip.lint.set(Rule::EccDouble, Verdict::Collect);
    board
}

/// Connects a client to a board.
pub fn connected(board: Board) -> (Rc<RefCell<Board>>, Client) {
    let board = Rc::new(RefCell::new(board));
    let client = Client::new(Box::new(Simulated::new("board", board.clone(), false)), &STOP, |_| ());
    (board, client)
}

/// Waits until the board answers. Returns `false` if this takes longer than `within`.
pub fn answers(client: &mut Client, within: Duration) -> bool {
    let until = client.now() + within;
    while client.now() < until {
        if client.connect().is_ok() {
            return true;
        }
    }
    false
}

/// Returns the state of the update.
pub fn report(client: &mut Client) -> UpdateReport {
    match client.ask(Command::Update(UpdateVerb::Report)).expect("an answer") {
        Reply::Update(report) => report,
        reply => panic!("{reply:?}"),
    }
}

/// Returns a valid update whose image hangs until the watchdog resets the processor.
pub fn small() -> Vec<u8> {
    // The top of the stack, the address of the first instruction, and the other vectors; then
    // `B .`, a branch to itself.
    let mut image = vec![0; 512];
    image[..4].copy_from_slice(&0x2001_8000_u32.to_le_bytes());
    image[4..8].copy_from_slice(&(ORIGIN + 512 + 1).to_le_bytes());
    image.extend(0xe7fe_u16.to_le_bytes());
    image.resize(600, 0xff);
    let identity = Identity { board: named(BOARD), version: [3, 0, 0], protocol: VERSION };
    let manifest = Manifest::of(identity, ORIGIN, &image).signed_by(&DEVELOPMENT_SEED);
    [manifest.encode().as_slice(), &image].concat()
}

/// Sends an update, and orders its check unless it was refused before.
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
