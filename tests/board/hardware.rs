//! Reasons for the non-maskable interrupt, divider of the UART, timing of a conversion, guard of
//! the stack, and test of the trips.

use firmware::board::start::TripFailure;
use nucleo_g474re::alarm::{Alarm, Word};
use nucleo_g474re::baud::divider;
use nucleo_g474re::config::{TRIP_A, config, trip_codes};
use nucleo_g474re::pages::{FLASH, SECOND_BANK, START};
use nucleo_g474re::sampling::{CYCLES_PER_CONVERSION, DIVIDER, MARGIN_EIGHTHS, TRIGGER_AFTER, sampling_ns, source_ohm};
use nucleo_g474re::stack::GUARD;
use nucleo_g474re::trips::{ALWAYS_TRIPPING, Levels, thresholds};

const SYSTEM_HZ: u32 = 170_000_000;

#[test]
fn a_damaged_word_is_classified_by_its_bank() {
    let word = |in_second_bank, offset| Some(Word { in_system_memory: false, in_second_bank, offset });
    let two_banks = |word| Alarm::from_flags(false, false, word, true);
    assert_eq!(two_banks(word(true, START - SECOND_BANK)), Alarm::Settings);
    assert_eq!(two_banks(word(false, START - SECOND_BANK)), Alarm::Code(START - SECOND_BANK + FLASH));
    assert_eq!(two_banks(word(false, 0x1234)), Alarm::Code(FLASH + 0x1234));
    // The factory's calibration is read once, and must not be mistaken for the settings.
    let factory = Some(Word { in_system_memory: true, in_second_bank: true, offset: START - SECOND_BANK });
    assert_eq!(two_banks(factory), Alarm::Code(START));
    // With one bank, the offset is relative to the whole flash.
    assert_eq!(Alarm::from_flags(false, false, word(false, START - FLASH), false), Alarm::Settings);
    assert_eq!(Alarm::from_flags(false, false, word(false, START - FLASH - 8), false), Alarm::Code(START - 8));
}

#[test]
fn a_clock_or_parity_failure_outranks_a_damaged_word() {
    let word = Some(Word { in_system_memory: false, in_second_bank: true, offset: START - SECOND_BANK });
    assert_eq!(Alarm::from_flags(true, true, word, true), Alarm::ClockFailed);
    assert_eq!(Alarm::from_flags(false, true, word, true), Alarm::RamParity);
    assert_eq!(Alarm::from_flags(false, false, None, true), Alarm::Unknown);
}

#[test]
fn the_uart_divider_has_twenty_bits_and_is_rounded() {
    assert_eq!(divider(SYSTEM_HZ, 921_600), Some(47_222));
    // 115 200 baud takes more than 16 bits.
    assert_eq!(divider(SYSTEM_HZ, 115_200), Some(377_778));
    let baud = 256.0 * f64::from(SYSTEM_HZ) / 377_778.0;
    assert!((baud / 115_200.0 - 1.0).abs() < 1e-5, "{baud}");
}

#[test]
fn an_impossible_baud_rate_is_refused() {
    for baud in [0, 300, 41_000, 60_000_000, u32::MAX] {
        assert_eq!(divider(SYSTEM_HZ, baud), None, "{baud}");
    }
    assert!(divider(SYSTEM_HZ, 42_000).is_some() && divider(SYSTEM_HZ, 42_500_000).is_some());
}

#[test]
fn a_conversion_ends_three_cycles_before_the_next_trigger() {
    let adc_ns = f64::from(DIVIDER) / f64::from(SYSTEM_HZ) * 1e9;
    let margin_ns = f64::from(MARGIN_EIGHTHS) / 8.0 * adc_ns;
    println!("margin {margin_ns:.1} ns, sampling {:.1} ns", sampling_ns(SYSTEM_HZ as f32));
    assert!(
        (f64::from(CYCLES_PER_CONVERSION) / f64::from(DIVIDER) - 2.125 - 3.5 - 12.5 - f64::from(MARGIN_EIGHTHS) / 8.0).abs()
            < 1e-12
    );
    assert!((margin_ns - 73.5).abs() < 0.1, "{margin_ns}");
    // The sampling ends a quarter of a sample after the step of the DAC, within a cycle.
    let end = f64::from(TRIGGER_AFTER) + 3.0 + f64::from(DIVIDER) * (2.125 + 3.5);
    assert!((end - 42.5).abs() <= 1.0, "{end}");
}

#[test]
fn the_source_of_the_front_end_settles_within_the_sampling() {
    let sampling = sampling_ns(SYSTEM_HZ as f32);
    assert!((sampling - 82.35).abs() < 0.01, "{sampling}");
    let most = source_ohm(sampling);
    assert!((most - 240.0).abs() < 1.0, "{most}");
    // The source of docs/board.md is an op-amp with 100 ohm and 1 nF.
    assert!(most > 2.0 * 100.0);
}

#[test]
fn the_stack_guard_ends_where_the_stack_begins() {
    // docs/board.md: the stack has 48 of the 96 KiB. SIZE = 13 for 2^(13 + 1) bytes, AP = 0, XN,
    // enabled.
    assert_eq!((GUARD.end(), GUARD.attributes()), (0x2001_8000 - (48 << 10), 0x1000_001b));
}

#[test]
fn a_missing_wire_or_an_offset_at_rest_is_identified() {
    let failure = |positive, negative| Levels { positive, negative }.failure();
    assert_eq!(failure(2048, 2050), None);
    // A pin that is not connected is pulled down.
    assert_eq!((failure(2048, 300), failure(300, 2048)), (Some(TripFailure::Wire), Some(TripFailure::NotAtRest)));
    assert_eq!(
        (failure(2048 + 201, 2249), failure(2048 - 201, 1847)),
        (Some(TripFailure::NotAtRest), Some(TripFailure::NotAtRest))
    );
    assert_eq!((failure(2100, 2140), failure(2100, 2141)), (None, Some(TripFailure::Wire)));
}

/// Returns the thresholds for a current limit, A, with the built-in scale of the current channel.
fn built(limit_a: f32) -> (u16, u16) {
    thresholds(limit_a, config().front_end.ampere_per_lsb)
}

#[test]
fn the_trips_follow_the_limit_by_half_an_ampere() {
    assert_eq!(built(config().limits.current_a), trip_codes(TRIP_A));
    // 496.5 codes per ampere, plus a margin of 248.
    assert_eq!((built(1.0), built(0.1)), ((2792, 1303), (2345, 1750)));
    // With half the shunt, the same code is twice the current.
    assert_eq!(thresholds(2.0, 2.0 * config().front_end.ampere_per_lsb), built(1.0));
    for (limit_a, ampere_per_lsb) in [(3.1, 1e-3), (1e3, 1e-3), (3.0, 1e-6), (f32::NAN, 1e-3), (3.0, 0.0), (f32::INFINITY, 1e-3)]
    {
        assert_eq!(thresholds(limit_a, ampere_per_lsb), trip_codes(TRIP_A), "{limit_a} {ampere_per_lsb}: above TRIP_A");
    }
}

#[test]
fn zero_current_never_trips() {
    let (upper, lower) = built(1e-6);
    // For every permitted zero, with the comparator's hysteresis.
    let (highest, lowest) = (2048 + 200, 2048 - 200);
    assert!(Levels { positive: highest, negative: highest }.failure().is_none());
    assert!(highest + 37 < upper && lowest - 37 > lower, "{upper} {lower}");
    // The limit itself is reached before the trips.
    for limit_a in [1e-6, 0.01, 0.5, 1.0, 2.0, 3.0] {
        let limit = (limit_a / config().front_end.ampere_per_lsb / 2.0) as u16;
        assert!(highest + limit < built(limit_a).0 && lowest - limit > built(limit_a).1, "{limit_a}");
    }
}

/// Simulates the comparators of the board, of which one may be stuck.
#[test]
fn every_failed_trip_is_detected() {
    type Comparator = fn(bool) -> bool;
    let test = |levels: Levels, run: (u16, u16), positive: Comparator, negative: Comparator| {
        let trips = |(upper, lower): (u16, u16)| positive(levels.positive > upper) || negative(levels.negative < lower);
        let mut steps = levels.steps(run).into_iter();
        steps.find(|&(thresholds, must_trip, _)| trips(thresholds) != must_trip).map(|(.., failure)| failure)
    };
    let (works, dead, stuck): (Comparator, Comparator, Comparator) = (|trips| trips, |_| false, |_| true);
    let cases = [1848, 2048, 2248].map(|level| [3.0, 1.0, 1e-6].map(|limit_a| (level, built(limit_a))));
    for (level, run) in cases.into_iter().flatten() {
        let levels = Levels { positive: level, negative: level };
        let test = |levels, positive, negative| test(levels, run, positive, negative);
        assert_eq!(test(levels, works, works), None);
        assert_eq!(test(levels, dead, works), Some(TripFailure::NoPositive));
        assert_eq!(test(levels, works, dead), Some(TripFailure::NoNegative));
        assert_eq!(
            (test(levels, stuck, works), test(levels, works, stuck)),
            (Some(TripFailure::Standing), Some(TripFailure::Standing))
        );
        // The test ends with the thresholds of the run.
        assert_eq!(levels.steps(run)[4].0, run);
        assert!(levels.positive > ALWAYS_TRIPPING.0 && levels.negative < ALWAYS_TRIPPING.1);
    }
}
