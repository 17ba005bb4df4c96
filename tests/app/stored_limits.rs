//! Stored limits: after a restart they are never exceeded by any other stored value.

use firmware::board::command::{Command, Reply, Verb};
use firmware::board::parameters::{Overrides, PARAMETERS, ParameterReport};
use firmware::board::settings::{Record, Settings};
use firmware::board::stored_state::StoredState;
use firmware::seam::block::Amplitude;
use firmware::seam::config::keys::ENERGY_PER_METRE;
use firmware::seam::config::{LaneTrims, TrackingMode, Trim, TrimPoint};
use firmware::seam::refusal::Refusal;
use hal_mock::bench::{Bench, Queues, Setup};
use hal_mock::flash::{Damage, Flash, PAGE_BYTES, WORD_BYTES};
use proptest::prelude::*;

use super::*;

const AMPLITUDE: u8 = 5;
const CURRENT: u8 = 6;
const SCAN: u8 = 7;
const VOLTAGE_LIMIT: u8 = 8;
const DRIVE_SCALE: u8 = 3;

fn storing(record: &Record) -> Flash {
    let mut settings = Settings::new(Flash::new(4, 1)).unwrap();
    settings.store(record).unwrap();
    settings.release()
}

fn get(bench: &mut Bench<Load>, key: u8) -> ParameterReport {
    match bench.ask(Command::Settings(Verb::Get(key))) {
        Some(Reply::Parameter(report)) => report,
        other => panic!("{key}: {other:?}"),
    }
}

fn trims(gains: &[f32]) -> LaneTrims {
    let point = |(n, &gain): (usize, &f32)| TrimPoint {
        hz: 39e3 + 1e3 * n as f32,
        lanes: core::array::from_fn(|_| Trim { gain, ..Trim::default() }),
    };
    gains.iter().enumerate().map(point).collect()
}

/// Returns values of a parameter: permitted ones, the ends of its range, and impossible ones.
fn value(key: u8) -> BoxedStrategy<f32> {
    let parameter = PARAMETERS.iter().find(|parameter| parameter.key == key);
    let built_in = parameter.map_or(1.0, |parameter| (parameter.read)(&Setup::default().config));
    let (least, most) = parameter.map_or((0.0, 1.0), |parameter| parameter.range.of(built_in));
    let (low, high) = (least.max(1e-12), most.min(1e9));
    let within = (0.0_f32..=1.0).prop_map(move |part| (low.ln() + part * (high / low).ln()).exp().clamp(low, high));
    let near = (0.1_f32..=1.5).prop_map(move |part| if built_in.is_finite() { part * built_in } else { 100.0 * part });
    let edges = prop::sample::select(vec![least, most, built_in, 0.5 * least, 2.0 * most]);
    let wild = prop::sample::select(vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, f32::MIN_POSITIVE, 1e30]);
    prop_oneof![4 => within, 4 => near, 2 => edges, 1 => wild].boxed()
}

/// Returns any record: up to half of the parameters, unknown keys, repeated keys, and lane trims.
fn record() -> impl Strategy<Value = Record> {
    let entry = prop_oneof![12 => 1_u8..=21, 6 => 8_u8..=14, 1 => prop::sample::select(vec![0, 22, 255])]
        .prop_flat_map(|key| value(key).prop_map(move |value| (key, value)));
    let gain = prop_oneof![4 => 0.9_f32..=1.1, 2 => 0.0_f32..=2.0, 1 => prop::sample::select(vec![0.0, 1.02, 2.0])];
    // Impossible trims are excluded: they are neither written nor read as a record.
    (prop::collection::vec(entry, 0..=12), prop::collection::vec(gain, 0..=3))
        .prop_map(|(entries, gains)| Record { trims: trims(&gains), parameters: entries.into_iter().collect() })
}

/// Returns any setup of a board: with or without an encoder, with or without tracking, with either
/// kind of drive, and with trimmed lanes.
fn board() -> impl Strategy<Value = Setup> {
    (any::<bool>(), 0_u8..3, 1_u8..=4, prop::sample::select(vec![1.0_f32, 0.8, 1.2])).prop_map(|(encoder, drive, lanes, gain)| {
        setup(|config| {
            config.front_end.metre_per_count = encoder.then_some(1e-6);
            config.lanes = lanes;
            config.phasing.gain_trim = [gain, 1.0].into_iter().collect();
            if drive > 0 {
                config.tracking.mode = TrackingMode::Observer;
            }
            if drive > 1 {
                config.drive.amplitude = Amplitude::MotionalCurrent(0.5);
            }
        })
    })
}

proptest! {
    #![proptest_config(cases(1500))]

    #[test]
    fn the_limits_of_any_record_act_and_the_board_runs(mut setup in board(), record in record(), volts in 0.1_f32..100.0) {
        setup.flash = storing(&record);
        let mut queues = Queues::default();
        // The board starts with any stored record.
        let mut bench = bench(&mut queues, &setup);
        bench.blocks(4);
        let reports: Vec<ParameterReport> = PARAMETERS.iter().map(|parameter| get(&mut bench, parameter.key)).collect();
        let report = |key: u8| reports.iter().find(|report| report.key == key);
        for &(key, stored) in &record.parameters {
            let Some(of) = report(key) else { continue };
            let limit = PARAMETERS.iter().any(|parameter| parameter.key == key && parameter.is_limit());
            if limit && (key != ENERGY_PER_METRE || setup.config.front_end.metre_per_count.is_some()) {
                // A stored value below the least permitted one is replaced by that.
                let most = if stored > of.min { stored } else { of.min };
                prop_assert!(of.acts <= most, "{key}: {stored} stored, {of:?}");
            }
            let differs = |&(other, value): &(u8, f32)| other == key && value.to_bits() != stored.to_bits();
            if of.acts.to_bits() != stored.to_bits() && !record.parameters.iter().any(differs) {
                let other_kind = [AMPLITUDE, CURRENT].contains(&key) && of.acts == 0.0;
                let no_period = key == 20 && report(19).is_some_and(|period| period.acts == 0.0);
                prop_assert!(matches!(of.stored, StoredState::Partly | StoredState::Refused) || other_kind || no_period, "{key}: {stored} stored, {of:?}");
            }
        }
        // The active drive values are within the active limits.
        let acts = |key: u8| report(key).map_or(f32::NAN, |of| of.acts);
        prop_assert!(acts(SCAN) <= acts(VOLTAGE_LIMIT) && acts(AMPLITUDE) <= acts(VOLTAGE_LIMIT) && acts(CURRENT) <= acts(9));
        // With any stored scale, no limit exceeds the code of the built-in limit.
        for (limit, scale) in [(VOLTAGE_LIMIT, DRIVE_SCALE), (9, 2)] {
            let built_in = |key: u8| report(key).map_or(f32::NAN, |of| of.built_in);
            let (codes, most) = (acts(limit) / acts(scale), built_in(limit) / built_in(scale));
            prop_assert!(codes <= most * (1.0 + 1e-6), "{limit}: {codes} codes of {most}");
        }
        // An order above a limit is reduced to it, on every lane.
        prop_assert_eq!(bench.ask(Command::Amplitude(Some(Amplitude::Volts(volts)))), Some(Reply::Ack));
        // A limit of the energy per metre cannot act without an encoder: then nothing is driven.
        let unjudged =
            setup.config.front_end.metre_per_count.is_none() && report(ENERGY_PER_METRE).is_some_and(|of| of.next.is_finite());
        let answer = if unjudged { Reply::Nak(Refusal::LimitsUnsure) } else { Reply::Ack };
        prop_assert_eq!(bench.ask(Command::Run), Some(answer));
        bench.blocks(150);
        let most_codes = (acts(VOLTAGE_LIMIT) / acts(DRIVE_SCALE)).min(2047.0);
        for lane in 0..usize::from(setup.config.lanes) {
            let loudest = peak(&played(&mut bench, lane));
            prop_assert!(f32::from(loudest) <= most_codes + 1.0, "lane {lane}: {loudest} codes of {most_codes}, {record:?}");
        }
    }

    #[test]
    fn a_lowered_limit_and_any_trims_act_together(limit in 1e-3_f32..12.0, gains in prop::collection::vec(0.5_f32..=2.0, 1..=3)) {
        let mut setup = setup(|config| config.lanes = 4);
        setup.flash = storing(&Record { trims: trims(&gains), parameters: Overrides::from_iter([(VOLTAGE_LIMIT, limit)]) });
        let mut queues = Queues::default();
        let mut bench = bench(&mut queues, &setup);
        bench.blocks(4);
        prop_assert_eq!(get(&mut bench, VOLTAGE_LIMIT).acts, limit);
        let points = gains.len() as u8;
        let trims = bench.ask(Command::Settings(Verb::Trims(0)));
        prop_assert!(matches!(trims, Some(Reply::Settings(report)) if report.points == points));
    }
}

#[test]
fn only_a_limit_without_its_sensor_is_refused() {
    for encoder in [false, true] {
        let mut setup = setup(|config| config.front_end.metre_per_count = encoder.then_some(1e-6));
        let mut queues = Queues::default();
        let mut bench = bench(&mut queues, &setup);
        bench.blocks(4);
        let set = bench.ask(Command::Settings(Verb::Set(ENERGY_PER_METRE, 1000.0)));
        assert_eq!(set, Some(if encoder { Reply::Ack } else { Reply::Nak(Refusal::NotConfigured) }));
        // Removing the limit is always permitted.
        assert_eq!(bench.ask(Command::Settings(Verb::Set(ENERGY_PER_METRE, f32::INFINITY))), Some(Reply::Ack));
        // As stored by an image with an encoder.
        let parameters = Overrides::from_iter([(VOLTAGE_LIMIT, 2.0), (ENERGY_PER_METRE, 1000.0), (21, 0.5)]);
        setup.flash = storing(&Record { trims: trims(&[1.02]), parameters });
        let mut queues = Queues::default();
        let mut bench = super::bench(&mut queues, &setup);
        bench.blocks(4);
        let acts = [VOLTAGE_LIMIT, ENERGY_PER_METRE, 21].map(|key| get(&mut bench, key).acts);
        assert_eq!(acts, [2.0, if encoder { 1000.0 } else { f32::INFINITY }, 0.5]);
        let report = get(&mut bench, AMPLITUDE);
        assert_eq!((report.stored, report.next), (StoredState::Refused, 3.0));
        assert!((report.acts - 2.0 / 1.02).abs() < 1e-6, "{report:?}");
    }
}

#[test]
fn only_invalid_settings_are_left_out() {
    // A bandwidth too large for the block rate, and a drive above its limit, together with valid
    // values.
    let parameters =
        Overrides::from_iter([(4, 41e3), (AMPLITUDE, 11.0), (VOLTAGE_LIMIT, 5.0), (15, 60.0), (18, 1000.0), (21, 2.5)]);
    let mut setup = setup(|config| config.tracking.mode = TrackingMode::PhaseLock);
    setup.flash = storing(&Record { trims: LaneTrims::new(), parameters });
    let built_in = setup.config.tracking.bandwidth_hz;
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &setup);
    bench.blocks(4);
    let acts = [4, AMPLITUDE, VOLTAGE_LIMIT, 15, 18, 21].map(|key| get(&mut bench, key).acts);
    assert_eq!(acts, [41e3, 5.0, 5.0, 60.0, built_in, 2.5]);
    assert_eq!((get(&mut bench, 18).next, get(&mut bench, 18).stored), (1000.0, StoredState::Refused));
}

/// Returns a flash with several records, the last one stored, and damaged words.
fn damaged_flash() -> impl Strategy<Value = (Record, Flash)> {
    let word = prop_oneof![3 => 0_usize..40, 3 => 512_usize..552, 2 => 0_usize..4 * PAGE_BYTES / WORD_BYTES];
    let bits = prop_oneof![2 => (0_u32..64).prop_map(|bit| 1_u64 << bit), 1 => any::<u64>(), 1 => Just(u64::MAX)];
    let damage = prop_oneof![2 => bits.prop_map(|bits| Damage::Flips(bits.to_le_bytes())), 1 => Just(Damage::Unreadable)];
    (prop::collection::vec(record(), 1..=4), prop::collection::vec((word, damage), 0..=4)).prop_map(|(records, damages)| {
        let mut settings = Settings::new(Flash::new(4, 1)).unwrap();
        records.iter().for_each(|record| settings.store(record).unwrap());
        let mut flash = settings.release();
        damages.into_iter().for_each(|(word, damage)| flash.damage(word, damage));
        (records.last().unwrap().clone(), flash)
    })
}

proptest! {
    #![proptest_config(cases(3000))]

    #[test]
    fn no_damage_raises_a_stored_limit((record, flash) in damaged_flash(), mut setup in board()) {
        setup.flash = flash;
        let mut queues = Queues::default();
        let mut bench = bench(&mut queues, &setup);
        bench.blocks(4);
        let drives = match bench.ask(Command::Run) {
            Some(Reply::Ack) => true,
            Some(Reply::Nak(Refusal::LimitsUnsure)) => false,
            other => panic!("{other:?}"),
        };
        let mut above = false;
        for parameter in PARAMETERS.iter().filter(|parameter| parameter.is_limit()) {
            let of = get(&mut bench, parameter.key);
            let stored = record.parameters.iter().filter(|(key, _)| *key == parameter.key).map(|&(_, value)| value);
            for value in stored.filter(|value| !value.is_nan()) {
                above |= of.acts > value.max(of.min);
            }
        }
        prop_assert!(!(drives && above), "{record:?}");
        if !drives {
            // The refusal states the reason, and other orders are refused in the same way.
            prop_assert_eq!(bench.ask(Command::Scan), Some(Reply::Nak(Refusal::LimitsUnsure)));
            let stored = get(&mut bench, VOLTAGE_LIMIT).stored;
            prop_assert!(stored.hides_limits() || stored == StoredState::Refused, "{stored:?}");
        }
    }
}

/// Returns a flash whose stored settings, with a voltage limit, cannot be read.
fn unreadable() -> Flash {
    let mut flash =
        storing(&Record { trims: LaneTrims::new(), parameters: Overrides::from_iter([(VOLTAGE_LIMIT, 2.0), (AMPLITUDE, 1.0)]) });
    [2, 2 * PAGE_BYTES / WORD_BYTES + 2].into_iter().for_each(|word| flash.damage(word, Damage::Unreadable));
    flash
}

#[test]
fn unreadable_limits_prevent_a_drive_until_stored_or_cleared() {
    for clears in [true, false] {
        let mut setup = setup(|_| {});
        setup.flash = unreadable();
        let mut queues = Queues::default();
        let mut bench = bench(&mut queues, &setup);
        bench.blocks(4);
        assert_eq!(get(&mut bench, VOLTAGE_LIMIT).stored, StoredState::Damaged);
        let verbs = if clears {
            vec![Verb::Clear]
        } else {
            vec![Verb::Set(VOLTAGE_LIMIT, 2.0), Verb::Set(AMPLITUDE, 1.0), Verb::Set(SCAN, 1.0), Verb::Store]
        };
        for verb in verbs {
            assert_eq!(bench.ask(Command::Settings(verb)), Some(Reply::Ack));
        }
        // The active limits are those of the start: the new ones act only after a reset.
        for order in [Command::Run, Command::Scan, Command::Calibrate] {
            assert_eq!(bench.ask(order), Some(Reply::Nak(Refusal::LimitsUnsure)));
        }
        bench.blocks(50);
        assert!(played(&mut bench, 0).iter().all(|&code| code == MID_CODE));
        setup.flash = bench.power_off();
        let mut queues = Queues::default();
        let mut bench = super::bench(&mut queues, &setup);
        bench.blocks(4);
        assert_eq!(get(&mut bench, VOLTAGE_LIMIT).acts, if clears { setup.config.limits.voltage_v } else { 2.0 });
        assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
    }
}

#[test]
fn one_damaged_copy_is_reported_until_it_is_stored_again() {
    let mut setup = setup(|_| {});
    setup.flash = storing(&Record { trims: LaneTrims::new(), parameters: Overrides::from_iter([(VOLTAGE_LIMIT, 5.0)]) });
    setup.flash.damage(2, Damage::Flips([1; 8]));
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &setup);
    bench.blocks(4);
    let report = get(&mut bench, VOLTAGE_LIMIT);
    assert_eq!((report.acts, report.stored), (5.0, StoredState::OneCopy));
    // Set a drive within that limit.
    for key in [AMPLITUDE, SCAN] {
        assert_eq!(bench.ask(Command::Settings(Verb::Set(key, 1.0))), Some(Reply::Ack));
    }
    assert_eq!(bench.ask(Command::Settings(Verb::Store)), Some(Reply::Ack));
    assert_eq!(get(&mut bench, VOLTAGE_LIMIT).stored, StoredState::Stored);
    assert_eq!(bench.ask(Command::Settings(Verb::Stores)), Some(Reply::Stores(2)));
    // Now the other copy may be lost.
    setup.flash = bench.power_off();
    setup.flash.damage(2 * PAGE_BYTES / WORD_BYTES + 2, Damage::Flips([1; 8]));
    let mut queues = Queues::default();
    let mut bench = super::bench(&mut queues, &setup);
    bench.blocks(4);
    assert_eq!(get(&mut bench, VOLTAGE_LIMIT).acts, 5.0);
}

#[test]
fn an_invalid_combination_is_refused_at_the_store_with_a_key() {
    let mut queues = Queues::default();
    let mut setup = setup(|config| config.tracking.mode = TrackingMode::PhaseLock);
    setup.flash = storing(&Record { trims: LaneTrims::new(), parameters: Overrides::from_iter([(AMPLITUDE, 2.0), (SCAN, 2.0)]) });
    let mut bench = bench(&mut queues, &setup);
    bench.blocks(4);
    // A drive of 2 V above a limit of 1 V.
    assert_eq!(bench.ask(Command::Settings(Verb::Set(VOLTAGE_LIMIT, 1.0))), Some(Reply::Ack));
    let refused = bench.ask(Command::Settings(Verb::Store));
    assert!(matches!(refused, Some(Reply::Nak(Refusal::DoesNotBuild(AMPLITUDE | SCAN)))), "{refused:?}");
    assert_eq!(get(&mut bench, AMPLITUDE).stored, StoredState::Changed);
    for key in [AMPLITUDE, SCAN] {
        assert_eq!(bench.ask(Command::Settings(Verb::Set(key, 0.5))), Some(Reply::Ack));
    }
    assert_eq!(bench.ask(Command::Settings(Verb::Store)), Some(Reply::Ack));
    // A waveform that prevents tracking is not an error of a single key.
    assert_eq!(bench.ask(Command::Settings(Verb::Set(64, 3.0))), Some(Reply::Ack));
    assert_eq!(bench.ask(Command::Settings(Verb::Store)), Some(Reply::Nak(Refusal::DoesNotBuild(0))));
    let (record, state) = Settings::new(bench.power_off()).unwrap().record();
    assert_eq!(
        (record.parameters.as_slice(), state),
        (&[(AMPLITUDE, 0.5), (SCAN, 0.5), (VOLTAGE_LIMIT, 1.0)][..], StoredState::Stored)
    );
}
