//! `friction`: sets the set point of the friction switch.

use clap::Args;
use firmware::board::command::Command;
use firmware::seam::block::Target;

use crate::answer::{Answer, short};
use crate::link_error::LinkError;
use crate::session::Session;

/// Arguments of the command.
#[derive(Args, Clone, Debug)]
pub struct FrictionArgs {
    /// Ratio to the friction without drive, 0 to 1; a force such as `0.05N`; or `configured`.
    #[arg(value_name = "RATIO|FORCE", value_parser = target)]
    target: SetPoint,
}

/// Set point of the friction switch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SetPoint {
    /// The configured set point.
    Configured,
    /// A set point given on the command line.
    Given(Target),
}

fn target(text: &str) -> Result<SetPoint, String> {
    const EXPECTED: &str = "expected a ratio from 0 to 1 (0.4), a force (0.05N), or `configured`";
    let number = |text: &str| text.trim().parse::<f32>().map_err(|_| EXPECTED.to_owned());
    let target = match text.strip_suffix(['N', 'n']) {
        _ if text == "configured" => return Ok(SetPoint::Configured),
        Some(newtons) => Target::Force(number(newtons)?),
        None => Target::Ratio(number(text)?),
    };
    if target.is_plausible() { Ok(SetPoint::Given(target)) } else { Err(EXPECTED.into()) }
}

/// Sends the set point to the board.
pub fn run(args: &FrictionArgs, session: &mut Session) -> Result<Answer, LinkError> {
    let ordered = match args.target {
        SetPoint::Configured => None,
        SetPoint::Given(target) => Some(target),
    };
    session.client.order(Command::Friction(ordered))?;
    let answer = Answer::to("friction");
    let answer = match ordered {
        None => answer.line("friction set point: as configured"),
        Some(Target::Ratio(ratio)) => {
            answer.line(format!("friction set point: {ratio} of the friction without drive")).field("target_ratio", short(ratio))
        }
        Some(Target::Force(newtons)) => {
            answer.line(format!("friction set point: {newtons} N")).field("target_force_n", short(newtons))
        }
    };
    let switched = session.status()?.friction.is_some();
    Ok(if switched { answer } else { answer.line("(not yet active: the friction switch reports once it runs)") })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_and_forces_are_distinguished() {
        assert_eq!(target("0.4"), Ok(SetPoint::Given(Target::Ratio(0.4))));
        assert_eq!(target("0.05N"), Ok(SetPoint::Given(Target::Force(0.05))));
        assert_eq!(target("configured"), Ok(SetPoint::Configured));
        assert!(["1.5", "-1", "half", "nan", "-3N", ""].iter().all(|text| target(text).is_err()));
    }
}
