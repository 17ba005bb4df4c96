//! Limits: a value above a limit is not played; it is reported, and is not a fault.

use firmware::board::command::{Command, Reply};
use firmware::controller::Controller;
use firmware::seam::block::Amplitude;
use firmware::seam::config::ShapeKind;
use firmware::seam::error::Error;
use firmware::seam::fault::Limit;
use firmware::seam::mode::Mode;
use firmware::seam::refusal::Refusal;
use hal_mock::bench::{Queues, Setup};
use proptest::prelude::*;

use super::*;

/// Voltage limit of 12 V, peak codes.
const LIMIT_CODES: u16 = 1200;

#[test]
fn a_voltage_over_the_limit_is_clamped_and_reported_by_number() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.ask(Command::TelemetryEvery(1));
    assert_eq!(bench.ask(Command::Amplitude(Some(Amplitude::Volts(50.0)))), Some(Reply::Ack));
    bench.blocks(200);
    bench.host.receive(usize::MAX);
    let report = *bench.host.telemetry().last().unwrap().1;
    assert_eq!((report.limit.map(|limit| limit as u8), report.drive.0, report.mode), (Some(96), 12.0, Mode::Run));
    assert_eq!(peak(&played(&mut bench, 0)), LIMIT_CODES);

    assert_eq!(bench.ask(Command::Amplitude(None)), Some(Reply::Ack));
    bench.blocks(10);
    let began = bench.played() as usize * BLOCK;
    bench.blocks(100);
    assert_eq!((bench.latest().unwrap().limit, peak(&played(&mut bench, 0)[began..])), (None, 300));
}

#[test]
fn the_exact_limit_is_not_reported() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.ask(Command::Amplitude(Some(Amplitude::Volts(12.0))));
    bench.blocks(10);
    assert_eq!(bench.latest().unwrap().limit, None);
    bench.ask(Command::Amplitude(Some(Amplitude::Volts(12.01))));
    bench.blocks(10);
    assert_eq!(bench.latest().unwrap().limit, Some(Limit::OverVoltageRequest));
}

#[test]
fn an_invalid_amplitude_is_refused() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    let sequence = bench.latest().unwrap().orders_sequence;
    for x in [f32::NAN, -f32::NAN, -1.0, f32::INFINITY, f32::NEG_INFINITY] {
        for amplitude in [Amplitude::Volts(x), Amplitude::MotionalCurrent(x)] {
            assert_eq!(bench.ask(Command::Amplitude(Some(amplitude))), Some(Reply::Nak(Refusal::NotPlausible)), "{amplitude:?}");
        }
    }
    let began = bench.played() as usize * BLOCK;
    bench.blocks(100);
    assert_eq!((peak(&played(&mut bench, 0)[began..]), bench.latest().unwrap().orders_sequence), (300, sequence));
}

/// Returns the peak code of a run at this amplitude.
fn peak_at(setup: &Setup, amplitude: Amplitude) -> u16 {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, setup);
    bench.ask(Command::Amplitude(Some(amplitude)));
    bench.blocks(100);
    peak(&played(&mut bench, 0))
}

#[test]
fn the_limit_is_a_peak_for_every_shape_and_frequency() {
    assert_eq!(peak_at(&Setup::default(), Amplitude::Volts(12.0)), LIMIT_CODES);
    for frequency_hz in [23e3, 40.4e3, 180e3] {
        let square = setup(|config| {
            config.drive.shape = ShapeKind::Square;
            config.drive.frequency_hz = frequency_hz;
        });
        let peak = peak_at(&square, Amplitude::Volts(12.0));
        assert!(peak <= LIMIT_CODES, "{peak} codes at {frequency_hz} Hz");
    }
}

#[test]
fn the_limit_applies_to_the_lane_with_the_largest_gain() {
    let trimmed = setup(|config| {
        config.lanes = 2;
        config.phasing.gain_trim = [1.0, 1.5].into_iter().collect();
    });
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &trimmed);
    bench.ask(Command::Amplitude(Some(Amplitude::Volts(12.0))));
    bench.blocks(100);
    let peak = peak(&played(&mut bench, 1));
    assert!((LIMIT_CODES - 1..=LIMIT_CODES).contains(&peak), "{peak} codes");
}

#[test]
fn the_scan_obeys_the_limit_of_the_largest_gain() {
    let trimmed = setup(|config| {
        config.lanes = 2;
        config.phasing.gain_trim = [1.0, 2.0].into_iter().collect();
        config.limits.voltage_v = 6.0;
        config.drive.scan_volts = 6.0;
    });
    let refused = Controller::build(&trimmed.config).err();
    assert!(matches!(refused, Some(Error::OutOfRange { parameter: "drive.scan_volts", max: 3.0, .. })), "{refused:?}");
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn the_limit_holds_for_any_amplitude(bits: u32, current: bool) {
        let x = f32::from_bits(bits);
        let amplitude = if current { Amplitude::MotionalCurrent(x) } else { Amplitude::Volts(x) };
        prop_assert!(peak_at(&Setup::default(), amplitude) <= LIMIT_CODES);
    }
}
