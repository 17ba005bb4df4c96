//! Round trips of the longest records, whole and in pieces, and refusal of malformed records.

use super::wire::{put_codes, take_codes};
use super::*;
use crate::seam::block::{Amplitude, BeltSense, Codes, Gate, MAX_BLOCK_SAMPLES, MAX_LANES, Request, SlowSense, Target, Trips};
use crate::seam::config::*;
use crate::seam::fault::{Fault, Limit};
use crate::seam::mode::Mode;
use crate::seam::telemetry::FrictionEstimate;
use crate::seam::transducer::Transducer;
use crate::seam::units::{Hertz, Turns};

/// Sends `record` in pieces of `piece` bytes, and checks that decoding into `other` restores it.
fn round_trip<T: Record + PartialEq + core::fmt::Debug>(record: &T, mut other: T, piece: usize) {
    let mut sent = BUFFER;
    let mut rest = encode(record, &mut sent).expect("it fits");
    let mut received = BUFFER;
    let read = |bytes: &mut [u8]| {
        let (now, later) = rest.split_at(piece.min(rest.len()));
        bytes[..now.len()].copy_from_slice(now);
        rest = later;
        Ok::<_, ()>(now.len())
    };
    let body = receive(&mut received, read).unwrap().expect("a whole record");
    assert_eq!(decode(body, &mut other), Ok(()));
    assert_eq!(other, *record);
}

fn codes() -> Codes {
    (0..MAX_BLOCK_SAMPLES as u16).map(|n| 0xffff - n).collect()
}

fn longest_question() -> Question {
    let orders = Orders {
        sequence: u32::MAX,
        request: Request::Run,
        attempt: u32::MAX,
        gate: Gate::Off,
        amplitude: Some(Amplitude::MotionalCurrent(1.0)),
        detune: Hertz(1.0),
        quadrature: Some(Turns(0.1)),
        friction: Some(Target::Force(1.0)),
        torso_kg: Some(1.0),
        emergency_stop: true,
        host_lost: true,
        clear_fault: true,
    };
    let slow = SlowSense {
        belt: Some(BeltSense { counts: i32::MIN, broken: true }),
        temperature: Some(1.0),
        force: Some(1.0),
        trips: Some(Trips { over_current: true, amplifier_fault: true, supply: true }),
        missed_blocks: Some(u32::MAX),
    };
    Question { orders, sense: SenseBlock { v: codes(), i: codes(), slow } }
}

fn longest_answer() -> Answer {
    let telemetry = Telemetry {
        block: u32::MAX,
        orders_sequence: u32::MAX,
        mode: Mode::Fault,
        fault: Some(Fault::BeltStopped),
        limit: Some(Limit::FrequencyWindow),
        tuning_word: u64::MAX,
        transducer: Some(Transducer::default()),
        listed: Some(Default::default()),
        friction: Some(FrictionEstimate { force_ratio: Some(1.0), ..FrictionEstimate::default() }),
        ..Telemetry::default()
    };
    let drive = DriveBlock { lanes: core::iter::repeat_n(codes(), MAX_LANES).collect(), listen: 3, drops_queue: true };
    Answer { drive, telemetry, instructions: Some(u32::MAX) }
}

fn longest_config() -> Config {
    let most = |x: f32| core::iter::repeat_n(x, MAX_LANES).collect();
    Config {
        sample_hz: 1e6,
        block_samples: u16::MAX,
        lanes: 4,
        front_end: FrontEnd {
            volt_per_lsb: 1.0,
            ampere_per_lsb: 1.0,
            sense_mid_code: u16::MAX,
            sense_max_code: u16::MAX,
            drive_volt_per_lsb: 1.0,
            drive_mid_code: u16::MAX,
            drive_max_code: u16::MAX,
            drive_lanes: u8::MAX,
            metre_per_count: Some(1.0),
            force_hz: Some(1.0),
            newton_per_lsb: Some(1.0),
        },
        drive: Drive {
            frequency_hz: 40e3,
            amplitude: Amplitude::Volts(1.0),
            scan_volts: 1.0,
            shape: ShapeKind::Noise,
            noise_band_hz: (1.0, 2.0),
            dither: true,
            soft_start_s: 0.5,
            seed: u64::MAX,
        },
        sweep: Sweep::Chirp(Chirp {
            kind: ChirpKind::Exponential,
            start_hz: 1.0,
            stop_hz: 2.0,
            time_s: 1.0,
            then: Then::UpDown,
            around: Around::Resonance,
        }),
        phasing: Phasing {
            direction: Direction::Reverse,
            phase_trim_turns: most(0.0),
            gain_trim: most(1.0),
            watch: true,
            calibration: core::iter::repeat_n(TrimPoint::default(), MAX_TRIM_POINTS).collect(),
        },
        burst: Burst {
            schedule: Schedule::Windows(core::iter::repeat_n((0.0, 1.0), MAX_WINDOWS).collect()),
            edge: Edge::Soft,
            edge_cycles: 1.0,
            brake: true,
        },
        tracking: Tracking {
            mode: TrackingMode::Off,
            span: 1.0,
            bandwidth_hz: 1.0,
            nominal_c0_f: Some(1.0),
            ..Tracking::new(1.0)
        },
        thermometer: Thermometer { hz_per_k: 1.0, c0_per_k: 1.0, ambient_c: 1.0, ..Thermometer::default() },
        heat_sink: HeatSink { ohm_at_25_c: Some(1.0), ..HeatSink::default() },
        supply: Supply::default(),
        limits: Limits {
            voltage_v: 1.0,
            current_a: 1.0,
            power_w: Some(1.0),
            temperature_c: 1.0,
            belt_stop_ms: 1.0,
            energy_j_per_m: Some(1.0),
            on_time_s: Some(1.0),
        },
        friction: Some(Friction {
            target: Target::Ratio(1.0),
            law: FrictionLaw::Coulomb,
            prefer: Prefer::Bursts,
            force_factor_n_per_v: 1.0,
            speed_m_per_s: 1.0,
            dahl_length_m: 1.0,
            average_s: 1.0,
            detent_pitch_m: 1.0,
            detent_ratio: 0.5,
        }),
        restraint: Some(Restraint::default()),
        link: Link { patience_s: 1.5 },
    }
}

#[test]
fn the_longest_records_round_trip_whole_or_in_pieces() {
    for piece in [1, 7, MAX_RECORD] {
        round_trip(&longest_config(), Config { lanes: 1, ..longest_config() }, piece);
        round_trip(&longest_question(), Question::default(), piece);
        round_trip(&longest_answer(), Answer::default(), piece);
        round_trip(&Closing { stack_power_up_bytes: u32::MAX, stack_blocks_bytes: u32::MAX }, Closing::default(), piece);
        let refused = Err("x".repeat(MAX_REASON_BYTES).as_str().try_into().unwrap());
        round_trip(&Opening { built: refused, silence: longest_answer().drive }, Opening::default(), piece);
        let beat = Beat { sense: longest_question().sense, pins: Pins { sent: u32::MAX, stop: true } };
        round_trip(&beat, Beat::default(), piece);
        let board = Board { enable: true, fed: u32::MAX, failed: true, resets: true };
        round_trip(&Played { drive: longest_answer().drive, board }, Played::default(), piece);
        // Decoding overwrites the previous value completely.
        round_trip(&Answer::default(), longest_answer(), piece);
        round_trip(&Question::default(), longest_question(), piece);
    }
}

#[test]
fn the_closing_request_is_a_record_but_not_a_question() {
    let mut sent = Some(CLOSE);
    let read = |bytes: &mut [u8]| {
        let close = sent.take().unwrap_or_default();
        bytes[..close.len()].copy_from_slice(&close);
        Ok::<_, ()>(close.len())
    };
    let mut buffer = BUFFER;
    let body = receive(&mut buffer, read).unwrap().expect("a whole record");
    assert!(body.is_empty() && decode(body, &mut Question::default()).is_err());
}

#[test]
fn the_stream_may_end_inside_a_record() {
    let mut pieces = [3usize, 0].into_iter();
    let read = |bytes: &mut [u8]| {
        bytes[..3].copy_from_slice(&[9, 0, 1]);
        pieces.next().ok_or(())
    };
    assert_eq!(receive(&mut BUFFER.clone(), read), Ok(None));
}

#[test]
fn too_many_or_truncated_codes_are_refused() {
    let mut buffer = BUFFER;
    put_codes(&codes(), &mut buffer).unwrap();
    let mut taken = Codes::new();
    assert!(take_codes(&mut taken, &buffer).is_some() && taken == codes());
    assert!(take_codes(&mut taken, &buffer[..2 * MAX_BLOCK_SAMPLES]).is_none(), "cut short");
    buffer[0] += 1;
    assert!(take_codes(&mut taken, &buffer).is_none(), "one code more than a block can have");
    assert!(put_codes(&codes(), &mut buffer[..2 * MAX_BLOCK_SAMPLES]).is_none(), "no room");
    let mut drive = DriveBlock::default();
    assert!(take_drive(&mut drive, &[MAX_LANES as u8 + 1, 0, 0, 0, 0, 0, 0]).is_none(), "one lane too many");
}

#[test]
fn bytes_after_a_record_are_refused() {
    let mut buffer = BUFFER;
    let length = encode(&longest_question(), &mut buffer).unwrap().len();
    assert_eq!(decode(&buffer[LENGTH_BYTES..length], &mut Question::default()), Ok(()));
    assert_eq!(decode(&buffer[LENGTH_BYTES..=length], &mut Question::default()), Err(BadRecord));
}
