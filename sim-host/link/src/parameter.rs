//! A parameter of the board, by its name, and what the board says of it.

use firmware::board::command::{Command, Reply, Verb};
use firmware::board::parameters::{PARAMETERS, ParameterReport};
use firmware::seam::config::Parameter;

use crate::client::{Client, unexpected};
use crate::link_error::LinkError;
use scene::nearest::{listed, nearest};

/// The parameter of this name.
pub fn parameter(name: &str) -> Result<&'static Parameter, LinkError> {
    PARAMETERS.iter().find(|parameter| parameter.name == name).ok_or_else(|| {
        let names = || PARAMETERS.iter().map(|parameter| parameter.name);
        // The last part alone is enough to be understood, not to be obeyed.
        let ends: Vec<&str> = names().filter(|known| known.rsplit('.').next() == Some(name)).collect();
        let similar = if ends.is_empty() { nearest(name, names()) } else { ends };
        let hint = match similar.as_slice() {
            [] => "`settings get` lists them".to_owned(),
            similar => format!("did you mean {}?", listed(similar.iter().take(3).copied(), "or")),
        };
        LinkError::Failed(format!("there is no setting `{name}`; {hint}"))
    })
}

/// What the board says of a parameter.
pub fn report(parameter: &Parameter, client: &mut Client) -> Result<ParameterReport, LinkError> {
    match client.ask(Command::Settings(Verb::Get(parameter.key)))? {
        Reply::Parameter(report) => Ok(report),
        reply => Err(unexpected("settings get", &reply)),
    }
}
