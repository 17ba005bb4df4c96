//! `settings`: the parameters that the board stores over power-off.
//!
//! A parameter is a number of the board's configuration. It has three values: the active one, the
//! set one (active after `settings store` and a restart) and the default. Lane trims are active as
//! soon as a calibration has measured them.

use clap::{Args, Subcommand};
use firmware::board::command::{Command, Reply, Verb};
use firmware::board::parameters::{PARAMETERS, need_of};
use firmware::board::stored_state::StoredState;
use firmware::seam::config::Parameter;
use firmware::seam::refusal::Refusal;

use crate::answer::{Answer, short};
use crate::client::unexpected;
use crate::link_error::LinkError;
use crate::parameter::{named, parameter, range, read, report, shown};
use crate::session::Session;
use crate::words;
use scene::nearest::listed;

/// Minimum number of stores in the life of a flash. A page of the Nucleo endures 10 000 erase
/// cycles (DS12288); each half has four pages, and each page holds three of the longest records.
const MIN_STORES: u32 = 100_000;

/// Order without a name: all parameters.
const ALL: SettingsOrder = SettingsOrder::Get { name: None };

/// Arguments of the command.
#[derive(Args, Clone, Debug)]
pub struct SettingsArgs {
    #[command(subcommand)]
    order: Option<SettingsOrder>,
}

impl SettingsArgs {
    /// Returns the order; without one, all parameters are listed.
    pub fn order(&self) -> &SettingsOrder {
        self.order.as_ref().unwrap_or(&ALL)
    }
}

/// Command on the settings.
#[derive(Clone, Debug, Subcommand)]
pub enum SettingsOrder {
    /// Show one parameter, those of a group, or all.
    #[command(visible_alias = "list")]
    Get {
        /// Name of the parameter, such as `limits.voltage_v`, or of a group, such as `limits`.
        name: Option<String>,
    },
    /// Set a parameter; it becomes active after `settings store` and `reset`.
    Set {
        /// Name of the parameter.
        name: String,
        /// Value: a number in the unit of the name or with a unit (`500mV`), or a name.
        #[arg(allow_hyphen_values = true)]
        value: String,
    },
    /// Store parameters and lane trims, so that they survive power-off.
    Store,
    /// Erase the stored settings; active and set values remain.
    Clear,
    /// Set every parameter to its default and remove the lane trims; the stored settings remain
    /// until `store`.
    Defaults,
    /// Show the lane trims.
    Trims,
}

/// Executes a command on the board's settings.
pub fn run(order: &SettingsOrder, session: &mut Session) -> Result<Answer, LinkError> {
    let plain = |session: &mut Session, verb: Verb, line: &str| -> Result<Answer, LinkError> {
        session.client.order(Command::Settings(verb))?;
        Ok(Answer::to("settings").line(line))
    };
    match order {
        SettingsOrder::Get { name: Some(name) } => get(&named(name)?, session),
        SettingsOrder::Get { name: None } => get(&PARAMETERS.iter().collect::<Vec<_>>(), session),
        SettingsOrder::Set { name, value } => set(parameter(name)?, value, session),
        SettingsOrder::Store => store(session),
        SettingsOrder::Clear => {
            plain(session, Verb::Clear, "no settings are stored; after a restart all parameters have their defaults")
        }
        SettingsOrder::Defaults => plain(
            session,
            Verb::Defaults,
            "all parameters are set to their defaults, and the lane trims are removed; `settings store` stores this",
        ),
        SettingsOrder::Trims => trims(session, Answer::to("settings")),
    }
}

fn get(parameters: &[&Parameter], session: &mut Session) -> Result<Answer, LinkError> {
    let width = parameters.iter().map(|parameter| parameter.name.len()).max().unwrap_or(0);
    let mut answer =
        Answer::to("settings").line(format!("{:width$}  {:>12}  {:>12}  {:>12}  range", "", "active", "set", "default"));
    let mut stored = StoredState::Nothing;
    for parameter in parameters {
        let of = report(parameter, &mut session.client)?;
        stored = of.stored;
        let reset = match stored {
            _ if of.next == of.acts => "",
            // Ignored, kept within a limit, or changed since.
            StoredState::Partly | StoredState::Refused => "  (not active as set)",
            _ => "  (active after `settings store` and `reset`)",
        };
        answer = answer
            .line(format!(
                "{:width$}  {:>12}  {:>12}  {:>12}  {}{reset}",
                parameter.name,
                shown(parameter, of.acts),
                shown(parameter, of.next),
                shown(parameter, of.built_in),
                range(parameter, of.min, of.max)
            ))
            .field(parameter.name, short(of.next));
        if let [_] = parameters {
            let fields = [("acts", of.acts), ("set", of.next), ("built_in", of.built_in), ("min", of.min), ("max", of.max)];
            answer = fields.into_iter().fold(answer, |answer, (name, value)| answer.field(name, short(value)));
        }
    }
    if let [_] = parameters {
        return Ok(answer.line(words::stored(stored)).field("kept", state_name(stored)));
    }
    let answer = answer.line(words::stored(stored)).field("kept", state_name(stored));
    match session.client.ask(Command::Settings(Verb::Stores)) {
        Ok(Reply::Stores(stores)) => Ok(answer
            .line(format!("settings were stored {stores} times; a flash endures at least {MIN_STORES}"))
            .field("stores", stores)),
        // Older firmware does not count the stores.
        Err(LinkError::Refused { refusal: Refusal::Unknown, .. }) => Ok(answer),
        reply => Err(reply.map_or_else(|error| error, |reply| unexpected("settings get", &reply))),
    }
}

fn store(session: &mut Session) -> Result<Answer, LinkError> {
    let refused = match session.client.order(Command::Settings(Verb::Store)) {
        Err(LinkError::Refused { refusal: Refusal::DoesNotBuild(key), .. }) => {
            PARAMETERS.iter().find(|parameter| parameter.key == key)
        }
        done => return done.map(|()| Answer::to("settings").line("stored over power-off")),
    };
    let what = match refused {
        Some(parameter) => {
            let of = report(parameter, &mut session.client)?;
            format!("{} = {} conflicts with the other values", parameter.name, shown(parameter, of.next))
        }
        None => "the kind of drive, its waveform or its bursts conflict with the tracking".into(),
    };
    Err(LinkError::Failed(format!(
        "the set values do not fit together, and nothing is stored: {what}. Change them (`settings get` shows them), then \
         `settings store`"
    )))
}

fn set(parameter: &Parameter, value: &str, session: &mut Session) -> Result<Answer, LinkError> {
    let value = read(parameter, value)?;
    match session.client.order(Command::Settings(Verb::Set(parameter.key, value))) {
        Err(LinkError::Refused { refusal: Refusal::OutOfRange | Refusal::NotPlausible, .. }) => {
            let of = report(parameter, &mut session.client)?;
            let range = range(parameter, of.min, of.max);
            Err(LinkError::Failed(format!(
                "{} must be {range}, not {value}; it is {} now",
                parameter.name,
                shown(parameter, of.next)
            )))
        }
        Err(LinkError::Refused { refusal: Refusal::NotConfigured, .. }) => Err(LinkError::Failed(dependency(parameter))),
        done => done.map(|()| {
            Answer::to("settings")
                .line(format!("{} = {}; active after `settings store` and `reset`", parameter.name, shown(parameter, value)))
                .field(parameter.name, short(value))
        }),
    }
}

/// Explains why a parameter cannot be set before, or removed after, another one.
fn dependency(parameter: &Parameter) -> String {
    let need = need_of(parameter.key).and_then(|key| PARAMETERS.iter().find(|parameter| parameter.key == key));
    match need {
        Some(need) => format!("{} has no effect without {}: set that first", parameter.name, need.name),
        None => {
            let users = PARAMETERS.iter().filter(|user| need_of(user.key) == Some(parameter.key)).map(|user| user.name);
            format!("{} is needed by other settings: remove those first, of {}", parameter.name, listed(users, "and"))
        }
    }
}

/// Adds the lane trims and the state of the stored settings to an answer.
pub fn trims(session: &mut Session, mut answer: Answer) -> Result<Answer, LinkError> {
    let mut point = 0;
    loop {
        let report = match session.client.ask(Command::Settings(Verb::Trims(point)))? {
            Reply::Settings(report) => report,
            reply => return Err(unexpected("settings trims", &reply)),
        };
        let Some(found) = report.point.filter(|_| point < report.points) else {
            let none = if point == 0 { "no lane trims; " } else { "" };
            return Ok(answer
                .line(format!("{none}{}", words::stored(report.stored)))
                .field("trim_points", report.points)
                .field("kept", state_name(report.stored)));
        };
        let lanes = found.lanes.iter().map(|trim| format!("{:+.3} deg x {:.4}", 360.0 * trim.phase_turns, trim.gain));
        answer = answer.line(format!("{:9.1} Hz: {}", found.hz, lanes.collect::<Vec<_>>().join(" | ")));
        point += 1;
    }
}

fn state_name(stored: StoredState) -> &'static str {
    match stored {
        StoredState::Nothing => "nothing",
        StoredState::Stored => "stored",
        StoredState::Damaged => "damaged",
        StoredState::Version(_) => "other_version",
        StoredState::Due => "due",
        StoredState::Failed => "failed",
        StoredState::Partly => "partly",
        StoredState::Refused => "refused",
        StoredState::Changed => "changed",
        StoredState::OneCopy => "one_copy",
        StoredState::Unfinished => "unfinished",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_suggested_for_an_unknown_setting() {
        let error = |name: &str| parameter(name).err().unwrap().to_string();
        assert_eq!(error("limit.voltage_v"), "there is no setting `limit.voltage_v`; did you mean `limits.voltage_v`?");
        assert_eq!(error("scan_volts"), "there is no setting `scan_volts`; did you mean `drive.scan_volts`?");
        assert_eq!(error("colour"), "there is no setting `colour`; `settings get` lists all settings");
    }
}
