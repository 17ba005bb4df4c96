//! Detection of a damaged transducer from its Q and the nominal one.
//!
//! A crack reduces Q to a fifth, and the nominal Q may be wrong by a factor of three. A crack also
//! creates a second resonance nearby, but healthy transducers have such resonances, too, so that it
//! proves nothing.

/// Minimum Q of a healthy transducer, relative to the nominal one.
const MIN_Q_REL: f32 = 1.0 / 3.0;
/// Q relative to the nominal one below which another measurement has to confirm it.
const LOW_Q_REL: f32 = 0.5;

/// Verdict on the transducer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Damage {
    /// Healthy.
    None,
    /// Another measurement has to confirm the low Q.
    Possible,
    /// Damaged.
    Certain,
}

/// Judges the transducer from an upper limit of its Q, relative to the nominal one.
pub(crate) fn damage(q: f32) -> Damage {
    match q {
        q if q < MIN_Q_REL => Damage::Certain,
        q if q < LOW_Q_REL => Damage::Possible,
        _ => Damage::None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_low_q_is_damage() {
        assert_eq!([0.33, 0.34, 0.49, 0.5].map(damage), [Damage::Certain, Damage::Possible, Damage::Possible, Damage::None]);
        // NaN does not indicate damage.
        assert_eq!(damage(f32::NAN), Damage::None);
    }
}
