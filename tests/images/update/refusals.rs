//! Updates that the image refuses, with their defect; the image continues unchanged.

use std::time::Duration;

use firmware::board::command::{Command, Reply};
use firmware::board::start::Start;
use firmware::board::update::{Standing, UpdateDefect, UpdateState, UpdateVerb};
use firmware::seam::mode::Mode;
use firmware::seam::refusal::Refusal;
use link::client::Client;
use link::link_error::LinkError;
use nucleo_g474re::slots::{MANIFEST, ORIGIN};
use update::identity::board as named;
use update::key::DEVELOPMENT_SEED;
use update::manifest::Manifest;

use super::images::{answers, connected, images, powered, report, send, small};

/// Sends an update, has it checked, and returns its final state.
fn state_of(file: &[u8], client: &mut Client) -> UpdateState {
    send(file, client).expect("accepted in silence");
    let until = client.now() + Duration::from_secs(5);
    while report(client).state == UpdateState::Checking {
        assert!(client.now() < until, "the check must end");
    }
    report(client).state
}

/// Returns a small update whose manifest was changed before it was signed.
fn changed(change: impl FnOnce(&mut Manifest)) -> Vec<u8> {
    let file = small();
    let mut manifest = Manifest::decode(file.first_chunk().expect("a manifest")).expect("whole");
    change(&mut manifest);
    [manifest.signed_by(&DEVELOPMENT_SEED).encode().as_slice(), &file[MANIFEST as usize..]].concat()
}

#[test]
fn invalid_updates_are_refused_with_their_defect() {
    let Some(images) = images() else { return };
    let (board, mut client) = connected(powered(images));
    assert!(answers(&mut client, Duration::from_secs(2)), "the board must start");
    let mut damaged = small();
    *damaged.last_mut().expect("an image") ^= 1;
    let unsigned = {
        let manifest = Manifest::decode(small().first_chunk().expect("a manifest")).expect("whole");
        let manifest = Manifest { signature: [0xff; 64], ..manifest };
        [manifest.encode().as_slice(), &small()[MANIFEST as usize..]].concat()
    };
    let stranger = {
        let manifest = Manifest::decode(small().first_chunk().expect("a manifest")).expect("whole");
        [manifest.signed_by(&[7; 32]).encode().as_slice(), &small()[MANIFEST as usize..]].concat()
    };
    let cases = [
        (vec![0x55; 1000], UpdateDefect::NotAnUpdate),
        (changed(|manifest| manifest.identity.board = named("another-board")), UpdateDefect::OtherBoard),
        (changed(|manifest| manifest.identity.protocol = 1), UpdateDefect::OlderProtocol(1)),
        (changed(|manifest| manifest.origin = ORIGIN + 512), UpdateDefect::OtherOrigin(ORIGIN + 512)),
        (vec![0; 300 << 10], UpdateDefect::Length(300 << 10)),
        (damaged, UpdateDefect::Damaged),
        (unsigned, UpdateDefect::Unsigned),
        (stranger, UpdateDefect::WrongSignature),
        (
            changed(|manifest| manifest.identity.version = [0, 9, 9]),
            UpdateDefect::OlderVersion { running: [1, 0, 0], offered: [0, 9, 9] },
        ),
    ];
    for (file, defect) in cases {
        assert_eq!(state_of(&file, &mut client), UpdateState::Refused(defect));
        let refused = client.ask(Command::Update(UpdateVerb::Install)).expect_err("the installation is refused");
        assert!(matches!(refused, LinkError::Refused { refusal: Refusal::OutOfRange, .. }), "{refused}");
    }
    assert_eq!(state_of(&small(), &mut client), UpdateState::Complete);
    // None of them was installed: a reset starts the same image.
    client.order(Command::Reset).expect("acknowledged");
    assert!(answers(&mut client, Duration::from_secs(2)), "the board must restart");
    let Reply::Faults(log) = client.ask(Command::Faults(0)).expect("an answer") else { panic!("no log") };
    assert_eq!(log.last_run, Start::Ordered, "the first stage must not overwrite the note of the last run");
    let after = report(&mut client);
    assert_eq!((after.running, after.standing), (Some([1, 0, 0]), Standing::Confirmed));
    assert!(board.borrow().bench().edges.is_empty(), "the amplifier must stay off");
}

#[test]
fn an_update_is_refused_during_a_drive() {
    let Some(images) = images() else { return };
    let (board, mut client) = connected(powered(images));
    assert!(answers(&mut client, Duration::from_secs(2)), "the board must start");
    client.order(Command::Patience(0.0)).expect("acknowledged");
    client.order(Command::Run).expect("acknowledged");
    let until = client.now() + Duration::from_millis(300);
    while client.status().expect("an answer").is_none_or(|report| report.mode != Mode::Run) {
        assert!(client.now() < until, "the board must lock");
        board.borrow_mut().run_for(Duration::from_millis(1)).expect("no finding");
    }
    for verb in [UpdateVerb::Begin(1000), UpdateVerb::Check, UpdateVerb::Install] {
        let refused = client.ask(Command::Update(verb)).expect_err("refused during a drive");
        assert!(matches!(refused, LinkError::Refused { refusal: Refusal::Driving, .. }), "{refused}");
    }
    assert_eq!(client.status().expect("an answer").expect("a report").mode, Mode::Run);
    assert!(board.borrow().bench().is_enabled());
}
