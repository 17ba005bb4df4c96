//! Detection of a damaged transducer from its resonances and the nominal values.
//!
//! A crack reduces Q to a fifth and creates a second resonance nearby. The nominal Q may be wrong
//! by a factor of three, and a healthy transducer may have a second resonance nearby. Damage is
//! therefore reported only if both occur together, or if Q is even lower.

/// Minimum Q of a healthy transducer, relative to the nominal one.
const MIN_Q_REL: f32 = 1.0 / 3.0;
/// Minimum Q with a second resonance nearby, relative to the nominal one.
const MIN_Q_WITH_NEIGHBOUR_REL: f32 = 0.5;
/// Maximum distance of a second resonance that indicates a crack, relative to the first.
const CRACK_DISTANCE_REL: f32 = 0.035;
/// Minimum strength of a second resonance that indicates a crack, relative to the first.
const CRACK_STRENGTH_REL: f32 = 0.1;

/// Verdict on the transducer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Damage {
    /// Healthy.
    None,
    /// Damaged only if there is a second resonance nearby.
    Possible,
    /// Damaged.
    Certain,
}

/// Judges the transducer from an upper limit of its Q, relative to the nominal one, and from the
/// other resonances: distance and strength of each, relative to the first.
pub(crate) fn damage(q: f32, others: impl IntoIterator<Item = (f32, f32)>) -> Damage {
    let mut neighbours =
        others.into_iter().filter(|(distance, strength)| distance.abs() < CRACK_DISTANCE_REL && *strength > CRACK_STRENGTH_REL);
    match q {
        q if q < MIN_Q_REL => Damage::Certain,
        q if q < MIN_Q_WITH_NEIGHBOUR_REL && neighbours.next().is_some() => Damage::Certain,
        q if q < MIN_Q_WITH_NEIGHBOUR_REL => Damage::Possible,
        _ => Damage::None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn low_q_and_a_second_resonance_are_damage() {
        assert_eq!(damage(0.2, []), Damage::Certain);
        assert_eq!(damage(0.4, [(-0.015, 0.2)]), Damage::Certain);
        for far_or_weak in [(0.05, 0.2), (-0.015, 0.05)] {
            assert_eq!(damage(0.4, [far_or_weak]), Damage::Possible);
        }
        assert_eq!(damage(0.6, [(-0.015, 0.2)]), Damage::None);
        // NaN does not indicate damage.
        assert_eq!(damage(f32::NAN, []), Damage::None);
    }
}
