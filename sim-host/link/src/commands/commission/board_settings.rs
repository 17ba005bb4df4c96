//! The settings of a board while a transducer is commissioned: what they were, what they are, and how they become that again.
//!
//! A setting becomes active by `settings store` and `reset`. What is tried is therefore stored, and what was stored before is stored again at the end.

use firmware::board::command::{Command, Verb};
use firmware::board::stored_state::StoredState;
use firmware::seam::config::Parameter;

use crate::commands::reset;
use crate::link_error::LinkError;
use crate::parameter::{parameter, report, shown};
use crate::session::Session;
use crate::words;

/// Settings that are changed on the way, or by the result.
const NAMES: [&str; 17] = [
    "drive.frequency_hz",
    "drive.amplitude_v",
    "drive.motional_current_a",
    "drive.scan_volts",
    "drive.shape",
    "limits.voltage_v",
    "limits.current_a",
    "tracking.mode",
    "tracking.span",
    "tracking.bandwidth_hz",
    "tracking.nominal_q",
    "tracking.nominal_lm_h",
    "tracking.nominal_c0_f",
    "tracking.c0_drift_per_s",
    "sweep.time_s",
    "friction.enabled",
    "restraint.enabled",
];

/// A setting of the board.
#[derive(Clone, Copy)]
struct Setting {
    parameter: &'static Parameter,
    /// Value before the commissioning, present value, and default of the image.
    before: f32,
    now: f32,
    built_in: f32,
}

/// The settings of a board that are changed, with their values from before.
pub struct BoardSettings {
    settings: Vec<Setting>,
    /// Whether something else is stored than before.
    changed: bool,
}

impl BoardSettings {
    /// Reads them. Refuses a board whose stored settings are not the active ones: they could not be restored.
    pub fn read(session: &mut Session) -> Result<Self, LinkError> {
        let mut settings = Vec::new();
        for name in NAMES {
            let parameter = parameter(name)?;
            let of = report(parameter, &mut session.client)?;
            if !is_settled(of.stored) {
                return Err(LinkError::Failed(format!(
                    "commissioning ends with the settings as they were, and those of this board are not settled: {}. Before it: `settings \
                     store` and `reset` to keep what is set, or `settings defaults`, `settings store` and `reset`",
                    words::stored(of.stored)
                )));
            }
            settings.push(Setting { parameter, before: of.next, now: of.next, built_in: of.built_in });
        }
        Ok(BoardSettings { settings, changed: false })
    }

    /// The value from before the commissioning.
    pub fn before(&self, name: &str) -> f32 {
        self.of(name).map_or(f32::NAN, |setting| setting.before)
    }

    /// Whether the board can be without this setting: its default is none.
    pub fn can_be_none(&self, name: &str) -> bool {
        self.of(name).is_some_and(|setting| setting.built_in.is_infinite())
    }

    fn of(&self, name: &str) -> Option<&Setting> {
        self.settings.iter().find(|setting| setting.parameter.name == name)
    }

    /// Makes these settings active, beside the present ones.
    pub fn apply(&mut self, values: &[(&str, f32)], session: &mut Session) -> Result<(), LinkError> {
        for &(name, value) in values {
            let Some(place) = self.settings.iter().position(|setting| setting.parameter.name == name) else { continue };
            self.set(place, value, session)?;
        }
        self.activate(session)
    }

    fn set(&mut self, place: usize, value: f32, session: &mut Session) -> Result<(), LinkError> {
        let Setting { parameter, now, .. } = self.settings[place];
        if now == value {
            return Ok(());
        }
        session.client.order(Command::Settings(Verb::Set(parameter.key, value)))?;
        self.settings[place].now = value;
        self.changed = true;
        Ok(())
    }

    /// Stores what is set, restarts the board, and sees that all of it is active.
    fn activate(&mut self, session: &mut Session) -> Result<(), LinkError> {
        self.changed = true;
        session.client.order(Command::Settings(Verb::Store))?;
        reset::run(session)?;
        let stored = report(self.settings[0].parameter, &mut session.client)?.stored;
        if is_settled(stored) {
            Ok(())
        } else {
            Err(LinkError::Failed(format!("the settings do not fit beside the board's other ones: {}", words::stored(stored))))
        }
    }

    /// Restores what was there before, with these values in their place.
    pub fn finish(&mut self, result: &[(&str, f32)], session: &mut Session) -> Result<(), LinkError> {
        if !self.changed {
            return Ok(());
        }
        for place in 0..self.settings.len() {
            let Setting { parameter, before, .. } = self.settings[place];
            let value = result.iter().find(|(name, _)| *name == parameter.name).map_or(before, |(_, value)| *value);
            self.set(place, value, session)?;
        }
        self.activate(session)?;
        self.changed = false;
        Ok(())
    }

    /// The commands that restore the settings, where this client cannot any more.
    pub fn by_hand(&self) -> String {
        let differs = self.settings.iter().filter(|setting| setting.now != setting.before);
        let lines = differs
            .map(|setting| format!("settings set {} {}", setting.parameter.name, shown(setting.parameter, setting.before)));
        lines.chain(["settings store".into(), "reset".into()]).collect::<Vec<String>>().join("\n")
    }
}

/// Whether the active settings are the stored ones.
fn is_settled(stored: StoredState) -> bool {
    matches!(stored, StoredState::Nothing | StoredState::Stored | StoredState::OneCopy | StoredState::Unfinished)
}
