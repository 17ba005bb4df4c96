//! Power cuts while the flash is written: by the first stage that installs an update, and by the
//! image that receives, marks or confirms one.
//!
//! The board must start with the old or the new image, with its amplifier off. The tests of
//! `sonoglide-update` cut every operation on simulated flash. These tests cut a sample of them,
//! with the real images on the model of the microcontroller.

use std::thread;
use std::time::Duration;

use board::Board;
use firmware::board::command::Command;
use firmware::board::link::encode;
use firmware::board::update::{Standing, UpdateState, UpdateVerb};
use nucleo_g474re::slots::{STATE, STORE};
use stm32g474::{Defect, FlashOperation, Ram};

use super::images::{Images, answers, connected, images, powered, report, send, small};

/// Time for which a board runs between two checks.
const STEP: Duration = Duration::from_millis(1);
/// Longest start: a swap of 117 pages, a check of a signature, and the swap back.
const STARTS_WITHIN: Duration = Duration::from_secs(40);

/// Returns the flash operations until `enough`, which is checked every `step`.
fn operations(mut board: Board, step: Duration, enough: impl Fn(&Board) -> bool) -> Vec<FlashOperation> {
    board.machine_mut().chip.record_flash();
    while !enough(&board) {
        board.run_for(step).expect("no finding");
    }
    board.machine().chip.flash_operations().to_vec()
}

/// Returns for each operation `true` if it is an erase.
fn erases(operations: &[FlashOperation]) -> Vec<bool> {
    operations.iter().map(|operation| operation.erases).collect()
}

/// Returns a board whose first stage finds a marked update.
fn marked(images: &Images) -> Board {
    let mut board = powered(images);
    let memory = &mut board.machine_mut().memory;
    memory.get_mut(STORE.start, images.new.len()).expect("flash").copy_from_slice(&images.new);
    memory.get_mut(STATE.start, 8).expect("flash").fill(0xf0);
    board
}

/// Cuts the power at a cycle. Returns the version that answers afterwards, and checks that the
/// amplifier stays off.
fn version_after(mut board: Board, at: u64, label: &str) -> u16 {
    let (resets, edges) = (board.bench().resets.len(), board.bench().edges.len());
    board.inject(at, Defect::BrownOut { ram: Ram::Lost });
    while board.bench().resets.len() == resets {
        board.run_block().expect("no finding");
    }
    board.bench_mut().to_host.clear();
    board.bench_mut().to_board.clear();
    let (board, mut client) = connected(board);
    assert!(answers(&mut client, STARTS_WITHIN), "{label}, cut at {at}: nothing starts");
    assert_eq!(board.borrow().bench().edges.len(), edges, "{label}, cut at {at}: the amplifier must stay off");
    report(&mut client).running.expect("a manifest")[0]
}

/// Cuts the power in `count` operations, spread evenly, in turn at their beginning, within, or
/// after them. Returns how often the old and the new image answered.
fn cut(board: &Board, operations: &[FlashOperation], count: usize, label: &str) -> [u32; 2] {
    let mut running = board.clone();
    // The run up to the cuts is simulated once, and the starts after the cuts in parallel.
    let answered: Vec<u16> = thread::scope(|scope| {
        let starts: Vec<_> = (0..count)
            .map(|n| {
                let operation = operations[n * (operations.len() - 1) / (count - 1)];
                let at = [operation.first + 40, (operation.first + operation.last) / 2, operation.last + 40][n % 3];
                let before = operation.first.saturating_sub(2000);
                if running.machine().cycle() < before {
                    running.machine_mut().run_until(before).expect("no finding");
                }
                let board = running.clone();
                let at = at.max(board.machine().cycle() + 10);
                scope.spawn(move || version_after(board, at, label))
            })
            .collect();
        starts.into_iter().map(|start| start.join().expect("a version")).collect()
    });
    let of = |version: u16| answered.iter().filter(|&&answer| answer == version).count() as u32;
    let versions = [of(1), of(2)];
    assert_eq!(versions[0] + versions[1], count as u32, "{label}: {answered:?}");
    println!("{label}: {} operations, {count} cut: old image {}, new image {}", operations.len(), versions[0], versions[1]);
    versions
}

#[test]
fn the_board_starts_after_a_cut_during_the_installation() {
    let Some(images) = images() else { return };
    let board = marked(images);
    let operations = operations(board.clone(), Duration::from_millis(10), |board| board.bench().samples() > 0);
    assert!(operations.len() > 50_000, "{}", operations.len());
    assert_eq!(operations.iter().filter(|operation| operation.erases).count(), 2 * 117);
    let [_, new] = cut(&board, &operations, 7, "installing");
    assert!(new > 0);
}

#[test]
fn a_cut_during_reception_or_mark_leaves_the_old_image() {
    let Some(images) = images() else { return };
    let (board, mut client) = connected(powered(images));
    assert!(answers(&mut client, Duration::from_secs(2)), "the board must start");
    let file = small();
    client.ask(Command::Update(UpdateVerb::Begin(file.len() as u32))).expect("accepted");
    // The first chunk causes the erase of its page and the writes of its words.
    let mut receiving = board.borrow().clone();
    let chunk = core::array::from_fn(|row| core::array::from_fn(|n| file[32 * row + n]));
    receiving.send(&encode(900, client.session(), Command::Update(UpdateVerb::Write(0, chunk))).expect("the frame fits"));
    let within = |board: &Board, time: u64| {
        let until = board.now() + Duration::from_millis(time);
        move |board: &Board| board.now() >= until
    };
    let found = operations(receiving.clone(), STEP, within(&receiving, 30));
    assert_eq!(found.len(), 1 + 16);
    assert_eq!(cut(&receiving, &found, 3, "receiving"), [3, 0]);
    // The mark invalidates the progress, erases two pages of the state, and writes a word.
    send(&file, &mut client).expect("accepted");
    while report(&mut client).state == UpdateState::Checking {}
    assert_eq!(report(&mut client).state, UpdateState::Complete);
    let mut marking = board.borrow().clone();
    marking.send(&encode(901, client.session(), Command::Update(UpdateVerb::Install)).expect("the frame fits"));
    let found = operations(marking.clone(), STEP, within(&marking, 60));
    assert_eq!(erases(&found), [false, true, true, false]);
    // The image of this update hangs. If it was marked, it is swapped in and back again.
    assert_eq!(cut(&marking, &found, 4, "marking"), [4, 0]);
}

#[test]
fn a_cut_during_the_confirmation_leaves_either_image() {
    let Some(images) = images() else { return };
    let mut board = marked(images);
    while board.bench().samples() == 0 {
        board.run_for(Duration::from_millis(1)).expect("no finding");
    }
    let (board, mut client) = connected(board);
    assert!(answers(&mut client, Duration::from_secs(1)), "the board must serve");
    assert_eq!(report(&mut client).standing, Standing::Trial);
    // It confirms itself after 0.1 s of blocks.
    let confirming = board.borrow().clone();
    let until = confirming.now() + Duration::from_millis(180);
    let found = operations(confirming.clone(), STEP, |board: &Board| board.now() >= until);
    // The last write is the marker of stored settings, which the erase of the state has removed.
    assert_eq!(erases(&found), [false, true, true, false, false]);
    let [old, new] = cut(&confirming, &found, 4, "confirming");
    assert!(old + new == 4 && new > 0);
}
