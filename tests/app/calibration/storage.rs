//! Trims in flash: a calibration stores them, a restart activates them, and an order removes them.

use firmware::board::command::{Command, Reply, TrimReport, Verb};
use firmware::board::parameters::Overrides;
use firmware::board::settings::{Record, Settings};
use firmware::board::stored_state::StoredState;
use firmware::seam::config::{Direction, LaneTrims};
use firmware::seam::refusal::Refusal;
use hal_mock::bench::{Queues, Setup};
use hal_mock::flash::Flash;

use super::super::bank::{Bank, THESIS};
use super::{MAX_GAIN_ERROR, MAX_PHASE_ERROR_DEG, bench_of, calibrated, errors, four_lanes, report, run};

#[test]
fn trims_survive_a_restart_and_act_from_the_first_block() {
    let mut setup = four_lanes(Direction::Forward);
    let mut queues = Queues::default();
    let mut bench = bench_of(&mut queues, &setup, Bank::new(THESIS, 1.0));
    assert_eq!(report(&mut bench, 0), TrimReport { stored: StoredState::Nothing, points: 0, point: None });
    calibrated(&mut bench);
    let found: Vec<TrimReport> = (0..6).map(|point| report(&mut bench, point)).collect();
    assert!(found.iter().all(|report| (report.stored, report.points) == (StoredState::Stored, 5)) && found[5].point.is_none());

    setup.flash = bench.power_off();
    let mut queues = Queues::default();
    let mut bench = bench_of(&mut queues, &setup, Bank::new(THESIS, 1.0));
    assert!((0..6).all(|point| report(&mut bench, point) == found[usize::from(point)]));
    run(&mut bench);
    let after = errors(&mut bench, 0.25);
    assert!(after.0 < MAX_PHASE_ERROR_DEG && after.1 < MAX_GAIN_ERROR, "{after:?}");
}

#[test]
fn a_calibration_stores_trims_despite_refused_parameters() {
    // A drive of 3 V above a limit of 2 V is an invalid configuration: key 8 is `limits.voltage_v`.
    let mut settings = Settings::new(Flash::new(4, 1)).unwrap();
    settings.store(&Record { trims: LaneTrims::new(), parameters: Overrides::from_iter([(8, 2.0)]) }).unwrap();
    let mut setup = Setup { flash: settings.release(), ..four_lanes(Direction::Forward) };
    for calibrates in [true, false] {
        let mut queues = Queues::default();
        let mut bench = bench_of(&mut queues, &setup, Bank::new(THESIS, 1.0));
        bench.blocks(4);
        if calibrates {
            calibrated(&mut bench);
        }
        let report = report(&mut bench, 0);
        assert_eq!((report.stored, report.points), (StoredState::Refused, 5), "{calibrates}");
        setup.flash = bench.power_off();
    }
}

#[test]
fn defaults_and_clear_each_reset_their_part() {
    let mut setup = four_lanes(Direction::Forward);
    let mut queues = Queues::default();
    let mut bench = bench_of(&mut queues, &setup, Bank::new(THESIS, 0.0));
    calibrated(&mut bench);
    // The trims are inactive from now on, but stay stored.
    assert_eq!(bench.ask(Command::Settings(Verb::Defaults)), Some(Reply::Ack));
    run(&mut bench);
    assert!(errors(&mut bench, 0.25).0 > 8.0);
    setup.flash = bench.power_off();
    let mut queues = Queues::default();
    let mut bench = bench_of(&mut queues, &setup, Bank::new(THESIS, 0.0));
    assert_eq!(report(&mut bench, 0).stored, StoredState::Stored);
    bench.blocks(4);
    // The trims are no longer stored, but stay active.
    assert_eq!(bench.ask(Command::Settings(Verb::Clear)), Some(Reply::Ack));
    assert_eq!((report(&mut bench, 0).stored, report(&mut bench, 0).points), (StoredState::Nothing, 5));
    let mut cleared = setup.clone();
    cleared.flash = {
        run(&mut bench);
        assert!(errors(&mut bench, 0.25).0 < MAX_PHASE_ERROR_DEG);
        bench.power_off()
    };
    let mut queues = Queues::default();
    let mut bench = bench_of(&mut queues, &cleared, Bank::new(THESIS, 0.0));
    assert_eq!(report(&mut bench, 0), TrimReport { stored: StoredState::Nothing, points: 0, point: None });
}

#[test]
fn nothing_is_written_during_a_drive() {
    let setup = four_lanes(Direction::Forward);
    let mut queues = Queues::default();
    let mut bench = bench_of(&mut queues, &setup, Bank::new(THESIS, 0.0));
    run(&mut bench);
    for verb in [Verb::Store, Verb::Clear, Verb::Defaults] {
        assert_eq!(bench.ask(Command::Settings(verb)), Some(Reply::Nak(Refusal::Driving)), "{verb:?}");
    }
    // Writing is also refused between an order to drive and its first block.
    assert_eq!(bench.ask(Command::Idle), Some(Reply::Ack));
    bench.blocks(4);
    assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
    assert_eq!(bench.ask(Command::Settings(Verb::Store)), Some(Reply::Nak(Refusal::Driving)));
    assert_eq!(bench.power_off().operations(), 0);
}

#[test]
fn a_failed_flash_is_reported_and_the_trims_still_act() {
    let mut setup = four_lanes(Direction::Forward);
    setup.flash.cut_power_after(3);
    let mut queues = Queues::default();
    let mut bench = bench_of(&mut queues, &setup, Bank::new(THESIS, 1.0));
    calibrated(&mut bench);
    assert_eq!((report(&mut bench, 0).stored, bench.fault()), (StoredState::Failed, None));
    assert_eq!(bench.ask(Command::Settings(Verb::Store)), Some(Reply::Nak(Refusal::Flash)));
    run(&mut bench);
    assert!(errors(&mut bench, 0.25).0 < MAX_PHASE_ERROR_DEG);
    // The first store was interrupted. The next power-up finds no complete record, reports this,
    // and runs.
    let mut flash: Flash = bench.power_off();
    flash.restore_power();
    setup.flash = flash;
    let mut queues = Queues::default();
    let mut bench = bench_of(&mut queues, &setup, Bank::new(THESIS, 1.0));
    assert!(matches!(report(&mut bench, 0), TrimReport { stored: StoredState::Unfinished, points: 0, point: None }));
    calibrated(&mut bench);
    assert_eq!(report(&mut bench, 0).stored, StoredState::Stored);
}
