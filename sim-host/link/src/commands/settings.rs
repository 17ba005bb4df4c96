//! `settings`: what the board keeps over power-off.
//!
//! Parameters are numbers of its configuration. What is set acts after a reset, if it was stored; three values are told apart: what acts, what
//! is set, what is built in. Lane trims act as soon as a calibration has found them.

use clap::Subcommand;
use firmware::board::command::{Command, Reply, Verb};
use firmware::board::kept::Kept;
use firmware::board::parameters::PARAMETERS;
use firmware::seam::config::Parameter;
use firmware::seam::refusal::Refusal;

use crate::answer::{Answer, short};
use crate::client::unexpected;
use crate::link_error::LinkError;
use crate::parameter::{parameter, report};
use crate::session::Session;

/// What to do with the settings.
#[derive(Clone, Debug, Subcommand)]
pub enum SettingsOrder {
    /// Show one parameter, or all.
    Get {
        /// Its name, such as `limits.voltage_v`.
        name: Option<String>,
    },
    /// Set a parameter; it acts after `settings store` and `reset`.
    Set {
        /// Its name.
        name: String,
        /// Its value, in the unit of its name.
        #[arg(allow_hyphen_values = true)]
        value: f32,
    },
    /// Keep parameters and lane trims over power-off.
    Store,
    /// Keep nothing; what acts and what is set stays.
    Clear,
    /// Set everything to what is built in, and trim by nothing; what is kept stays until `store`.
    Defaults,
    /// Show the lane trims.
    Trims,
}

/// Does it.
pub fn run(order: &SettingsOrder, session: &mut Session) -> Result<Answer, LinkError> {
    let plain = |session: &mut Session, verb: Verb, line: &str| -> Result<Answer, LinkError> {
        session.client.order(Command::Settings(verb))?;
        Ok(Answer::to("settings").line(line))
    };
    match order {
        SettingsOrder::Get { name: Some(name) } => get(&[parameter(name)?], session),
        SettingsOrder::Get { name: None } => get(&PARAMETERS.iter().collect::<Vec<_>>(), session),
        SettingsOrder::Set { name, value } => set(parameter(name)?, *value, session),
        SettingsOrder::Store => plain(session, Verb::Store, "kept over power-off"),
        SettingsOrder::Clear => plain(session, Verb::Clear, "nothing is kept; after a reset the board is as it was built"),
        SettingsOrder::Defaults => {
            plain(session, Verb::Defaults, "set to what is built in, and trimmed by nothing; `settings store` keeps that")
        }
        SettingsOrder::Trims => trims(session, Answer::to("settings")),
    }
}

fn get(parameters: &[&Parameter], session: &mut Session) -> Result<Answer, LinkError> {
    let width = parameters.iter().map(|parameter| parameter.name.len()).max().unwrap_or(0);
    let mut answer =
        Answer::to("settings").line(format!("{:width$}  {:>12}  {:>12}  {:>12}  range", "", "acts", "set", "built in"));
    let mut kept = Kept::Nothing;
    for parameter in parameters {
        let of = report(parameter, &mut session.client)?;
        kept = of.kept;
        let reset = match kept {
            _ if of.next == of.acts => "",
            // Left out, or held within a limit; or set since.
            Kept::Partly | Kept::Refused => "  (does not act as it is set)",
            _ => "  (acts after `settings store` and `reset`)",
        };
        answer = answer
            .line(format!(
                "{:width$}  {:>12}  {:>12}  {:>12}  {}{reset}",
                parameter.name,
                number(of.acts),
                number(of.next),
                number(of.built_in),
                range(of.min, of.max)
            ))
            .field(parameter.name, short(of.next));
        if let [_] = parameters {
            let fields = [("acts", of.acts), ("set", of.next), ("built_in", of.built_in), ("min", of.min), ("max", of.max)];
            answer = fields.into_iter().fold(answer, |answer, (name, value)| answer.field(name, short(value)));
        }
    }
    Ok(answer.line(in_words(kept)).field("kept", kept_name(kept)))
}

fn set(parameter: &Parameter, value: f32, session: &mut Session) -> Result<Answer, LinkError> {
    match session.client.order(Command::Settings(Verb::Set(parameter.key, value))) {
        Err(LinkError::Refused { refusal: Refusal::OutOfRange | Refusal::NotPlausible, .. }) => {
            let of = report(parameter, &mut session.client)?;
            let range = range(of.min, of.max);
            Err(LinkError::Failed(format!("{} can be {range}, not {value}; it is {} now", parameter.name, number(of.next))))
        }
        Err(LinkError::Refused { refusal: Refusal::NotConfigured, .. }) => Err(LinkError::Failed(format!(
            "{} is nothing on this board: what it would be judged by is not there (an energy for each metre of belt needs a belt encoder)",
            parameter.name
        ))),
        done => done.map(|()| {
            Answer::to("settings")
                .line(format!("{} = {}; it acts after `settings store` and `reset`", parameter.name, number(value)))
                .field(parameter.name, short(value))
        }),
    }
}

/// The lane trims, and what is kept of them.
pub fn trims(session: &mut Session, mut answer: Answer) -> Result<Answer, LinkError> {
    let mut point = 0;
    loop {
        let report = match session.client.ask(Command::Settings(Verb::Trims(point)))? {
            Reply::Settings(report) => report,
            reply => return Err(unexpected("settings trims", &reply)),
        };
        let Some(found) = report.point.filter(|_| point < report.points) else {
            let none = if point == 0 { "no lane trims act; " } else { "" };
            return Ok(answer
                .line(format!("{none}{}", in_words(report.kept)))
                .field("trim_points", report.points)
                .field("kept", kept_name(report.kept)));
        };
        let lanes = found.lanes.iter().map(|trim| format!("{:+.3} deg x {:.4}", 360.0 * trim.phase_turns, trim.gain));
        answer = answer.line(format!("{:9.1} Hz: {}", found.hz, lanes.collect::<Vec<_>>().join(" | ")));
        point += 1;
    }
}

/// A parameter's value as a reader wants it.
fn number(value: f32) -> String {
    match value {
        _ if value.is_infinite() => "none".into(),
        _ if value == 0.0 || (1e-3..1e6).contains(&value.abs()) => value.to_string(),
        _ => format!("{value:e}"),
    }
}

fn range(min: f32, max: f32) -> String {
    match max {
        _ if min == max => "as built".into(),
        _ if max.is_infinite() => format!("{} and more", number(min)),
        _ => format!("{} to {}", number(min), number(max)),
    }
}

fn kept_name(kept: Kept) -> &'static str {
    match kept {
        Kept::Nothing => "nothing",
        Kept::Stored => "stored",
        Kept::Damaged => "damaged",
        Kept::Version(_) => "other_version",
        Kept::Due => "due",
        Kept::Failed => "failed",
        Kept::Partly => "partly",
        Kept::Refused => "refused",
        Kept::Changed => "changed",
    }
}

/// What the board keeps, in a sentence.
pub(crate) fn in_words(kept: Kept) -> String {
    match kept {
        Kept::Nothing => "the board keeps nothing over power-off".into(),
        Kept::Stored => "the board keeps its settings over power-off".into(),
        Kept::Damaged => "what the board has kept cannot be read; `settings store` replaces it".into(),
        Kept::Version(version) => {
            format!(
                "what the board has kept is of version {version}, which its firmware does not read; `settings store` replaces it"
            )
        }
        Kept::Due => "the board keeps them as soon as its drive is silent".into(),
        Kept::Failed => "the board's flash does not keep them".into(),
        Kept::Partly => {
            "some of what the board has kept does not act as it is: its firmware does not know it, or it is out of its range; `settings get` \
             shows what acts"
                .into()
        }
        Kept::Refused => {
            "what the board has kept does not fit together: its limits act, the drive is held within them, and what does not fit is left out; \
             `settings get` shows what acts and what is set"
                .into()
        }
        Kept::Changed => "what is set differs from what the board keeps: `settings store` keeps it, a reset forgets it".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_setting_names_the_nearest() {
        let error = |name: &str| parameter(name).err().unwrap().to_string();
        assert_eq!(error("limit.voltage_v"), "there is no setting `limit.voltage_v`; did you mean `limits.voltage_v`?");
        assert_eq!(error("scan_volts"), "there is no setting `scan_volts`; did you mean `drive.scan_volts`?");
        assert_eq!(error("colour"), "there is no setting `colour`; `settings get` lists them");
    }

    #[test]
    fn ranges_read_well() {
        assert_eq!(
            (range(0.001, f32::INFINITY), range(1e-12, 1e-3), range(2.0, 2.0)),
            ("0.001 and more".into(), "1e-12 to 0.001".into(), "as built".into())
        );
    }
}
