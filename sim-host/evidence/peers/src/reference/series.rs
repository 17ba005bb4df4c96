//! x, v, f, q as power series in time about a given moment.

use crate::scaled::{Clock, Scaled};

/// Number of coefficients of a series.
const TERMS: usize = 25;
/// Number of points within a step at which the slip is tested for a reversal. Two reversals between
/// neighbouring points are missed.
const PROBES: u32 = 8;

/// Coefficients of the four series.
pub struct Series([[f64; TERMS]; 4]);

impl Series {
    /// Expands the solution from a state on, with the sign of the slip held.
    pub fn new(scaled: &Scaled, sign: f64, clock: &Clock, y: &[f64; 4]) -> Self {
        let mut series = [[0.0; TERMS]; 4];
        let [x, v, f, q] = &mut series;
        (x[0], v[0], f[0], q[0]) = (y[0], y[1], y[2], y[3]);
        let peak = scaled.excess != 0.0;
        let per_square = 1.0 / (scaled.stribeck * scaled.stribeck);
        let (mut slip, mut square, mut exp, mut bounded) = ([0.0; TERMS], [0.0; TERMS], [0.0; TERMS], [0.0; TERMS]);
        let (mut sine, mut cosine) = ([0.0; TERMS], [0.0; TERMS]);
        (sine[0], cosine[0]) = clock.phase().sin_cos();
        for k in 0..TERMS - 1 {
            let per = 1.0 / (k + 1) as f64;
            slip[k] = if k == 0 { scaled.sliding + v[0] } else { v[k] };
            // f / G(V), with E = exp(-V^2 / Vs^2), E' = -(V^2)' E / Vs^2, G = 1 + s E
            bounded[k] = f[k];
            if peak {
                square[k] = (0..=k).map(|j| slip[j] * slip[k - j]).sum();
                exp[k] = if k == 0 {
                    (-square[0] * per_square).exp()
                } else {
                    let sum: f64 = (1..=k).map(|j| j as f64 * square[j] * exp[k - j]).sum();
                    -per_square * sum / k as f64
                };
                let sum: f64 = (1..=k).map(|j| scaled.excess * exp[j] * bounded[k - j]).sum();
                bounded[k] = (f[k] - sum) / (1.0 + scaled.excess * exp[0]);
            }
            let product: f64 = (0..=k).map(|j| slip[j] * bounded[k - j]).sum();
            let bristle = scaled.kappa * (slip[k] - sign * product);
            let force = f[k] + scaled.damping * bristle + scaled.viscous * slip[k];
            (x[k + 1], q[k + 1]) = (v[k] * per, scaled.share * force * per);
            f[k + 1] = bristle * per;
            v[k + 1] = (scaled.forcing * cosine[k] - scaled.spring * x[k] - scaled.friction * force) * per;
            // The rate of the phase is the frequency, which in a chirp grows with time.
            let gain = if k == 0 { 0.0 } else { scaled.rate };
            let before = k.saturating_sub(1);
            let (sine_before, cosine_before) = (gain * sine[before], gain * cosine[before]);
            cosine[k + 1] = -(clock.frequency * sine[k] + sine_before) * per;
            sine[k + 1] = (clock.frequency * cosine[k] + cosine_before) * per;
        }
        Series(series)
    }

    /// Returns the state at a time after the moment of expansion.
    pub fn at(&self, t: f64) -> [f64; 4] {
        self.0.map(|series| series.iter().rev().fold(0.0, |sum, term| sum * t + term))
    }

    /// Returns the first reversal within a length. At a reversal the slip is zero; there the next
    /// zero is found as a zero of slip over time.
    pub fn reversal(&self, sliding: f64, sign: f64, length: f64) -> Option<f64> {
        let mut slip = self.0[1];
        slip[0] += sliding;
        let terms = if slip[0] == 0.0 { &slip[1..] } else { &slip[..] };
        let forward = |t: f64| sign * terms.iter().rev().fold(0.0, |sum, term| sum * t + term);
        let probe = |number: u32| length * f64::from(number) / f64::from(PROBES);
        let after = (1..=PROBES).find(|&number| forward(probe(number)) < 0.0)?;
        let (mut before, mut after) = (probe(after - 1), probe(after));
        loop {
            let half = 0.5 * (before + after);
            if half <= before || half >= after {
                return Some(after);
            }
            if forward(half) < 0.0 { after = half } else { before = half }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{Case, Kind};

    #[test]
    fn a_series_obeys_the_equations() {
        for kind in Kind::ALL {
            let scaled = Case::new(kind, 10).scaled;
            let mut clock = Clock::new(&scaled);
            clock.advance(0.7);
            let (y, sign) = ([0.3, 0.02 - scaled.sliding, 0.4, 0.1], 1.0);
            let series = Series::new(&scaled, sign, &clock, &y);
            let (t, h) = (1e-3, 1e-5);
            let [ahead, behind, now] = [t + h, t - h, t].map(|t| series.at(t));
            let mut rates = [0.0; 4];
            scaled.held(sign, clock.phase_at(t).cos(), &now, &mut rates);
            for i in 0..4 {
                assert!(((ahead[i] - behind[i]) / (2.0 * h) - rates[i]).abs() < 1e-6, "{kind:?} {i}");
            }
        }
    }
}
