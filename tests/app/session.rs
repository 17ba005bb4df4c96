//! Sessions: a frame from an old buffer or from another host has no effect, and does not count as a
//! sign of the host.

use firmware::board::capture::{Arm, CaptureVerb, Trigger};
use firmware::board::command::{Command, Reply, Verb};
use firmware::board::link::{NO_SESSION, VERSION, encode};
use firmware::board::update::UpdateVerb;
use firmware::seam::block::{Amplitude, Gate};
use firmware::seam::config::Link;
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use firmware::seam::refusal::Refusal;
use firmware::seam::units::{Hertz, Turns};
use hal_mock::bench::{Bench, Queues, Setup};
use proptest::prelude::*;

use super::frame::frame;
use super::*;

/// Answer to a frame of another session.
const SESSION_REFUSED: Reply = Reply::Nak(Refusal::Session);

/// Returns one command of each kind.
fn commands() -> Vec<Command> {
    vec![
        Command::Idle,
        Command::Scan,
        Command::Run,
        Command::Gate(Gate::On),
        Command::Amplitude(Some(Amplitude::Volts(2.0))),
        Command::ClearFault,
        Command::TelemetryEvery(1),
        Command::Detune(Hertz(10.0)),
        Command::Quadrature(Some(Turns(0.25))),
        Command::Calibrate,
        Command::Settings(Verb::Trims(0)),
        Command::Settings(Verb::Set(15, 61.0)),
        Command::Settings(Verb::Store),
        Command::Settings(Verb::Clear),
        Command::Settings(Verb::Defaults),
        Command::Resonances,
        Command::Friction(None),
        Command::Occupant(None),
        Command::Status,
        Command::Capture(CaptureVerb::Arm(Arm { trigger: Trigger::Now, before: 0, lane: 0 })),
        Command::Capture(CaptureVerb::State),
        Command::Faults(0),
        Command::Reset,
        Command::Patience(0.0),
        Command::Update(UpdateVerb::Report),
    ]
}

/// Returns the board's answer to a command in a frame of this session.
fn answer(bench: &mut Bench<Load>, session: u32, command: Command) -> Reply {
    bench.host.receive(usize::MAX);
    bench.host.forget();
    bench.host.send_bytes(&encode(9, session, command).unwrap()).unwrap();
    bench.poll();
    bench.host.receive(usize::MAX);
    bench.host.answer_to(9).expect("an answer")
}

/// Begins a session with this nonce, and returns its number.
fn begin(bench: &mut Bench<Load>, nonce: u32) -> u32 {
    match answer(bench, NO_SESSION, Command::Identify(nonce)) {
        Reply::Identity(identity) => identity.session,
        other => panic!("{other:?}"),
    }
}

#[test]
fn before_any_session_every_command_is_refused() {
    let mut queues = Queues::default();
    let mut bench = new_bench(&mut queues, &Setup::default());
    for session in [NO_SESSION, 1, 0x1234_5678, u32::MAX] {
        for command in commands() {
            assert_eq!(answer(&mut bench, session, command), SESSION_REFUSED, "{command:?} in {session}");
            bench.blocks(2);
        }
    }
    // A frame without a session, or a meaningless one, is refused too.
    for body in [&[][..], &[99], &[4, 77]] {
        bench.host.send_bytes(&frame(VERSION, 9, NO_SESSION, body)).unwrap();
        bench.poll();
        bench.host.receive(usize::MAX);
        assert_eq!(bench.host.answer_to(9), Some(SESSION_REFUSED));
    }
    bench.blocks(STARTS_WITHIN);
    assert_eq!((bench.mode(), last_driven(&mut bench), bench.watchdog.resets()), (Mode::Idle, None, 0));
    assert!(bench.host.telemetry().next().is_none() && bench.power_off().bytes().iter().all(|&byte| byte == 0xff));
}

#[test]
fn a_frame_of_an_earlier_session_is_refused_and_drives_nothing() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    let earlier = begin(&mut bench, 1);
    assert_eq!(answer(&mut bench, earlier, Command::Gate(Gate::On)), Reply::Ack);
    let present = begin(&mut bench, 2);
    assert_ne!(earlier, present);
    for command in commands() {
        assert_eq!(answer(&mut bench, earlier, command), SESSION_REFUSED, "{command:?}");
        bench.blocks(2);
    }
    bench.blocks(STARTS_WITHIN);
    assert_eq!((bench.mode(), last_driven(&mut bench), bench.watchdog.resets()), (Mode::Idle, None, 0));
    assert_eq!(answer(&mut bench, present, Command::Run), Reply::Ack);
    assert!(bench.run_until(|report| report.mode == Mode::Run, STARTS_WITHIN).is_some());
    // The old session cannot stop the drive of the present host either.
    for command in [Command::Idle, Command::Gate(Gate::Off), Command::Reset] {
        assert_eq!(answer(&mut bench, earlier, command), SESSION_REFUSED);
    }
    bench.blocks(10);
    assert_eq!(bench.mode(), Mode::Run);
}

#[test]
fn each_nonce_has_its_own_session() {
    let mut queues = Queues::default();
    let mut bench = new_bench(&mut queues, &Setup::default());
    let first = begin(&mut bench, 77);
    bench.blocks(100);
    // As after a lost answer.
    assert_eq!((begin(&mut bench, 77), answer(&mut bench, first, Command::Gate(Gate::On))), (first, Reply::Ack));
    let second = begin(&mut bench, 78);
    assert!(first != second && second != NO_SESSION);
    assert_eq!(answer(&mut bench, first, Command::Status), SESSION_REFUSED);
    assert!(matches!(answer(&mut bench, second, Command::Status), Reply::Status(Some(_))));
}

#[test]
fn answers_carry_the_session_of_their_command() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    let first = bench.host.session();
    bench.ask(Command::TelemetryEvery(1));
    // The recorder answers one block later, after another session has begun.
    let asked = bench.host.send(Command::Capture(CaptureVerb::Arm(Arm { trigger: Trigger::Now, before: 0, lane: 0 }))).unwrap();
    bench.poll();
    let request = bench.host.send(Command::Identify(5)).unwrap();
    bench.poll();
    bench.blocks(3);
    bench.host.receive(usize::MAX);
    let second = bench.host.session();
    let session_of = |number: u16| {
        bench
            .host
            .frames()
            .iter()
            .rfind(|frame| frame.sequence == number && !is_telemetry(&frame.body))
            .map(|frame| frame.session)
    };
    assert_eq!((session_of(asked), session_of(request)), (Some(first), Some(5)));
    let telemetry: Vec<u32> =
        bench.host.frames().iter().filter(|frame| is_telemetry(&frame.body)).map(|frame| frame.session).collect();
    assert!(telemetry.len() >= 4 && telemetry.is_sorted_by_key(|&session| session == second), "{telemetry:?}");
    assert_eq!((telemetry.first(), telemetry.last()), (Some(&first), Some(&second)));
}

fn is_telemetry(reply: &Reply) -> bool {
    matches!(reply, Reply::Telemetry(_))
}

#[test]
fn a_replayed_conversation_does_not_drive() {
    // The conversation of an earlier host, or that of the present one, whose session has had no
    // other command since.
    for ended in [true, false] {
        let mut queues = Queues::default();
        let mut bench = new_bench(&mut queues, &Setup::default());
        let session = begin(&mut bench, 7);
        let said = [Command::Patience(0.0), Command::Gate(Gate::On), Command::Run];
        let frames = said.iter().zip(10..).map(|(&command, number)| encode(number, session, command).unwrap().to_vec());
        let conversation: Vec<u8> =
            encode(9, NO_SESSION, Command::Identify(7)).unwrap().into_iter().chain(frames.flatten()).collect();
        bench.host.send_bytes(&conversation).unwrap();
        assert!(bench.run_until(|report| report.mode == Mode::Run, STARTS_WITHIN).is_some());
        assert_eq!(answer(&mut bench, session, Command::Idle), Reply::Ack);
        bench.blocks(STARTS_WITHIN);
        let silent_from = last_driven(&mut bench);
        let present = if ended { begin(&mut bench, 8) } else { session };
        for again in 0..3 {
            bench.host.forget();
            bench.host.send_bytes(&conversation).unwrap();
            bench.blocks(STARTS_WITHIN);
            bench.host.receive(usize::MAX);
            let answers: Vec<Reply> = (10..13).filter_map(|number| bench.host.answer_to(number)).collect();
            assert_eq!(answers, [SESSION_REFUSED; 3], "{ended}, time {again}");
            assert_eq!((bench.mode(), last_driven(&mut bench)), (Mode::Idle, silent_from));
        }
        // The present host is informed by the refusal, and must connect again.
        assert_eq!(answer(&mut bench, present, Command::Run), SESSION_REFUSED);
        let next = begin(&mut bench, 9);
        assert_eq!(answer(&mut bench, next, Command::Run), Reply::Ack);
    }
}

#[test]
fn a_session_ends_with_a_reset() {
    let mut queues = [Queues::default(), Queues::default()];
    let [before, after] = &mut queues;
    let mut bench = bench(before, &Setup::default());
    bench.blocks(123);
    let session = begin(&mut bench, 7);
    assert_eq!(answer(&mut bench, session, Command::Gate(Gate::On)), Reply::Ack);
    let mut bench = new_bench(after, &Setup { flash: bench.power_off(), ..Setup::default() });
    assert_eq!(answer(&mut bench, session, Command::Run), SESSION_REFUSED);
    bench.blocks(40);
    assert_ne!(begin(&mut bench, 7), session);
    assert_eq!(answer(&mut bench, session, Command::Run), SESSION_REFUSED);
    bench.blocks(STARTS_WITHIN);
    assert_eq!(last_driven(&mut bench), None);
}

#[test]
fn foreign_frames_do_not_prevent_the_host_timeout() {
    // 400 blocks of 32 us.
    let setup = setup(|config| config.link = Link { patience_s: 12.8e-3 });
    let foreign: [(&str, Command, bool); 4] = [
        ("an order of another session", Command::Run, true),
        ("a question of another session", Command::Status, true),
        ("a timeout of another session", Command::Patience(0.0), true),
        ("requests for a session, and nothing else in it", Command::Identify(3), false),
    ];
    for (what, command, is_refused) in foreign {
        let mut queues = Queues::default();
        let mut bench = running(&mut queues, &setup);
        let session = bench.host.session();
        bench.ask(Command::Status);
        for n in 0..11_u32 {
            // A new nonce each time, so that no request repeats an earlier one.
            let command = if is_refused { command } else { Command::Identify(n) };
            assert_eq!(answer(&mut bench, session ^ 0x10, command) == SESSION_REFUSED, is_refused, "{what}");
            bench.blocks(40);
        }
        assert_eq!(bench.fault(), Some(Fault::HostLost), "{what}");
        assert!(!bench.enable.is_high());
        // Only an order of the session clears the fault.
        assert_eq!(answer(&mut bench, session ^ 0x10, Command::ClearFault), SESSION_REFUSED);
        bench.blocks(10);
        assert_eq!(bench.fault(), Some(Fault::HostLost));
        let present = begin(&mut bench, 99);
        assert_eq!(answer(&mut bench, present, Command::ClearFault), Reply::Ack);
        bench.blocks(10);
        assert_eq!((bench.mode(), bench.fault()), (Mode::Idle, None));
    }
}

#[test]
fn another_host_does_not_change_the_drive_or_its_timeout() {
    let setup = setup(|config| config.link = Link { patience_s: 12.8e-3 });
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &setup);
    let driver = bench.host.session();
    let observer = begin(&mut bench, 2);
    for _ in 0..10 {
        // The observer is the host now: its queries prevent the loss of the host.
        assert!(matches!(answer(&mut bench, observer, Command::Status), Reply::Status(_)));
        assert_eq!(answer(&mut bench, driver, Command::Status), SESSION_REFUSED);
        bench.blocks(300);
        assert_eq!((bench.mode(), bench.fault()), (Mode::Run, None));
    }
    bench.blocks(403);
    assert_eq!(bench.fault(), Some(Fault::HostLost));
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn only_the_latest_session_is_obeyed(
        steps in prop::collection::vec((0_usize..25, any::<u32>(), 0_u8..8, 0_u64..30), 1..60),
    ) {
        // Two boards: one receives all frames, the other only those of the present session and all
        // requests for a session.
        let mut queues = [Queues::default(), Queues::default()];
        let [all, own] = &mut queues;
        let (mut all, mut own) = (new_bench(all, &Setup::default()), new_bench(own, &Setup::default()));
        let (mut present, mut former) = (NO_SESSION, Vec::new());
        for (command, number, kind, blocks) in steps {
            let command = commands()[command];
            let foreign = match kind {
                0 => {
                    former.push(present);
                    let sessions = [begin(&mut all, number), begin(&mut own, number)];
                    prop_assert_eq!(sessions[0], sessions[1]);
                    prop_assert!(sessions[0] != NO_SESSION && sessions[0] != present);
                    present = sessions[0];
                    None
                }
                1 => Some(number),
                2 => Some(present ^ (1 << (number % 32))),
                3 => former.get(number as usize % former.len().max(1)).copied(),
                4 => Some(NO_SESSION),
                _ => None,
            };
            match foreign {
                Some(session) if session != present || session == NO_SESSION => {
                    prop_assert_eq!(answer(&mut all, session, command), SESSION_REFUSED);
                }
                _ if kind == 0 => {}
                _ => {
                    let send = |bench: &mut Bench<Load>| {
                        bench.host.send_bytes(&encode(9, present, command).unwrap()).unwrap();
                        bench.poll();
                    };
                    send(&mut all);
                    send(&mut own);
                }
            }
            all.blocks(blocks);
            own.blocks(blocks);
        }
        prop_assert_eq!((all.mode(), all.fault(), all.watchdog.resets()), (own.mode(), own.fault(), own.watchdog.resets()));
        prop_assert_eq!(all.analog().hash(), own.analog().hash());
        let (all, own) = (all.power_off(), own.power_off());
        prop_assert!(all.bytes() == own.bytes());
    }
}
