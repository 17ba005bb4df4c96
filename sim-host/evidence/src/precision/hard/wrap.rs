//! A ring that vibrates as a whole under webbing: friction along the wrap that changes within a
//! small part of it.

use std::f64::consts::PI;
use std::hint::black_box;
use std::time::Instant;

use super::{Check, HardResult};
use contact::SolveError;
use contact::wrap::normal::{Normal, NormalPart};
use contact::wrap::ode::Sliding;
use contact::wrap::table::{Table, Tensioned};
use contact::wrap::{Pull, Ring};

const WRAP_DEG: f64 = 150.0;
const MU: f64 = 0.3;
/// Equal steps of the classical method along the wrap.
const STEPS: u32 = 1000;
/// Equal steps of the reference, whose error at a kink goes with the power 2.5 of the step.
const REFERENCE_STEPS: u32 = 1 << 20;
const HZ: f64 = 20e3;
/// Ring of docs/evidence/dring.md: 40 um, 8 mm.
const FITTED_NORMAL: Normal = Normal { amplitude_m: 40e-6, radius_m: 8e-3 };

/// Returns the shortest of a few times, us.
fn micros<T>(mut work: impl FnMut() -> T) -> f64 {
    let timed = (0..5).map(|_| {
        let began = Instant::now();
        black_box(work());
        began.elapsed()
    });
    1e6 * timed.min().unwrap_or_default().as_secs_f64()
}

fn sliding(velocity_ratio: f64, low_n: f64, pull: Pull) -> Sliding {
    Sliding { speed_m_per_s: 5.0 * velocity_ratio, tip_m_per_s: 5.0, hz: HZ, low_n, pull, in_surface: true }
}

/// Runs a radial ring under webbing that barely slides: friction is full within `z` of the middle,
/// and `z / sin p` of the full friction elsewhere.
///
/// With `int asin(z / p) dp` in closed form near the middle, and `int dp / sin p = ln tan(p / 2)`
/// away from it, both ends of the wrap have `G = (4 / pi) z (1 + ln(4 tan(wrap / 4) / z))`, up to
/// `z^3 ln z`.
pub fn barely_sliding(velocity_ratio: f64) -> Result<HardResult, SolveError> {
    let ring = Ring::new(WRAP_DEG, MU, 0.0, (0.0, 0.0))?;
    let exact = 4.0 / PI * velocity_ratio * (1.0 + (4.0 * (0.25 * ring.wrap_rad).tan() / velocity_ratio).ln());
    let found = ring.exponent(velocity_ratio, None, Pull::Shoulder);
    let steps = ring.stepped_exponent(STEPS, &NormalPart::None, &sliding(velocity_ratio, 100.0, Pull::Shoulder)) / MU;
    let table = Table::new(ring, None);
    let ratio = exact / ring.wrap_rad;
    let back = table.velocity_ratio(&Tensioned { ratio, low_n: 100.0, pull: Pull::Shoulder }, 5.0, 1.0);
    let us = micros(|| ring.exponent(velocity_ratio, None, Pull::Shoulder));
    Ok(HardResult {
        problem: "friction is full over a millionth of the wrap, and negligible elsewhere",
        naive: format!("{STEPS} steps of the tension: relative error {:.1e}", steps / exact - 1.0),
        chosen: format!("panels between kinks: G {:.12e} rad, the limit {exact:.12e}, {us:.0} us", found.in_surface_rad),
        checks: vec![
            Check::at_most("G: deviation from its limit, rad", found.in_surface_rad - exact, 1e-12),
            Check::at_most("stated error", found.error_rad, 1e-11),
            Check::at_most("velocity ratio: deviation by the table", back - velocity_ratio, 1e-9),
        ],
    })
}

/// Runs a vibration half a degree out of the plane of the wrap: at the place where it is normal to
/// the webbing a root is rounded over a hundredth of a radian. The reference is steps of the
/// tension, whose order a kink lowers.
pub fn barely_out_of_plane() -> Result<HardResult, SolveError> {
    compared(
        "half a degree out of the plane a root is rounded within a hundredth of the wrap",
        &Ring::new(WRAP_DEG, MU, 0.13 / MU, (0.0, 0.5))?,
        &NormalPart::None,
        &sliding(0.3, 300.0, Pull::Shoulder),
    )
}

/// Runs the fitted normal part at a small tension at the retractor's end: Bernoulli's equation, in
/// closed form.
pub fn fitted() -> Result<HardResult, SolveError> {
    let ring = Ring::new(WRAP_DEG, MU, 0.13 / MU, (20.0, 30.0))?;
    let sliding = sliding(0.005, 5.0, Pull::Retractor);
    let mut found =
        compared("the normal part depends on the unknown tension", &ring, &NormalPart::Fitted(FITTED_NORMAL), &sliding)?;
    let (steps, _) = ring.tension_exponent(&NormalPart::Fitted(FITTED_NORMAL), &sliding);
    let closed = ring.fitted_exponent(sliding.speed_m_per_s, sliding.tip_m_per_s, &FITTED_NORMAL, (sliding.low_n, sliding.pull));
    let us = micros(|| {
        ring.fitted_exponent(sliding.speed_m_per_s, sliding.tip_m_per_s, &FITTED_NORMAL, (sliding.low_n, sliding.pull))
    });
    found.chosen += &format!("; Bernoulli's closed form: {us:.0} us");
    found.checks.push(Check::at_most("closed form: deviation from the panels", closed - steps, 1e-11));
    Ok(found)
}

/// Compares panels between kinks with a million steps of the tension.
fn compared(problem: &'static str, ring: &Ring, normal: &NormalPart, sliding: &Sliding) -> Result<HardResult, SolveError> {
    let (exponent, stated) = ring.tension_exponent(normal, sliding);
    let (coarse, reference) =
        (ring.stepped_exponent(STEPS, normal, sliding), ring.stepped_exponent(REFERENCE_STEPS, normal, sliding));
    let us = micros(|| ring.tension_exponent(normal, sliding));
    let naive_us = micros(|| ring.stepped_exponent(STEPS, normal, sliding));
    Ok(HardResult {
        problem,
        naive: format!("{STEPS} steps of the tension: off by {:.1e}, {naive_us:.0} us", coarse - reference),
        chosen: format!("panels between kinks: ln(T1 / T2) {exponent:.12}, {us:.0} us"),
        checks: vec![
            Check::at_most(format!("deviation from {REFERENCE_STEPS} steps"), exponent - reference, 1e-10),
            Check::at_most("stated error", stated, 1e-11),
        ],
    })
}
