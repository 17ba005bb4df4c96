//! Materials: elastic and piezoelectric constants with their losses.
//!
//! ```text
//! epsS = epsT (1 - k33^2),   sD = sE (1 - k33^2),   g33 = d33 / epsT,   k33^2 = d33^2 / (sE epsT)
//! ```

use crate::keys::Material;
use crate::port::C;

/// Permittivity of free space, F/m.
const EPSILON_0: f64 = 8.854_187_812_8e-12;

/// Piezoelectric constants along the axis, with losses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ceramic {
    /// Compliance at constant field `s33E`, 1/Pa.
    compliance_e: C,
    /// Permittivity at constant stress `eps33T`, F/m.
    permittivity_t: C,
    /// `d33`, m/V.
    d33: f64,
}

impl Ceramic {
    /// Returns the square of the coupling `k33`.
    pub(crate) fn coupling_square(&self) -> C {
        C::new(self.d33 * self.d33, 0.0) / (self.compliance_e * self.permittivity_t)
    }

    /// Returns the modulus at constant charge, `1 / s33D`, Pa.
    pub(crate) fn modulus_d(&self) -> C {
        (self.compliance_e * (C::new(1.0, 0.0) - self.coupling_square())).inv()
    }

    /// Returns `g33`, V m/N.
    pub(crate) fn g33(&self) -> C {
        C::new(self.d33, 0.0) / self.permittivity_t
    }

    /// Returns the permittivity at constant strain, F/m.
    pub(crate) fn permittivity_s(&self) -> C {
        self.permittivity_t * (C::new(1.0, 0.0) - self.coupling_square())
    }
}

impl Material {
    /// Returns Young's modulus with its loss, Pa: `E (1 + j/Q)`; `q` replaces the material's own Q.
    pub(crate) fn modulus(&self, q: f64) -> C {
        C::new(self.modulus_pa, self.modulus_pa / q)
    }

    /// Returns the piezoelectric constants, if there are any; `q` and `loss_tangent` replace the
    /// material's own losses.
    pub(crate) fn ceramic(&self, q: f64, loss_tangent: f64) -> Option<Ceramic> {
        let permittivity = EPSILON_0 * self.permittivity?;
        Some(Ceramic {
            compliance_e: self.modulus(q).inv(),
            permittivity_t: C::new(permittivity, -permittivity * loss_tangent),
            d33: self.d33_m_per_v?,
        })
    }
}
