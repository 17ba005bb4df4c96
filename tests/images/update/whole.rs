//! Complete update, from the first byte to the confirmed image.

use std::time::{Duration, Instant};

use firmware::board::command::{Command, Reply, Verb};
use firmware::board::parameters::ParameterReport;
use firmware::board::update::Standing;
use link::client::Client;
use link::commands::identify;
use link::commands::update::{UpdateArgs, run};
use link::session::{Session, SessionOptions};

use super::images::{answers, connected, images, powered, report, small};

/// Key of `limits.current_a`, and a value that differs from the built-in one, A.
const CURRENT_LIMIT: (u8, f32) = (9, 2.25);

/// Reads the current limit from the board.
fn current_limit(client: &mut Client) -> ParameterReport {
    match client.ask(Command::Settings(Verb::Get(CURRENT_LIMIT.0))).expect("an answer") {
        Reply::Parameter(report) => report,
        reply => panic!("{reply:?}"),
    }
}

#[test]
fn an_update_over_the_link_is_installed_and_confirmed() {
    let Some(images) = images() else { return };
    let began = Instant::now();
    let (board, mut client) = connected(powered(images));
    assert!(answers(&mut client, Duration::from_secs(2)), "the first stage must start the image");
    let before = report(&mut client);
    println!("{before:?}: {:?} of the board, {:?} here", board.borrow().now(), began.elapsed());
    assert_eq!((before.running, before.standing), (Some([1, 0, 0]), Standing::Confirmed));
    let (key, value) = CURRENT_LIMIT;
    for verb in [Verb::Set(key, value), Verb::Store] {
        client.ask(Command::Settings(verb)).expect("accepted");
    }
    assert_ne!(current_limit(&mut client).acts, value, "the value acts only after a reset");
    let mut session = Session::begin(client, SessionOptions::default()).expect("a session");
    let file = std::env::temp_dir().join(format!("sonoglide-update-{}", std::process::id()));
    std::fs::write(&file, &images.new).expect("a file");
    let answer =
        run(&UpdateArgs { file: Some(file.clone()), ..UpdateArgs::default() }, &mut session).expect("the update succeeds");
    std::fs::remove_file(&file).expect("the file exists");
    println!("{}: {:?} of the board, {:?} here", answer.text, board.borrow().now(), began.elapsed());
    assert_eq!(answer.fields["version"], "2.0.0");
    assert_eq!(answer.fields["standing"], "confirmed");
    assert_eq!(current_limit(&mut session.client).acts, value, "stored settings survive an update");
    assert!(identify::run(&mut session).expect("an answer").text.contains("development key"));
    // The client refuses an older version without sending it, and the board while its button is
    // released.
    let file = std::env::temp_dir().join(format!("sonoglide-older-{}", std::process::id()));
    std::fs::write(&file, &images.old).expect("a file");
    for allow_downgrade in [false, true] {
        let args = UpdateArgs { file: Some(file.clone()), allow_downgrade, ..UpdateArgs::default() };
        let refused = run(&args, &mut session).expect_err("older").to_string();
        assert!(refused.contains("the board runs 2.0.0 and the update is the older 1.0.0"), "{refused}");
        assert_eq!(refused.starts_with("the board refuses the update"), allow_downgrade, "{refused}");
    }
    std::fs::remove_file(&file).expect("the file exists");
    let board = board.borrow();
    assert!(board.bench().edges.is_empty(), "the amplifier must stay off: {:?}", board.bench().edges);
    assert_eq!(board.bench().resets.len(), 1, "{:?}", board.bench().resets);
}

#[test]
fn an_image_that_hangs_is_rolled_back_after_a_watchdog_reset() {
    let Some(images) = images() else { return };
    let (board, mut client) = connected(powered(images));
    assert!(answers(&mut client, Duration::from_secs(2)), "the board must start");
    let mut session = Session::begin(client, SessionOptions::default()).expect("a session");
    let file = std::env::temp_dir().join(format!("sonoglide-hanging-{}", std::process::id()));
    std::fs::write(&file, small()).expect("a file");
    let failed = run(&UpdateArgs { file: Some(file.clone()), ..UpdateArgs::default() }, &mut session)
        .expect_err("the image hangs")
        .to_string();
    std::fs::remove_file(&file).expect("the file exists");
    assert_eq!(failed, "the new image did not start or did not work: the board runs 1.0.0 again");
    let after = report(&mut session.client);
    assert_eq!((after.running, after.standing), (Some([1, 0, 0]), Standing::RolledBack));
    let board = board.borrow();
    let resets: Vec<String> = board.bench().resets.iter().map(ToString::to_string).collect();
    assert_eq!(resets, ["software", "the independent watchdog"]);
    assert!(board.bench().edges.is_empty(), "the amplifier must stay off: {:?}", board.bench().edges);
}
