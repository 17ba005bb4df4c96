//! Amplitude: the drive voltage for the amplitude asked for.
//!
//! A voltage is passed on. A motional current (tip velocity times force factor) is held by a PI loop whatever the load
//! does to Q: about the resonance `I_m = (V / Rm) / (1 + tau s)`, so that `Ki = 2 pi B Rm` and `Kp = Ki tau` leave a
//! first-order loop of bandwidth `B`.
//!
//! The loop does not compare with the set-point itself but with what an undisturbed ring-up would show by now (the
//! set-point through the same lag): it holds still through the edges of a burst and corrects only what the load does.

use crate::generate::drive_scale::DriveScale;
use crate::generate::fold_back::FoldBack;
use crate::generate::phasing;
use crate::seam::block::Amplitude;
use crate::seam::compare::{larger, smaller, up_to};
use crate::seam::config::{Config, Drive, Limits};
use crate::seam::error::Error;
use crate::seam::fault::Limit;
use crate::seam::phasor::{Phasor, magnitude};
use crate::seam::transducer::Transducer;

/// Bandwidth of the loop, Hz: slower than the phase loop, so that the two do not fight.
const BANDWIDTH_HZ: f32 = 60.0;
/// The loop listens once the ring-up has come so far.
const LISTEN_ABOVE: f32 = 0.8;
/// Less than so many codes of the drive converter is none: a dither shows no less, and what is a multiple of the drive stays finite.
const LEAST_CODES: f32 = 1.0 / 64.0;
/// A new amplitude begins with at least this part of the voltage that it takes without load.
const LEAST_PART: f32 = 0.25;
/// Settled: within this part of what is asked for, for so many blocks.
const SETTLED: (f32, u32) = (0.01, 32);

/// The amplitude control. Without an identified transducer a motional current cannot be held, and plays as silence.
#[derive(Clone, Debug)]
pub(crate) struct AmplitudeLoop {
    /// The voltage limit is that of the lane with the largest gain.
    limits: Limits,
    /// As configured, V.
    voltage_limit: f32,
    /// Less is silence, V.
    least_volts: f32,
    start_volts: f32,
    block_s: f32,
    ohm: f32,
    lag: f32,
    /// What an undisturbed resonance would show by now, A.
    expected: f32,
    integral_volts: f32,
    volts: f32,
    limited: bool,
    fold_back: FoldBack,
    /// Part by which the amplitude rises a block at the start, the part that it has risen to, and the motional current that it rises from, A.
    rise: f32,
    risen: f32,
    rises_from_a: f32,
    /// Blocks in which the amplitude was what is asked for.
    within: u32,
    /// What was asked for last, A; zero before anything was.
    asked: f32,
}

/// The largest amplitude that the voltage limit and the converters leave to a drive with trimmed lanes, V.
pub(crate) fn most_volts(config: &Config) -> Result<f32, Error> {
    let converter_v = DriveScale::build(&config.front_end)?.range_v();
    Ok(config.limits.voltage_v.min(converter_v) / phasing::loudest(&config.phasing))
}

impl AmplitudeLoop {
    /// Checks the amplitude and the limits.
    pub(crate) fn build(config: &Config, block_s: f32) -> Result<Self, Error> {
        let converter_v = DriveScale::build(&config.front_end)?.range_v();
        let voltage_v = most_volts(config)?;
        let limits = Limits { voltage_v, ..config.limits.clone() };
        // However low a limit is, there is a drive within it.
        Drive::SCAN_VOLTS.check_up_to(config.drive.scan_volts, limits.voltage_v)?;
        match config.drive.amplitude {
            Amplitude::Volts(volts) => Drive::AMPLITUDE_V.check_up_to(volts, limits.voltage_v)?,
            Amplitude::MotionalCurrent(amperes) => Drive::MOTIONAL_CURRENT_A.check_up_to(amperes, limits.current_a)?,
        };
        Ok(AmplitudeLoop {
            limits,
            voltage_limit: config.limits.voltage_v.min(converter_v),
            least_volts: LEAST_CODES * config.front_end.drive_volt_per_lsb,
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
            rises_from_a: 0.0,
            within: 0,
            asked: 0.0,
        })
    }

    /// Forgets the transducer.
    pub(crate) fn restart(&mut self) {
        self.lag = 0.0;
        self.integral_volts = self.start_volts;
        self.within = 0;
    }

    /// Sets the largest gain of a lane; the voltage limit is for that lane. Returns the limit of the drive before the gain, V.
    pub(crate) fn set_loudest(&mut self, gain: f32) -> f32 {
        self.limits.voltage_v = self.voltage_limit / gain;
        self.limits.voltage_v
    }

    /// Starts on an identified transducer, which rings at `motional_current` amperes already.
    pub(crate) fn seed(&mut self, transducer: &Transducer, motional_current: f32) {
        self.ohm = transducer.rm_ohm;
        self.lag = (self.block_s / transducer.time_constant_s()).min(1.0);
        self.expected = motional_current;
        (self.risen, self.rises_from_a) = (0.0, motional_current);
        self.fold_back.begin(transducer.lm_h, self.block_s, self.lag);
        self.integral_volts = self.start_volts;
        self.within = 0;
        self.asked = 0.0;
    }

    /// The next measured block had been rung up by a boost: there is nothing to wait for.
    pub(crate) fn has_rung_up(&mut self) {
        if self.asked > 0.0 {
            self.expected = self.asked;
        }
    }

    /// Takes the motional current of a block, what it was played with, V, if that was the same throughout, and the susceptance of the clamped branch, S.
    #[inline]
    pub(crate) fn watch_current(&mut self, volts: Option<f32>, motional_current: Phasor, susceptance: f32) {
        match volts {
            Some(volts) => self.fold_back.watch(volts, motional_current, susceptance),
            None => self.fold_back.interrupt(),
        }
    }

    /// Follows one block: what is asked for, the mean envelope of the measured block, and its motional current.
    pub(crate) fn update(&mut self, target: Amplitude, envelope: f32, motional_current: Phasor) {
        let target = if self.risen < 1.0 { self.rise_to(target) } else { target };
        let asked = match target {
            Amplitude::Volts(volts) => {
                self.within = SETTLED.1;
                volts
            }
            Amplitude::MotionalCurrent(amperes) => self.hold(amperes, envelope, motional_current),
        };
        let most = self.most_now();
        self.limited = asked > most;
        let volts = up_to(most, asked);
        self.volts = if volts < self.least_volts { 0.0 } else { volts };
    }

    /// Peak voltage to drive with, V.
    pub(crate) fn volts(&self) -> f32 {
        self.volts
    }

    /// The voltage before anything is identified: the scan's, V.
    pub(crate) fn start_volts(&self) -> f32 {
        self.start_volts
    }

    /// How many times the present voltage the limit is; at least one.
    pub(crate) fn headroom(&self) -> f32 {
        if self.volts > 0.0 { (self.limits.voltage_v / self.volts).max(1.0) } else { 1.0 }
    }

    /// The voltage limit, of the lane with the largest gain, V.
    pub(crate) fn most_volts(&self) -> f32 {
        self.limits.voltage_v
    }

    /// The most voltage at present: within its own limit, and such that the current stays within its.
    fn most_now(&self) -> f32 {
        smaller(self.limits.voltage_v, self.fold_back.ceiling())
    }

    /// The current limit, A.
    pub(crate) fn most_amperes(&self) -> f32 {
        self.limits.current_a
    }

    /// So much of a voltage that `louder` times as much is within the limit.
    pub(crate) fn within(&self, volts: f32, louder: f32) -> f32 {
        if volts * louder > self.limits.voltage_v { self.limits.voltage_v / louder } else { volts }
    }

    /// Whether the amplitude has been reached, or cannot be.
    pub(crate) fn settled(&self) -> bool {
        self.within >= SETTLED.1 || self.limited
    }

    /// Whether a limit stops the loop or the order from getting what it wants.
    pub(crate) fn limited(&self) -> bool {
        self.limited
    }

    /// Which limit does so: that of the current, or that of the voltage.
    pub(crate) fn limit(&self) -> Limit {
        if self.fold_back.ceiling() < self.limits.voltage_v { Limit::FoldedBack } else { Limit::OverVoltageRequest }
    }

    /// The amplitude of a soft start on its way to what is asked for.
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

    /// As much more is asked for, as much more voltage it takes: the loop corrects only what that is wrong by.
    // Not inlined: the fast memory of a board has no room for what few blocks have.
    #[cold]
    #[inline(never)]
    fn follow(&mut self, asked: f32) {
        if self.asked > 0.0 {
            // Of an amplitude within the noise the loop may have left nothing, from which nothing could be scaled.
            let (scaled, least) = (self.integral_volts * (asked / self.asked), LEAST_PART * self.ohm * asked);
            self.integral_volts = up_to(self.limits.voltage_v, larger(scaled, least));
        }
        self.asked = asked;
    }

    fn hold(&mut self, amperes: f32, envelope: f32, motional_current: Phasor) -> f32 {
        if self.lag == 0.0 {
            // Nothing is identified, so that the voltage for it is unknown.
            return 0.0;
        }
        let ceiling = up_to(self.limits.current_a, amperes);
        self.expected += self.lag * (envelope * ceiling - self.expected);
        if ceiling == 0.0 {
            // What is known of the load is for the next amplitude.
            self.within = SETTLED.1;
            return 0.0;
        }
        if self.asked != ceiling {
            self.follow(ceiling);
        }
        if envelope != 1.0 || self.expected < LISTEN_ABOVE * ceiling {
            return self.integral_volts;
        }
        let motional_current = magnitude(motional_current);
        // A load of ten times the resistance leaves a tenth of the bandwidth, were it not for what the loop has found of it by now.
        let ohm = larger(self.ohm, self.integral_volts / ceiling);
        let error_volts = ohm * (self.expected - motional_current);
        self.within = if (ceiling - motional_current).abs() < SETTLED.0 * ceiling { self.within.saturating_add(1) } else { 0 };
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
