//! What the image refuses, by name; it goes on as it was.

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

/// The state in which an update ends that is sent and checked.
fn state_of(file: &[u8], client: &mut Client) -> UpdateState {
    send(file, client).expect("in silence");
    let until = client.now() + Duration::from_secs(5);
    while report(client).state == UpdateState::Checking {
        assert!(client.now() < until, "it is checked");
    }
    report(client).state
}

/// A small update with a manifest that was changed before it was signed.
fn changed(change: impl FnOnce(&mut Manifest)) -> Vec<u8> {
    let file = small();
    let mut manifest = Manifest::decode(file.first_chunk().expect("a manifest")).expect("whole");
    change(&mut manifest);
    [manifest.signed_by(&DEVELOPMENT_SEED).encode().as_slice(), &file[MANIFEST as usize..]].concat()
}

#[test]
fn what_is_no_update_for_this_board_is_refused_by_name_and_the_image_goes_on() {
    let Some(images) = images() else { return };
    let (board, mut client) = connected(powered(images));
    assert!(answers(&mut client, Duration::from_secs(2)), "it starts");
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
    ];
    for (file, defect) in cases {
        assert_eq!(state_of(&file, &mut client), UpdateState::Refused(defect));
        let refused = client.ask(Command::Update(UpdateVerb::Install)).expect_err("nothing is installed");
        assert!(matches!(refused, LinkError::Refused { refusal: Refusal::OutOfRange, .. }), "{refused}");
    }
    assert_eq!(state_of(&small(), &mut client), UpdateState::Complete);
    // None of it was installed: a reset starts the image that ran.
    client.order(Command::Reset).expect("acknowledged");
    assert!(answers(&mut client, Duration::from_secs(2)), "it starts again");
    let Reply::Faults(log) = client.ask(Command::Faults(0)).expect("an answer") else { panic!("no log") };
    assert_eq!(log.last_run, Start::Ordered, "the first stage leaves the RAM that names the last run's end");
    let after = report(&mut client);
    assert_eq!((after.running, after.standing), (Some([1, 0, 0]), Standing::Confirmed));
    assert!(board.borrow().bench().edges.is_empty(), "the amplifier stays off");
}

#[test]
fn an_update_is_refused_while_the_board_drives_and_the_drive_goes_on() {
    let Some(images) = images() else { return };
    let (board, mut client) = connected(powered(images));
    assert!(answers(&mut client, Duration::from_secs(2)), "it starts");
    client.order(Command::Patience(0.0)).expect("acknowledged");
    client.order(Command::Run).expect("acknowledged");
    let until = client.now() + Duration::from_millis(300);
    while client.status().expect("an answer").is_none_or(|report| report.mode != Mode::Run) {
        assert!(client.now() < until, "it locks");
        board.borrow_mut().run_for(Duration::from_millis(1)).expect("no finding");
    }
    for verb in [UpdateVerb::Begin(1000), UpdateVerb::Check, UpdateVerb::Install] {
        let refused = client.ask(Command::Update(verb)).expect_err("it drives");
        assert!(matches!(refused, LinkError::Refused { refusal: Refusal::Driving, .. }), "{refused}");
    }
    assert_eq!(client.status().expect("an answer").expect("a report").mode, Mode::Run);
    assert!(board.borrow().bench().is_enabled());
}
