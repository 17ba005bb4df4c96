//! Rules of a carriage: its contact has static friction, and its motion follows from forces.

use super::drive::FREQUENCY;
use super::kind::Kind;
use super::{Rules, shown};
use crate::diagnostic::Problem;
use crate::schema::join;
use crate::wording::{self, header};

pub(super) const CARRIAGE: &str = "rig.carriage";
pub(super) const LUGRE: &str = "contact.lugre";
/// Smallest ratio of the drive frequency to the carriage's own frequency.
const MIN_FREQUENCY_RATIO: f64 = 10.0;
/// Faults that stop a belt.
const BELT_STOP_FAULTS: [&str; 2] = ["belt_stopped", "encoder_lies"];

impl Rules<'_> {
    pub(super) fn carriage(&mut self) {
        self.check_carriage_pair();
        if !self.given(CARRIAGE) {
            return;
        }
        for kind in self.tables("fault").into_iter().map(|path| join(&path, "kind")).collect::<Vec<_>>() {
            if let Some(fault) = self.text(&kind).filter(|fault| BELT_STOP_FAULTS.contains(fault)) {
                let message = format!("a carriage cannot have the fault `{fault}`");
                let problem = Problem::new(self.place(&kind), message, "only for a belt or a slider");
                self.add(&kind, problem.help("a carriage moves according to the forces on it"));
            }
        }
        let (pull, at_s, stiffness) = ("rig.carriage.pull_m_per_s", "rig.carriage.pull_at_s", "rig.carriage.stiffness_n_per_m");
        if let Some(time) = self.number(at_s) {
            self.within_the_run(at_s, time);
        }
        if let (Some(speed), Some(0.0)) = (self.number(pull).filter(|speed| *speed != 0.0), self.number(stiffness)) {
            let message = format!("a pull of {} m/s by a spring without stiffness", shown(speed));
            let problem = Problem::new(self.place(pull), message, format!("needs `{stiffness}`"));
            self.add(pull, problem.help("a constant force is `rig.carriage.force_n`"));
        }
        self.check_slow();
    }

    /// Checks that the carriage is slow against the vibration, because it is simulated in steps of
    /// the vibration, and that neither carriage nor tip is damped within such a step.
    fn check_slow(&mut self) {
        const MASS: &str = "rig.carriage.mass_kg";
        let numbers =
            ["rig.carriage.stiffness_n_per_m", "contact.lugre.stiffness_n_per_m", MASS, FREQUENCY].map(|key| self.number(key));
        let [Some(spring), Some(bristles), Some(mass), Some(drive_hz)] = numbers else { return };
        let (own_hz, most_hz) = (((spring + bristles) / mass).sqrt() / std::f64::consts::TAU, drive_hz / MIN_FREQUENCY_RATIO);
        if own_hz > most_hz {
            let message = format!("the carriage oscillates on spring and contact at {} Hz", shown(own_hz.round()));
            let label = format!("must be at most {} Hz: needs a larger mass", shown(most_hz));
            let problem = Problem::new(self.place(MASS), message, label);
            self.add(
                MASS,
                problem
                    .help("the limit is a tenth of `controller.drive.frequency_hz`: the carriage must not follow the vibration"),
            );
        }
        let tip_kg = self.number("stack.bvd.lm_h").zip(self.number("stack.bvd.force_factor_n_per_v"));
        let lightest = tip_kg.map_or(mass, |(lm_h, factor)| mass.min(lm_h * factor * factor));
        let most = std::f64::consts::TAU * most_hz;
        for (key, on_kg) in
            [("rig.carriage.damping_n_s_per_m", mass), ("contact.lugre.sigma1", lightest), ("contact.lugre.sigma2", lightest)]
        {
            if self.number(key).is_some_and(|damping| damping > most * on_kg) {
                let label =
                    format!("must be at most {} N s/m here", shown(wording::bound(most * on_kg, -1.0, |x| x <= most * on_kg)));
                let problem =
                    Problem::new(self.place(key), format!("`{key}` stops the motion within a few periods of the drive"), label);
                self.add(key, problem.help("carriage and tip must not stop within a step of the simulation"));
            }
        }
    }

    /// Checks the pair: a carriage needs static friction, as in LuGre's model, and LuGre's contact
    /// under a driven tip needs a carriage.
    fn check_carriage_pair(&mut self) {
        if self.kind != Some(Kind::Driven) || self.given("stator") {
            return;
        }
        let tables = |table: &str, own: &str| {
            let keys = self.root.at(table).and_then(|node| node.table());
            let keys = keys.into_iter().flat_map(|table| table.keys()).map(|key| join(table, key));
            keys.filter(|path| path != own && self.clean(path)).collect::<Vec<_>>()
        };
        let of_carriage =
            "a carriage starts by itself, which needs static friction; with `static_mu` equal to `mu` the contact is Dahl's";
        let of_contact = "static friction matters only if motion can stop: with a slider of given speed, use [contact.dahl]";
        let (wrong, with, needed, help) = match (self.given(CARRIAGE), self.given(LUGRE)) {
            (true, false) => (tables("contact", LUGRE), CARRIAGE, LUGRE, of_carriage),
            (false, true) => (tables("rig", CARRIAGE), LUGRE, CARRIAGE, of_contact),
            _ => return,
        };
        for path in wrong {
            let message = format!("[{with}] and {} cannot be combined", header(&path));
            let problem = Problem::new(self.key(&path), message, format!("[{with}] needs [{needed}]"));
            self.add(&path, problem.help(help));
        }
    }
}
