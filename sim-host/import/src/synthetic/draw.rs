//! Generation of an example from its number: circuit, sweep, connection, noise.

use num_complex::Complex64;

use super::file::{Form, form, written};
use super::random::Random;
use super::{Example, Kind, Noise};
use crate::admittance::circuit::{Branch, Equivalent};
use crate::admittance::coordinate::{Coordinate, Topology};
use crate::admittance::fixture::Fixture;
use crate::admittance::options::Options;
use crate::complex::polar;

/// Largest bound of Q, Rm, C0 and coupling of an example, relative to the values. A less precise
/// measurement would be repeated by its user.
const MAX_BOUND_REL: f64 = 0.1;
/// Factor by which the noise is reduced until the example is precise enough.
const NOISE_REDUCTION: f64 = 0.4;

/// Draws the example with this number.
pub(super) fn draw(number: u64) -> Example {
    let mut random = Random::new(number.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5eed);
    let (truth, hz) = circuit_and_sweep(&mut random);
    let form = form(&mut random);
    let memory = random.chance(0.15);
    let correlation = if memory { random.between(0.3, 0.8) } else { 0.0 };
    let coordinate = connection(&mut random, form, &truth);
    let (first, second) = match coordinate {
        Coordinate::Scattering(..) => (random.log(1e-4, 3e-3), random.log(1e-5, 1e-3)),
        Coordinate::Immittance => (random.log(2e-4, 1e-2), random.log(2e-4, 1e-2)),
    };
    let with_fixture =
        random.chance(0.2) && !matches!(coordinate, Coordinate::Scattering(Topology::SeriesThrough | Topology::ShuntThrough, _));
    let series_ohm = if random.chance(0.1) { truth.branches[0].rm_ohm() * random.between(0.05, 0.5) } else { 0.0 };
    // A fixture with a lead of some nanohenries and a stray capacitance across the transducer.
    let (lead_ohm, lead_h) = (random.log(1e-3, 1e-1), random.log(1e-9, 3e-7));
    let stray_f = truth.c0_f * random.log(1e-3, 0.3);
    let between = |hz: &f64| {
        let omega = std::f64::consts::TAU * hz;
        let (lead, stray) = (Complex64::new(lead_ohm, omega * lead_h), Complex64::new(0.0, omega * stray_f));
        let (lead, stray) = if with_fixture { (lead, stray) } else { (Complex64::ZERO, Complex64::ZERO) };
        Fixture { lead, stray, series_ohm }
    };
    let between = if with_fixture || series_ohm > 0.0 { hz.iter().map(between).collect() } else { Vec::new() };
    let mut example = Example {
        name: format!("example.{}", form.ending()),
        bytes: Vec::new(),
        options: Options { series_ohm, ..Options::default() },
        fixture: None,
        truth,
        kind: Kind { form: form.called(), memory, fixture: with_fixture || series_ohm > 0.0 },
        hz,
        between,
        noise: Noise { coordinate, first, second, correlation },
    };
    while !is_precise(&example) && example.noise.first > 1e-7 {
        example.noise.first *= NOISE_REDUCTION;
        example.noise.second *= NOISE_REDUCTION;
    }
    let seen = |(at, hz): (usize, &f64)| {
        let own = example.truth.admittance(*hz);
        example.between.get(at).map_or(own, |fixture| fixture.seen(own).0)
    };
    let seen: Vec<Complex64> = example.hz.iter().enumerate().map(seen).collect();
    let noisy = noisy(&mut random, &example, &seen);
    let ends = |fixture: &Fixture| ((fixture.lead + fixture.stray.inv()).inv(), fixture.lead.inv());
    let (open, short): (Vec<_>, Vec<_>) = example.between.iter().map(ends).unzip();
    let style = random.part();
    let down = random.chance(0.1);
    let write = |values: &[Complex64]| written(form, style, down, &example.hz, values, coordinate);
    let (bytes, units, fixture) = {
        let (bytes, units) = write(&noisy);
        (bytes, units, with_fixture.then(|| [write(&open).0, write(&short).0]))
    };
    example.options.units = units;
    Example { bytes, fixture, ..example }
}

/// Returns `true` if the bounds of the example are small enough.
fn is_precise(example: &Example) -> bool {
    let (Some(bounds), values) = (example.bounds(), example.true_values()) else { return false };
    let band = values[0] / values[2];
    bounds[0] < MAX_BOUND_REL * band && [2, 3, 6, 7].iter().all(|&at| bounds[at] < MAX_BOUND_REL * values[at])
}

fn circuit_and_sweep(random: &mut Random) -> (Equivalent, Vec<f64>) {
    let (hz, q) = (random.log(18e3, 200e3), random.log(10.0, 2000.0));
    let (c0_f, coupling) = (random.log(0.5e-9, 500e-9), random.log(0.05, 0.6));
    let cm_f = c0_f * coupling * coupling / (1.0 - coupling * coupling);
    let branch = |hz: f64, q: f64, cm_f: f64| Branch { hz, q, siemens: std::f64::consts::TAU * hz * q * cm_f };
    let mut branches = vec![branch(hz, q, cm_f)];
    // Half-width of the sweep in bandwidths, at most a quarter of the frequency.
    let half = (hz / q * random.log(3.0, 40.0)).min(0.25 * hz);
    let centre = hz + half * random.between(-0.5, 0.5);
    let (from, to) = (centre - half, centre + half);
    let further = if random.chance(0.3) { 1 + usize::from(random.chance(0.25)) } else { 0 };
    for _ in 0..further {
        let (at, own) = (random.between(from + 0.1 * half, to - 0.1 * half), q * random.log(0.5, 3.0));
        let band = |branch: &Branch| branch.hz / branch.q;
        // Closer than two bandwidths, a mode is not visible as a separate one in the curve.
        if branches.iter().all(|known| (known.hz - at).abs() > 2.0 * band(known).max(at / own)) {
            branches.push(branch(at, own, cm_f * random.log(0.02, 0.4)));
        }
    }
    branches.sort_by(|a, b| b.merit(c0_f).total_cmp(&a.merit(c0_f)));
    let points = random.one(&[101, 201, 401, 801, 1601]);
    let step = (to - from) / (points - 1) as f64;
    // The frequencies of a sweep have few decimals.
    let sweep = (0..points).map(|n| (1e3 * (from + n as f64 * step)).round() / 1e3).collect();
    (Equivalent { c0_f, loss_tangent: random.between(0.0, 0.02), branches }, sweep)
}

/// Returns the quantity that the instrument reads; for two ports, in the suitable connection.
fn connection(random: &mut Random, form: Form, truth: &Equivalent) -> Coordinate {
    let ohm = if form.is_touchstone() { random.one(&[50.0, 50.0, 50.0, 75.0]) } else { 50.0 };
    let low = truth.branches[0].rm_ohm() < ohm;
    match form {
        Form::TwoPort(_) if low => Coordinate::Scattering(Topology::ShuntThrough, ohm),
        Form::TwoPort(_) => Coordinate::Scattering(Topology::SeriesThrough, ohm),
        Form::OnePort(_) | Form::TableReflection | Form::TableReflectionDb => Coordinate::Scattering(Topology::OnePort, ohm),
        _ => Coordinate::Immittance,
    }
}

/// Returns admittances with the noise of the instrument.
fn noisy(random: &mut Random, example: &Example, seen: &[Complex64]) -> Vec<Complex64> {
    let noise = &example.noise;
    let rho = noise.correlation;
    let fresh = (1.0 - rho * rho).sqrt();
    let mut state = [random.normal(), random.normal()];
    let with = |seen: &Complex64| {
        let sd = noise.sd(*seen);
        let error = [state[0] * sd[0], state[1] * sd[1]];
        state = [rho * state[0] + fresh * random.normal(), rho * state[1] + fresh * random.normal()];
        match noise.coordinate {
            Coordinate::Scattering(..) => {
                noise.coordinate.admittance(noise.coordinate.of(*seen) + Complex64::new(error[0], error[1]))
            }
            Coordinate::Immittance => seen * polar(1.0 + error[0], error[1]),
        }
    };
    seen.iter().map(with).collect()
}
