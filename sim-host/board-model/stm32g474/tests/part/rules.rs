//! Every rule of the lint: a program that is right, and one that trips just this rule.

mod clocks;
mod converters;
mod flash;
mod others;

use sonoglide_stm32g474::{Bare, Rule, Verdict};

use crate::rig::{Rig, Setup};

type Program = fn(&mut Rig<Bare>);

/// Runs both programs: the first one has no finding, the second one just this one.
#[track_caller]
pub fn check(rule: Rule, right: Program, wrong: Program) {
    for (program, expected) in [(right, &[][..]), (wrong, &[rule][..])] {
        let mut rig = Rig::bare();
        rig.part.lint.set(Rule::IwdgMissing, if rule == Rule::IwdgMissing { Verdict::Collect } else { Verdict::Ignore });
        program(&mut rig);
        assert_eq!(rig.rules(), expected, "{:#?}", rig.findings());
    }
}

/// A part that runs at 170 MHz with all that the board uses clocked.
pub fn up(rig: &mut Rig<Bare>) {
    rig.clocks(Setup::default());
}
