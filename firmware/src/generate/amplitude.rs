//! Amplitude control: the drive voltage for the amplitude set point.
//!
//! A voltage is passed on unchanged. A motional current (tip velocity times force factor) is held
//! by a PI loop, however the load changes Q. Near the resonance `I_m = (V / Rm) / (1 + tau s)`, so
//! that `Ki = 2 pi B Rm` and `Kp = Ki tau` give a first-order loop of bandwidth `B`.
//!
//! The loop does not compare the current with the set point itself, but with the response of an
//! undisturbed ring-up (the set point through the same lag). Therefore it holds still through the
//! edges of a burst, and corrects only the effect of the load.

use crate::generate::drive_scale::DriveScale;
use crate::generate::fold_back::FoldBack;
use crate::generate::phasing;
use crate::seam::block::Amplitude;
use crate::seam::compare::{larger, smaller, up_to};
use crate::seam::config::{Config, Drive};
use crate::seam::error::Error;
use crate::seam::fault::Limit;
use crate::seam::phasor::{Phasor, magnitude};
use crate::seam::transducer::Transducer;

/// Bandwidth of the loop, Hz: slower than the phase loop, so that the two do not interact.
const BANDWIDTH_HZ: f32 = 60.0;
/// Part of the set point that a ring-up must have reached before the loop acts.
const MIN_RING_UP_REL: f32 = 0.8;
/// Smallest drive, codes of the drive converter; less is silence. A dither resolves no less, and
/// multiples of the drive stay finite.
const MIN_DRIVE_CODES: f32 = 1.0 / 64.0;
/// Smallest voltage that a new amplitude begins with, relative to the voltage without load.
const MIN_VOLTAGE_REL: f32 = 0.25;
/// Largest relative deviation of a settled amplitude from its set point.
const SETTLED_REL: f32 = 0.01;
/// Number of blocks within that deviation after which an amplitude is settled.
const SETTLED_BLOCKS: u8 = 32;
/// Largest change of the set point from block to block, relative, that a measurement of the clamped
/// branch tolerates: until the current has followed, a step looks like a susceptance of up to twice
/// the change times the motional conductance.
const MAX_CHANGE_REL: f32 = 1e-3;

/// The amplitude control. Without an identified transducer a motional current cannot be held, and
/// plays as silence.
#[derive(Clone, Debug)]
pub(crate) struct AmplitudeLoop {
    /// Voltage limit of the lane with the largest gain, V.
    most_volts: f32,
    /// Voltage limit at a gain of one, V.
    voltage_limit: f32,
    /// Smallest drive, V; less is silence.
    least_volts: f32,
    start_volts: f32,
    block_s: f32,
    ohm: f32,
    lag: f32,
    /// Current that an undisturbed resonance would have now, A.
    expected: f32,
    integral_volts: f32,
    /// Last set point, V or A.
    set_point: f32,
    /// `true` if the last block has changed it by more than [`MAX_CHANGE_REL`].
    stepped: bool,
    volts: f32,
    limited: bool,
    fold_back: FoldBack,
    /// Part of a soft start that passes in a block.
    rise: f32,
    /// Part of a soft start that has passed.
    risen: f32,
    /// Motional current at the beginning of a soft start, A.
    rises_from_a: f32,
    /// Number of blocks in which the amplitude was at the set point.
    settled_blocks: u8,
    /// Last set point, A; zero before the first.
    last_set_point_a: f32,
}

/// Returns the largest amplitude that the voltage limit and the converters allow with trimmed
/// lanes, V.
pub(crate) fn most_volts(config: &Config) -> Result<f32, Error> {
    let converter_v = DriveScale::build(&config.front_end)?.range_v();
    Ok(config.limits.voltage_v.min(converter_v) / phasing::loudest(&config.phasing))
}

impl AmplitudeLoop {
    /// Builds the amplitude control, and checks the amplitude and the limits.
    pub(crate) fn build(config: &Config, block_s: f32) -> Result<Self, Error> {
        let converter_v = DriveScale::build(&config.front_end)?.range_v();
        let voltage_v = most_volts(config)?;
        // Without a lower bound: every limit, however low, allows some drive.
        Drive::SCAN_VOLTS.check_up_to(config.drive.scan_volts, voltage_v)?;
        match config.drive.amplitude {
            Amplitude::Volts(volts) => Drive::AMPLITUDE_V.check_up_to(volts, voltage_v)?,
            Amplitude::MotionalCurrent(amperes) => Drive::MOTIONAL_CURRENT_A.check_up_to(amperes, config.limits.current_a)?,
        };
        Ok(AmplitudeLoop {
            most_volts: voltage_v,
            voltage_limit: config.limits.voltage_v.min(converter_v),
            least_volts: MIN_DRIVE_CODES * config.front_end.drive_volt_per_lsb,
            start_volts: config.drive.scan_volts,
            block_s,
            ohm: 0.0,
            lag: 0.0,
            expected: 0.0,
            integral_volts: config.drive.scan_volts,
            volts: config.drive.scan_volts,
            limited: false,
            fold_back: FoldBack::build(config.limits.current_a),
            rise: if config.drive.soft_start_s > block_s { block_s / config.drive.soft_start_s } else { 1.0 },
            risen: 0.0,
            set_point: 0.0,
            stepped: false,
            rises_from_a: 0.0,
            settled_blocks: 0,
            last_set_point_a: 0.0,
        })
    }

    /// Discards the identified transducer.
    pub(crate) fn restart(&mut self) {
        self.lag = 0.0;
        self.integral_volts = self.start_volts;
        self.settled_blocks = 0;
    }

    /// Sets the largest gain of a lane, to which the voltage limit applies. Returns the limit of
    /// the drive before this gain, V.
    pub(crate) fn set_loudest(&mut self, gain: f32) -> f32 {
        self.most_volts = self.voltage_limit / gain;
        self.most_volts
    }

    /// Starts with an identified transducer that already vibrates with this motional current, A, at
    /// this drive, V.
    // Not inlined: it runs once a lock, and the fast memory of a board has no room for it.
    #[cold]
    #[inline(never)]
    pub(crate) fn seed(&mut self, transducer: &Transducer, motional_current: f32, volts: f32) {
        self.ohm = transducer.rm_ohm;
        self.lag = (self.block_s / transducer.time_constant_s()).min(1.0);
        self.expected = motional_current;
        (self.risen, self.rises_from_a) = (0.0, motional_current);
        self.fold_back.begin(transducer.lm_h, self.block_s, self.lag);
        self.integral_volts = volts;
        self.settled_blocks = 0;
        self.last_set_point_a = 0.0;
    }

    /// Records that a boost has completed the ring-up of the next measured block.
    pub(crate) fn has_rung_up(&mut self) {
        if self.last_set_point_a > 0.0 {
            self.expected = self.last_set_point_a;
        }
    }

    /// Takes the motional current of a block, its drive voltage, V, if that was constant, and the
    /// susceptance of the clamped branch, S.
    #[inline]
    pub(crate) fn watch_current(&mut self, volts: Option<f32>, motional_current: Phasor, susceptance: f32) {
        match volts {
            Some(volts) => self.fold_back.watch(volts, motional_current, susceptance),
            None => self.fold_back.interrupt(),
        }
    }

    /// Updates the drive voltage from the set point, the mean envelope of the measured block, and
    /// its motional current.
    pub(crate) fn update(&mut self, target: Amplitude, envelope: f32, motional_current: Phasor) {
        let target = if self.risen < 1.0 { self.rise_to(target) } else { target };
        let (Amplitude::Volts(now) | Amplitude::MotionalCurrent(now)) = target;
        self.stepped = (now - self.set_point).abs() > MAX_CHANGE_REL * now;
        self.set_point = now;
        let set_point = match target {
            Amplitude::Volts(volts) => {
                self.settled_blocks = SETTLED_BLOCKS;
                volts
            }
            Amplitude::MotionalCurrent(amperes) => self.hold(amperes, envelope, motional_current),
        };
        let most = self.most_now();
        self.limited = set_point > most;
        let volts = up_to(most, set_point);
        self.volts = if volts < self.least_volts { 0.0 } else { volts };
    }

    /// Returns `true` during a soft start, and if an order or a derating has just changed the set
    /// point by more than a measurement of the clamped branch tolerates.
    pub(crate) fn is_stepped(&self) -> bool {
        self.stepped || self.risen < 1.0
    }

    /// Returns the peak voltage of the drive, V.
    pub(crate) fn volts(&self) -> f32 {
        self.volts
    }

    /// Returns the voltage before a transducer is identified, V: the voltage of the scan.
    pub(crate) fn start_volts(&self) -> f32 {
        self.start_volts
    }

    /// Returns the ratio of the voltage limit to the present voltage; at least one.
    pub(crate) fn headroom(&self) -> f32 {
        if self.volts > 0.0 { (self.most_volts / self.volts).max(1.0) } else { 1.0 }
    }

    /// Returns the voltage limit of the lane with the largest gain, V.
    pub(crate) fn most_volts(&self) -> f32 {
        self.most_volts
    }

    /// Returns the largest voltage at present, within the limits of voltage and current, V.
    fn most_now(&self) -> f32 {
        smaller(self.most_volts, self.fold_back.ceiling())
    }

    /// Returns the current limit, A.
    pub(crate) fn most_amperes(&self) -> f32 {
        self.fold_back.most_amperes()
    }

    /// Reduces a voltage so that `louder` times its value is within the limit.
    pub(crate) fn limit_volts(&self, volts: f32, louder: f32) -> f32 {
        if volts * louder > self.most_volts { self.most_volts / louder } else { volts }
    }

    /// Returns `true` if the amplitude has been reached, or cannot be reached.
    pub(crate) fn settled(&self) -> bool {
        self.settled_blocks >= SETTLED_BLOCKS || self.limited
    }

    /// Returns `true` if a limit reduces the set point or the output of the loop.
    pub(crate) fn limited(&self) -> bool {
        self.limited
    }

    /// Returns the limit that does so: that of the current, or that of the voltage.
    pub(crate) fn limit(&self) -> Limit {
        if self.fold_back.ceiling() < self.most_volts { Limit::FoldedBack } else { Limit::OverVoltageRequest }
    }

    /// Returns the present set point of a soft start on its way to `target`.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    fn rise_to(&mut self, target: Amplitude) -> Amplitude {
        self.risen += self.rise;
        let rise = |from: f32, to: f32| if self.risen < 1.0 && to > from { from + self.risen * (to - from) } else { to };
        match target {
            Amplitude::Volts(volts) => Amplitude::Volts(rise(self.start_volts, volts)),
            Amplitude::MotionalCurrent(amperes) => Amplitude::MotionalCurrent(rise(self.rises_from_a, amperes)),
        }
    }

    /// Scales the voltage with a changed set point, so that the loop corrects only the remaining
    /// error.
    // Not inlined: the fast memory of a board has no room for code that few blocks need.
    #[cold]
    #[inline(never)]
    fn scale_voltage(&mut self, set_point: f32) {
        if self.last_set_point_a > 0.0 {
            // At an amplitude within the noise, the integral may be zero, which cannot be scaled.
            let (scaled, least) =
                (self.integral_volts * (set_point / self.last_set_point_a), MIN_VOLTAGE_REL * self.ohm * set_point);
            self.integral_volts = up_to(self.most_volts, larger(scaled, least));
        }
        self.last_set_point_a = set_point;
    }

    fn hold(&mut self, amperes: f32, envelope: f32, motional_current: Phasor) -> f32 {
        if self.lag == 0.0 {
            // Without an identified transducer the voltage is unknown.
            return 0.0;
        }
        let ceiling = up_to(self.fold_back.most_amperes(), amperes);
        self.expected += self.lag * (envelope * ceiling - self.expected);
        if ceiling == 0.0 {
            // The integral, which reflects the load, is kept for the next amplitude.
            self.settled_blocks = SETTLED_BLOCKS;
            return 0.0;
        }
        if self.last_set_point_a != ceiling {
            self.scale_voltage(ceiling);
        }
        if envelope != 1.0 || self.expected < MIN_RING_UP_REL * ceiling {
            return self.integral_volts;
        }
        let motional_current = magnitude(motional_current);
        // The resistance found so far. With the identified one, ten times the resistance under load
        // would leave a tenth of the bandwidth.
        let ohm = larger(self.ohm, self.integral_volts / ceiling);
        let error_volts = ohm * (self.expected - motional_current);
        self.settled_blocks =
            if (ceiling - motional_current).abs() < SETTLED_REL * ceiling { self.settled_blocks.saturating_add(1) } else { 0 };
        if !error_volts.is_finite() {
            return self.integral_volts;
        }
        let integral_gain = core::f32::consts::TAU * BANDWIDTH_HZ * self.block_s;
        self.integral_volts = up_to(self.most_now(), self.integral_volts + integral_gain * error_volts);
        self.integral_volts + error_volts * integral_gain / self.lag
    }
}

#[cfg(test)]
mod tests;
