//! Played drive: purity of its codes, continuity, and the refusal of invalid settings.

use firmware::controller::Controller;
use firmware::generate::nco::cycles_per_sample;
use firmware::seam::block::{Amplitude, Gate, Orders, Request, SenseBlock};
use firmware::seam::config::{Around, Chirp, ChirpKind, Config, ShapeKind, Sweep, Then, TrackingMode, Trim, TrimPoint};
use firmware::seam::error::Error;
use firmware::seam::fault::Limit;
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use firmware::seam::units::{Hertz, Turns};
use hal_mock::analog::Analog;
use hal_mock::block_clock::BlockClock;
use hal_mock::loop_back::{LoopBack, config};
use report::spectrum::Spectrum;

/// Test frequency, not a divisor of the sample rate, Hz.
const TONE_HZ: f64 = 40_123.4;
/// Number of samples of a spectrum.
const SPECTRUM_SAMPLES: usize = 1 << 16;

fn changed(change: impl FnOnce(&mut Config)) -> Config {
    let mut config = config();
    // Nearly the whole range of the converter: 2040 of 2047 codes.
    (config.drive.amplitude, config.limits.voltage_v) = (Amplitude::Volts(20.4), 20.46);
    // The loop-back's current follows the voltage's steps, which are large here.
    (config.tracking.nominal_c0_f, config.drive.scan_volts) = (Some(20e-9), 10.0);
    config.drive.frequency_hz = TONE_HZ as f32;
    change(&mut config);
    config
}

/// Controller on a loop-back, with orders that a test can change.
struct Driver {
    controller: Controller,
    clock: BlockClock<Recorder>,
    orders: Orders,
}

/// Load that records the codes of the first lane.
struct Recorder {
    load: LoopBack,
    codes: Vec<u16>,
}

impl Analog for Recorder {
    fn exchange(&mut self, drive: &firmware::seam::block::DriveBlock, sense: &mut SenseBlock) {
        self.codes.extend(drive.lanes[0].iter());
        self.load.exchange(drive, sense);
    }
}

impl Driver {
    /// Creates a controller and starts its run.
    fn running(config: &Config) -> Self {
        let controller = Controller::build(config).unwrap();
        let recorder = Recorder { load: LoopBack::of(config), codes: Vec::new() };
        let clock = BlockClock::new(recorder, &controller.silence());
        let orders = Orders { sequence: 1, attempt: 1, request: Request::Run, gate: Gate::On, ..Orders::default() };
        let mut driver = Driver { controller, clock, orders };
        while driver.block().mode != Mode::Run {
            assert!(driver.clock.blocks() < 1000, "{:?}", driver.block());
        }
        // Skip the codes that were played before the run.
        driver.blocks(4);
        driver
    }

    fn block(&mut self) -> Telemetry {
        self.clock.tick(|sense, drive| self.controller.process(&self.orders, sense, drive))
    }

    fn blocks(&mut self, blocks: usize) -> Telemetry {
        (0..blocks).map(|_| self.block()).last().unwrap()
    }

    fn order(&mut self, change: impl FnOnce(&mut Orders)) {
        self.orders.sequence += 1;
        change(&mut self.orders);
    }

    /// Returns the next samples, in codes about zero.
    fn samples(&mut self, count: usize) -> Vec<f64> {
        self.clock.analog.codes.clear();
        while self.clock.analog.codes.len() < count {
            assert_eq!(self.block().fault, None);
        }
        self.clock.analog.codes[..count].iter().map(|&code| f64::from(code) - 2048.0).collect()
    }
}

fn spectrum(config: &Config) -> Spectrum {
    let tone = f64::from(config.drive.frequency_hz) / 1e6;
    Spectrum::new(&Driver::running(config).samples(SPECTRUM_SAMPLES), tone)
}

#[test]
fn a_sine_is_limited_only_by_quantization() {
    let spectrum = spectrum(&changed(|_| ()));
    println!("sine: SFDR {:.1} dB, SNDR {:.1} dB", spectrum.sfdr_db(), spectrum.sndr_db());
    // 12 bits at 2040 of 2048 codes: 6.02 * 12 + 1.76 - 0.03 = 73.97 dB.
    assert!(spectrum.sfdr_db() > 90.0, "SFDR {}", spectrum.sfdr_db());
    assert!((73.5..74.3).contains(&spectrum.sndr_db()), "SNDR {}", spectrum.sndr_db());
}

/// At a divisor of the sample rate, the rounding repeats in every period and causes harmonics;
/// dither turns them into noise.
#[test]
fn dither_turns_the_harmonics_of_rounding_into_noise() {
    let on_a_divisor =
        |dither: bool| spectrum(&changed(|config| (config.drive.frequency_hz, config.drive.dither) = (40e3, dither)));
    let (plain, dithered) = (on_a_divisor(false), on_a_divisor(true));
    let both = |of: fn(&Spectrum) -> f64| (of(&plain), of(&dithered));
    println!("40 kHz, plain and dithered: SFDR {:.1?} dB, SNDR {:.1?} dB", both(Spectrum::sfdr_db), both(Spectrum::sndr_db));
    assert!(plain.sfdr_db() < 86.0 && dithered.sfdr_db() > 90.0, "SFDR {} and {}", plain.sfdr_db(), dithered.sfdr_db());
    assert!((67.0..71.0).contains(&dithered.sndr_db()), "SNDR {}", dithered.sndr_db());
}

#[test]
fn square_and_sawtooth_have_no_aliases_in_the_band() {
    for shape in [ShapeKind::Square, ShapeKind::Sawtooth] {
        for hz in [20_061.7, TONE_HZ as f32, 61_234.5, 200_123.0] {
            let clean = spectrum(&changed(|config| (config.drive.shape, config.drive.frequency_hz) = (shape, hz))).foreign_dbc();
            println!("{shape:?} at {hz} Hz: {clean:.1} dBc");
            assert!(clean < -65.0, "{shape:?} at {hz} Hz: {clean} dBc");
        }
    }
    // For comparison, the same square without tables, in two levels.
    let naive: Vec<f64> =
        (0..SPECTRUM_SAMPLES).map(|n| if (n as f64 * TONE_HZ * 1e-6).fract() < 0.5 { 1.0 } else { -1.0 }).collect();
    let folded = Spectrum::new(&naive, TONE_HZ * 1e-6).foreign_dbc();
    println!("square of two levels at {TONE_HZ} Hz: {folded:.1} dBc");
    assert!((-15.0..-12.0).contains(&folded), "{folded} dBc");
}

#[test]
fn noise_stays_within_its_band_and_peak() {
    let noise = |seed: u64| {
        changed(|config| {
            (config.drive.shape, config.drive.noise_band_hz, config.drive.seed) = (ShapeKind::Noise, (30e3, 50e3), seed)
        })
    };
    let samples = Driver::running(&noise(1)).samples(1 << 18);
    let spectrum = Spectrum::new(&samples, 0.04);
    // An eighth-order Butterworth filter has 3 dB at its corners: a twentieth of the power is
    // outside.
    assert!(spectrum.part_within(0.028, 0.052) > 0.95, "{}", spectrum.part_within(0.028, 0.052));
    assert!(spectrum.part_within(0.02, 0.07) > 0.999, "{}", spectrum.part_within(0.02, 0.07));
    println!("noise 30 to 50 kHz: {:.4} of the power in 28 to 52 kHz", spectrum.part_within(0.028, 0.052));
    let rms = (samples.iter().map(|x| x * x).sum::<f64>() / samples.len() as f64).sqrt();
    let peak = samples.iter().fold(0.0f64, |peak, x| peak.max(x.abs()));
    assert!((rms / (2040.0 / 4.0) - 1.0).abs() < 0.02 && (2000.0..=2041.0).contains(&peak), "rms {rms}, peak {peak}");
    assert_eq!(samples[..1000], Driver::running(&noise(1)).samples(1000));
    assert_ne!(samples[..1000], Driver::running(&noise(2)).samples(1000));
}

/// Includes the first burst, which follows the tone of the self-test at another frequency.
#[test]
fn the_first_burst_begins_at_zero() {
    for n in 0..400 {
        let hz = 20e3 + 60.7 * n as f32;
        let mut driver = Driver::running(&changed(|config| config.drive.frequency_hz = hz));
        driver.blocks(10);
        let codes = &driver.clock.analog.codes;
        let size = |n: usize| codes[n].abs_diff(2048);
        // Find a sample above the amplitude of the self-test, then go back to the last one within
        // the DC correction.
        let loud = (0..codes.len()).find(|&n| size(n) > 600).unwrap();
        let first = (0..loud).rev().find(|&n| size(n) <= 33).unwrap() + 1;
        assert!(f64::from(size(first)) <= largest_step(hz.into(), 2040.0) + 33.0, "{hz} Hz: {}", size(first));
    }
}

/// Returns the largest step between neighbouring samples of a tone of this frequency and amplitude,
/// with rounding.
fn largest_step(hz: f64, amplitude: f64) -> f64 {
    amplitude * 2.0 * (std::f64::consts::PI * hz * 1e-6).sin() + 1.0
}

#[test]
fn frequency_amplitude_direction_change_with_continuous_phase() {
    let mut driver = Driver::running(&changed(|config| config.lanes = 4));
    let mut largest = 0.0f64;
    for (n, hz) in [0.0, 1500.0, -1900.0, 37.5, 1990.0, 0.0].into_iter().enumerate() {
        driver.order(|orders| orders.detune = Hertz(hz));
        let samples = driver.samples(640 + 7 * n);
        largest = samples.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(largest, f64::max);
    }
    assert!(largest <= largest_step(TONE_HZ + 2000.0, 2040.0), "{largest}");
}

/// Checks the played frequency and phase of a chirp through the whole controller, and its
/// continuity.
#[test]
fn a_chirp_is_continuous_and_ends_at_its_frequency() {
    let (start_hz, stop_hz) = (20e3, 200e3);
    for kind in [ChirpKind::Linear, ChirpKind::Exponential] {
        let (then, around) = (Then::Hold, Around::Zero);
        let chirp = Chirp { kind, start_hz, stop_hz, time_s: 0.1, then, around };
        let mut driver = Driver::running(&changed(|config| config.sweep = Sweep::Chirp(chirp)));
        let samples = driver.samples(100_000);
        let report = driver.block();
        assert!((cycles_per_sample(report.tuning_word) * 1e6 - 200e3).abs() < 1e-3, "{kind:?} ends at {}", report.frequency.0);
        // The number of upward zero crossings equals the number of turns of the phase.
        let crossings = samples.windows(2).filter(|pair| pair[0] < 0.0 && pair[1] >= 0.0).count() as f64;
        let turns = match kind {
            ChirpKind::Linear => 0.5 * (20e3 + 200e3) * 0.1,
            ChirpKind::Exponential => (200e3 - 20e3) * 0.1 / 10f64.ln(),
        };
        // The record begins three blocks after the chirp, so it ends three blocks later.
        let expected = turns + (200e3 - 20e3) * 3.0 * 32e-6;
        assert!((crossings - expected).abs() < 1.0, "{kind:?}: {crossings} turns of {expected}");
        let broken = samples.windows(2).any(|pair| (pair[1] - pair[0]).abs() > largest_step(200e3, 2040.0));
        assert!(!broken, "{kind:?}");
    }
}

#[test]
fn an_order_beyond_a_limit_is_limited_and_reported_by_number() {
    let mut driver = Driver::running(&changed(|_| ()));
    driver.order(|orders| orders.detune = Hertz(1e6));
    let report = driver.blocks(2);
    assert_eq!(report.limit.map(u8::from), Some(97));
    assert!((report.frequency.0 - 1.05 * TONE_HZ as f32).abs() < 0.1, "{report:?}");
    driver.order(|orders| (orders.detune, orders.quadrature) = (Hertz(0.0), Some(Turns(0.4))));
    assert_eq!(driver.blocks(2).limit, Some(Limit::QuadratureRequest));
    driver.order(|orders| (orders.quadrature, orders.amplitude) = (None, Some(Amplitude::Volts(1e9))));
    let report = driver.blocks(2);
    assert_eq!(report.limit, Some(Limit::OverVoltageRequest));
    assert!(driver.samples(1000).iter().all(|code| code.abs() <= 2047.0));
    driver.order(|orders| orders.amplitude = None);
    assert_eq!(driver.blocks(2).limit, None);
}

/// A brake has a larger amplitude than the drive it stops, up to the limit. With any order during
/// the brake, every sample stays within the limit.
#[test]
fn no_order_raises_a_brake_above_the_limit() {
    let limited = changed(|config| {
        (config.drive.amplitude, config.limits.voltage_v) = (Amplitude::Volts(3.0), 12.0);
        config.drive.scan_volts = 3.0;
        config.tracking.nominal_c0_f = Some(100e-9);
    });
    for (first, then) in [(3.0, 12.0), (12.0, 3.0), (1.0, 1e9), (3.0, 0.0)] {
        for pause in 1..12 {
            let mut driver = Driver::running(&limited);
            driver.order(|orders| orders.amplitude = Some(Amplitude::Volts(first)));
            driver.blocks(20);
            driver.order(|orders| orders.gate = Gate::Brake);
            driver.blocks(pause);
            driver.order(|orders| orders.amplitude = Some(Amplitude::Volts(then)));
            let samples = driver.samples(3200);
            let most = samples.iter().fold(0.0f64, |most, x| most.max(x.abs()));
            assert!(most <= 1201.0, "{first} V, then {then} V after {pause} blocks: {most} codes");
            assert!(samples[2000..].iter().all(|&x| x == 0.0), "{first} V, then {then} V after {pause} blocks");
        }
    }
    // An order that brakes and lowers the drive at the same time brakes the residual vibration.
    let mut driver = Driver::running(&limited);
    driver.order(|orders| orders.amplitude = Some(Amplitude::Volts(10.0)));
    driver.blocks(20);
    driver.order(|orders| (orders.gate, orders.amplitude) = (Gate::Brake, Some(Amplitude::Volts(1.0))));
    let against = driver.samples(1600).iter().fold(0.0f64, |most, x| most.max(x.abs()));
    assert!(against > 1000.0 && against <= 1201.0, "{against} codes");
}

#[test]
fn invalid_settings_are_refused_with_their_name() {
    let chirp = |start_hz: f32, stop_hz: f32| {
        let (kind, then, around) = (ChirpKind::Linear, Then::Hold, Around::Zero);
        Sweep::Chirp(Chirp { kind, start_hz, stop_hz, time_s: 0.1, then, around })
    };
    let point = |hz: f32, gain: f32| TrimPoint { hz, lanes: [Trim { phase_turns: 0.0, gain }; 4] };
    let refused = |change: &dyn Fn(&mut Config)| match Controller::build(&changed(change)) {
        Err(Error::OutOfRange { parameter, .. }) => parameter,
        other => panic!("{:?}", other.err()),
    };
    assert_eq!(refused(&|config| config.drive.frequency_hz = 460e3), "drive.frequency_hz");
    assert_eq!(refused(&|config| config.sweep = chirp(20e3, 460e3)), "sweep.stop_hz");
    assert_eq!(refused(&|config| config.sweep = chirp(-1e3, 20e3)), "sweep.start_hz");
    assert_eq!(refused(&|config| config.sweep = chirp(20e3, f32::NAN)), "sweep.stop_hz");
    assert_eq!(refused(&|config| config.lanes = 5), "lanes");
    assert_eq!(refused(&|config| (config.lanes, config.front_end.drive_lanes) = (3, 2)), "lanes");
    assert_eq!(refused(&|config| config.phasing.phase_trim_turns = [0.0, 0.6].into_iter().collect()), "phasing.phase_trim_turns");
    assert_eq!(refused(&|config| config.phasing.gain_trim = [2.1].into_iter().collect()), "phasing.gain_trim");
    assert_eq!(refused(&|config| config.phasing.calibration = [point(40e3, -0.1)].into_iter().collect()), "phasing.gain_trim");
    assert_eq!(refused(&|config| config.drive.amplitude = Amplitude::Volts(20.47)), "drive.amplitude_v");
    let backwards = |config: &mut Config| (config.drive.shape, config.drive.noise_band_hz) = (ShapeKind::Noise, (50e3, 30e3));
    assert_eq!(refused(&backwards), "drive.noise_high_hz");
    let contradiction = |change: &dyn Fn(&mut Config)| Controller::build(&changed(change)).err();
    assert_eq!(
        contradiction(&|config| config.phasing.calibration = [point(41e3, 1.0), point(40e3, 1.0)].into_iter().collect()),
        Some(Error::TrimOrder)
    );
    let tracked = |change: fn(&mut Config)| {
        contradiction(&|config| {
            config.tracking.mode = TrackingMode::PhaseLock;
            change(config);
        })
    };
    assert_eq!(tracked(|config| config.drive.shape = ShapeKind::Noise), Some(Error::NoiseWithTracking));
    let swept_noise = |config: &mut Config| (config.drive.shape, config.sweep) = (ShapeKind::Noise, chirp(20e3, 30e3));
    assert_eq!(contradiction(&swept_noise), Some(Error::NoiseWithSweep));
    assert_eq!(
        contradiction(&|config| {
            config.tracking.mode = TrackingMode::PhaseLock;
            config.sweep = chirp(20e3, 30e3);
        }),
        Some(Error::ChirpAgainstTracking)
    );
}
