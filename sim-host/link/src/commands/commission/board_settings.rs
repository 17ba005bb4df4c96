//! Settings of a board during a commissioning: reads, changes and restores them.
//!
//! A setting becomes active by `settings store` and `reset`. Therefore settings are stored before
//! they are tried, and the earlier ones are stored again at the end.

use firmware::board::command::{Command, Verb};
use firmware::board::stored_state::StoredState;
use firmware::seam::config::Parameter;

use crate::commands::reset;
use crate::link_error::LinkError;
use crate::parameter::{parameter, report, shown};
use crate::session::Session;
use crate::words;

/// Names of the settings that the commissioning or its result changes.
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
/// Names of the further settings of a commissioning with a heating run.
const HEATING_NAMES: [&str; 4] =
    ["thermometer.hz_per_k", "thermometer.resistance_k_per_w", "thermometer.heat_capacity_j_per_k", "thermometer.tolerance"];

/// Setting of the board with its values.
#[derive(Clone, Copy)]
struct Setting {
    parameter: &'static Parameter,
    /// Value before the commissioning.
    before: f32,
    /// Present value.
    now: f32,
    /// Default of the image.
    built_in: f32,
}

/// Changed settings of a board with their earlier values.
pub struct BoardSettings {
    settings: Vec<Setting>,
    /// `true` if the stored settings differ from the earlier ones.
    changed: bool,
}

impl BoardSettings {
    /// Reads the settings. Refuses a board with active settings that are not the stored ones,
    /// because they could not be restored.
    pub fn read(heating: bool, session: &mut Session) -> Result<Self, LinkError> {
        let mut settings = Vec::new();
        for name in NAMES.into_iter().chain(HEATING_NAMES.into_iter().filter(|_| heating)) {
            let parameter = parameter(name)?;
            let of = report(parameter, &mut session.client)?;
            if !is_settled(of.stored) {
                return Err(LinkError::Failed(format!(
                    "commissioning restores the settings at its end, but the active settings of this board are not the stored \
                     ones: {}. First send `settings store` and `reset` to keep the set values, or `settings defaults`, `settings \
                     store` and `reset`",
                    words::stored(of.stored)
                )));
            }
            settings.push(Setting { parameter, before: of.next, now: of.next, built_in: of.built_in });
        }
        Ok(BoardSettings { settings, changed: false })
    }

    /// Returns the value before the commissioning.
    pub fn before(&self, name: &str) -> f32 {
        self.of(name).map_or(f32::NAN, |setting| setting.before)
    }

    /// Returns `true` if the setting may be absent: its default is `none`.
    pub fn can_be_none(&self, name: &str) -> bool {
        self.of(name).is_some_and(|setting| setting.built_in.is_infinite())
    }

    fn of(&self, name: &str) -> Option<&Setting> {
        self.settings.iter().find(|setting| setting.parameter.name == name)
    }

    /// Makes these settings active, in addition to the present ones.
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

    /// Stores the set values, restarts the board, and checks that all of them are active.
    fn activate(&mut self, session: &mut Session) -> Result<(), LinkError> {
        self.changed = true;
        session.client.order(Command::Settings(Verb::Store))?;
        reset::run(session)?;
        let stored = report(self.settings[0].parameter, &mut session.client)?.stored;
        if is_settled(stored) {
            Ok(())
        } else {
            Err(LinkError::Failed(format!("the settings conflict with other settings of the board: {}", words::stored(stored))))
        }
    }

    /// Restores the earlier settings, except for these values.
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

    /// Returns the commands with which the user can restore the settings.
    pub fn by_hand(&self) -> String {
        let differs = self.settings.iter().filter(|setting| setting.now != setting.before);
        let lines = differs
            .map(|setting| format!("settings set {} {}", setting.parameter.name, shown(setting.parameter, setting.before)));
        lines.chain(["settings store".into(), "reset".into()]).collect::<Vec<String>>().join("\n")
    }
}

/// Returns `true` if the active settings are the stored ones.
fn is_settled(stored: StoredState) -> bool {
    matches!(stored, StoredState::Nothing | StoredState::Stored | StoredState::OneCopy | StoredState::Unfinished)
}
