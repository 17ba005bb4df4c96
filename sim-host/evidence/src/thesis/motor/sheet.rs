//! The sheet of the prototype: values of Figure B.8 and B.4, and assumed values that they lack.

/// Length of an inch, m.
pub const INCH_M: f64 = 25.4e-3;
/// Permittivity of free space, F/m.
pub const VACUUM_F_PER_M: f64 = 8.854e-12;

/// Density, kg/m^3 (Figure B.8).
pub const DENSITY_KG_PER_M3: f64 = 7800.0;
/// Density of the simulation, kg/m^3 (Table B.1).
pub const DENSITY_SIMULATED_KG_PER_M3: f64 = 7750.0;
/// Young's modulus in the plane, Pa (Figure B.8, its second row); bending stretches along the
/// sheet.
pub const IN_PLANE_PA: f64 = 6.6e10;
/// Young's modulus through the thickness, Pa (Figure B.8, YE3).
pub const THROUGH_PA: f64 = 5.2e10;
/// Relative permittivity (Figure B.8).
pub const PERMITTIVITY: f64 = 1800.0;
/// Strain through the thickness per field, m/V (Figure B.8).
pub const D33_M_PER_V: f64 = 390e-12;
/// Strain along the sheet per field, m/V (Figure B.8).
pub const D31_M_PER_V: f64 = -190e-12;
/// Mechanical quality (Figure B.8).
pub const QUALITY: f64 = 80.0;
/// Field at which depolarisation begins, V/m (Figure B.8).
pub const DEPOLARISING_V_PER_M: f64 = 5e5;
/// Thickness, m: 0.040" (B.4).
pub const THICKNESS_M: f64 = 0.040 * INCH_M;
/// Side, m: 2.85" (B.4).
pub const SIDE_M: f64 = 2.85 * INCH_M;

/// Poisson's ratio, missing in Figure B.8: -s12/s11 of PZT-5A, 5.74/16.4 (A. Erturk, D. J. Inman,
/// *Piezoelectric Energy Harvesting*, 2011, Table E.1).
pub const POISSON: f64 = 5.74 / 16.4;
/// Shear modulus of bending, Pa, missing in Figure B.8: 1/s55 of PZT-5A (the same table).
pub const SHEAR_PA: f64 = 1.0 / 47.5e-12;
/// Shear per field across the poling, m/V, missing in Figure B.8: d15 of PZT-5A (the same table).
pub const D15_M_PER_V: f64 = 584e-12;
/// Density of PZT-5H, kg/m^3 (the same source).
pub const DENSITY_5H_KG_PER_M3: f64 = 7500.0;
/// Density of PZT-5A, kg/m^3 (the same source).
pub const DENSITY_5A_KG_PER_M3: f64 = 7750.0;

/// Sheet in bending.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheet {
    /// Young's modulus along the wave, Pa.
    pub modulus_pa: f64,
    /// Density of the material, kg/m^3.
    pub density_kg_per_m3: f64,
    /// Thickness of the layer, m.
    pub thickness_m: f64,
    /// Poisson's ratio: zero for a narrow beam, whose sides are free to move.
    pub poisson: f64,
}

impl Sheet {
    /// The prototype as a beam, as in the appendix.
    pub const BEAM: Sheet =
        Sheet { modulus_pa: IN_PLANE_PA, density_kg_per_m3: DENSITY_KG_PER_M3, thickness_m: THICKNESS_M, poisson: 0.0 };
    /// The prototype as a plate that is wide compared with the wave.
    pub const PLATE: Sheet = Sheet { poisson: POISSON, ..Sheet::BEAM };

    /// Returns the bending stiffness per width, N m: `E h^3 / (12 (1 - nu^2))`.
    pub fn stiffness_n_m(&self) -> f64 {
        self.modulus_pa * self.thickness_m.powi(3) / (12.0 * (1.0 - self.poisson * self.poisson))
    }

    /// Returns the constant of B.10, m^2/s: `c = sqrt(EI / (rho A))`. It is not a speed: the wave's
    /// is sqrt(c w).
    pub fn c_m2_per_s(&self) -> f64 {
        (self.stiffness_n_m() / (self.density_kg_per_m3 * self.thickness_m)).sqrt()
    }

    /// Returns the wave number of the free bending wave, rad/m (B.12).
    pub fn wave_number(&self, frequency_hz: f64) -> f64 {
        (std::f64::consts::TAU * frequency_hz / self.c_m2_per_s()).sqrt()
    }

    /// Returns the frequency of the free bending wave of a wave number, Hz: the inverse of B.12.
    pub fn frequency_hz(&self, wave_number: f64) -> f64 {
        wave_number * wave_number * self.c_m2_per_s() / std::f64::consts::TAU
    }

    /// Returns the distance of a face from the middle, m: z of B.13.
    pub fn face_m(&self) -> f64 {
        0.5 * self.thickness_m
    }

    /// Returns the speed of a crest's particle along the sheet, m/s: `a w z k`, for a wave of
    /// amplitude a.
    pub fn crest_m_per_s(&self, amplitude_m: f64, frequency_hz: f64) -> f64 {
        amplitude_m * std::f64::consts::TAU * frequency_hz * self.face_m() * self.wave_number(frequency_hz)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the feasibility study, computed with other code.
    #[test]
    fn the_wave_has_the_numbers_of_an_independent_study() {
        let beam = Sheet::BEAM;
        assert!((beam.wave_number(20e3) - 384.0).abs() < 0.5 && (beam.wave_number(40e3) - 543.0).abs() < 0.5);
        assert!((1e3 * beam.crest_m_per_s(20e-9, 20e3) - 0.49).abs() < 5e-3);
        assert!((1e3 * beam.crest_m_per_s(20e-9, 40e3) - 1.39).abs() < 5e-3);
    }

    #[test]
    fn frequency_and_wave_number_are_inverse() {
        let back = Sheet::PLATE.frequency_hz(Sheet::PLATE.wave_number(31e3));
        assert!((back / 31e3 - 1.0).abs() < 1e-14, "{back}");
    }
}
