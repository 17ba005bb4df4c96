//! A particle of the face: B.11, B.13, B.14, and the direction in which it drags a rotor (B.2.2).

use std::f64::consts::TAU;

use super::sheet::Sheet;
use super::{MEASURED_HZ, MEASURED_M, wave};
use crate::thesis::claim::{Check, Claim, number};
use crate::thesis::picture::{axis, column, line};
use report::{Figure, Series, Style};

/// Number of points a period.
const POINTS: usize = 48;

/// Face of the sheet with a wave.
#[derive(Clone, Copy)]
struct Face {
    amplitude_m: f64,
    omega: f64,
    /// Wave number, rad/m; negative for a wave in the opposite direction.
    k: f64,
    /// Height above the middle, m; negative below.
    z_m: f64,
}

impl Face {
    fn upper(frequency_hz: f64) -> Face {
        let sheet = Sheet::BEAM;
        let k = sheet.wave_number(frequency_hz);
        Face { amplitude_m: MEASURED_M, omega: TAU * frequency_hz, k, z_m: sheet.face_m() }
    }

    /// Returns the displacement by equation B.11, m.
    fn w(&self, x: f64, t: f64) -> f64 {
        self.amplitude_m * (self.omega * t - self.k * x).sin()
    }

    /// Returns the first expression of B.13, m, with the slope by differences of B.11.
    fn u_by_slope(&self, x: f64, t: f64) -> f64 {
        let step = 1e-4 / self.k.abs();
        -self.z_m * (self.w(x + step, t) - self.w(x - step, t)) / (2.0 * step)
    }

    /// Returns the second expression of B.13, m.
    fn u(&self, x: f64, t: f64) -> f64 {
        self.amplitude_m * self.z_m * self.k * (self.omega * t - self.k * x).cos()
    }

    /// Returns the points of a period at an arbitrary place.
    fn locus(&self) -> Vec<(f64, f64)> {
        let x = 0.3 / self.k;
        (0..=POINTS).map(|i| TAU / self.omega * i as f64 / POINTS as f64).map(|t| (self.u_by_slope(x, t), self.w(x, t))).collect()
    }

    /// Returns the velocity along the sheet at the crest, m/s, by differences.
    fn at_crest_m_per_s(&self) -> f64 {
        let period = TAU / self.omega;
        let outward = |t: f64| self.w(0.0, t) * self.z_m.signum();
        let times = (0..4000).map(|i| period * f64::from(i) / 4000.0);
        let crest = times.max_by(|&a, &b| outward(a).total_cmp(&outward(b))).unwrap_or(0.0);
        let step = 1e-5 * period;
        (self.u_by_slope(0.0, crest + step) - self.u_by_slope(0.0, crest - step)) / (2.0 * step)
    }
}

/// Draws Figure B.6: displacement across the sheet over displacement along it.
pub fn figure() -> Figure {
    let nm = |values: &[f64]| values.iter().map(|value| 1e9 * value).collect::<Vec<_>>();
    let mut series = Vec::new();
    for hz in MEASURED_HZ {
        let face = Face::upper(hz);
        let label = format!("{} kHz", hz / 1e3);
        let (u, w): (Vec<f64>, Vec<f64>) = face.locus().into_iter().unzip();
        let half = face.amplitude_m * face.z_m * face.k;
        let angle = |i: usize| TAU * i as f64 / 240.0;
        let ellipse_u: Vec<f64> = (0..=240).map(|i| half * angle(i).cos()).collect();
        let ellipse_w: Vec<f64> = (0..=240).map(|i| face.amplitude_m * angle(i).sin()).collect();
        series.push(line(format!("B.14, {label}"), column("w_ellipse_nm", &label), &nm(&ellipse_u), nm(&ellipse_w)));
        let points = line(format!("B.11 and B.13, {label}"), column("w_nm", &label), &nm(&u), nm(&w));
        series.push(Series { style: Style::Points, ..points });
    }
    Figure {
        id: "fig-b-06".into(),
        title: "Figure B.6: locus of a particle of the face, 20 nm".into(),
        caption: "A wave of 20 nm (B.6) on the sheet of Figure B.8, as a thin beam. Points: instants of B.11 and of B.13, \
                  with the slope by differences. Lines: ellipse of B.14. The motion along the sheet is z k times that \
                  across it: 0.195 at 20 kHz, 0.276 at 40 kHz."
            .into(),
        x: axis("along the sheet, u [nm]"),
        y: axis("across the sheet, w [nm]"),
        series,
        equal_aspect: true,
        ..Figure::default()
    }
}

/// Judges the claims about the motion of a particle.
pub fn claims() -> Vec<Claim> {
    vec![ellipse(), towards_source()]
}

fn ellipse() -> Claim {
    let [slope, printed] = [Face::u_by_slope, Face::u].map(|u| {
        MEASURED_HZ.map(|hz| {
            let face = Face::upper(hz);
            let half = face.amplitude_m * face.z_m * face.k;
            let instants = (0..POINTS).map(|i| TAU / face.omega * i as f64 / POINTS as f64);
            let off =
                instants.map(|t| ((u(&face, 1e-3, t) / half).powi(2) + (face.w(1e-3, t) / face.amplitude_m).powi(2) - 1.0).abs());
            off.fold(0.0, f64::max)
        })
    });
    // Area enclosed by the points, by the trapezoidal rule, over pi times the half axes.
    let area = MEASURED_HZ.map(|hz| {
        let face = Face::upper(hz);
        let enclosed: f64 = face.locus().windows(2).map(|p| 0.5 * (p[0].0 * p[1].1 - p[1].0 * p[0].1)).sum();
        let polygon = TAU.recip() * POINTS as f64 * (TAU / POINTS as f64).sin();
        enclosed / (std::f64::consts::PI * face.amplitude_m.powi(2) * face.z_m * face.k * polygon)
    });
    let share = MEASURED_HZ.map(|hz| wave::rotation_share(&Sheet::BEAM, hz) * wave::timoshenko(&Sheet::BEAM, hz));
    let axes = [0, 1].map(|i| share[i] / Sheet::BEAM.wave_number(MEASURED_HZ[i]));
    let pair = |name: &str, values: [f64; 2]| vec![number(format!("{name}, 20 kHz"), values[0]), number("40 kHz", values[1])];
    Claim {
        id: "particle-ellipse",
        section: "B.2.2, B.11, B.13, B.14",
        says: "A particle of the face moves on an ellipse with half axes a z k along the sheet and a across it.",
        checks: vec![
            Check::new(
                "u by the second expression of B.13 (left side of B.14 within 1e-12 of one)",
                printed.iter().all(|off| *off < 1e-12),
                pair("largest deviation", printed),
            ),
            Check::new(
                "u by differences of B.11 (within 1e-7), area by the trapezoidal rule (within 1e-6)",
                slope.iter().all(|off| *off < 1e-7) && area.iter().all(|area| (area.abs() - 1.0).abs() < 1e-6),
                [pair("largest deviation", slope), pair("area over that of the ellipse, signed", area)].concat(),
            ),
            Check::new(
                "with shear and rotary inertia (half axis along the sheet within 10 % of a z k)",
                axes.iter().all(|ratio| (ratio - 1.0).abs() < 0.1),
                pair("half axis over a z k", axes),
            ),
        ],
    }
}

fn towards_source() -> Claim {
    let cases: [(&str, &dyn Fn(Face) -> Face); 3] = [
        ("upper face", &|face| face),
        ("lower face", &|face| Face { z_m: -face.z_m, ..face }),
        ("wave reversed", &|face| Face { k: -face.k, ..face }),
    ];
    let check = |(condition, turned): (&str, &dyn Fn(Face) -> Face)| {
        let faces = MEASURED_HZ.map(|hz| turned(Face::upper(hz)));
        // Positive in the direction of the wave.
        let speeds = faces.map(|face| 1e3 * face.at_crest_m_per_s() * face.k.signum());
        let numbers = vec![
            number("speed at the crest along the wave at 20 nm, 20 kHz [mm/s]", speeds[0]),
            number("40 kHz [mm/s]", speeds[1]),
        ];
        Check::new(format!("{condition}: velocity of the particle at the crest"), speeds.iter().all(|v| *v < 0.0), numbers)
    };
    Claim {
        id: "rotor-towards-source",
        section: "B.2.2",
        says: "At the crests the particle moves against the wave, so the rotor moves towards the wave's source, and turns \
               with it.",
        checks: cases.into_iter().map(check).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_crest_has_the_speed_of_the_formula() {
        for hz in MEASURED_HZ {
            let expected = -Sheet::BEAM.crest_m_per_s(MEASURED_M, hz);
            let found = Face::upper(hz).at_crest_m_per_s();
            assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
        }
    }
}
