//! Whether a resonance is that of a damaged transducer, as far as nominal values tell.
//!
//! A crack leaves a fifth of Q, and makes a second resonance near by. A nominal Q may be wrong by a factor of three, and a healthy transducer may have
//! a second resonance near by: neither says anything by itself, but both together, or a Q that is lower still.

/// Smallest Q of a healthy transducer, relative to the nominal one; and with the company of a crack.
const SMALLEST_Q: f32 = 1.0 / 3.0;
const CRACKED_Q: f32 = 0.5;
/// A second resonance that is as near as this to the first, relative to it, and this strong, is the company of a crack.
const CRACK: (f32, f32) = (0.035, 0.1);

/// What a Q and the company of other resonances say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Damage {
    /// It is healthy.
    None,
    /// It would be damaged if it had company.
    Possible,
    /// It is damaged.
    Certain,
}

/// What a Q at most, relative to the nominal one, and the other resonances say: how far each is from the first, relative to it, and its strength, the same.
pub(crate) fn damage(q: f32, others: impl IntoIterator<Item = (f32, f32)>) -> Damage {
    let mut company = others.into_iter().filter(|(apart, strength)| apart.abs() < CRACK.0 && *strength > CRACK.1);
    match q {
        q if q < SMALLEST_Q => Damage::Certain,
        q if q < CRACKED_Q && company.next().is_some() => Damage::Certain,
        q if q < CRACKED_Q => Damage::Possible,
        _ => Damage::None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_low_quality_factor_and_company_together_are_damage() {
        assert_eq!(damage(0.2, []), Damage::Certain);
        assert_eq!(damage(0.4, [(-0.015, 0.2)]), Damage::Certain);
        for far_or_weak in [(0.05, 0.2), (-0.015, 0.05)] {
            assert_eq!(damage(0.4, [far_or_weak]), Damage::Possible);
        }
        assert_eq!(damage(0.6, [(-0.015, 0.2)]), Damage::None);
        // What is no number accuses nobody.
        assert_eq!(damage(f32::NAN, []), Damage::None);
    }
}
