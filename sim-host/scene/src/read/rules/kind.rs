//! Rules of the kinds of scene: the firmware drives a transducer, a contact is studied alone, or a
//! transducer is designed.

use super::Rules;
use crate::diagnostic::Problem;
use crate::nearest::{listed, shown};
use crate::schema::{Schema, join};
use crate::tree::Node;
use crate::wording::header;

const CONTROLLER: &str = "controller";
const EXCITATION: &str = "excitation";
const DESIGN: &str = "design";

/// Kind of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A scene in which the firmware drives.
    Driven,
    /// A scene of a contact study.
    Excited,
    /// A scene of a design.
    Designed,
}

pub(super) const BELT: &str = "rig.belt";
pub(super) const EMPIRICAL: &str = "contact.empirical";
/// Tables that only a driven scene can have.
const DRIVEN_ONLY: &[&str] = &[
    "amplifier",
    "sensors",
    "stack",
    "stator",
    "trace",
    "fault",
    "rig.slider",
    "rig.rotor",
    "rig.belt",
    "rig.dring",
    "rig.carriage",
    "contact.empirical",
];
/// Tables that a design cannot have.
const NOT_DESIGNED: &[&str] = &[
    "amplifier",
    "sensors",
    "stack",
    "stator",
    "trace",
    "fault",
    "contact",
    "rig",
    "integrator",
    "disturbance",
    "comparison",
    "overlay",
    "duration_s",
];
/// Tables that only a contact study can have.
const EXCITED_ONLY: &[&str] =
    &["rig.kinematic", "rig.sdof", "contact.coulomb", "contact.hertz", "contact.compliant", "contact.expression"];
/// Keys of the integrator that only a contact study can have.
const STUDY_KEYS: &[&str] = &["method", "order", "tolerance", "tolerance_of", "window", "window_periods"];
/// Largest number of steps per period of the stack.
const MAX_DRIVEN_STEPS: f64 = 4096.0;

/// Refuses a scene of two kinds. Everything else in the table that must go is of no interest.
pub(crate) fn two_kinds(root: &Node) -> Option<Problem> {
    let place = |table: &'static str| Some((table, root.table()?.get(table)?.key.clone()));
    let mut kinds: Vec<_> = [CONTROLLER, EXCITATION, DESIGN].into_iter().filter_map(place).collect();
    let named = kinds.iter().map(|(table, _)| header(table)).collect::<Vec<_>>().join(" and ");
    // Sources come before the ones that they change.
    kinds.sort_by_key(|(_, place)| (std::cmp::Reverse(place.source), place.start));
    let [(earlier, _), .., (_, later)] = &kinds[..] else { return None };
    let message = format!("{named} exclude each other");
    let help = "either the firmware drives a stack, or [excitation] excites a contact that is studied alone, or a transducer \
                is designed";
    Some(Problem::new(later.clone(), message, format!("{} is already given", header(earlier))).help(help))
}

impl Rules<'_> {
    /// Determines the kind of the scene, by which of three tables it has. `two_kinds` has refused
    /// several.
    pub(super) fn kind(&mut self) {
        self.kind = match [CONTROLLER, EXCITATION, DESIGN].map(|table| self.given(table)) {
            [true, _, _] => Some(Kind::Driven),
            [_, true, _] => Some(Kind::Excited),
            [_, _, true] => Some(Kind::Designed),
            _ => {
                if self.lacks(CONTROLLER) && self.lacks(EXCITATION) && self.lacks(DESIGN) {
                    let keys = |table: &str| {
                        let schema = Schema::root().at(table);
                        format!("{} with at least {}", header(table), listed(schema.iter().flat_map(|s| s.required()), "and"))
                    };
                    let label = format!("add {}, or {}, or [design]", keys(CONTROLLER), keys(EXCITATION));
                    let message = "a scene needs [controller], [excitation] or [design]";
                    let problem = Problem::new(self.root.place.clone(), message, label);
                    let help = "with [controller] the firmware drives a stack, with [excitation] a contact is studied alone, \
                                with [design] a transducer is designed";
                    self.findings.problems.push(problem.help(help));
                }
                None
            }
        };
    }

    /// Checks that the scene has the tables that its kind requires, and none of the other kind.
    pub(super) fn check_tables(&mut self) {
        let needed: &[(&str, &str, &str)] = match self.kind {
            Some(Kind::Driven) if self.given(BELT) => &[
                (CONTROLLER, "stack", "the horn on the belt is missing: add the stack whose tip it is, [stack.bvd]"),
                ("rig", "contact", "the friction of the belt is missing: add [contact.empirical]"),
            ],
            Some(Kind::Driven) if self.given(EMPIRICAL) => &[
                (CONTROLLER, "stack", "there is nothing to drive: add a stack, [stack.bvd]"),
                ("contact", "rig", "the belt is missing: add [rig.belt]"),
            ],
            Some(Kind::Driven) => &[
                (CONTROLLER, "stack", "there is nothing to drive: add a stack, [stack.bvd], or a motor's [stator]"),
                ("contact", "rig", "nothing presses on the contact and moves it: add a rig, such as [rig.slider]"),
                ("rig", "contact", "there is no contact to press on and move: add one, such as [contact.dahl]"),
            ],
            Some(Kind::Excited) => &[
                (EXCITATION, "contact", "there is no contact to study: add one, such as [contact.dahl]"),
                (EXCITATION, "rig", "nothing carries the contact: add a rig, such as [rig.sdof]"),
            ],
            Some(Kind::Designed) => &[],
            None => &[
                ("contact", "rig", "nothing presses on the contact and moves it: add a rig"),
                ("rig", "contact", "there is no contact to press on and move: add one, such as [contact.dahl]"),
            ],
        };
        for (given, missing, reason) in needed {
            // A stator is driven instead of a stack; rotor and D-ring include their own contact.
            let own_contact = !self.lacks("rig.rotor") || !self.lacks("rig.dring");
            if (*missing == "stack" && !self.lacks("stator")) || (*given == "rig" && own_contact) {
                continue;
            }
            // Problems inside the given table are ignored here.
            if self.root.at(given).and_then(Node::table).is_some() && self.lacks(missing) {
                let message = format!("[{given}] without [{missing}]");
                let problem = Problem::new(self.place(given), message, format!("needs [{missing}]"));
                self.add(missing, problem.help(*reason));
            }
        }
        let foreign = match self.kind {
            Some(Kind::Driven) => EXCITED_ONLY,
            Some(Kind::Excited) => DRIVEN_ONLY,
            Some(Kind::Designed) => NOT_DESIGNED,
            None => &[],
        };
        for table in foreign.iter().filter(|table| self.given(table)).collect::<Vec<_>>() {
            self.add_foreign(table);
        }
    }

    fn add_foreign(&mut self, table: &str) {
        let (scene, owner) = match self.kind {
            Some(Kind::Excited) => ("a contact study", CONTROLLER),
            Some(Kind::Designed) => ("a design", if table == "contact" { EXCITATION } else { CONTROLLER }),
            _ => ("a scene with [controller]", EXCITATION),
        };
        let help = match table {
            _ if self.kind == Some(Kind::Designed) => {
                "a design has no run: its circuit is written to `stack.toml`, and `[stack.design]` of a driven scene uses it"
            }
            "rig.slider" => {
                "a contact study has [rig.sdof] or [rig.kinematic]; its sliding is `excitation.velocity_ratio` or \
                 `sliding_m_per_s`"
            }
            "rig.belt" => "a belt is pulled under the horn of a stack that the firmware drives",
            "contact.empirical" => {
                "this law describes a belt under a driven horn, [rig.belt]; to study a contact alone with vibration across it, \
                 use [contact.hertz]"
            }
            "rig.dring" => "the firmware controls the friction of a D-ring",
            "rig.carriage" => "a carriage slides on the tip of a stack that the firmware drives",
            "rig.rotor" => "a rotor turns on a [stator], which the firmware drives",
            "rig.kinematic" | "rig.sdof" => "the stack vibrates along the motion of [rig.slider]",
            _ if table.starts_with("contact.") => {
                "the contact at a stack's tip is Dahl's, [contact.dahl], or with [rig.carriage] LuGre's, [contact.lugre]"
            }
            _ => "[excitation] excites the contact directly: no controller, converter or stack is simulated",
        };
        let shown = if table.ends_with("_s") { format!("`{table}`") } else { header(table) };
        let message = format!("{shown} cannot be used in {scene}");
        let problem = Problem::new(self.key(table), message, format!("belongs to [{owner}]"));
        self.add(table, problem.help(help));
    }

    /// Checks keys that are fixed in a driven scene.
    pub(super) fn driven(&mut self) {
        for key in STUDY_KEYS.iter().map(|key| join("integrator", key)) {
            if self.value(&key).is_some() {
                let message = format!("`{key}` cannot be used in a scene with [controller]");
                let problem = Problem::new(self.key(&key), message, "belongs to [excitation]");
                self.add(&key, problem.help("the step of a driven contact is set by `integrator.steps_per_period`"));
            }
        }
        let steps = "integrator.steps_per_period";
        if self.number(steps).is_some_and(|steps| steps > MAX_DRIVEN_STEPS) {
            let label = format!("must be at most {} with [controller]", shown(MAX_DRIVEN_STEPS));
            let problem = Problem::new(self.place(steps), format!("`{steps}` is out of range"), label);
            self.add(steps, problem);
        }
        for (normal, help) in [
            ("contact.dahl.normal_n", "the normal force is `rig.slider.load_n` plus `rig.slider.self_weight_n`"),
            ("contact.lugre.normal_n", "the normal force is `rig.carriage.normal_n`"),
        ] {
            if self.value(normal).is_some() {
                let message = "`normal_n` cannot be used in a scene with [controller]";
                let problem = Problem::new(self.key(normal), message, "the rig gives the normal force");
                self.add(normal, problem.help(help));
            }
        }
        for sign in ["contact.dahl.sign", "contact.lugre.sign"] {
            if self.text(sign) == Some("literal") {
                let message = "friction that feeds energy into a stack is not simulated";
                let problem = Problem::new(self.place(sign), message, "must be `passive` with [controller]");
                self.add(sign, problem.help("the literal sign is for contact studies, with [excitation]"));
            }
        }
    }
}
