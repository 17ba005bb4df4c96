//! Settings stored in the flash, with power cuts while they are written.

use std::time::Duration;

use board::Board;
use firmware::board::command::{Command, Reply, Verb};
use firmware::board::parameters::ParameterReport;
use firmware::board::stored_state::StoredState;
use link::client::Client;
use stm32g474::map::at::flash;
use stm32g474::map::base::FLASH;
use stm32g474::{Defect, Ram, Rule, Verdict};

use super::{connected, elf, powered};

#[test]
fn stored_settings_survive_a_reset() {
    let Some(elf) = elf() else { return };
    let (board, mut client) = connected(powered(elf, &[]));
    client.connect().expect("an answer");
    /// Key of `tracking.nominal_q`.
    const KEY: u8 = 15;
    let get = |client: &mut Client| match client.ask(Command::Settings(Verb::Get(KEY))).expect("an answer") {
        Reply::Parameter(report) => report,
        reply => panic!("{reply:?}"),
    };
    let before = get(&mut client);
    let lower = 0.5 * before.acts;
    client.order(Command::Settings(Verb::Set(KEY, lower))).expect("acknowledged");
    client.order(Command::Settings(Verb::Store)).expect("acknowledged");
    client.order(Command::Reset).expect("acknowledged");
    board.borrow_mut().run_for(Duration::from_millis(40)).expect("the board restarts");
    let after = get(&mut client);
    assert_eq!((after.acts, after.stored), (lower, StoredState::Stored));
    assert_eq!(board.borrow().was_reset().map(|reset| reset.to_string()).as_deref(), Some("software"));
}

/// Keys of `limits.current_a` and `tracking.nominal_q`.
const KEYS: [u8; 2] = [9, 15];
/// Values that are stored first.
const OLD: [f32; 2] = [2.5, 40.0];
/// Values that are being stored when the power is cut.
const NEW: [f32; 2] = [2.0, 30.0];
/// Values that are stored after the power cut.
const LAST: [f32; 2] = [1.5, 20.0];
/// Longest start, in which the flash is read and the converters are calibrated.
const STARTS_WITHIN: Duration = Duration::from_millis(20);
/// Time between two checks of the flash, cycles.
const STEP_CYCLES: u64 = 170;

fn set(client: &mut Client, values: [f32; 2]) {
    for (key, value) in KEYS.into_iter().zip(values) {
        client.order(Command::Settings(Verb::Set(key, value))).expect("acknowledged");
    }
}

fn parameters(client: &mut Client) -> [ParameterReport; 2] {
    KEYS.map(|key| match client.ask(Command::Settings(Verb::Get(key))).expect("an answer") {
        Reply::Parameter(report) => report,
        reply => panic!("{reply:?}"),
    })
}

/// Returns a board with this number of stores, the last one of `OLD`, and with `NEW` set but not
/// stored; and the session of its host.
fn prepared(elf: &[u8], stores: u32) -> (Board, u32) {
    let mut board = powered(elf, &[]);
    // Words cut by a power failure read as damaged, which the image must tolerate.
    board.machine_mut().chip.lint.set(Rule::EccDouble, Verdict::Collect);
    let (board, mut client) = connected(board);
    client.connect().expect("an answer");
    for left in (0..stores).rev() {
        set(&mut client, if left % 2 == 0 { OLD } else { LAST });
        client.order(Command::Settings(Verb::Store)).expect("stored");
    }
    set(&mut client, NEW);
    (board.borrow().clone(), client.session())
}

/// Begins to store, without waiting for the answer.
fn begin((mut board, session): (Board, u32)) -> Board {
    let frame = firmware::board::link::encode(77, session, Command::Settings(Verb::Store)).expect("the frame fits");
    board.send(&frame);
    board
}

/// Returns the cycles at which each flash operation begins and ends while the settings are stored.
fn operations(mut board: Board) -> Vec<(u64, u64)> {
    let busy = |board: &Board| board.machine().chip.peek(FLASH + flash::SR) >> 16 & 1 == 1;
    let (mut found, mut began) = (Vec::new(), None);
    let until = board.now() + Duration::from_millis(60);
    while board.now() < until {
        let at = board.machine().cycle();
        board.machine_mut().run_until(at + STEP_CYCLES).expect("no finding");
        match (began, busy(&board)) {
            (None, true) => began = Some(at),
            (Some(first), false) => {
                found.push((first, at));
                began = None;
            }
            _ => {}
        }
    }
    found
}

#[test]
fn a_power_cut_leaves_the_old_settings_or_the_new_ones() {
    let Some(elf) = elf() else { return };
    let (mut cuts, mut kept) = (0, 0);
    // The first case writes to an unused half of the flash, the second to a used one.
    for stores in [1, 4] {
        let board = begin(prepared(elf, stores));
        let operations = operations(board.clone());
        assert!(operations.len() >= 3, "{operations:?}");
        for (place, &(first, last)) in operations.iter().enumerate() {
            // Cut at the beginning of the operation, within it, just after it, and before the next
            // one.
            let next = operations.get(place + 1).map_or(last + 1000 * STEP_CYCLES, |(next, _)| *next);
            for at in [first + STEP_CYCLES, (first + last) / 2, last + 2 * STEP_CYCLES, (last + next) / 2] {
                cuts += 1;
                kept += u32::from(is_whole_after(board.clone(), at));
            }
        }
    }
    println!("{cuts} cuts, the old settings after {kept}");
    assert!(kept > 0 && kept < cuts, "both results must occur: {kept} of {cuts}");
}

/// Cuts the power at a cycle, and checks the settings afterwards. Returns `true` if they are the
/// old ones.
fn is_whole_after(mut board: Board, at: u64) -> bool {
    board.inject(at, Defect::BrownOut { ram: Ram::Lost });
    while board.was_reset().is_none() {
        board.run_block().expect("no finding");
    }
    board.bench_mut().to_host.clear();
    board.run_for(STARTS_WITHIN).expect("the board starts");
    let (board, mut client) = connected(board);
    client.connect().expect("an answer");
    let found = parameters(&mut client);
    let acts = found.map(|report| report.acts);
    assert!(acts == OLD || acts == NEW, "cut at {at}: {found:?}");
    // If the cut has left a differing copy, the state reports it.
    let is_whole = |report: &ParameterReport| matches!(report.stored, StoredState::Stored | StoredState::OneCopy);
    assert!(found.iter().all(is_whole), "cut at {at}: {found:?}");
    // The next record can be stored after any cut.
    set(&mut client, LAST);
    client.order(Command::Settings(Verb::Store)).expect("stored");
    client.order(Command::Reset).expect("acknowledged");
    board.borrow_mut().run_for(STARTS_WITHIN).expect("the board restarts");
    let after = parameters(&mut client);
    assert_eq!(after.map(|report| (report.acts, report.stored)), LAST.map(|value| (value, StoredState::Stored)), "cut at {at}");
    acts == OLD
}
