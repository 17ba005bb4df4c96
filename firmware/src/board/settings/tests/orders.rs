//! Orders to set, to store and to clear, and the reports after them.

use super::*;
use crate::board::parameters::ParameterReport;
use crate::seam::config::Config;

fn blank() -> Settings<Ram> {
    Settings::new(Ram([0xFF; 8192])).unwrap()
}

fn built_in() -> Config {
    crate::board::parameters::tests::config()
}

fn report(store: &mut SettingsStore, settings: &mut Settings<Ram>, key: u8) -> ParameterReport {
    match store.obey(Verb::Get(key), false, settings, None) {
        Reply::Parameter(report) => report,
        other => panic!("{other:?}"),
    }
}

/// Returns the state that is reported with each parameter.
fn reported(store: &mut SettingsStore, settings: &mut Settings<Ram>) -> StoredState {
    report(store, settings, 5).stored
}

#[test]
fn a_set_parameter_is_reported_as_changed_until_stored() {
    let mut settings = blank();
    with_store(&mut settings, |store, settings| {
        let mut obey = |verb: Verb| {
            let reply = store.obey(verb, true, settings, Some(&built_in));
            (reply, reported(store, settings))
        };
        let default = obey(Verb::Get(5)).0;
        let Reply::Parameter(ParameterReport { built_in: value, .. }) = default else { panic!("{default:?}") };
        // Setting the present value is not a change.
        assert_eq!(obey(Verb::Set(5, value)), (Reply::Ack, StoredState::Nothing));
        assert_eq!(obey(Verb::Set(5, 2.0)), (Reply::Ack, StoredState::Changed));
        assert_eq!(obey(Verb::Set(5, 2.0)), (Reply::Ack, StoredState::Changed));
        assert_eq!(obey(Verb::Store), (Reply::Ack, StoredState::Stored));
        assert_eq!(obey(Verb::Set(5, 2.0)), (Reply::Ack, StoredState::Stored));
        assert_eq!(obey(Verb::Stores).0, Reply::Stores(1));
        // The defaults are a change only if another value is set.
        assert_eq!(obey(Verb::Defaults), (Reply::Ack, StoredState::Changed));
        assert_eq!(obey(Verb::Store), (Reply::Ack, StoredState::Nothing));
        assert_eq!(obey(Verb::Get(0)).0, Reply::Nak(Refusal::NoSuchKey));
    });
    let mut settings = blank();
    with_store(&mut settings, |store, settings| {
        assert_eq!(store.obey(Verb::Defaults, true, settings, None), Reply::Ack);
        assert_eq!(reported(store, settings), StoredState::Nothing);
    });
}

#[test]
fn a_report_has_the_active_and_the_set_value() {
    let mut settings = blank();
    settings.store(&Record { trims: LaneTrims::new(), parameters: Overrides::from_iter([(8, 5.0)]) }).unwrap();
    with_store(&mut settings, |store, settings| {
        assert_eq!(store.obey(Verb::Set(8, 4.0), true, settings, None), Reply::Ack);
        let ParameterReport { key, acts, next, built_in, min, max, stored } = report(store, settings, 8);
        assert_eq!((key, acts, next, built_in, min, max), (8, 5.0, 4.0, 15.466, 1e-3, 15.466));
        assert_eq!(stored, StoredState::Changed);
        // A limit is never set above its ceiling, and falls with it.
        assert_eq!(store.obey(Verb::Set(8, 15.5), true, settings, None), Reply::Nak(Refusal::OutOfRange));
        assert_eq!(store.obey(Verb::Set(3, 0.0008), true, settings, None), Reply::Ack);
        let scaled = report(store, settings, 8);
        assert!((scaled.max - 1.5466).abs() < 1e-5 && scaled.next == scaled.max && scaled.built_in == 15.466, "{scaled:?}");
        // A value that is not a limit stays.
        assert_eq!(report(store, settings, 3).next, 0.0008);
        assert_eq!(store.obey(Verb::Set(8, 2.0), false, settings, None), Reply::Nak(Refusal::Driving));
    });
}

#[test]
fn parameters_that_do_not_build_are_not_stored() {
    let mut settings = blank();
    with_store(&mut settings, |store, settings| {
        // The limit of 0.5 V is below the drive of 3 V.
        assert_eq!(store.obey(Verb::Set(8, 0.5), true, settings, None), Reply::Ack);
        let refused = store.obey(Verb::Store, true, settings, Some(&built_in));
        assert!(matches!(refused, Reply::Nak(Refusal::DoesNotBuild(key)) if key != 0), "{refused:?}");
        assert_eq!(reported(store, settings), StoredState::Changed);
        assert_eq!(store.obey(Verb::Set(8, 4.0), true, settings, None), Reply::Ack);
        assert_eq!(store.obey(Verb::Store, true, settings, Some(&built_in)), Reply::Ack);
    });
    assert_eq!(settings.record().0.parameters, [(8, 4.0)]);
}

#[test]
fn trims_that_do_not_build_are_not_stored() {
    let mut settings = blank();
    let out_of_order = longest().trims.into_iter().rev().collect();
    with_calibrated(out_of_order, &mut settings, |store, settings| {
        store.store_trims(false, settings);
        let refused = store.obey(Verb::Store, true, settings, Some(&built_in));
        assert!(matches!(refused, Reply::Nak(Refusal::DoesNotBuild(_))), "{refused:?}");
        assert_eq!(settings.stores(), 0);
    });
}

#[test]
fn trims_are_stored_once_in_silence() {
    let mut settings = blank();
    with_store(&mut settings, |store, settings| {
        // Trims are due until the drive is silent.
        assert_eq!(reported(store, settings), StoredState::Nothing);
        store.store_trims(false, settings);
        assert_eq!((reported(store, settings), settings.stores()), (StoredState::Due, 0));
        store.store_trims(true, settings);
        assert_eq!((reported(store, settings), settings.stores()), (StoredState::Stored, 1));
        // Unchanged trims are not stored again.
        store.store_trims(true, settings);
        assert_eq!(settings.stores(), 1);
        assert_eq!(store.obey(Verb::Clear, true, settings, None), Reply::Ack);
        assert_eq!((reported(store, settings), settings.record().0), (StoredState::Nothing, Record::default()));
    });
}
