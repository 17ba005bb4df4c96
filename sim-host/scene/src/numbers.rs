//! Many scenes of contact studies that differ in a few numbers: set in the scene itself, not in its text.
//!
//! A scene made of a text is parsed, laid over others, walked through by its schema, judged by the rules and read; a point of a map of a
//! million needs none of that again, if nothing but numbers changes which no rule looks at. Which these are is the table here; what a rule does
//! look at (a zero, a resonance, the range of the schema) is looked at for every value. The others are made of their text.

use super::problem::resonates;
use super::schema::Schema;
use super::{Excitation, Excited, Model, Scene};

/// A number of a scene.
type Place = fn(&mut Scene) -> Option<&mut f64>;

/// The numbers that no rule looks at, but for their being zero and for what [`Numbers::set`] sees to.
const PLACES: [(&str, Place); 12] = [
    ("contact.coulomb.mu", |scene| Some(&mut scene.contact.as_mut()?.coulomb.as_mut()?.mu)),
    ("contact.coulomb.normal_n", |scene| scene.contact.as_mut()?.coulomb.as_mut()?.normal_n.as_mut()),
    ("contact.dahl.mu", |scene| Some(&mut scene.contact.as_mut()?.dahl.as_mut()?.mu)),
    ("contact.dahl.normal_n", |scene| scene.contact.as_mut()?.dahl.as_mut()?.normal_n.as_mut()),
    ("contact.dahl.stiffness_n_per_m", |scene| Some(&mut scene.contact.as_mut()?.dahl.as_mut()?.stiffness_n_per_m)),
    ("excitation.force_n", |scene| excitation(scene)?.force_n.as_mut()),
    ("excitation.sliding_m_per_s", |scene| excitation(scene)?.sliding_m_per_s.as_mut()),
    ("excitation.velocity_ratio", |scene| excitation(scene)?.velocity_ratio.as_mut()),
    ("rig.kinematic.vibration_m_per_s", |scene| Some(&mut scene.rig.as_mut()?.kinematic.as_mut()?.vibration_m_per_s)),
    ("rig.sdof.damping_ratio", |scene| Some(&mut scene.rig.as_mut()?.sdof.as_mut()?.damping_ratio)),
    ("rig.sdof.mass_kg", |scene| Some(&mut scene.rig.as_mut()?.sdof.as_mut()?.mass_kg)),
    ("rig.sdof.stiffness_n_per_m", |scene| Some(&mut scene.rig.as_mut()?.sdof.as_mut()?.stiffness_n_per_m)),
];

fn excitation(scene: &mut Scene) -> Option<&mut Excitation> {
    scene.excitation.as_mut()
}

/// A scene, and those of its numbers that change.
#[derive(Clone, Debug)]
pub struct Numbers {
    scene: Scene,
    places: Vec<(Place, f64, f64)>,
}

impl Numbers {
    /// The numbers of these keys in a valid scene that gives them; none if the scene is no contact study under one load whose vibration is along the sliding, or a key is not one of
    /// those that can be set so.
    pub fn of(mut scene: Scene, keys: &[&str]) -> Option<Self> {
        let one_load = scene.disturbance.is_empty() && scene.fault.is_empty();
        let along =
            |scene: &Excited| scene.excitation.angle_deg == 0.0 && !matches!(scene.model, Model::Hertz(_) | Model::Compliant(_));
        scene.excited().filter(|scene| one_load && along(scene))?;
        let mut places = Vec::with_capacity(keys.len());
        for key in keys {
            let (_, place) = PLACES.iter().find(|(name, _)| name == key)?;
            place(&mut scene)?;
            let (least, most) = Schema::root().at(key)?.range();
            places.push((*place, least.unwrap_or(f64::MIN), most.unwrap_or(f64::MAX)));
        }
        Some(Numbers { scene, places })
    }

    /// Sets the numbers, in the order of their keys, and shows the scene. None of values that the rules have to judge: such a scene is to be made of
    /// its text.
    pub fn set(&mut self, values: &[f64]) -> Option<&Scene> {
        if values.len() != self.places.len() {
            return None;
        }
        for (&(place, least, most), &value) in self.places.iter().zip(values) {
            if !(value > 0.0 && value >= least && value <= most) {
                return None;
            }
            *place(&mut self.scene)? = value;
        }
        let hz = self.scene.excitation.as_ref()?.frequency_hz;
        let sdof = self.scene.rig.as_ref()?.sdof.as_ref();
        let judged = sdof.is_some_and(|sdof| resonates(sdof.mass_kg, sdof.stiffness_n_per_m, sdof.damping_ratio, hz));
        (!judged).then_some(&self.scene)
    }
}
