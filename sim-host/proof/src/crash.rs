//! The crash, measured: who gets less force at the shoulder, from which actuator, at what price; when a switch comes too late; and whether the
//! crash itself could tell who sits there.
//!
//! ```text
//! single (scene + changes)    the firmware decides, against stack, belt and torso    --+
//! many   (scene + [[vary]])   the same, a thousand crashes a class                   --+--> tables: docs/crash.md, report
//! by_clock (plant alone)      the switch is thrown at stated moments                 --+
//! mass   (plant alone)        mass from force and payout, by least squares           --+
//! ```
//!
//! All of it is simulated (SIL), of assumed people in an assumed belt.

pub mod by_clock;
pub mod many;
pub mod mass;
pub mod single;
pub mod table;

#[cfg(test)]
mod tests;

use std::sync::atomic::AtomicBool;

use rayon::prelude::*;

use self::by_clock::Timed;
use self::many::Class;
use self::mass::Known;
use self::single::{Case, Single};
use scene::load::LoadError;
use sim::run::RunError;
use sim::study::StudyError;

/// The scene that everything is made of.
pub const SCENE: &str = "dring-crash";

/// How much is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Crashes of each class of occupants.
    pub runs: u32,
    /// Crashes from which the mass is to be told.
    pub crashes: u32,
}

impl Extent {
    /// What the documentation states.
    pub const FULL: Self = Extent { runs: 1000, crashes: 4000 };
    /// Enough to see that nothing has become worse.
    pub const QUICK: Self = Extent { runs: 20, crashes: 500 };
}

/// Everything that was run.
pub struct Campaign {
    /// Single crashes, group by group.
    pub single: Vec<Single>,
    /// The switch thrown by a clock.
    pub timed: Vec<Timed>,
    /// Many crashes of each class.
    pub classes: Vec<Class>,
    /// What the crash tells of the mass.
    pub known: Vec<Known>,
}

/// Why there is no campaign.
#[derive(Debug, thiserror::Error)]
pub enum Trouble {
    /// A scene is not valid.
    #[error("the crash `{0}`: {1}")]
    Scene(String, LoadError),
    /// A scene has no result.
    #[error("the crash `{0}` has no result")]
    Empty(String, #[source] RunError),
    /// Many of them have none.
    #[error("the crashes of the {0} occupant have no result")]
    Many(&'static str, #[source] StudyError),
    /// The scene is none of a crash.
    #[error("the scene `{0}` has no [rig.dring]")]
    NoCrash(String),
}

/// A target, judged.
pub struct Judged {
    /// What was to be reached.
    pub what: &'static str,
    /// How much of it.
    pub target: String,
    /// How much it is.
    pub found: f64,
    /// Whether that is enough.
    pub holds: bool,
}

impl Campaign {
    /// Every target, judged.
    pub fn judged(&self) -> Vec<Judged> {
        let single = |case: &str, metric: &str| {
            let found = self.single.iter().find(|single| single.case.name == case);
            found.and_then(|single| single.metrics.get(metric)).unwrap_or(f64::NAN)
        };
        let least =
            |what, found: f64, least: f64| Judged { what, target: format!("at least {least}"), found, holds: found >= least };
        let none = |what, found: f64| Judged { what, target: "0".into(), found, holds: found == 0.0 };
        let class = |name: &str, count: fn(&Class) -> usize| {
            self.classes.iter().find(|class| class.name == name).map_or(f64::NAN, |class| count(class) as f64)
        };
        vec![
            least("5th percentile, ideal switch: less force [%]", single("light", "shoulder_force_reduction_percent"), 30.0),
            least(
                "5th percentile, 2.5 kW: less force [%]",
                single("2.5 kW into the contact", "shoulder_force_reduction_percent"),
                20.0,
            ),
            none("95th percentile: added excursion [mm]", 1e3 * single("heavy", "added_excursion_m")),
            none("95th percentile: wrongly LOW [runs]", class("heavy", Class::low)),
            none("50th percentile: wrongly LOW [runs]", class("medium", Class::low)),
            none("5th percentile: LOW missed [runs]", class("light", Class::high)),
            none("ended in a fault [runs]", self.classes.iter().map(|class| class.faulted() as f64).sum()),
        ]
    }

    /// Whether every target is reached.
    pub fn holds(&self) -> bool {
        self.judged().iter().all(|judged| judged.holds)
    }
}

/// Runs everything; `progress` is told what comes next.
pub fn conduct(extent: Extent, progress: &mut dyn FnMut(&str)) -> Result<Campaign, Trouble> {
    progress("single crashes");
    let single = Case::ALL.par_iter().map(Case::run).collect::<Result<Vec<_>, _>>()?;
    progress("by a clock");
    let timed = by_clock::conduct()?;
    progress("many crashes");
    let classes = many::conduct(extent.runs, &AtomicBool::new(false))?;
    progress("mass by the crash alone");
    Ok(Campaign { single, timed, classes, known: mass::conduct(extent.crashes)? })
}
