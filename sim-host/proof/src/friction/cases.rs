//! The cases: a contact, how its friction is switched, and what is wrong of what is told.

use contact::closed::friction_ratio;
use scene::load::{LoadError, Loaded, load};

/// Friction in silence, N: mu 0.3 under 0.48 N.
const COULOMB_N: f64 = 0.144;
/// Loudest tip velocity, m/s, and frequency, Hz.
const LOUDEST: (f64, f64) = (0.175, 40e3);
/// The survey is over by then, s, and every ratio is held for so long.
const SURVEYED_S: f64 = 0.6;
const HELD_S: f64 = 0.12;

/// Dahl lengths of the contacts, m, from stiff to soft.
pub const LENGTHS_M: [f64; 4] = [0.15e-6, 0.5e-6, 2e-6, 5.36e-6];
/// Sliding speeds of experiment 1, m/s.
pub const SPEEDS_M_PER_S: [f64; 2] = [0.038, 0.068];

/// How the friction is switched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// By amplitude, and the inverse of Dahl's law.
    Amplitude,
    /// By amplitude, and the inverse of Coulomb's: the reference.
    Coulomb,
    /// By boosted bursts at this frequency, Hz.
    Bursts(f64),
    /// By bursts without a boost, at this frequency, Hz: what the boost is for.
    Plain(f64),
}

/// A case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// Dahl length of the contact, m.
    pub length_m: f64,
    /// Sliding speed, m/s.
    pub speed_m_per_s: f64,
    /// What is told of the speed, over what it is.
    pub told: f64,
    /// How.
    pub way: Way,
}

impl Case {
    /// In words.
    pub fn name(&self) -> String {
        let way = match self.way {
            Way::Amplitude => "amplitude".to_owned(),
            Way::Coulomb => "amplitude by Coulomb's law".to_owned(),
            Way::Bursts(hz) => format!("boosted bursts, {hz} Hz"),
            Way::Plain(hz) => format!("plain bursts, {hz} Hz"),
        };
        let micrometres = 1e6 * self.length_m;
        format!("{micrometres} um, {} m/s, told {} %: {way}", self.speed_m_per_s, (1e2 * (self.told - 1.0)).round())
    }

    /// The ratio of this contact at a tip velocity, m/s, by the closed form of steady Dahl friction.
    pub fn ratio_at(&self, tip_m_per_s: f64) -> f64 {
        friction_ratio(self.speed_m_per_s / tip_m_per_s, tip_m_per_s / (std::f64::consts::TAU * LOUDEST.1 * self.length_m))
    }

    /// The least ratio.
    pub fn floor(&self) -> f64 {
        self.ratio_at(LOUDEST.0)
    }

    /// Kappa at the loudest drive.
    pub fn kappa(&self) -> f64 {
        LOUDEST.0 / (std::f64::consts::TAU * LOUDEST.1 * self.length_m)
    }

    /// The ratios that are wanted: parts of what lies above the floor. By bursts as far as their duty goes, from 0.15 to a ratio of 0.8; by
    /// amplitude beyond on either side, and what lies below the floor.
    pub fn wanted(&self) -> Vec<f64> {
        let floor = self.floor();
        let above = |part: f64| floor + part * (1.0 - floor);
        let round = |ratio: f64| (1e4 * ratio).round() / 1e4;
        let wanted = match self.way {
            Way::Bursts(_) | Way::Plain(_) => {
                let most = (0.8 - floor) / (1.0 - floor);
                (0..5).map(|n| above(0.15 + 0.25 * f64::from(n) * (most - 0.15))).collect()
            }
            Way::Amplitude => [0.03, 0.15, 0.3, 0.5, 0.7, 0.85, 0.95].map(above).into_iter().chain([0.6 * floor]).collect(),
            Way::Coulomb => [0.15, 0.3, 0.5, 0.7, 0.85].map(above).to_vec(),
        };
        wanted.into_iter().map(round).collect()
    }

    fn changes(&self) -> Vec<String> {
        let wanted = self.wanted();
        let list = |values: Vec<f64>| format!("[{}]", values.iter().map(f64::to_string).collect::<Vec<_>>().join(", "));
        // The first is wanted from the beginning, and held from the survey on.
        let times = (1..wanted.len()).map(|n| SURVEYED_S + HELD_S * n as f64).map(|s| (1e3 * s).round() / 1e3).collect();
        let set = |key: &str, value: &dyn std::fmt::Display| format!("{key}={value}");
        let mut changes = vec![
            set("contact.dahl.stiffness_n_per_m", &(COULOMB_N / self.length_m).round()),
            set("rig.slider.speed_m_per_s", &self.speed_m_per_s),
            set("controller.friction.speed_m_per_s", &((1e6 * self.told * self.speed_m_per_s).round() / 1e6)),
            set("controller.friction.step_s", &list(times)),
            set("duration_s", &((1e3 * (SURVEYED_S + HELD_S * wanted.len() as f64)).round() / 1e3)),
            set("controller.friction.target_ratio", &wanted[0]),
            set("controller.friction.step_ratio", &list(wanted[1..].to_vec())),
        ];
        match self.way {
            Way::Amplitude => {}
            Way::Coulomb => changes.push(set("controller.friction.law", &"\"coulomb\"")),
            Way::Bursts(hz) => changes.push(set("controller.burst.period_s", &(1.0 / hz))),
            Way::Plain(hz) => {
                changes.extend([set("controller.burst.period_s", &(1.0 / hz)), set("controller.burst.edge", &"\"hard\"")]);
            }
        }
        changes
    }

    fn scene(&self) -> &'static str {
        if matches!(self.way, Way::Bursts(_) | Way::Plain(_)) { "friction-burst" } else { "friction-ratio" }
    }

    /// The scene.
    pub fn load(&self) -> Result<Loaded, LoadError> {
        load(self.scene(), &self.changes())
    }

    /// How to run it by itself.
    pub fn command(&self) -> String {
        let sets: String = self.changes().iter().map(|set| format!(" --set '{set}'")).collect();
        format!("sim-host run {}{sets}", self.scene())
    }
}

/// Every case: contacts by speeds, told 2 % too little and too much.
pub fn all() -> Vec<Case> {
    let mut cases = Vec::new();
    for length_m in LENGTHS_M {
        for speed_m_per_s in SPEEDS_M_PER_S {
            let case = |told: f64, way: Way| Case { length_m, speed_m_per_s, told, way };
            cases.extend([case(0.98, Way::Amplitude), case(1.02, Way::Amplitude), case(0.98, Way::Coulomb)]);
            cases.extend([250.0, 500.0, 1000.0].map(|hz| case(0.98, Way::Bursts(hz))));
            cases.extend([case(1.02, Way::Bursts(1000.0)), case(0.98, Way::Plain(1000.0))]);
        }
    }
    cases
}

/// A few of them, for continuous integration.
pub fn few() -> Vec<Case> {
    let kept = |case: &Case| match case.way {
        Way::Amplitude => case.told < 1.0,
        Way::Bursts(hz) => hz == 1000.0 && case.told > 1.0,
        Way::Coulomb | Way::Plain(_) => false,
    };
    all().into_iter().filter(|case| case.speed_m_per_s == SPEEDS_M_PER_S[0] && kept(case)).collect()
}
