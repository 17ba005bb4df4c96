//! The two kinds of scene, each as what it certainly has.

use std::ops::Deref;

use super::contact::Model;
use super::{Amplifier, Controller, Dahl, Excitation, Kinematic, Method, Scene, Sdof, Sensors, Slider, Stack};

/// Largest error of the mean friction ratio of a contact study that names none.
const TOLERANCE: f64 = 1e-7;

/// A scene, by its kind.
#[derive(Clone, Copy, Debug)]
pub enum Kind<'a> {
    /// The firmware drives.
    Driven(Driven<'a>),
    /// A contact study.
    Excited(Excited<'a>),
}

/// A scene in which the firmware drives a stack.
#[derive(Clone, Copy, Debug)]
pub struct Driven<'a> {
    scene: &'a Scene,
    /// The firmware that drives, and what it is told.
    pub controller: &'a Controller,
    /// The power amplifier.
    pub amplifier: &'a Amplifier,
    /// The converters and the load cell.
    pub sensors: &'a Sensors,
    /// The stack.
    pub stack: &'a Stack,
    /// The contact at its tip and what moves it, if there are any.
    pub sliding: Option<(&'a Dahl, &'a Slider)>,
}

/// A scene in which a contact is studied by itself.
#[derive(Clone, Copy, Debug)]
pub struct Excited<'a> {
    scene: &'a Scene,
    /// What shakes the contact.
    pub excitation: &'a Excitation,
    /// The contact.
    pub model: Model<'a>,
    /// What it is part of.
    pub body: Body<'a>,
}

/// What a studied contact is part of.
#[derive(Clone, Copy, Debug)]
pub enum Body<'a> {
    /// A given vibration.
    Kinematic(&'a Kinematic),
    /// One mass on a spring.
    Sdof(&'a Sdof),
}

impl Scene {
    /// The scene by its kind; none if it lacks what its rules demand.
    pub fn kind(&self) -> Option<Kind<'_>> {
        self.driven().map(Kind::Driven).or_else(|| self.excited().map(Kind::Excited))
    }

    /// The scene as one in which the firmware drives.
    pub fn driven(&self) -> Option<Driven<'_>> {
        let dahl = self.contact.as_ref().and_then(|contact| contact.dahl.as_ref());
        let slider = self.rig.as_ref().and_then(|rig| rig.slider.as_ref());
        Some(Driven {
            scene: self,
            controller: self.controller.as_ref()?,
            amplifier: self.amplifier.as_ref()?,
            sensors: self.sensors.as_ref()?,
            stack: self.stack.as_ref()?,
            sliding: dahl.zip(slider),
        })
    }

    /// The scene as a contact study.
    pub fn excited(&self) -> Option<Excited<'_>> {
        let rig = self.rig.as_ref()?;
        let kinematic = rig.kinematic.as_ref().map(Body::Kinematic);
        let body = kinematic.or_else(|| rig.sdof.as_ref().map(Body::Sdof))?;
        Some(Excited { scene: self, excitation: self.excitation.as_ref()?, model: self.contact.as_ref()?.model()?, body })
    }

    /// Writes out the defaults of the tables and keys that this kind of scene has, and no others.
    pub(super) fn complete(mut self) -> Self {
        if self.controller.is_some() {
            self.amplifier.get_or_insert_default();
            self.sensors.get_or_insert_default();
        } else if self.excitation.is_some() {
            self.integrator.method.get_or_insert(Method::Auto);
            self.integrator.tolerance.get_or_insert(TOLERANCE);
            self.contact.iter_mut().for_each(super::Contact::complete);
        }
        self
    }
}

impl Deref for Driven<'_> {
    type Target = Scene;

    fn deref(&self) -> &Scene {
        self.scene
    }
}

impl Deref for Excited<'_> {
    type Target = Scene;

    fn deref(&self) -> &Scene {
        self.scene
    }
}
