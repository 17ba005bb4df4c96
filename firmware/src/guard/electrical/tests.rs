//! Tests at, below and above each threshold, and of the fault that is reported if two apply. The
//! drive is 3 V on 300 nF; a code is 5 mV or 1 mA, and the current limit is 3 A.

use super::*;
use crate::board::parameters::tests::config;
use crate::seam::phasor::Phasor;

const MID: u16 = 4096;
const ALL: Suspect = Suspect { v: true, i: true, unexplained: false, distorted: false };

/// The checks, the scale of the codes, and the last block.
struct Rig {
    electrical: Electrical,
    convert: Convert,
    sense: SenseBlock,
    sensed: Sensed,
}

impl Rig {
    fn new(config: &Config) -> Self {
        // Codes that only vary: the test sets the phasors.
        let codes: Codes = (0..config.block_samples).map(|n| config.front_end.sense_mid_code + n % 2).collect();
        Rig {
            electrical: Electrical::build(config),
            convert: Convert::build(&config.front_end).unwrap(),
            sense: SenseBlock { v: codes.clone(), i: codes, ..SenseBlock::default() },
            sensed: Sensed { v: Phasor::new(3.0, 0.0), i: Phasor::new(0.0, 0.226) },
        }
    }

    fn block(&mut self, volts: Option<f32>, suspect: Suspect) -> Option<Fault> {
        self.electrical.inspect(&self.convert, &self.sense, &self.sensed, volts, suspect)
    }

    /// Returns the first fault in blocks played with 3 V, and the number of blocks until it.
    fn found(&mut self) -> Option<(usize, Fault)> {
        (1..100).find_map(|n| Some((n, self.block(Some(3.0), Suspect::default())?)))
    }

    /// Returns the same for these amplitudes.
    fn found_of(volts: f32, amperes: f32) -> Option<(usize, Fault)> {
        let mut rig = Rig::new(&config());
        // The phases do not matter.
        rig.sensed = Sensed { v: Phasor::new(0.6, 0.8) * volts, i: Phasor::new(-0.8, 0.6) * amperes };
        rig.found()
    }
}

/// Returns the test configuration with a change.
fn with(change: impl FnOnce(&mut Config)) -> Config {
    let mut config = config();
    change(&mut config);
    config
}

/// Returns the fault of a block in which the first `codes` codes of current or voltage are `code`.
fn of_codes(config: &Config, current: bool, codes: usize, code: u16, suspect: Suspect) -> Option<Fault> {
    let mut rig = Rig::new(config);
    let channel = if current { &mut rig.sense.i } else { &mut rig.sense.v };
    channel[..codes].fill(code);
    rig.block(None, suspect)
}

#[test]
fn two_samples_over_the_current_limit_are_a_fault() {
    let of = |codes, code| of_codes(&config(), true, codes, code, ALL);
    for (at, over) in [(MID + 2999, MID + 3001), (MID - 2999, MID - 3001)] {
        assert_eq!(of(32, at), None);
        assert_eq!((of(1, over), of(2, over), of(32, over)), (None, Some(Fault::OverCurrent), Some(Fault::OverCurrent)));
    }
    // A channel that the lock-in does not suspect is not inspected.
    assert_eq!(of_codes(&config(), true, 2, MID + 3001, Suspect { i: false, ..ALL }), None);
}

#[test]
fn more_than_an_eighth_of_samples_at_an_end_is_clipping() {
    for end in [0, 8190] {
        let of = |codes| of_codes(&config(), false, codes, end, ALL);
        assert_eq!((of(4), of(5)), (None, Some(Fault::SenseSaturated)));
        assert_eq!(of_codes(&config(), false, 5, end, Suspect { v: false, ..ALL }), None);
        // A clipped current is over the limit, which is nearer than the end of the range.
        assert_eq!(of_codes(&config(), true, 5, end, ALL), Some(Fault::OverCurrent));
    }
}

#[test]
fn with_a_limit_beyond_the_range_clipping_is_the_fault() {
    // The range is 2.048 A to one side.
    for (mid, end) in [(2048, 0), (6142, 8190)] {
        let config = with(|config| (config.front_end.sense_mid_code, config.limits.current_a) = (mid, 2.5));
        let of = |codes, suspect| of_codes(&config, true, codes, end, suspect);
        assert_eq!((of(4, ALL), of(5, ALL)), (None, Some(Fault::SenseSaturated)), "{mid}");
        assert_eq!(of(5, Suspect { i: false, ..ALL }), None);
    }
}

#[test]
fn a_voltage_may_be_off_by_a_factor_of_two_for_seven_blocks() {
    let implausible = Some((8, Fault::SensorImplausible));
    for (volts, expected) in [(1.51, None), (1.49, implausible), (5.98, None), (6.02, implausible)] {
        assert_eq!(Rig::found_of(volts, 0.01), expected, "{volts} V");
    }
}

#[test]
fn a_small_drive_has_the_same_voltage_factor() {
    for (volts, wrong) in [(0.51, false), (0.49, true), (1.99, false), (2.01, true)] {
        let mut rig = Rig::new(&config());
        rig.sensed = Sensed { v: Phasor::new(0.0, 0.4 * volts), i: Phasor::new(0.001, 0.0) };
        assert_eq!((0..20).any(|_| rig.block(Some(0.4), Suspect::default()).is_some()), wrong, "{volts} of the drive");
    }
}

#[test]
fn a_current_explains_a_low_voltage() {
    // Half an ohm takes 2 V at 4 A; half of the remaining 1 V is accepted. From 6 A all 3 V may
    // drop.
    for (volts, amperes, plausible) in
        [(0.51, 4.0, true), (0.49, 4.0, false), (0.05, 5.5, false), (0.0, 6.0, true), (0.0, 7.0, true)]
    {
        assert_eq!(Rig::found_of(volts, amperes).is_none(), plausible, "{volts} V, {amperes} A");
    }
}

#[test]
fn below_a_hundredth_of_the_clamped_current_is_open() {
    let open = Some((8, Fault::LoadOpen));
    // 300 nF take 226 mA from 3 V at 40 kHz.
    for (amperes, expected) in [(2.3e-3, None), (2.22e-3, open), (0.0, open)] {
        assert_eq!(Rig::found_of(3.0, amperes), expected, "{amperes} A");
    }
    // Without a nominal capacitance, that of the smallest transducer counts.
    let least_a = 3.0 * 0.01 * core::f32::consts::TAU * 40e3 * Tracking::CAPACITANCES_F.0;
    for (part, expected) in [(1.02, None), (0.98, open)] {
        let mut rig = Rig::new(&with(|config| config.tracking.nominal_c0_f = None));
        rig.sensed.i = Phasor::new(0.0, part * least_a);
        assert_eq!(rig.found(), expected, "{part}");
    }
}

#[test]
fn a_constant_channel_is_a_fault() {
    let mut rig = Rig::new(&config());
    rig.sense.v.fill(MID + 100);
    assert_eq!(rig.found(), Some((8, Fault::SensorImplausible)));
    let mut rig = Rig::new(&config());
    rig.sense.i.fill(MID + 100);
    assert_eq!(rig.found(), Some((8, Fault::LoadOpen)));
    // A single code that differs shows that the converter works.
    rig = Rig::new(&config());
    (rig.sense.v, rig.sense.i) = (rig.sense.v.iter().map(|_| MID).collect(), rig.sense.i.iter().map(|_| MID).collect());
    (rig.sense.v[31], rig.sense.i[0]) = (MID + 1, MID + 1);
    assert_eq!(rig.found(), None);
}

#[test]
fn one_plausible_block_restarts_the_count() {
    for wrong in
        [Sensed { v: Phasor::new(0.1, 0.0), i: Phasor::new(0.0, 0.2) }, Sensed { v: Phasor::new(3.0, 0.0), i: Phasor::default() }]
    {
        let mut rig = Rig::new(&config());
        let right = rig.sensed;
        assert!(!rig.electrical.is_implausible());
        for _ in 0..20 {
            rig.sensed = wrong;
            for _ in 0..7 {
                assert_eq!(rig.block(Some(3.0), Suspect::default()), None);
                assert!(rig.electrical.is_implausible());
            }
            rig.sensed = right;
            assert_eq!(rig.block(Some(3.0), Suspect::default()), None);
            assert!(!rig.electrical.is_implausible());
        }
        // Edges, whose amplitude is unknown, and silence leave the count unchanged: bursts may be
        // short.
        rig.sensed = wrong;
        for volts in [None, Some(0.0)] {
            rig.electrical = Electrical::build(&config());
            (0..7).for_each(|_| {
                assert_eq!([rig.block(Some(3.0), Suspect::default()), rig.block(volts, Suspect::default())], [None; 2])
            });
            assert_eq!(rig.found().map(|(blocks, _)| blocks), Some(1));
        }
    }
}

#[test]
fn a_drive_of_few_codes_is_not_judged() {
    // 16 codes of the coarser converter: 8 mV a code for the drive, or 20 mV a code for the
    // voltage.
    for (volt_per_lsb, least) in [(0.005, 0.128), (0.02, 0.32)] {
        let mut rig = Rig::new(&with(|config| config.front_end.volt_per_lsb = volt_per_lsb));
        assert!(!rig.electrical.is_judged(least) && rig.electrical.is_judged(1.001 * least), "{least} V");
        rig.sensed = Sensed::default();
        assert!((0..100).all(|_| rig.block(Some(least), Suspect::default()).is_none()));
        assert!((0..100).any(|_| rig.block(Some(1.001 * least), Suspect::default()).is_some()));
    }
}

#[test]
fn reports_of_the_board_are_faults_of_that_block() {
    let of = |trips: Option<Trips>, missed: Option<u32>| {
        let mut rig = Rig::new(&config());
        (rig.sense.slow.trips, rig.sense.slow.missed_blocks) = (trips, missed);
        rig.block(None, Suspect::default())
    };
    let trips = |over_current, amplifier_fault, supply| Some(Trips { over_current, amplifier_fault, supply });
    assert_eq!(of(trips(false, false, false), Some(0)), None);
    assert_eq!(of(trips(true, false, false), None), Some(Fault::OverCurrent));
    assert_eq!(of(trips(false, false, true), None), Some(Fault::AmplifierSupply));
    assert_eq!(of(trips(false, true, false), None), Some(Fault::AmplifierFault));
    // Priority: a lost block, then the amplifier's own fault, then its supply, then over-current.
    assert_eq!(of(trips(true, true, true), None), Some(Fault::AmplifierFault));
    assert_eq!(of(trips(true, false, true), None), Some(Fault::AmplifierSupply));
    assert_eq!(of(trips(true, true, false), None), Some(Fault::AmplifierFault));
    assert_eq!(of(trips(false, true, true), None), Some(Fault::AmplifierFault));
    assert_eq!(of(trips(true, true, true), Some(1)), Some(Fault::LateBlock));
}

#[test]
fn a_cut_block_is_late() {
    for cut in [|sense: &mut SenseBlock| sense.v.truncate(31), |sense: &mut SenseBlock| sense.i.truncate(31)] {
        let mut rig = Rig::new(&config());
        cut(&mut rig.sense);
        assert_eq!(rig.block(None, Suspect::default()), Some(Fault::LateBlock));
    }
}

#[test]
fn of_two_faults_the_cause_is_reported() {
    let trip = Some(Trips { over_current: true, ..Trips::default() });
    // A clipped voltage comes before a trip. Counted faults come last, the voltage before the
    // current.
    let mut rig = Rig::new(&config());
    rig.sense.v[..5].fill(8190);
    rig.sense.slow.trips = trip;
    assert_eq!(rig.block(None, ALL), Some(Fault::SenseSaturated));
    assert_eq!(rig.block(None, Suspect::default()), Some(Fault::OverCurrent));
    assert_eq!(Rig::found_of(0.0, 0.0), Some((8, Fault::SensorImplausible)));
    rig.sensed = Sensed::default();
    assert!((0..20).all(|_| rig.block(Some(3.0), Suspect::default()) == Some(Fault::OverCurrent)));
    rig.sense.slow.trips = None;
    assert_eq!(rig.block(Some(3.0), Suspect::default()), Some(Fault::SensorImplausible));
}

/// Silence leaves the counts unchanged, so that only a new attempt resets them.
#[test]
fn a_new_attempt_forgets_implausible_blocks() {
    let mut rig = Rig::new(&config());
    rig.sensed.v = Phasor::default();
    assert_eq!(rig.found().map(|(_, fault)| fault), Some(Fault::SensorImplausible));
    assert_eq!(rig.block(None, Suspect::default()), Some(Fault::SensorImplausible));
    rig.electrical.begin();
    assert_eq!(rig.block(None, Suspect::default()), None);
}
