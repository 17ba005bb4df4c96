//! Displacement of the sheet by its strain (B.4), by a bending wave (B.6), and with a layer on top
//! (B.8).
//!
//! Under a uniform voltage the sheet does not bend, as both halves stretch equally. With a pattern
//! on one face the field fades across the sheet. The free curvature is then `-(d31 + d15)` times
//! the second derivative of the potential along the sheet: stretching that grows across the sheet
//! and shear that changes along it are compatible without stress. Per volt on the face, a potential
//! of wave number k has the moment arm `h/2 - tanh(kh/2)/k`; bonded to an equal passive sheet the
//! arm is h/2.

use super::electrodes::Pattern;
use super::sheet::{D15_M_PER_V, D31_M_PER_V, D33_M_PER_V, DEPOLARISING_V_PER_M, SIDE_M, Sheet, THICKNESS_M};
use super::{MEASURED_HZ, MEASURED_M, VOLTAGE_V};
use crate::thesis::claim::{Check, Claim, number};

/// Factor of half a decade: within it, values count as of the same order of magnitude.
const HALF_DECADE: f64 = 3.162;

/// Returns the moment arm per volt of a pattern of wave number k on one face of a bare sheet, m.
fn arm_m(sheet: &Sheet, k: f64) -> f64 {
    sheet.face_m() - (k * sheet.face_m()).tanh() / k
}

/// Returns the amplitudes, m, of the bending waves that the tabs send forward and backward on an
/// endless sheet, for a strain per field: `A = M/(4 EI k)`, where M is the transform of the moment
/// at k.
fn wave_m(k: f64, strain_m_per_v: f64, voltage_v: f64) -> [f64; 2] {
    let sheet = Sheet::BEAM;
    let per_metre = 3.0 * strain_m_per_v.abs() * voltage_v * arm_m(&sheet, k) / (sheet.thickness_m.powi(3) * k);
    [k, -k].map(|k| per_metre * Pattern::PRINTED.transform(k).norm())
}

/// Returns the largest displacement across the sheet of a point at height `z_m` above its middle,
/// over the wave's amplitude; the point sinks as its section tilts.
fn lift(k: f64, z_m: f64) -> f64 {
    let angles = (0..720).map(|i| f64::from(i).to_radians() / 2.0);
    let highest = angles.map(|phase| MEASURED_M * phase.sin() - z_m * (1.0 - (MEASURED_M * k * phase.cos()).cos()));
    highest.fold(0.0, f64::max) / MEASURED_M
}

/// Judges the claims about the displacement.
pub fn claims() -> Vec<Claim> {
    vec![tens_and_hundreds(), twenty(), layer()]
}

fn tens_and_hundreds() -> Claim {
    let check = |condition: &str, voltage_v: f64, length_m: f64| {
        let through = 1e9 * D33_M_PER_V * voltage_v;
        let along = 1e9 * D31_M_PER_V * voltage_v * length_m / THICKNESS_M;
        let numbers = vec![
            number("d33 V [nm]", through),
            number("d31 V L/t [nm]", along),
            number("field over that of depolarisation", voltage_v / THICKNESS_M / DEPOLARISING_V_PER_M),
        ];
        Check::new(condition, (10.0..100.0).contains(&through) && (-1000.0..-100.0).contains(&along), numbers)
    };
    Claim {
        id: "tens-and-hundreds",
        section: "B.4",
        says: "A field along the poling thickens the sheet by tens of nanometres and shortens it by hundreds.",
        checks: vec![
            check("whole sheet, 60 V", VOLTAGE_V, SIDE_M),
            check("whole sheet, 60 V peak to peak", 0.5 * VOLTAGE_V, SIDE_M),
            check("across one tab of the pattern, 60 V", VOLTAGE_V, Pattern::PRINTED.width_m),
        ],
    }
}

fn twenty() -> Claim {
    let near = |m: f64| (MEASURED_M / HALF_DECADE..MEASURED_M * HALF_DECADE).contains(&m);
    let still = |condition: &str, m: f64| Check::new(condition, near(m), vec![number("displacement [nm]", 1e9 * m)]);
    let moving = |hz: f64| {
        let k = Sheet::BEAM.wave_number(hz);
        let [along, back] = wave_m(k, D31_M_PER_V + D15_M_PER_V, VOLTAGE_V);
        let numbers = vec![
            number("wave along the tabs [nm]", 1e9 * along),
            number("backward [nm]", 1e9 * back),
            number("arm over h/2", arm_m(&Sheet::BEAM, k) / Sheet::BEAM.face_m()),
        ];
        let condition = format!("bending wave from the printed tabs, one pass, no resonance, 60 V, {} kHz", hz / 1e3);
        Check::new(condition, near(along.max(back)), numbers)
    };
    Claim {
        id: "twenty-nanometres",
        section: "B.6",
        says: "Displacements are of the order of 20 nm (within half a decade).",
        checks: vec![
            still("thickness of the sheet under 60 V, no wave", D33_M_PER_V * VOLTAGE_V),
            still("half of it, on each face", 0.5 * D33_M_PER_V * VOLTAGE_V),
            moving(MEASURED_HZ[0]),
            moving(MEASURED_HZ[1]),
        ],
    }
}

fn layer() -> Claim {
    let (sheet, tooth_m) = (Sheet::BEAM, 1e-3);
    let k = MEASURED_HZ.map(|hz| sheet.wave_number(hz));
    let ratio = k.map(|k| (sheet.face_m() + tooth_m) * k / (sheet.face_m() * k));
    let lift = k.map(|k| lift(k, sheet.face_m() + tooth_m)).into_iter().fold(0.0, f64::max);
    let arm = k.map(|k| sheet.face_m() / arm_m(&sheet, k));
    Claim {
        id: "teeth-amplify",
        section: "B.8",
        says: "A metal layer with teeth amplifies the displacements of the sheet (by more than a tenth).",
        checks: vec![
            Check::new(
                "motion along the sheet on a tooth of 1 mm, for an equal wave (B.13)",
                ratio.iter().all(|ratio| *ratio > 1.1),
                vec![number("u on the tooth over u on the face", ratio[0])],
            ),
            Check::new(
                "motion across the sheet on the same tooth, which turns with its section",
                lift > 1.1,
                vec![number("w on the tooth over w on the face", lift)],
            ),
            Check::new(
                "bending moment per volt, bonded to an equal passive sheet, compared with the bare sheet",
                arm.iter().all(|arm| *arm > 1.1),
                vec![number("arm over the bare sheet's, 20 kHz", arm[0]), number("40 kHz", arm[1])],
            ),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with the moment of the field, integrated over the sheet, of a potential that is one
    /// on the upper face and zero on the lower.
    #[test]
    fn the_arm_is_the_moment_of_the_field() {
        let (sheet, k) = (Sheet::BEAM, 543.0);
        let h = sheet.thickness_m;
        let steps = 20_000;
        let field = |z: f64| -k * (k * (z + 0.5 * h)).cosh() / (k * h).sinh();
        let moment: f64 = (0..steps)
            .map(|i| h * ((f64::from(i) + 0.5) / f64::from(steps) - 0.5))
            .map(|z| z * field(z) * h / f64::from(steps))
            .sum();
        assert!((-moment / arm_m(&sheet, k) - 1.0).abs() < 1e-6, "{moment} {}", arm_m(&sheet, k));
        // For waves that are long compared with the thickness the arm is k^2 h^3/24.
        let long = arm_m(&sheet, 10.0) / (100.0 * h.powi(3) / 24.0);
        assert!((long - 1.0).abs() < 1e-4, "{long}");
    }

    /// Shear d15 acts like stretching: with the potential c (x^2 - z^2)/2 the displacements
    /// `u = d31 c x z`, `w = d33 c z^2/2 - (d31 + d15) c x^2/2` have exactly the strains of the
    /// free ceramic.
    #[test]
    fn the_free_curvature_is_without_stress() {
        let (c, x, z, step) = (1e9, 3e-3, 0.2e-3, 1e-6);
        let u = |x: f64, z: f64| D31_M_PER_V * c * x * z;
        let w = |x: f64, z: f64| 0.5 * c * (D33_M_PER_V * z * z - (D31_M_PER_V + D15_M_PER_V) * x * x);
        let slope = |f: &dyn Fn(f64) -> f64, at: f64| (f(at + step) - f(at - step)) / (2.0 * step);
        let (field_x, field_z) = (-c * x, c * z);
        let shear = slope(&|z| u(x, z), z) + slope(&|x| w(x, z), x);
        assert!((slope(&|x| u(x, z), x) / (D31_M_PER_V * field_z) - 1.0).abs() < 1e-9);
        assert!((slope(&|z| w(x, z), z) / (D33_M_PER_V * field_z) - 1.0).abs() < 1e-9);
        assert!((shear / (D15_M_PER_V * field_x) - 1.0).abs() < 1e-9);
    }
}
