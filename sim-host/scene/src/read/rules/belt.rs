//! Rules of the belt's sensors: a sensor needs a belt, and a sensor fault needs the sensor.

use super::Rules;
use crate::diagnostic::Problem;
use crate::schema::join;

const ENCODER: &str = "sensors.encoder_counts_per_mm";
const FORCE: &str = "sensors.force_hz";
/// Rigs with a part that moves past the tip.
const MOVING_RIGS: [&str; 4] = ["rig.slider", "rig.belt", "rig.dring", "rig.carriage"];

impl Rules<'_> {
    pub(super) fn belt(&mut self) {
        let moves = MOVING_RIGS.iter().any(|rig| !self.lacks(rig));
        for sensor in [ENCODER, FORCE] {
            if self.given(sensor) && !moves {
                let message = format!("`{sensor}` in a scene without a moving belt");
                let problem = Problem::new(self.key(sensor), message, "needs a rig with a belt, such as [rig.slider]");
                self.add(sensor, problem);
            }
        }
        for path in self.tables("fault") {
            let key = join(&path, "kind");
            let needed = match self.text(&key) {
                Some("encoder_stuck" | "encoder_lost" | "encoder_lies") => ENCODER,
                Some("force_stuck") => FORCE,
                _ => continue,
            };
            if self.lacks(needed) {
                let message = "the sensor that fails does not exist";
                let problem = Problem::new(self.place(&key), message, format!("needs `{needed}`"));
                self.add(&key, problem);
            }
        }
    }
}
