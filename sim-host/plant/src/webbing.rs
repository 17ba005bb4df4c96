//! A seat belt, pulled between the horn of a welder and a base (thesis 3.2).
//!
//! ```text
//! pull = mu W (1 - r) in the direction of the belt,   lag r' = R(W, v, a) - r,   horn damped by c = damping W
//! ```
//!
//! `R` is the fitted law ([`empirical`](contact::empirical)) at the true amplitude `a` of the
//! stack's tip, `r` the reduction reached so far. One state, advanced by its exact flow once a
//! block with the amplitude at the block's end: the stack settles in milliseconds, the pull takes
//! over a second. The damping is part of the motional resistance, `Rm + c / phi^2`, and adds no
//! state.
//!
//! The time constant `lag` describes the whole pull: air cylinder, belt and load cell together. The
//! thesis attributes it to inertia, and its data cannot separate them. The speed is constant,
//! although less friction speeds up the real belt.

use crate::belt_motion::BeltMotion;
use crate::circuit::Circuit;
use crate::truth::HornTruth;
use contact::empirical::EmpiricalLaw;
use scene::{Belt, Driven, Empirical};

/// The belt under the horn.
#[derive(Clone, Debug)]
pub struct Webbing {
    law: EmpiricalLaw,
    mu: f64,
    load_n: f64,
    /// Belt under the horn.
    pub belt: BeltMotion,
    /// Last direction of motion, one or minus one; zero before it moves.
    way: f64,
    full_amplitude_m: f64,
    lag_s: f64,
    damping_s_per_m: f64,
    reached: f64,
    truth: HornTruth,
}

impl Webbing {
    /// Creates the belt of a scene before any vibration. The seed determines the ripple of the
    /// speed.
    pub fn new(contact: &Empirical, belt: &Belt, seed: u64) -> Self {
        Webbing {
            law: contact.law(),
            mu: contact.mu,
            load_n: belt.load_n,
            belt: BeltMotion::new(belt.speed_m_per_s).with_ripple(belt.ripple_rms, belt.ripple_hz, seed),
            way: 0.0,
            full_amplitude_m: belt.full_amplitude_m,
            lag_s: belt.lag_s,
            damping_s_per_m: belt.damping_s_per_m,
            reached: 0.0,
            truth: HornTruth::default(),
        }
    }

    /// Returns the force of the horn on the belt, N.
    pub fn load_n(&self) -> f64 {
        self.load_n
    }

    /// Changes the force of the horn on the belt, N. Returns the change of the horn's damping, N
    /// s/m.
    pub fn set_load(&mut self, load_n: f64) -> f64 {
        let before_n = std::mem::replace(&mut self.load_n, load_n);
        self.damping_s_per_m * (load_n - before_n)
    }

    /// Pulls the belt for a block in which the horn vibrates with an amplitude, m. Returns the mean
    /// pull, N.
    pub fn pull(&mut self, amplitude_m: f64, block_s: f64) -> f64 {
        let amplitude_fraction = amplitude_m / self.full_amplitude_m;
        let lasting = self.law.lasting(self.load_n, self.belt.speed_m_per_s(), amplitude_fraction);
        let left = self.reached - lasting;
        let mean = if self.lag_s > 0.0 {
            let gone = -(-block_s / self.lag_s).exp_m1();
            self.reached -= left * gone;
            lasting + left * gone * self.lag_s / block_s
        } else {
            self.reached = lasting;
            lasting
        };
        self.truth = HornTruth { amplitude_fraction, lasting_reduction: lasting };
        // A belt that has stopped still resists the pull.
        let speed = self.belt.speed_m_per_s();
        self.way = if speed == 0.0 { self.way } else { speed.signum() };
        self.way * self.mu * self.load_n * (1.0 - mean)
    }

    /// Returns the vibration of the horn in the last block.
    pub fn truth(&self) -> HornTruth {
        self.truth
    }
}

/// Returns a stack's circuit with the damping of the belt under its tip, if there is one.
pub fn damped(circuit: Circuit, scene: &Driven) -> Circuit {
    let damping_n_s_per_m = scene.belt().map_or(0.0, |(_, belt)| belt.damping_s_per_m * belt.load_n);
    with_damping(circuit, damping_n_s_per_m)
}

/// Returns a circuit with additional damping at its tip, N s/m.
pub fn with_damping(circuit: Circuit, n_s_per_m: f64) -> Circuit {
    Circuit { rm_ohm: circuit.rm_ohm + n_s_per_m / circuit.force_factor_n_per_v.powi(2), ..circuit }
}

#[cfg(test)]
mod tests {
    use super::*;
    use contact::empirical::reached;

    fn webbing(lag_s: f64) -> Webbing {
        let belt = Belt {
            load_n: 270.0,
            speed_m_per_s: 0.025,
            amplitude_fraction: 0.7,
            full_amplitude_m: 85e-6,
            lag_s,
            trigger_delay_s: 0.0,
            damping_s_per_m: 0.06,
            ripple_rms: 0.0,
            ripple_hz: 10.0,
        };
        Webbing::new(&Empirical::default(), &belt, 1)
    }

    /// Blocks of any length follow the same exponential, up and down.
    #[test]
    fn the_pull_follows_with_the_lag() {
        for block_s in [50e-6, 0.1] {
            let mut belt = webbing(0.45);
            let blocks = (2.0 / block_s) as usize;
            (0..blocks).for_each(|_| _ = belt.pull(0.7 * 85e-6, block_s));
            let expected = reached(EmpiricalLaw::FITTED.lasting(270.0, 0.025, 0.7), 2.0, 0.45);
            assert!((belt.reached - expected).abs() < 1e-12, "{} {expected}", belt.reached);
            (0..blocks).for_each(|_| _ = belt.pull(0.0, block_s));
            assert!((belt.reached - expected * (-2f64 / 0.45).exp()).abs() < 1e-12);
        }
    }

    /// The mean over one long block is that over many short ones.
    #[test]
    fn block_mean_is_independent_of_its_length() {
        let (mut one, mut many) = (webbing(0.45), webbing(0.45));
        let long = one.pull(60e-6, 0.3);
        let short = (0..3000).map(|_| many.pull(60e-6, 1e-4)).sum::<f64>() / 3000.0;
        assert!((long / short - 1.0).abs() < 1e-12, "{long} {short}");
        let mut prompt = webbing(0.0);
        assert!((prompt.pull(0.7 * 85e-6, 50e-6) - 0.3 * 270.0 * (1.0 - 0.587)).abs() < 1e-9);
    }

    #[test]
    fn friction_opposes_the_belt_after_its_first_motion() {
        let mut belt = webbing(0.0);
        let forward = belt.pull(60e-6, 1e-3);
        belt.belt = BeltMotion::new(-0.025);
        assert_eq!(belt.pull(60e-6, 1e-3), -forward);
        belt.belt = BeltMotion::new(0.0);
        assert!(belt.pull(60e-6, 1e-3) < 0.0);
        let mut still = webbing(0.0);
        still.belt = BeltMotion::new(0.0);
        assert_eq!(still.pull(60e-6, 1e-3), 0.0);
    }

    #[test]
    fn a_load_damps_the_horn() {
        let rest = Circuit { c0_f: 10e-9, cm_f: 0.2e-9, lm_h: 0.3166, rm_ohm: 25.0, force_factor_n_per_v: 0.331 };
        let more = webbing(0.45).set_load(670.0);
        assert!((more - 24.0).abs() < 1e-12, "{more}");
        assert!((with_damping(rest, more).rm_ohm - 25.0 - 24.0 / 0.331f64.powi(2)).abs() < 1e-9);
    }
}
