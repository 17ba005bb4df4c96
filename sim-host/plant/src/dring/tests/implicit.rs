//! The same crash by another method: constant steps, backward differences, no modes and no events.
//! In each step the payout is found by bisection, so that the tensions match the friction at the
//! resulting speed. The spool releases webbing above the limiter's force. First order in the step.

use super::super::actuator::Actuator;
use super::super::motion::Extremes;
use super::{END_S, Times, rate};
use crate::dring::Bench;
use contact::wrap::Pull;

pub(super) struct Implicit;

impl Implicit {
    pub(super) fn crash(bench: &Bench, times: Times, h: f64) -> Extremes {
        let (mut x, mut v, mut p, mut s, mut a) = (0.0, 0.0, 0.0, 0.0, 0.0f64);
        let mut seated = true;
        let mut found = Extremes::default();
        let (t0, ks, kr) = (bench.shoulder.pretension_n, bench.shoulder.stiffness_n_per_m, bench.retractor.stiffness_n_per_m);
        let slack = bench.shoulder.slack_m;
        let shoulder = |e: f64| t0 + ks * (e.min(0.0) + (e - slack).max(0.0));
        for step in 0..(END_S / h) as u64 {
            let time_s = (step as f64 + 1.0) * h;
            a = (a + h * rate(times, time_s - h - bench.pulse.at_s)).clamp(0.0, 1.0);
            let pulse = bench.pulse.at(time_s, bench.pulse.contains(time_s));
            let moved = x + h * v;
            // The spool releases or winds up the webbing that exceeds the limits of the span.
            let spool = |p: f64| if kr * (p - s) + t0 > bench.limiter_n { p - (bench.limiter_n - t0) / kr } else { s.min(p) };
            // Excess of the shoulder tension over the friction limit at the speed of this payout;
            // falls as the payout rises.
            let surplus = |next: f64| {
                let (ts, tr) = (shoulder(moved - next), t0 + kr * (next - spool(next)));
                let speed = (next - p) / h;
                let gain = bench.capstan.gain(friction(bench, a, speed.abs(), ts, tr));
                if speed >= 0.0 { ts - gain * tr } else { gain * ts - tr }
            };
            // Friction jumps from one end to the other at zero speed.
            let nudge = 1e-13;
            let next = match (surplus(p + nudge), surplus(p - nudge)) {
                (out, _) if out > 0.0 => root(&surplus, p + nudge, p + 50.0 * h),
                (_, back) if back < 0.0 => root(&surplus, p - 50.0 * h, p - nudge),
                _ => p,
            };
            (s, p) = (spool(next), next);
            let ts = shoulder(moved - p);
            seated &= bench.torso_kg * pulse <= ts;
            x = moved;
            v += if seated { 0.0 } else { h * (pulse - ts / bench.torso_kg) };
            found.shoulder_n = found.shoulder_n.max(ts);
            found.excursion_m = found.excursion_m.max(x);
        }
        found
    }
}

/// Returns the ratio of friction at a speed, from the laws themselves rather than their inverses.
fn friction(bench: &Bench, amplitude: f64, speed: f64, ts: f64, tr: f64) -> f64 {
    use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};
    let floor = bench.capstan.floor();
    let low = ts.min(tr);
    let used = amplitude.max(0.01);
    let by_velocity = |tip: f64| (speed / (used * tip)).min(1.0);
    let ratio = match bench.actuator {
        Actuator::Ring(tip, ref table) => {
            let pull = if ts > tr { Pull::Shoulder } else { Pull::Retractor };
            table.ratio(speed / (used * tip), (tip, used), (low, pull))
        }
        Actuator::None | Actuator::Stack => 1.0,
        Actuator::Ideal => return 1.0 - (1.0 - floor) * amplitude,
        _ if amplitude == 0.0 => 1.0,
        Actuator::Tangential(tip) => FRAC_2_PI * by_velocity(tip).asin(),
        Actuator::TangentialDahl(tip) => {
            let xi = by_velocity(tip);
            FRAC_PI_2 * xi / (xi * xi.asin() + (1.0 - xi * xi).sqrt())
        }
        // The friction force depends on the ratio that it causes: both must match. A larger ratio
        // leaves less force.
        Actuator::Power(watts) => fitting(|ratio| {
            let coulomb = low * (bench.capstan.gain(ratio) - 1.0) / ratio;
            FRAC_2_PI * (coulomb * speed / (FRAC_PI_2 * used * watts)).atan()
        }),
        Actuator::Normal => fitting(|ratio| {
            let normal = low * (bench.capstan.gain(ratio) - 1.0) / (ratio * bench.capstan.mu_high);
            let effect = 0.587 * (1.0 + 25.0 / 38.3) / (1.0 + speed / 38.3e-3) * (normal / 270.0).powf(-0.0584);
            1.0 - used * effect
        }),
    };
    ratio.clamp(floor, 1.0)
}

/// Solves `law(ratio) = ratio` for a law that rises less steeply than its argument.
fn fitting(law: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (1e-6, 1.0);
    for _ in 0..34 {
        let ratio = 0.5 * (low + high);
        if law(ratio) > ratio { low = ratio } else { high = ratio }
    }
    0.5 * (low + high)
}

fn root(falling: &impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..44 {
        let middle = 0.5 * (low + high);
        if falling(middle) > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
