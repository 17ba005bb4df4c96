//! Construction of a controller from its configuration, by value or in place.
//!
//! A controller takes 10 KB, half of them for the scan, and each move may copy it on the stack. The
//! build therefore has two parts: first everything that can be refused, which is small; then the
//! rest, which cannot fail.

use core::mem::MaybeUninit;

use super::Controller;
use super::chain::Chain;
use super::stages::Stages;
use super::stages::follow::{Follow, edges};
use crate::act::friction::FrictionSwitch;
use crate::act::restraint::Restraint;
use crate::find::calibrate::Calibrate;
use crate::find::clamped::PowerOn;
use crate::find::lanes::Lanes;
use crate::find::scan::Scan;
use crate::find::self_test::SelfTest;
use crate::generate::amplitude::AmplitudeLoop;
use crate::generate::burst::Burst;
use crate::generate::nco::Nco;
use crate::generate::phasing::Phasing;
use crate::generate::shape::Shape;
use crate::generate::shaper::Shaper;
use crate::generate::signal_generator::{Played, SignalGenerator};
use crate::generate::sweep::Sweep;
use crate::guard::Guard;
use crate::guard::continuity::Continuity;
use crate::guard::supervisor::{Acquisition, Supervisor};
use crate::seam::block::{Amplitude, LATENCY_BLOCKS};
use crate::seam::config::{Config, ShapeKind, Sweep as SweepKind, TrackingMode};
use crate::seam::error::Error;
use crate::sense::belt::Belt;
use crate::sense::convert::Convert;
use crate::track::tracked_transducer::TrackedTransducer;
use crate::track::tracker::Tracker;

/// Parts of a controller for which a configuration may be refused.
struct Parts {
    chain: Chain,
    follow: Follow,
}

impl Controller {
    /// Checks a configuration and builds its controller. Errors name the parameter that is out of
    /// range.
    pub fn build(config: &Config) -> Result<Self, Error> {
        Parts::build(config).map(|parts| Controller::from_parts(config, parts))
    }

    /// Checks a configuration.
    pub(crate) fn check(config: &Config) -> Result<(), Error> {
        Parts::build(config).map(drop)
    }

    /// Builds the controller in `place`, with at most one copy on the stack.
    #[inline(never)]
    pub fn build_in<'a>(place: &'a mut MaybeUninit<Self>, config: &Config) -> Result<&'a mut Self, Error> {
        let parts = Parts::build(config)?;
        Ok(place.write(Controller::from_parts(config, parts)))
    }

    // None of these builders is inlined: then each part is written directly to its place.
    #[inline(never)]
    fn from_parts(config: &Config, Parts { chain, follow }: Parts) -> Self {
        let hold = chain.generator.sweep.hold.clone();
        Controller {
            played: [Played::at_rest(&hold); LATENCY_BLOCKS],
            chain,
            stages: Stages {
                follow,
                self_test: SelfTest::build(config),
                clamped: PowerOn::build(config),
                calibrate: Calibrate::build(config),
                // Last: parts after it would keep the compiler from building it in place.
                scan: Scan::build(config, &hold),
            },
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
        let (shape, phasing) = (Shape::build(config)?, Phasing::build(config)?);
        let burst = Burst::build(&config.burst, config.drive.frequency_hz, config.sample_hz)?;
        let restraint = config.restraint.as_ref().map(|restraint| Restraint::build(restraint, block_s)).transpose()?;
        let (belt, guard) = (Belt::build(config, block_s), Guard::build(config, block_s)?);
        let tracker = Tracker::build(config, block_s)?;
        let amplitude = AmplitudeLoop::build(config, block_s)?;
        let friction = FrictionSwitch::build(config, block_s)?;
        let generator = SignalGenerator {
            nco: Nco::default(),
            samples: config.block_samples.into(),
            sweep,
            amplitude,
            scale: convert.drive.clone(),
            shaper: Shaper::build(config),
            burst,
            phasing,
            shape,
            shaped: false,
            fades: false,
        };
        let supervisor = Supervisor::new(Acquisition::from_tracking(config.tracking.mode));
        let track = TrackedTransducer::build(config, tracker);
        let lanes = Lanes::build(config, block_s);
        let continuity = Continuity::build(config.drive.frequency_hz, block_s, config.block_samples, config.limits.voltage_v);
        let chain = Chain {
            block: 0,
            supervisor,
            track,
            generator,
            convert,
            guard,
            belt,
            restraint,
            calibrates: false,
            lanes,
            continuity,
        };
        Ok(Parts { chain, follow: Follow::build(config, friction) })
    }
}
