//! Settings of the board with their values, ranges and meanings.

use firmware::board::parameters::PARAMETERS;
use firmware::seam::config::Parameter;
use link::link_error::LinkError;
use link::parameter::{range, report, shown};
use link::session::Session;
use scene::schema::Schema;
use serde_json::{Value, json};

/// Returns all settings of the board.
pub fn list(session: &mut Session) -> Result<Vec<Value>, LinkError> {
    PARAMETERS
        .iter()
        .map(|parameter| {
            let of = report(parameter, &mut session.client)?;
            Ok(json!({
                "name": parameter.name, "meaning": meaning(parameter), "range": range(parameter, of.min, of.max),
                "active": shown(parameter, of.acts), "set": shown(parameter, of.next), "default": shown(parameter, of.built_in),
            }))
        })
        .collect()
}

/// Returns the meaning of a setting, which a scene has under the same name.
fn meaning(parameter: &Parameter) -> Option<&'static str> {
    let keys = std::iter::once("controller").chain(parameter.name.split('.'));
    keys.into_iter().try_fold(Schema::root(), |table, key| table.property(key))?.description()
}
