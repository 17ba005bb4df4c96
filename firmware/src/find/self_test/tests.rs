//! Tests block by block at, below and above each threshold: 0.5 V at 34 kHz on 300 nF, which draw
//! 32 mA; a code is 5 mV or 1 mA.

use super::*;
use crate::board::parameters::tests::config;
use crate::seam::block::Codes;

const MID: u16 = 4096;
/// Susceptance of 300 nF at 34 kHz, S.
const CLAMPED: f32 = 0.064_09;
/// Blocks until the vibration has decayed, plus silent blocks after it.
const SILENT: usize = 3 + 31;
/// Blocks of the tone.
const TONE: usize = 65;

fn config_with(change: impl FnOnce(&mut Config)) -> Config {
    let mut config = config();
    change(&mut config);
    config
}

/// Creates codes around an offset: `pairs` pairs of them are `apart` above and below it.
fn codes(offset: i32, pairs: usize, apart: i32) -> Codes {
    let apart = |n: usize| if n < 2 * pairs { apart * (1 - 2 * (n % 2) as i32) } else { 0 };
    (0..32).map(|n| (i32::from(MID) + offset + apart(n)) as u16).collect()
}

fn quiet() -> SenseBlock {
    SenseBlock { v: codes(0, 0, 0), i: codes(0, 0, 0), ..SenseBlock::default() }
}

/// Creates phasors of this voltage, and of a current that leads it by `lead` degrees.
fn sensed(volts: f32, amperes: f32, lead: f32) -> Sensed {
    let turned = |size: f32, degrees: f32| Phasor::new(size * degrees.to_radians().cos(), size * degrees.to_radians().sin());
    Sensed { v: turned(volts, 70.0), i: turned(amperes, 70.0 + lead) }
}

fn healthy() -> Sensed {
    sensed(0.5, 0.5 * CLAMPED, 90.0)
}

struct Rig {
    test: SelfTest,
    convert: Convert,
    sense: SenseBlock,
    sensed: Sensed,
    block: usize,
}

impl Rig {
    fn new(config: &Config) -> Self {
        let convert = Convert::build(&config.front_end).unwrap();
        Rig { test: SelfTest::build(config), convert, sense: quiet(), sensed: healthy(), block: 0 }
    }

    fn step(&mut self) -> Step {
        self.block += 1;
        self.test.listen(&mut self.convert, &self.sense, &self.sensed, 0.5)
    }

    /// Runs to the first step that is not silence; returns its block and the step.
    fn first_tone(&mut self) -> (usize, Step) {
        loop {
            let step = self.step();
            if step != Step::Silence {
                return (self.block, step);
            }
        }
    }

    /// Runs to the end of the test; returns its block and the last step.
    fn end(&mut self) -> (usize, Step) {
        loop {
            let step = self.step();
            if !matches!(step, Step::Silence | Step::Tone { .. }) {
                return (self.block, step);
            }
        }
    }
}

/// Returns the last step of a test with these phasors.
fn judged(config: &Config, sensed: Sensed) -> Step {
    let mut rig = Rig::new(config);
    rig.sensed = sensed;
    rig.end().1
}

const DONE: Step = Step::Done { volts: 0.0 };
const IMPLAUSIBLE: Step = Step::Failed(Fault::SensorImplausible);

#[test]
fn silence_then_a_tone_and_again_after_a_restart() {
    let mut rig = Rig::new(&config());
    for _ in 0..2 {
        assert!((0..SILENT).all(|_| rig.step() == Step::Silence));
        for n in 0..TONE {
            let Step::Tone { offset_hz, volts, lane: 0 } = rig.step() else { panic!("no tone") };
            // It rises and falls in steps of an eighth.
            let eighths = (n + 1).min(TONE - n).min(8);
            assert!((offset_hz + 6000.0).abs() < 0.1 && volts == 0.5 * eighths as f32 / 8.0, "{n}: {offset_hz} {volts}");
        }
        assert_eq!(rig.step(), DONE);
        rig.test.restart();
    }
}

#[test]
fn waits_until_the_vibration_is_a_quarter_of_the_tone() {
    let first = |pairs: usize, apart: i32, change: fn(&mut Config)| {
        let mut rig = Rig::new(&config_with(change));
        rig.sense.i = codes(0, pairs, apart);
        rig.first_tone()
    };
    // The threshold is 8.01 mA rms; a larger steady value is noise after two windows of 16 blocks.
    let by_noise = 32 + 32;
    assert_eq!((first(16, 8, |_| {}).0, first(16, 9, |_| {}).0), (SILENT + 1, by_noise));
    // Noise is below 16 codes. A longer ring-down than three times the nominal Q allows is a fault.
    assert_eq!(first(16, 15, |_| {}).0, by_noise);
    assert_eq!(first(16, 16, |_| {}), (1498, IMPLAUSIBLE));
    // At four times the nominal Q the ring-down may be longer; a window is half a time constant.
    assert_eq!(first(16, 16, |config| config.tracking.nominal_q = 200.0), (2990, IMPLAUSIBLE));
    assert_eq!(first(16, 9, |config| config.tracking.nominal_q = 200.0).0, 48 + 32);
    // Without a nominal capacitance, two codes count as quiet.
    let unknown = |config: &mut Config| config.tracking.nominal_c0_f = None;
    assert_eq!((first(15, 2, unknown).0, first(16, 2, unknown).0), (SILENT + 1, by_noise));
}

#[test]
fn decaying_current_is_not_noise() {
    // The mean square falls from 99 to 90, or to 81, which is below 0.85 times 99.
    for (pairs, blocks) in [(10, 32), (9, 48)] {
        let mut rig = Rig::new(&config());
        rig.sense.i = codes(0, 11, 12);
        (0..16).for_each(|_| assert_eq!(rig.step(), Step::Silence));
        rig.sense.i = codes(0, pairs, 12);
        assert_eq!(rig.first_tone().0, blocks + 32, "{pairs}");
    }
}

#[test]
fn a_ring_down_ends_as_soon_as_it_is_quiet() {
    let mut rig = Rig::new(&config());
    rig.sense.i = codes(0, 16, 100);
    (0..777).for_each(|_| assert_eq!(rig.step(), Step::Silence));
    rig.sense = quiet();
    assert_eq!(rig.first_tone().0, 777 + 1 + 32);
}

#[test]
fn offset_up_to_a_twentieth_is_removed_else_a_fault() {
    // The limit is 204.75 codes.
    for (offset, fits) in [(204, true), (-204, true), (205, false), (-205, false)] {
        for voltage in [true, false] {
            let mut rig = Rig::new(&config());
            *(if voltage { &mut rig.sense.v } else { &mut rig.sense.i }) = codes(offset, 0, 0);
            let (block, step) = rig.first_tone();
            assert_eq!((block, step == IMPLAUSIBLE), (SILENT + 1, !fits), "{offset}");
            let moved = if fits { offset as f32 } else { 0.0 };
            let expected = if voltage { (moved, 0.0) } else { (0.0, moved) };
            assert_eq!((rig.convert.v.zero() - 4096.0, rig.convert.i.zero() - 4096.0), expected);
        }
    }
}

#[test]
fn noise_is_measured_in_the_second_half_of_the_silence() {
    let mut rig = Rig::new(&config());
    (rig.sense.v, rig.sense.i) = (codes(0, 16, 5), codes(0, 16, 6));
    (0..3 + 16).for_each(|_| assert_eq!(rig.step(), Step::Silence));
    (rig.sense.v, rig.sense.i) = (codes(0, 16, 2), codes(0, 16, 3));
    (0..15).for_each(|_| assert_eq!(rig.step(), Step::Silence));
    assert_ne!(rig.step(), Step::Silence);
    (rig.sense.v, rig.sense.i) = (codes(0, 16, 50), codes(0, 16, 60));
    assert_eq!(rig.end().1, DONE);
    assert_eq!(rig.test.noise(), (4.0, 9.0));
    rig.test.restart();
    assert_eq!(rig.test.noise(), (0.0, 0.0));
}

#[test]
fn voltage_must_match_the_played_one() {
    let of = |volts: f32, amperes: f32| judged(&config(), sensed(volts, amperes, 90.0));
    assert_eq!((of(0.749, 0.05), of(0.751, 0.05)), (DONE, IMPLAUSIBLE));
    // Half an ohm of source resistance drops 12 mV at 25 mA, and 60 mV at 120 mA.
    assert_eq!((of(0.328, 0.025), of(0.322, 0.025)), (DONE, IMPLAUSIBLE));
    assert_eq!((of(0.297, 0.12), of(0.290, 0.12)), (DONE, IMPLAUSIBLE));
    assert_eq!(of(0.0, 0.0), IMPLAUSIBLE);
}

#[test]
fn current_must_match_the_nominal_capacitance() {
    let of = |part: f32| judged(&config(), sensed(0.5, part * 0.5 * CLAMPED, 90.0));
    assert_eq!((of(7.98), of(8.02)), (DONE, Step::Failed(Fault::LoadShorted)));
    assert_eq!((of(1.0 / 2.99), of(1.0 / 3.01)), (DONE, Step::Failed(Fault::LoadOpen)));
    // A short also reduces the voltage. A voltage that is too high is a failed channel.
    assert_eq!(judged(&config(), sensed(0.1, 0.6, 90.0)), Step::Failed(Fault::LoadShorted));
    assert_eq!(judged(&config(), sensed(0.8, 0.6, 90.0)), IMPLAUSIBLE);
}

/// Another resonance near the first tone looks like a short; 28 kHz, far from it, tells them apart.
#[test]
fn too_much_current_is_decided_by_a_second_tone() {
    for (part, expected) in [(7.98, DONE), (8.02, Step::Failed(Fault::LoadShorted))] {
        let mut rig = Rig::new(&config());
        rig.sensed = sensed(0.5, 20.0 * 0.5 * CLAMPED, 90.0);
        (0..SILENT + TONE).for_each(|_| assert!(matches!(rig.step(), Step::Silence | Step::Tone { .. })));
        rig.sensed = sensed(0.5, part * 0.5 * CLAMPED * 0.7 / 0.85, 90.0);
        let Step::Tone { offset_hz, .. } = rig.step() else { panic!("no second tone") };
        assert!((offset_hz + 12_000.0).abs() < 0.1, "{offset_hz}");
        assert_eq!(rig.end(), (SILENT + 2 * TONE + 1, expected));
        // After a restart the first tone is driven again.
        rig.test.restart();
        let Step::Tone { offset_hz, .. } = rig.first_tone().1 else { panic!("no tone") };
        assert!((offset_hz + 6_000.0).abs() < 0.1, "{offset_hz}");
    }
}

#[test]
fn short_is_detected_in_its_first_block() {
    let test = SelfTest::build(&config());
    let is_short = |part: f32, played: f32| test.is_short(&sensed(0.1, part * 0.5 * CLAMPED, 30.0), played);
    assert_eq!([is_short(7.98, 0.5), is_short(8.02, 0.5), is_short(8.02, 0.6)], [false, true, false]);
}

#[test]
fn without_a_nominal_capacitance_it_is_measured() {
    let config = config_with(|config| config.tracking.nominal_c0_f = None);
    let omega = core::f32::consts::TAU * 34e3;
    let of = |farad: f32| {
        let mut rig = Rig::new(&config);
        rig.sensed = sensed(0.4, 0.4 * omega * farad, 90.0);
        (rig.end().1, rig.test.capacitance_f().unwrap())
    };
    for farad in [0.11e-9, 1e-9, 3e-6, 19e-6] {
        let (step, found) = of(farad);
        assert!(step == DONE && (found / farad - 1.0).abs() < 1e-4, "{farad}: {step:?}, {found}");
    }
    assert_eq!(of(0.09e-9).0, Step::Failed(Fault::LoadOpen));
    assert_eq!(of(21e-6).0, Step::Failed(Fault::LoadShorted));
    assert_eq!(SelfTest::build(&config_with(|_| {})).capacitance_f(), None);
}

#[test]
fn sixteen_blocks_before_the_tone_falls_are_measured() {
    for (early, expected) in [(TONE - 24, DONE), (TONE - 23, Step::Failed(Fault::LoadOpen))] {
        let mut rig = Rig::new(&config());
        (0..SILENT).for_each(|_| assert_eq!(rig.step(), Step::Silence));
        // No current during the ring-up; then a little more than a third of the nominal current.
        rig.sensed = sensed(0.5, 0.0, 90.0);
        (0..early).for_each(|_| assert!(matches!(rig.step(), Step::Tone { .. })));
        rig.sensed = sensed(0.5, 0.5 * CLAMPED / 2.95, 90.0);
        assert_eq!(rig.end(), (SILENT + TONE + 1, expected), "{early}");
    }
}

#[test]
fn lagging_current_is_a_swapped_pair_after_four_blocks() {
    let swapped = |sensed: Sensed| {
        let mut rig = Rig::new(&config());
        rig.sensed = sensed;
        let (block, step) = rig.end();
        assert!(step != Step::Failed(Fault::SenseSwapped) || block == 40, "{block}");
        step == Step::Failed(Fault::SenseSwapped)
    };
    let lags = |degrees: f32| swapped(sensed(0.5, 0.032, -degrees));
    assert_eq!([-90.0, 0.0, 44.0, 46.0, 90.0, 134.0, 136.0].map(lags), [false, false, false, true, true, true, false]);
    // The phase of a mean of less than 1.25 codes, four of the full tone, is not judged.
    let of = |volts: f32, amperes: f32| swapped(sensed(volts, amperes, -90.0));
    assert_eq!([of(0.006, 0.01), of(0.0065, 0.01), of(0.5, 0.0012), of(0.5, 0.0013)], [false, true, false, true]);
}

#[test]
fn phase_is_averaged_over_the_first_four_blocks() {
    let mut rig = Rig::new(&config());
    // The tone is measured two blocks after the order; one lagging block of four is ignored.
    (0..SILENT + 2).for_each(|_| assert!(!matches!(rig.step(), Step::Failed(_))));
    rig.sensed = sensed(0.5, 0.032, -90.0);
    assert!(matches!(rig.step(), Step::Tone { .. }));
    rig.sensed = healthy();
    assert_eq!(rig.end().1, DONE);
}
