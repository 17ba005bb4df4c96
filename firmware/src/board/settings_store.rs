//! Settings in the background task: trims of a calibration arrive, parameters are set, and both are
//! stored.

use embedded_storage::nor_flash::NorFlash;
use heapless::spsc::{Consumer, Producer};

use crate::board::command::{Reply, TrimReport, Verb};
use crate::board::parameters::{PARAMETERS, ParameterReport, Values, apply, ceiling, check_need, overrides, place_of, values_of};
use crate::board::power_up::PowerUp;
use crate::board::settings::{Record, Settings};
use crate::board::stored_state::StoredState;
use crate::controller::Controller;
use crate::seam::config::{Config, LaneTrims, Parameter};
use crate::seam::error::Error;
use crate::seam::refusal::Refusal;

/// Active and set values of the settings, as the background task knows them, and the state of the
/// stored ones.
pub(crate) struct SettingsStore<'a> {
    trims_out: Consumer<'a, LaneTrims>,
    trims_in: Producer<'a, LaneTrims>,
    trims: LaneTrims,
    acts: Values,
    next: Values,
    built_in: Values,
    stored: StoredState,
    /// `true` if a parameter was set after the settings were stored or read.
    changed: bool,
    /// Defect of the stored settings at power-up.
    flaw: Option<StoredState>,
    /// `true` if the marker of stored settings was checked since its page may have been erased.
    pub(crate) marker_checked: bool,
}

impl<'a> SettingsStore<'a> {
    /// Creates a settings store between the two queues of trims, for the settings of this power-up.
    pub(crate) fn new(trims_out: Consumer<'a, LaneTrims>, trims_in: Producer<'a, LaneTrims>, power_up: &PowerUp) -> Self {
        SettingsStore {
            trims_out,
            trims_in,
            trims: power_up.config.phasing.calibration.clone(),
            acts: values_of(&power_up.config),
            next: power_up.next,
            built_in: power_up.built_in,
            stored: power_up.stored,
            changed: false,
            flaw: Some(power_up.stored).filter(|state| matches!(state, StoredState::Partly | StoredState::Refused)),
            marker_checked: false,
        }
    }

    /// Takes the trims found by a calibration, and stores them once the drive is silent.
    pub(crate) fn store_trims<F: NorFlash>(&mut self, silent: bool, settings: &mut Settings<F>) {
        while let Some(found) = self.trims_out.dequeue() {
            self.trims = found;
            // Unreadable settings are not overwritten without an order.
            if !self.stored.hides_limits() {
                self.stored = StoredState::Due;
            }
        }
        // Settings of earlier firmware have no marker. A failure leaves them as they were.
        use StoredState::{Changed, OneCopy, Partly, Refused, Stored, Version};
        let has_record = matches!(self.stored, Stored | OneCopy | Partly | Refused | Changed | Version(_));
        if silent && !core::mem::replace(&mut self.marker_checked, true) && has_record {
            let _ = settings.mark();
        }
        if !silent || self.stored != StoredState::Due {
            return;
        }
        let (mut record, found) = settings.record();
        // Settings that have become unreadable may have limits. They are not replaced by trims
        // alone.
        if found.hides_limits() {
            self.stored = StoredState::Failed;
            return;
        }
        // The stored parameters stay; set ones wait for an order. The report shows a failure.
        record.trims.clone_from(&self.trims);
        let stored = self.store(&record, settings);
        if let (Ok(()), Some(flaw)) = (stored, self.flaw) {
            self.stored = flaw;
        }
    }

    /// Obeys a command.
    pub(crate) fn obey<F: NorFlash>(
        &mut self,
        verb: Verb,
        silent: bool,
        settings: &mut Settings<F>,
        built_in: Option<&dyn Fn() -> Config>,
    ) -> Reply {
        let done = match verb {
            Verb::Trims(point) => return Reply::Settings(self.trims(point)),
            Verb::Stores => return Reply::Stores(settings.stores()),
            Verb::Get(key) => return self.parameter(key).map_or_else(Reply::Nak, Reply::Parameter),
            _ if !silent => Err(Refusal::Driving),
            Verb::Set(key, value) => self.set(key, value),
            Verb::Store => built_in.map_or(Ok(()), |built_in| self.check(built_in)).and_then(|()| {
                let record = Record { trims: self.trims.clone(), parameters: overrides(&self.next, &self.built_in) };
                self.store(&record, settings).map(|()| (self.changed, self.flaw) = (false, None))
            }),
            Verb::Clear => {
                settings.clear().map(|()| (self.stored, self.flaw) = (StoredState::Nothing, None)).map_err(|_| Refusal::Flash)
            }
            Verb::Defaults => {
                let taken = self.trims_in.enqueue(LaneTrims::new()).map_err(|_| Refusal::Busy);
                taken.map(|()| {
                    self.trims.clear();
                    self.changed |= self.next != self.built_in;
                    self.next = self.built_in;
                })
            }
        };
        done.map_or_else(Reply::Nak, |()| Reply::Ack)
    }

    fn set(&mut self, key: u8, value: f32) -> Result<(), Refusal> {
        let place = place_of(key)?;
        PARAMETERS[place].check(value, ceiling(place, &self.next, &self.built_in))?;
        // A limit that cannot be checked would not limit anything, and a parameter of a missing
        // part would have no effect.
        check_need(place, value, &self.next, &self.built_in)?;
        self.changed |= self.next[place] != value;
        self.next[place] = value;
        Ok(())
    }

    /// Refuses set parameters that would not all act with the active trims after a reset. Not
    /// inlined, so that its stack is free again before anything is stored.
    #[inline(never)]
    fn check(&self, built_in: &dyn Fn() -> Config) -> Result<(), Refusal> {
        let mut config = built_in();
        apply(&mut config, &self.next, &self.built_in, |_| true);
        if !self.trims.is_empty() {
            config.phasing.calibration.clone_from(&self.trims);
        }
        Controller::check(&config).map_err(|error| {
            let named =
                |parameter: &&Parameter| matches!(error, Error::OutOfRange { parameter: name, .. } if parameter.name == name);
            Refusal::DoesNotBuild(PARAMETERS.iter().find(named).map_or(0, |parameter| parameter.key))
        })
    }

    fn store<F: NorFlash>(&mut self, record: &Record, settings: &mut Settings<F>) -> Result<(), Refusal> {
        let result = settings.store(record);
        self.stored = match result {
            Ok(()) if record.is_empty() => StoredState::Nothing,
            Ok(()) => StoredState::Stored,
            // Not retried without an order: that would wear out the flash.
            Err(_) => StoredState::Failed,
        };
        result.map_err(|_| Refusal::Flash)
    }

    fn trims(&self, point: u8) -> TrimReport {
        let point = self.trims.get(usize::from(point)).copied();
        TrimReport { stored: self.stored, points: self.trims.len() as u8, point }
    }

    fn parameter(&self, key: u8) -> Result<ParameterReport, Refusal> {
        let place = place_of(key)?;
        let (built_in, ceiling) = (self.built_in[place], ceiling(place, &self.next, &self.built_in));
        let (min, max) = PARAMETERS[place].range.of(ceiling);
        // A limit that was not set falls with its ceiling.
        let next = if PARAMETERS[place].is_limit() { self.next[place].min(ceiling) } else { self.next[place] };
        let stored = match self.stored {
            StoredState::Stored | StoredState::Nothing | StoredState::OneCopy | StoredState::Unfinished if self.changed => {
                StoredState::Changed
            }
            state => state,
        };
        Ok(ParameterReport { key, acts: self.acts[place], next, built_in, min, max, stored })
    }
}
