//! Parameters over the link: a set value acts after a reset if it was stored, and no set or stored
//! value exceeds a limit.

use firmware::board::command::{Command, Reply, Verb};
use firmware::board::parameters::{Overrides, PARAMETERS, ParameterReport};
use firmware::board::settings::{Record, Settings};
use firmware::board::stored_state::StoredState;
use firmware::seam::block::Amplitude;
use firmware::seam::config::{LaneTrims, TrimPoint};
use firmware::seam::mode::Mode;
use firmware::seam::refusal::Refusal;
use hal_mock::bench::{Bench, Queues, Setup};
use hal_mock::flash::Flash;

use super::*;

/// Key of `drive.amplitude_v`.
const AMPLITUDE: u8 = 5;
/// Key of the voltage limit.
const VOLTAGE_LIMIT: u8 = 8;
/// Key of the current limit.
const CURRENT_LIMIT: u8 = 9;
/// Key of the limit of the ON time.
const ON_TIME: u8 = 12;
/// Key of the patience of the link.
const PATIENCE_S: u8 = 21;

fn get(bench: &mut Bench<Load>, key: u8) -> ParameterReport {
    match bench.ask(Command::Settings(Verb::Get(key))) {
        Some(Reply::Parameter(report)) => report,
        other => panic!("{key}: {other:?}"),
    }
}

/// Returns a bench after its first blocks, when the board knows that it is silent.
fn silent<'a>(queues: &'a mut Queues, setup: &Setup) -> Bench<'a, Load> {
    let mut bench = bench(queues, setup);
    bench.blocks(4);
    bench
}

/// Starts a run and returns its largest code.
fn loudest(bench: &mut Bench<Load>) -> u16 {
    assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
    assert!(bench.run_until(|report| report.mode == Mode::Run, STARTS_WITHIN).is_some(), "{:?}", bench.latest());
    bench.blocks(10);
    let began = bench.played() as usize * BLOCK;
    bench.blocks(50);
    peak(&played(bench, 0)[began..])
}

/// Returns a flash with a stored record.
fn keeping(trims: LaneTrims, parameters: &[(u8, f32)]) -> Flash {
    let mut settings = Settings::new(Flash::new(4, 1)).unwrap();
    settings.store(&Record { trims, parameters: Overrides::from_iter(parameters.iter().copied()) }).unwrap();
    settings.release()
}

fn trims() -> LaneTrims {
    LaneTrims::from_iter([TrimPoint { hz: 40e3, ..TrimPoint::default() }])
}

#[test]
fn a_stored_value_acts_after_a_reset() {
    for stores in [true, false] {
        let mut setup = Setup::default();
        let mut queues = Queues::default();
        let mut bench = silent(&mut queues, &setup);
        let built_in = get(&mut bench, AMPLITUDE);
        let expected = ParameterReport {
            key: AMPLITUDE,
            acts: 3.0,
            next: 3.0,
            built_in: 3.0,
            min: 1e-3,
            max: 1e4,
            stored: StoredState::Nothing,
        };
        assert_eq!(built_in, expected);
        assert_eq!(bench.ask(Command::Settings(Verb::Set(AMPLITUDE, 2.0))), Some(Reply::Ack));
        assert_eq!(get(&mut bench, AMPLITUDE), ParameterReport { next: 2.0, stored: StoredState::Changed, ..built_in });
        if stores {
            assert_eq!(bench.ask(Command::Settings(Verb::Store)), Some(Reply::Ack));
            assert_eq!(get(&mut bench, AMPLITUDE), ParameterReport { next: 2.0, stored: StoredState::Stored, ..built_in });
        }
        assert_eq!(loudest(&mut bench), 300);

        setup.flash = bench.power_off();
        let mut queues = Queues::default();
        let mut bench = silent(&mut queues, &setup);
        let after = ParameterReport { acts: 2.0, next: 2.0, stored: StoredState::Stored, ..built_in };
        assert_eq!(get(&mut bench, AMPLITUDE), if stores { after } else { built_in });
        assert_eq!(loudest(&mut bench), if stores { 200 } else { 300 });
    }
}

#[test]
fn defaults_and_clear_each_reset_their_part() {
    let mut setup = setup(|config| config.lanes = 2);
    setup.flash = keeping(trims(), &[(AMPLITUDE, 2.0)]);
    let mut queues = Queues::default();
    let mut bench = silent(&mut queues, &setup);
    assert_eq!(bench.ask(Command::Settings(Verb::Defaults)), Some(Reply::Ack));
    let report = get(&mut bench, AMPLITUDE);
    assert_eq!((report.acts, report.next, report.stored), (2.0, 3.0, StoredState::Changed));
    assert!(matches!(bench.ask(Command::Settings(Verb::Trims(0))), Some(Reply::Settings(report)) if report.points == 0));
    // Not stored: a reset restores the earlier state.
    setup.flash = bench.power_off();
    let mut queues = Queues::default();
    let mut bench = silent(&mut queues, &setup);
    let report = get(&mut bench, AMPLITUDE);
    assert_eq!((report.acts, report.next, report.stored), (2.0, 2.0, StoredState::Stored));
    assert!(matches!(bench.ask(Command::Settings(Verb::Trims(0))), Some(Reply::Settings(report)) if report.points == 1));
    // Stored: neither parameters nor trims remain.
    assert_eq!(bench.ask(Command::Settings(Verb::Defaults)), Some(Reply::Ack));
    bench.blocks(2);
    assert_eq!(bench.ask(Command::Settings(Verb::Store)), Some(Reply::Ack));
    setup.flash = bench.power_off();
    assert_eq!(Settings::new(setup.flash.clone()).unwrap().record(), (Record::default(), StoredState::Nothing));
    setup.flash = keeping(trims(), &[(AMPLITUDE, 2.0)]);
    let mut queues = Queues::default();
    let mut bench = silent(&mut queues, &setup);
    assert_eq!(bench.ask(Command::Settings(Verb::Clear)), Some(Reply::Ack));
    let report = get(&mut bench, AMPLITUDE);
    assert_eq!((report.acts, report.next, report.stored), (2.0, 2.0, StoredState::Nothing));
    assert_eq!(Settings::new(bench.power_off()).unwrap().record(), (Record::default(), StoredState::Nothing));
}

#[test]
fn a_refused_value_changes_nothing() {
    let mut queues = Queues::default();
    let mut bench = silent(&mut queues, &Setup::default());
    let wrong = [
        (AMPLITUDE, f32::NAN, Refusal::NotPlausible),
        (AMPLITUDE, -1.0, Refusal::OutOfRange),
        (AMPLITUDE, f32::INFINITY, Refusal::OutOfRange),
        (VOLTAGE_LIMIT, 12.01, Refusal::OutOfRange),
        (CURRENT_LIMIT, 3.5, Refusal::OutOfRange),
        (ON_TIME, 0.0, Refusal::OutOfRange),
        (PATIENCE_S, 3601.0, Refusal::OutOfRange),
        (0, 1.0, Refusal::NoSuchKey),
        (200, f32::NAN, Refusal::NoSuchKey),
    ];
    let before: Vec<ParameterReport> = PARAMETERS.iter().map(|parameter| get(&mut bench, parameter.key)).collect();
    for (key, value, refusal) in wrong {
        assert_eq!(bench.ask(Command::Settings(Verb::Set(key, value))), Some(Reply::Nak(refusal)), "{key} {value}");
    }
    let after: Vec<ParameterReport> = PARAMETERS.iter().map(|parameter| get(&mut bench, parameter.key)).collect();
    assert_eq!(before, after);
    assert_eq!(bench.ask(Command::Settings(Verb::Get(200))), Some(Reply::Nak(Refusal::NoSuchKey)));
    // A limit can be set and removed again.
    assert_eq!(bench.ask(Command::Settings(Verb::Set(ON_TIME, 7.0))), Some(Reply::Ack));
    assert_eq!(bench.ask(Command::Settings(Verb::Set(ON_TIME, f32::INFINITY))), Some(Reply::Ack));
    // A limit that is invalid in every configuration is refused.
    assert_eq!(bench.ask(Command::Settings(Verb::Set(ON_TIME, 4e4))), Some(Reply::Nak(Refusal::OutOfRange)));
    assert_eq!((get(&mut bench, ON_TIME).next, get(&mut bench, ON_TIME).max), (f32::INFINITY, 3e4));
}

#[test]
fn nothing_is_set_or_written_while_it_drives() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    for verb in [Verb::Set(AMPLITUDE, 2.0), Verb::Store, Verb::Clear, Verb::Defaults] {
        assert_eq!(bench.ask(Command::Settings(verb)), Some(Reply::Nak(Refusal::Driving)), "{verb:?}");
    }
    assert_eq!(get(&mut bench, AMPLITUDE).next, 3.0);
    assert_eq!(bench.power_off().operations(), 0);
}

#[test]
fn a_lower_limit_holds_and_a_stored_value_above_it_never_acts() {
    let setup = Setup { flash: keeping(LaneTrims::new(), &[(VOLTAGE_LIMIT, 4.0)]), ..Setup::default() };
    let mut queues = Queues::default();
    let mut bench = silent(&mut queues, &setup);
    assert_eq!(bench.ask(Command::Amplitude(Some(Amplitude::Volts(9.0)))), Some(Reply::Ack));
    assert_eq!(loudest(&mut bench), 400);
    // A value that is out of range, or a key that is unknown, is left out; the others act. A limit
    // that is too low is replaced by the lowest one, not by the built-in one.
    for (wrong, lowest) in
        [((VOLTAGE_LIMIT, 50.0), None), ((CURRENT_LIMIT, -1.0), Some((CURRENT_LIMIT, 1e-6))), ((199, 1.0), None)]
    {
        let setup = Setup { flash: keeping(LaneTrims::new(), &[(AMPLITUDE, 2.0), wrong]), ..Setup::default() };
        let mut queues = Queues::default();
        let mut bench = silent(&mut queues, &setup);
        let report = get(&mut bench, AMPLITUDE);
        assert_eq!((report.acts, report.stored), (2.0, StoredState::Partly), "{wrong:?}");
        let limit = get(&mut bench, VOLTAGE_LIMIT);
        assert_eq!((limit.acts, limit.next), (12.0, 12.0), "{wrong:?}");
        match lowest {
            Some((key, lowest)) => assert_eq!((get(&mut bench, key).acts, get(&mut bench, key).next), (lowest, lowest)),
            None => assert_eq!(loudest(&mut bench), 200, "{wrong:?}"),
        }
    }
    let setup =
        Setup { flash: keeping(LaneTrims::new(), &[(AMPLITUDE, 2.0), (VOLTAGE_LIMIT, f32::NEG_INFINITY)]), ..Setup::default() };
    let mut queues = Queues::default();
    let mut bench = silent(&mut queues, &setup);
    assert_eq!([VOLTAGE_LIMIT, AMPLITUDE].map(|key| get(&mut bench, key).acts), [1e-3, 1e-3]);
}

#[test]
fn invalid_settings_are_replaced_within_the_stored_limits() {
    // A drive of 3 V above a limit of 2 V.
    let mut setup = setup(|config| config.lanes = 2);
    setup.flash = keeping(trims(), &[(VOLTAGE_LIMIT, 2.0)]);
    let mut queues = Queues::default();
    let mut bench = silent(&mut queues, &setup);
    let report = get(&mut bench, VOLTAGE_LIMIT);
    // The stored value can still be read and corrected.
    assert_eq!((report.acts, report.next, report.stored), (2.0, 2.0, StoredState::Refused));
    assert_eq!((get(&mut bench, AMPLITUDE).acts, get(&mut bench, AMPLITUDE).next), (2.0, 3.0));
    assert!(matches!(bench.ask(Command::Settings(Verb::Trims(0))), Some(Reply::Settings(report)) if report.points == 1));
    assert_eq!(loudest(&mut bench), 200);
    bench.ask(Command::Idle);
    bench.blocks(4);
    assert_eq!(bench.ask(Command::Settings(Verb::Set(AMPLITUDE, 1.5))), Some(Reply::Ack));
    assert_eq!(bench.ask(Command::Settings(Verb::Store)), Some(Reply::Ack));
    setup.flash = bench.power_off();
    let mut queues = Queues::default();
    let mut bench = silent(&mut queues, &setup);
    assert_eq!((get(&mut bench, VOLTAGE_LIMIT).acts, get(&mut bench, VOLTAGE_LIMIT).stored), (2.0, StoredState::Stored));
    assert_eq!(loudest(&mut bench), 150);
}

#[test]
fn patience_is_a_parameter() {
    let setup = Setup { flash: keeping(LaneTrims::new(), &[(PATIENCE_S, 3.2e-3)]), ..Setup::default() };
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &setup);
    bench.blocks(104);
    assert_eq!(bench.fault(), Some(firmware::seam::fault::Fault::HostLost));
}
