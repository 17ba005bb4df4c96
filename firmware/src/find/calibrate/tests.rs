use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128StarStar;

use super::*;
use crate::seam::block::Amplitude;
use crate::seam::config::{
    Burst, Direction, Drive, FrontEnd, HeatSink, Limits, Link, Phasing as PhasingConfig, Supply, Sweep, Thermometer, Tracking,
    TrackingMode,
};

const SCAN_VOLTS: f32 = 3.0;

fn config(lanes: u8) -> Config {
    Config {
        sample_hz: 1e6,
        block_samples: 32,
        lanes,
        front_end: FrontEnd::OF_TESTS,
        drive: Drive::sine(40_000.0, Amplitude::Volts(3.0), SCAN_VOLTS),
        sweep: Sweep::Hold,
        phasing: PhasingConfig::default(),
        burst: Burst::default(),
        tracking: Tracking {
            mode: TrackingMode::Off,
            span: 0.05,
            bandwidth_hz: 100.0,
            nominal_c0_f: Some(200e-9),
            ..Tracking::new(50.0)
        },
        thermometer: Thermometer::default(),
        heat_sink: HeatSink::default(),
        supply: Supply::default(),
        limits: Limits { voltage_v: 12.0, ..Limits::default() },
        friction: None,
        restraint: None,
        link: Link::default(),
    }
}

/// Errors of the lanes: a delay, a gain, and one pole.
#[derive(Clone, Copy)]
struct Errors {
    delay_s: [f32; MAX_LANES],
    gain: [f32; MAX_LANES],
    pole_hz: [f32; MAX_LANES],
}

const NONE: Errors = Errors { delay_s: [0.0; 4], gain: [1.0; 4], pole_hz: [1e9; 4] };
/// Errors of the generator in the thesis: 5 to 10 degrees at 40 kHz, and several per cent.
const THESIS: Errors =
    Errors { delay_s: [0.1e-6, 0.45e-6, 0.8e-6, -0.3e-6], gain: [1.0, 1.04, 0.95, 1.07], pole_hz: [400e3, 500e3, 350e3, 600e3] };

impl Errors {
    fn at(&self, lane: usize, hz: f32) -> Phasor {
        let pole = hz / self.pole_hz[lane];
        let turns = -hz * self.delay_s[lane] - libm::atanf(pole) / core::f32::consts::TAU;
        sine::rotation((f64::from(turns) * 18_446_744_073_709_551_616.0) as i64 as u64) * self.gain[lane]
            / fpu::sqrtf(1.0 + pole * pole)
    }
}

/// Amplifiers with their multiplexer; computes the phasors of each block, with noise in codes.
struct Bank {
    errors: Errors,
    codes: f32,
    chance: Xoshiro128StarStar,
    /// Lane that cannot be measured.
    unmeasured: Option<usize>,
    /// Relative pull on the source by a load that rings up with twice the nominal time constant.
    pull: f32,
    /// Frequency that is ringing up, Hz, and the number of blocks so far.
    rung: (f32, u32),
}

impl Bank {
    fn new(errors: Errors, codes: f32) -> Self {
        Bank { errors, codes, chance: Xoshiro128StarStar::seed_from_u64(1), unmeasured: None, pull: 0.0, rung: (0.0, 0) }
    }

    fn update(&mut self, phasing: &mut Phasing, quadrature: f32, hz: f32, lane: usize) -> Phasor {
        use rand_core::Rng;
        // The sum of twelve uniform numbers is nearly Gaussian. A block of 32 samples has a noise
        // of sqrt(2 / 32) codes in each component of its phasor.
        let mut noise = || (0..12).map(|_| self.chance.next_u32() as f32 / 4_294_967_296.0).sum::<f32>() - 6.0;
        let noise = Phasor::new(noise(), noise()) * (self.codes * 0.01 * 0.25);
        let row = phasing.lanes(hz, quadrature)[lane].row;
        self.rung = (hz, if hz == self.rung.0 { self.rung.1 + 1 } else { 0 });
        // Q 100 at 40 kHz: 0.796 ms, in blocks of 32 us.
        let pulled = 1.0 - self.pull * (1.0 - libm::expf(-(self.rung.1 as f32) / 24.87));
        let measured = if self.unmeasured == Some(lane) {
            Phasor::default()
        } else {
            row * self.errors.at(lane, hz) * (SCAN_VOLTS * pulled)
        };
        measured + noise
    }
}

/// Runs a calibration to its end; returns it, its last step, and the number of blocks.
fn calibrate(config: &Config, phasing: &mut Phasing, bank: &mut Bank) -> (Calibrate, Step, u32) {
    let mut calibrate = Calibrate::build(config);
    let quadrature = phasing.quadrature(None).0;
    let mut coming = std::collections::VecDeque::from([Phasor::default(); LATENCY_BLOCKS]);
    for block in 1..1_000_000 {
        let sensed = Sensed { v: coming.pop_front().unwrap(), ..Sensed::default() };
        match calibrate.listen(phasing, &sensed) {
            Step::Tone { offset_hz, lane, .. } => {
                let hz = config.drive.frequency_hz + offset_hz;
                coming.push_back(bank.update(phasing, quadrature, hz, lane.into()));
            }
            end => return (calibrate, end, block),
        }
    }
    panic!("no end");
}

/// Returns the largest remaining error of any lane over the window: degrees, and relative gain.
fn residual(config: &Config, phasing: &mut Phasing, bank: &Bank, quadrature: f32) -> (f32, f32) {
    let offsets = Phasing::offsets(quadrature);
    let window = config.tracking.span * config.drive.frequency_hz;
    let mut worst = (0.0_f32, 0.0_f32);
    for n in -100..=100 {
        let hz = config.drive.frequency_hz + window * n as f32 / 100.0;
        let lanes = phasing.lanes(hz, quadrature).clone();
        let response = |lane: usize| lanes[lane].row * bank.errors.at(lane, hz);
        for (lane, &offset) in offsets.iter().enumerate().take(lanes.len()) {
            let error = response(lane) / response(0) * sine::rotation(u64::from(offset) << 32).conj();
            worst = (worst.0.max(argument(error).degrees().abs()), worst.1.max((magnitude(error) - 1.0).abs()));
        }
    }
    worst
}

#[test]
fn lane_errors_of_the_thesis_are_trimmed_in_one_code_of_noise() {
    for quadrature in [Direction::Forward, Direction::Reverse] {
        for span in [0.01, 0.05, 0.2] {
            let mut config = config(4);
            config.phasing.direction = quadrature;
            config.tracking.span = span;
            let mut phasing = Phasing::build(&config).unwrap();
            let mut bank = Bank::new(THESIS, 1.0);
            let quadrature = phasing.quadrature(None).0;
            let before = residual(&config, &mut phasing, &bank, quadrature);
            assert!(before.0 > 9.0 && before.1 > 0.05, "{before:?}");
            let (_, end, _) = calibrate(&config, &mut phasing, &mut bank);
            assert_eq!(end, Step::Done { volts: 0.0 });
            let after = residual(&config, &mut phasing, &bank, quadrature);
            std::println!("span {span}: {before:?} -> {after:?}");
            // Noise of 0.01 %, and the curvature of four poles between the frequencies.
            assert!(after.0 < 0.02 && after.1 < 5e-4, "{span}: {after:?}");
        }
    }
}

#[test]
fn trims_only_reduce_and_add_to_the_configured_trims() {
    let mut config = config(4);
    config.phasing.phase_trim_turns = [0.0, 0.01, -0.01, 0.02].into_iter().collect();
    config.phasing.gain_trim = [1.0, 1.1, 0.9, 1.0].into_iter().collect();
    let mut phasing = Phasing::build(&config).unwrap();
    let mut bank = Bank::new(THESIS, 0.0);
    assert_eq!(calibrate(&config, &mut phasing, &mut bank).1, Step::Done { volts: 0.0 });
    for point in phasing.calibration() {
        let largest = point.lanes.iter().map(|trim| trim.gain).fold(0.0, f32::max);
        assert_eq!(largest, 1.0);
    }
    let after = residual(&config, &mut phasing, &bank, 0.25);
    assert!(after.0 < 0.02 && after.1 < 5e-4, "{after:?}");
}

#[test]
fn too_large_an_error_is_a_fault_and_keeps_the_trims() {
    let cases: [fn(&mut Bank); 6] = [
        |bank| bank.errors.delay_s[2] = 4e-6,
        |bank| bank.errors.gain[1] = 0.65,
        |bank| bank.errors.gain[3] = 1.5,
        |bank| bank.errors.gain[0] = 0.6,
        |bank| bank.unmeasured = Some(3),
        |bank| bank.unmeasured = Some(0),
    ];
    for (n, change) in cases.into_iter().enumerate() {
        let config = config(4);
        let mut phasing = Phasing::build(&config).unwrap();
        let trims: LaneTrims = [TrimPoint { hz: 40e3, lanes: [Trim { phase_turns: 0.01, gain: 0.9 }; 4] }].into_iter().collect();
        phasing.trim(trims.clone());
        let mut bank = Bank::new(NONE, 0.0);
        change(&mut bank);
        let (calibrate, end, _) = calibrate(&config, &mut phasing, &mut bank);
        assert_eq!((end, calibrate.completed()), (Step::Failed(Fault::LaneImplausible), 0), "{n}");
        assert_eq!(*phasing.calibration(), trims, "{n}");
    }
}

#[test]
fn trims_that_do_not_verify_are_a_fault() {
    // The amplifier changes between the passes.
    let config = config(2);
    let mut phasing = Phasing::build(&config).unwrap();
    let mut calibrate = Calibrate::build(&config);
    let mut bank = Bank::new(NONE, 0.0);
    let end = (0..100_000).find_map(|_| {
        bank.errors.gain[1] = if phasing.calibration().is_empty() { 1.0 } else { 1.0015 };
        let hz = 40e3 + calibrate.window_hz * POSITIONS[calibrate.point];
        let measured = bank.update(&mut phasing, 0.25, hz, calibrate.lane);
        let step = calibrate.listen(&mut phasing, &Sensed { v: measured, ..Sensed::default() });
        (!matches!(step, Step::Tone { .. })).then_some(step)
    });
    assert_eq!((end, phasing.calibration().len()), (Some(Step::Failed(Fault::LaneImplausible)), 0));
}

#[test]
fn one_lane_needs_no_trims_and_an_abort_leaves_them() {
    let one = config(1);
    let mut phasing = Phasing::build(&one).unwrap();
    let (done, end, blocks) = calibrate(&one, &mut phasing, &mut Bank::new(NONE, 0.0));
    assert_eq!((end, blocks, done.completed(), phasing.calibration().len()), (Step::Done { volts: 0.0 }, 1, 1, 0));

    let two = config(2);
    let mut phasing = Phasing::build(&two).unwrap();
    let trims: LaneTrims = [TrimPoint { hz: 40e3, lanes: [Trim { phase_turns: 0.01, gain: 0.9 }; 4] }].into_iter().collect();
    phasing.trim(trims.clone());
    let mut calibrate = Calibrate::build(&two);
    assert_eq!(
        calibrate.listen(&mut phasing, &Sensed::default()),
        Step::Tone { offset_hz: 2000.0 * POSITIONS[0], volts: SCAN_VOLTS, lane: 0 }
    );
    assert!(phasing.calibration().is_empty());
    calibrate.abandon(&mut phasing);
    assert_eq!(*phasing.calibration(), trims);
}

#[test]
fn one_code_of_noise_leaves_the_stated_error() {
    let (mut turns, mut gains, mut count) = (0.0, 0.0, 0.0);
    for seed in 0..10 {
        let config = config(4);
        let mut phasing = Phasing::build(&config).unwrap();
        let mut bank = Bank::new(NONE, 1.0);
        bank.chance = Xoshiro128StarStar::seed_from_u64(seed);
        assert_eq!(calibrate(&config, &mut phasing, &mut bank).1, Step::Done { volts: 0.0 });
        for trims in phasing.calibration().iter().map(|point| &point.lanes) {
            for trim in &trims[1..] {
                turns += trim.phase_turns * trim.phase_turns;
                gains += (trim.gain / trims[0].gain - 1.0) * (trim.gain / trims[0].gain - 1.0);
                count += 1.0;
            }
        }
    }
    let (degrees, part) = (360.0 * fpu::sqrtf(turns / count), fpu::sqrtf(gains / count));
    std::println!("rms of the noise: {degrees:.4} degrees, {:.4} %", 100.0 * part);
    // From 150 samples of each: within a fifth.
    assert!(
        (0.8..1.2).contains(&(part / NOISE_REL)) && (0.8..1.2).contains(&(degrees.to_radians() / NOISE_REL)),
        "{degrees} {part}"
    );
}

#[test]
fn interpolation_error_of_a_pole_is_small() {
    let mut config = config(2);
    config.tracking.span = 0.2;
    let mut phasing = Phasing::build(&config).unwrap();
    let mut bank = Bank::new(Errors { pole_hz: [1e9, 80e3, 1e9, 1e9], ..NONE }, 0.0);
    assert_eq!(calibrate(&config, &mut phasing, &mut bank).1, Step::Done { volts: 0.0 });
    let after = residual(&config, &mut phasing, &bank, 0.25);
    std::println!("one pole at twice the frequency, 20 % window: {:.3} degrees, {:.3} %", after.0, 100.0 * after.1);
    assert!(after.0 < 0.025 && after.1 < 2.2e-4, "{after:?}");
}

#[test]
fn a_load_of_twice_the_nominal_q_does_not_matter() {
    let config = config(2);
    let mut phasing = Phasing::build(&config).unwrap();
    let mut bank = Bank::new(NONE, 0.0);
    bank.pull = 0.3;
    assert_eq!(calibrate(&config, &mut phasing, &mut bank).1, Step::Done { volts: 0.0 });
    let after = residual(&config, &mut phasing, &bank, 0.25);
    std::println!("a pull of 30 % that rings up twice as slowly as nominal: {:.1e}", after.1);
    // exp(-8) of the pull in the first averaged block, less on average.
    assert!(after.1 < 0.3 * 3.4e-4, "{after:?}");
}
