//! Every rule: a correct program, and one that violates only this rule.

mod clocks;
mod converters;
mod flash;
mod others;

use sonoglide_stm32g474::{Bare, Rule, Verdict};

use crate::rig::{Rig, Setup};

type Program = fn(&mut Rig<Bare>);

/// Runs both programs: the first has no finding, the second only a finding of this rule.
#[track_caller]
pub fn check(rule: Rule, right: Program, wrong: Program) {
    for (program, expected) in [(right, &[][..]), (wrong, &[rule][..])] {
        let mut rig = Rig::bare();
        rig.part.lint.set(Rule::IwdgMissing, if rule == Rule::IwdgMissing { Verdict::Collect } else { Verdict::Ignore });
        program(&mut rig);
        assert_eq!(rig.rules(), expected, "{:#?}", rig.findings());
    }
}

/// Sets the clock to 170 MHz and enables the clocks of all peripherals of the board.
pub fn up(rig: &mut Rig<Bare>) {
    rig.clocks(Setup::default());
}
