//! Single crashes: the scene with changes, and what comes of it. The firmware decides.

use super::{SCENE, Trouble};
use scene::load::load;
use sim::instruments::measure;
use sim::metrics::Metrics;
use sim::run::{self, Watch};

/// What a case is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Who sits there.
    Occupant,
    /// What lowers the friction, for the light occupant.
    Actuator,
    /// The same, ON as soon as the belt pulls.
    Early,
    /// How far webbing is wrapped.
    Wrap,
    /// Where the load limiter lets go.
    Limiter,
    /// What the controller is told, and what lies.
    Doubt,
}

/// A scene with changes.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// In words.
    pub name: &'static str,
    /// What it is about.
    pub group: Group,
    /// Changes of the scene.
    pub sets: &'static [&'static str],
}

/// A case that has been run.
pub struct Single {
    /// Which.
    pub case: &'static Case,
    /// Its numbers.
    pub metrics: Metrics,
}

const fn case(group: Group, name: &'static str, sets: &'static [&'static str]) -> Case {
    Case { name, group, sets }
}

impl Case {
    /// All of them.
    pub const ALL: &'static [Case] = &[
        case(Group::Occupant, "light", &[]),
        case(Group::Occupant, "medium", &["rig.dring.occupant=50th"]),
        case(Group::Occupant, "heavy", &["rig.dring.occupant=95th"]),
        case(Group::Actuator, "ideal switch", &[]),
        case(Group::Actuator, "5 m/s tip, Coulomb", &["rig.dring.actuator=tangential"]),
        case(Group::Actuator, "5 m/s tip, Dahl", &["rig.dring.actuator=tangential_dahl"]),
        case(Group::Actuator, "2.5 kW into the contact", &["rig.dring.actuator=power"]),
        case(Group::Actuator, "5 kW into the contact", &["rig.dring.actuator=power", "rig.dring.power_w=5000"]),
        case(Group::Actuator, "10 kW into the contact", &["rig.dring.actuator=power", "rig.dring.power_w=10000"]),
        case(Group::Actuator, "the 40 kHz stack", &["rig.dring.actuator=stack"]),
        case(Group::Actuator, "normal vibration", &["rig.dring.actuator=normal"]),
        case(Group::Early, "the 40 kHz stack, ON from the first pull", &[AT_ONCE, "rig.dring.actuator=stack"]),
        case(Group::Early, "normal vibration, ON from the first pull", &[AT_ONCE, "rig.dring.actuator=normal"]),
        case(Group::Wrap, "90 degrees", &["rig.dring.wrap_deg=90"]),
        case(Group::Wrap, "120 degrees", &["rig.dring.wrap_deg=120"]),
        case(Group::Wrap, "150 degrees", &[]),
        case(Group::Wrap, "180 degrees", &["rig.dring.wrap_deg=180"]),
        case(Group::Limiter, "2.2 kN", &[]),
        case(Group::Limiter, "3.0 kN", &["rig.dring.limiter_n=3000"]),
        case(Group::Limiter, "3.7 kN", &["rig.dring.limiter_n=3700"]),
        case(Group::Doubt, "the seat reads nothing", &["rig.dring.seat_reads=false"]),
        case(Group::Doubt, "the seat reads 3 kg", &["rig.dring.torso_kg=14", "rig.dring.seat_error=-0.7857142857142857"]),
        case(Group::Doubt, "the seat reads a light torso as 22 kg", &["rig.dring.seat_error=0.5714285714285714"]),
        case(Group::Doubt, "the force channel is stuck at nothing", &["fault.0.kind=force_stuck", "fault.0.at_s=0.05"]),
        case(Group::Doubt, "a line of the encoder is broken", &["fault.0.kind=encoder_lost", "fault.0.at_s=0.059"]),
    ];

    /// Runs and measures it.
    pub fn run(&'static self) -> Result<Single, Trouble> {
        let name = || self.name.to_owned();
        let sets: Vec<String> = self.sets.iter().map(|&set| set.to_owned()).collect();
        let loaded = load(SCENE, &sets).map_err(|error| Trouble::Scene(name(), error))?;
        let scene = loaded.scene.driven().ok_or_else(|| Trouble::NoCrash(name()))?;
        let record = run::run(&scene, Watch::default()).map_err(|error| Trouble::Empty(name(), error))?;
        Ok(Single { case: self, metrics: measure(&scene, &record) })
    }

    /// How to run it by itself.
    pub fn command(&self) -> String {
        let sets: String = self.sets.iter().map(|set| format!(" --set {set}")).collect();
        format!("sim-host run {SCENE}{sets}")
    }
}

/// Less than the belt's pretension: the crash is sensed as soon as webbing comes out.
const AT_ONCE: &str = "controller.restraint.sensed_n=1";
