//! The belt: the image reads the encoder with a stored scale, and does not drive at a D-ring
//! without it.

use std::time::Duration;

use board::{Board, configure};
use firmware::board::command::{Command, Verb};
use firmware::board::parameters::Overrides;
use firmware::seam::config::keys::{METRE_PER_COUNT, RESTRAINT_ENABLED};
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use firmware::seam::refusal::Refusal;
use link::client::Client;
use link::link_error::LinkError;
use nucleo_g474re::config::SILENCE;
use nucleo_g474re::pages;

use super::{connected, elf, powered, reaches};

/// Scale of the encoder, 10 um per count.
const SCALE: (u8, f32) = (METRE_PER_COUNT, 1e-5);

/// Returns a board with these settings in its flash.
fn storing(elf: &[u8], parameters: &[(u8, f32)]) -> Board {
    let mut board = powered(elf, &[]);
    let bytes = (pages::START + pages::SIZE - pages::FLASH) as usize;
    let flash = board.machine_mut().memory.get_mut(pages::FLASH, bytes).expect("the flash");
    configure::store(Overrides::from_iter(parameters.iter().copied()), flash).expect("the settings fit");
    board
}

/// Returns the reason why an order is refused.
fn refusal(client: &mut Client, order: Command) -> Option<Refusal> {
    match client.order(order) {
        Err(LinkError::Refused { refusal, .. }) => Some(refusal),
        _ => None,
    }
}

#[test]
fn the_image_refuses_a_d_ring_without_the_belt_scale() {
    let Some(elf) = elf() else { return };
    let (board, mut client) = connected(storing(elf, &[(RESTRAINT_ENABLED, 1.0)]));
    client.connect().expect("an answer");
    for order in [Command::Run, Command::Scan, Command::Calibrate] {
        assert_eq!(refusal(&mut client, order), Some(Refusal::NoBeltScale), "{order:?}");
    }
    board.borrow_mut().run_for(Duration::from_millis(5)).expect("no finding");
    let board = board.borrow();
    assert!(board.bench().edges.is_empty() && board.bench().code() == SILENCE, "PA10 stays low, the DAC at mid-scale");
}

#[test]
fn a_stored_scale_arms_the_interlock_after_a_reset() {
    let Some(elf) = elf() else { return };
    let (board, mut client) = connected(powered(elf, &[]));
    client.connect().expect("an answer");
    // A setting that requires the scale is refused before the scale is set, and accepted
    // afterwards.
    let restraint = Command::Settings(Verb::Set(RESTRAINT_ENABLED, 1.0));
    assert_eq!(refusal(&mut client, restraint), Some(Refusal::NotConfigured));
    for order in [Verb::Set(SCALE.0, SCALE.1), Verb::Set(RESTRAINT_ENABLED, 1.0), Verb::Store] {
        client.order(Command::Settings(order)).expect("acknowledged");
    }
    let gone = Command::Settings(Verb::Set(METRE_PER_COUNT, f32::INFINITY));
    assert_eq!(refusal(&mut client, gone), Some(Refusal::NotConfigured));
    client.order(Command::Reset).expect("acknowledged");
    board.borrow_mut().run_for(Duration::from_millis(50)).expect("no finding");
    client.connect().expect("an answer");
    // The dummy load has no encoder, so the wires of a channel never have opposite levels.
    client.order(Command::Patience(0.0)).expect("acknowledged");
    client.order(Command::Run).expect("acknowledged");
    assert!(reaches(&mut client, &board, Mode::Fault, Duration::from_millis(100)), "the board must not drive");
    let report = client.status().expect("an answer").expect("a report");
    assert_eq!(report.fault, Some(Fault::BeltSensorLost));
}
