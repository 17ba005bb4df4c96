//! Lane trims: what a calibration has found, for who keeps it.

use super::Controller;
use crate::config::LaneTrims;
use crate::phasing::check_calibration;
use crate::supervisor::Mode;

impl Controller {
    /// The trims that act, from a calibration or from the configuration.
    pub fn calibration(&self) -> &LaneTrims {
        self.phasing.calibration()
    }

    /// How many calibrations have been completed: one more than before, and there is something to keep.
    pub fn calibrations(&self) -> u32 {
        self.calibrate.completed()
    }

    /// Trims the lanes. Only in silence, because the drive would jump, and only by what can be trims and leaves a scan within the limit;
    /// returns whether it was done.
    pub fn trim(&mut self, trims: LaneTrims) -> bool {
        let silent = matches!(self.supervisor.mode(), Mode::Idle | Mode::Fault);
        if !silent || check_calibration(&trims).is_err() {
            return false;
        }
        self.calibrate.abandon(&mut self.phasing);
        let before = self.phasing.trim(trims);
        let fits = self.amplitude.set_loudest(self.phasing.loudest()) >= self.scan_volts;
        if !fits {
            self.phasing.trim(before);
            self.amplitude.set_loudest(self.phasing.loudest());
        }
        fits
    }
}
