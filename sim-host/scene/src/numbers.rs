//! Fast variation of a few numbers of a contact study, without reading the scene's text again.
//!
//! A scene read from text is parsed, merged with its bases, walked by its schema, checked by the
//! rules and converted. A point of a map of a million needs none of these if only numbers change
//! that no rule checks. The table in this file lists these numbers. The few remaining checks (zero,
//! resonance, range of the schema) are made for every value. All other scenes are read from text.

use super::problem::resonates;
use super::schema::Schema;
use super::{Excitation, Excited, Model, Scene};

/// Access to a number of a scene.
type Accessor = fn(&mut Scene) -> Option<&mut f64>;

/// Keys of the numbers that need no check of the rules, except those that [`Numbers::set`] makes.
const ACCESSORS: [(&str, Accessor); 12] = [
    ("contact.coulomb.mu", |scene| Some(&mut scene.contact.as_mut()?.coulomb.as_mut()?.mu)),
    ("contact.coulomb.normal_n", |scene| scene.contact.as_mut()?.coulomb.as_mut()?.normal_n.as_mut()),
    ("contact.dahl.mu", |scene| Some(&mut scene.contact.as_mut()?.dahl.as_mut()?.mu)),
    ("contact.dahl.normal_n", |scene| scene.contact.as_mut()?.dahl.as_mut()?.normal_n.as_mut()),
    ("contact.dahl.stiffness_n_per_m", |scene| Some(&mut scene.contact.as_mut()?.dahl.as_mut()?.stiffness_n_per_m)),
    ("excitation.force_n", |scene| excitation(scene)?.force_n.as_mut()),
    ("excitation.sliding_m_per_s", |scene| excitation(scene)?.sliding_m_per_s.as_mut()),
    ("excitation.velocity_ratio", |scene| excitation(scene)?.velocity_ratio.as_mut()),
    ("rig.kinematic.vibration_m_per_s", |scene| scene.rig.as_mut()?.kinematic.as_mut()?.vibration_m_per_s.as_mut()),
    ("rig.sdof.damping_ratio", |scene| Some(&mut scene.rig.as_mut()?.sdof.as_mut()?.damping_ratio)),
    ("rig.sdof.mass_kg", |scene| Some(&mut scene.rig.as_mut()?.sdof.as_mut()?.mass_kg)),
    ("rig.sdof.stiffness_n_per_m", |scene| Some(&mut scene.rig.as_mut()?.sdof.as_mut()?.stiffness_n_per_m)),
];

fn excitation(scene: &mut Scene) -> Option<&mut Excitation> {
    scene.excitation.as_mut()
}

/// A scene and access to its numbers that change.
#[derive(Clone, Debug)]
pub struct Numbers {
    scene: Scene,
    places: Vec<(Accessor, f64, f64)>,
}

impl Numbers {
    /// Returns access to the numbers of these keys in a valid scene that gives them.
    ///
    /// Returns `None` if a key cannot be set in this way, or if the scene is not a contact study
    /// with constant load and vibration along the sliding.
    pub fn of(mut scene: Scene, keys: &[&str]) -> Option<Self> {
        let one_load = scene.disturbance.is_empty() && scene.fault.is_empty();
        let along = |scene: &Excited| {
            scene.excitation.angle_deg == 0.0
                && !matches!(scene.model, Model::Hertz(_) | Model::Compliant(_) | Model::Expression(_))
        };
        scene.excited().filter(|scene| one_load && along(scene))?;
        let mut places = Vec::with_capacity(keys.len());
        for key in keys {
            let (_, place) = ACCESSORS.iter().find(|(name, _)| name == key)?;
            place(&mut scene)?;
            let (least, most) = Schema::root().at(key)?.range();
            places.push((*place, least.unwrap_or(f64::MIN), most.unwrap_or(f64::MAX)));
        }
        Some(Numbers { scene, places })
    }

    /// Sets the numbers, in the order of their keys, and returns the scene. Returns `None` if the
    /// rules must check the values: then the scene must be read from text.
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
