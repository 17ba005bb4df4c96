//! From a configuration to a controller, by value or where it is to stay.
//!
//! A controller takes 10 KB, half of them the scan's. Passed on by value it stands on the stack as often as it is passed on; what is refused, and
//! what is large, are therefore built apart: first all that can be refused, which is small, and then a controller that cannot be.

use core::mem::MaybeUninit;

use super::edges::{self, Edges};
use super::{Controller, Played};
use crate::amplitude::AmplitudeLoop;
use crate::belt::Belt;
use crate::block::{Amplitude, LATENCY_BLOCKS};
use crate::burst::Burst;
use crate::calibrate::Calibrate;
use crate::clamped::PowerOn;
use crate::clamped::online::Online;
use crate::config::{Config, ShapeKind, Sweep as SweepKind, TrackingMode};
use crate::convert::Convert;
use crate::error::Error;
use crate::friction::FrictionSwitch;
use crate::guard::Guard;
use crate::nco::{Nco, Stretch};
use crate::phasing::Phasing;
use crate::restraint::Restraint;
use crate::scan::Scan;
use crate::self_test::SelfTest;
use crate::shape::Shape;
use crate::shaper::Shaper;
use crate::supervisor::{Acquisition, Supervisor};
use crate::sweep::Sweep;
use crate::tracker::Tracker;
use crate::tracker::identified::Learning;

/// What a configuration may be refused for.
struct Parts {
    sweep: Sweep,
    convert: Convert,
    shape: Shape,
    phasing: Phasing,
    burst: Burst,
    restraint: Option<Restraint>,
    belt: Belt,
    guard: Guard,
    tracker: Tracker,
    amplitude: AmplitudeLoop,
    friction: Option<FrictionSwitch>,
}

impl Controller {
    /// Checks a configuration and builds its controller. Names the parameter that is out of range.
    pub fn build(config: &Config) -> Result<Self, Error> {
        Parts::build(config).map(|parts| Controller::of(config, parts))
    }

    /// Whether a controller can be built of it.
    pub fn check(config: &Config) -> Result<(), Error> {
        Parts::build(config).map(drop)
    }

    /// Builds it where it is to stay: it passes over the stack once at most.
    #[inline(never)]
    pub fn build_in<'a>(place: &'a mut MaybeUninit<Self>, config: &Config) -> Result<&'a mut Self, Error> {
        let parts = Parts::build(config)?;
        Ok(place.write(Controller::of(config, parts)))
    }

    // Not inlined, as neither are the others: then each part is written where it is to stay.
    #[inline(never)]
    fn of(config: &Config, parts: Parts) -> Self {
        let Parts { sweep, convert, shape, phasing, burst, restraint, belt, guard, tracker, amplitude, friction } = parts;
        let tone = Stretch { word: sweep.hold.word(), ..Stretch::default() };
        Controller {
            samples: config.block_samples.into(),
            convert,
            shape,
            phasing,
            amplitude_asked: config.drive.amplitude,
            nominal_periods: config.tracking.nominal_q / core::f32::consts::PI,
            nominal_lm_h: config.tracking.nominal_lm_h,
            scan_volts: config.drive.scan_volts,
            braked_volts: 0.0,
            edges: Edges::build(config),
            block: 0,
            nco: Nco::default(),
            burst,
            restraint,
            shaper: Shaper::build(config),
            played: [Played { tone, relative: 1.0, flat: true, pure: true, ..Played::default() }; LATENCY_BLOCKS],
            belt,
            guard,
            supervisor: Supervisor::default(),
            self_test: SelfTest::build(config),
            calibrate: Calibrate::build(config),
            acquisition: Acquisition::of(config.tracking.mode),
            power_on: PowerOn::build(config),
            calibrates_again: false,
            online: Online::build(config),
            probe_hz: 0.0,
            tracker,
            amplitude,
            friction,
            transducer: None,
            learning: Learning::default(),
            learned: 0,
            // Last: what is built after it would keep the compiler from building it in its place.
            scan: Scan::build(config, &sweep.hold),
            sweep,
        }
    }
}

impl Parts {
    #[inline(never)]
    fn build(config: &Config) -> Result<Self, Error> {
        config.check_ranges()?;
        let tracked = config.tracking.mode != TrackingMode::Off;
        if matches!(config.drive.amplitude, Amplitude::MotionalCurrent(_)) && !tracked {
            return Err(Error::CurrentWithoutTracking);
        }
        if config.drive.shape == ShapeKind::Noise && tracked {
            return Err(Error::NoiseWithTracking);
        }
        if config.drive.shape == ShapeKind::Noise && config.sweep != SweepKind::Hold {
            return Err(Error::NoiseWithSweep);
        }
        edges::check(config)?;
        let sweep = Sweep::build(config)?;
        let block_s = f32::from(config.block_samples) / config.sample_hz;
        let mut convert = Convert::build(&config.front_end)?;
        convert.i.set_limit(config.limits.current_a);
        Ok(Parts {
            sweep,
            convert,
            shape: Shape::build(config)?,
            phasing: Phasing::build(config)?,
            burst: Burst::build(&config.burst, config.drive.frequency_hz, config.sample_hz)?,
            restraint: config.restraint.as_ref().map(|restraint| Restraint::build(restraint, block_s)).transpose()?,
            belt: Belt::build(config, block_s),
            guard: Guard::build(config, block_s)?,
            tracker: Tracker::build(config, block_s)?,
            amplitude: AmplitudeLoop::build(config, block_s)?,
            friction: FrictionSwitch::build(config, block_s)?,
        })
    }
}
