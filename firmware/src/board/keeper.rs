//! The slow side's end of the settings: what a calibration has found comes in, parameters are set, and what is to be kept is kept.

use embedded_storage::nor_flash::NorFlash;
use heapless::spsc::{Consumer, Producer};

use crate::board::command::{Reply, TrimReport, Verb};
use crate::board::kept::Kept;
use crate::board::parameters::{PARAMETERS, ParameterReport, Values, overrides, place_of, values_of};
use crate::board::power_up::PowerUp;
use crate::board::settings::{Record, Settings};
use crate::seam::config::ENERGY_PER_METRE;
use crate::seam::config::LaneTrims;
use crate::seam::refusal::Refusal;

/// The settings that act and those that are set, as far as the slow side knows, and what is kept of them.
pub(crate) struct Keeper<'a> {
    found: Consumer<'a, LaneTrims>,
    taken: Producer<'a, LaneTrims>,
    trims: LaneTrims,
    acts: Values,
    next: Values,
    built_in: Values,
    kept: Kept,
    /// A parameter was set since the settings were stored or read.
    changed: bool,
    /// What was wrong with the parameters that are kept, at power-up.
    flaw: Option<Kept>,
    /// The belt has an encoder, by which an energy for each metre of it is known.
    has_encoder: bool,
}

impl<'a> Keeper<'a> {
    /// A keeper between the two queues of trims, for what the board was started with.
    pub(crate) fn new(found: Consumer<'a, LaneTrims>, taken: Producer<'a, LaneTrims>, power_up: &PowerUp) -> Self {
        Keeper {
            found,
            taken,
            trims: power_up.config.phasing.calibration.clone(),
            acts: values_of(&power_up.config),
            next: power_up.next,
            built_in: power_up.built_in,
            kept: power_up.kept,
            changed: false,
            flaw: Some(power_up.kept).filter(|kept| matches!(kept, Kept::Partly | Kept::Refused)),
            has_encoder: power_up.config.front_end.metre_per_count.is_some(),
        }
    }

    /// Takes what a calibration has found, and keeps it once the drive is silent.
    pub(crate) fn keep<F: NorFlash>(&mut self, silent: bool, settings: &mut Settings<F>) {
        while let Some(found) = self.found.dequeue() {
            self.trims = found;
            // What another version has left is not written over without an order.
            if !matches!(self.kept, Kept::Version(_)) {
                self.kept = Kept::Due;
            }
        }
        if silent && self.kept == Kept::Due {
            // Beside the parameters that are kept: those that are only set wait for an order. That it was not kept is in the report.
            let parameters = settings.record().0.parameters;
            let stored = self.store(Record { trims: self.trims.clone(), parameters }, settings);
            if let (Ok(()), Some(flaw)) = (stored, self.flaw) {
                self.kept = flaw;
            }
        }
    }

    /// Obeys a command.
    pub(crate) fn obey<F: NorFlash>(&mut self, verb: Verb, silent: bool, settings: &mut Settings<F>) -> Reply {
        let done = match verb {
            Verb::Trims(point) => return Reply::Settings(self.trims(point)),
            Verb::Get(key) => return self.parameter(key).map_or_else(Reply::Nak, Reply::Parameter),
            _ if !silent => Err(Refusal::Driving),
            Verb::Set(key, value) => self.set(key, value),
            Verb::Store => {
                let record = Record { trims: self.trims.clone(), parameters: overrides(&self.next, &self.built_in) };
                self.store(record, settings).map(|()| (self.changed, self.flaw) = (false, None))
            }
            Verb::Clear => settings.clear().map(|()| (self.kept, self.flaw) = (Kept::Nothing, None)).map_err(|_| Refusal::Flash),
            Verb::Defaults => {
                let taken = self.taken.enqueue(LaneTrims::new()).map_err(|_| Refusal::Busy);
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
        PARAMETERS[place].check(value, self.built_in[place])?;
        // A limit that nothing is judged by would be none.
        if key == ENERGY_PER_METRE && !self.has_encoder && value != self.built_in[place] {
            return Err(Refusal::NotConfigured);
        }
        self.changed |= self.next[place] != value;
        self.next[place] = value;
        Ok(())
    }

    fn store<F: NorFlash>(&mut self, record: Record, settings: &mut Settings<F>) -> Result<(), Refusal> {
        let stored = settings.store(&record);
        self.kept = match stored {
            Ok(()) if record.is_empty() => Kept::Nothing,
            Ok(()) => Kept::Stored,
            // Not tried again unless it is ordered: that would wear the flash out.
            Err(_) => Kept::Failed,
        };
        stored.map_err(|_| Refusal::Flash)
    }

    fn trims(&self, point: u8) -> TrimReport {
        let point = self.trims.get(usize::from(point)).copied();
        TrimReport { kept: self.kept, points: self.trims.len() as u8, point }
    }

    fn parameter(&self, key: u8) -> Result<ParameterReport, Refusal> {
        let place = place_of(key)?;
        let built_in = self.built_in[place];
        let (min, max) = PARAMETERS[place].range.of(built_in);
        let kept = match self.kept {
            Kept::Stored | Kept::Nothing if self.changed => Kept::Changed,
            kept => kept,
        };
        Ok(ParameterReport { key, acts: self.acts[place], next: self.next[place], built_in, min, max, kept })
    }
}
