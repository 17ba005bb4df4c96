//! The two kinds of scene, each as what it certainly has.

use std::f64::consts::TAU;
use std::ops::Deref;

use contact::Method;

use super::contact::Model;
use super::tree::Node;
use super::{
    Amplifier, Belt, Carriage, Controller, Dahl, Dring, Empirical, Excitation, FaultKind, Kinematic, Lugre, Profile, Rotor,
    Scene, Sdof, Sensors, Slider, Stack, Stator,
};

/// Largest error of the mean friction ratio of a contact study that names none.
const TOLERANCE: f64 = 1e-7;

/// A scene, by its kind.
#[derive(Clone, Copy, Debug)]
pub enum Kind<'a> {
    /// A scene in which the firmware drives.
    Driven(Driven<'a>),
    /// A scene of a contact study.
    Excited(Excited<'a>),
}

/// A scene in which the firmware drives a stack, or the stator of a motor.
#[derive(Clone, Copy, Debug)]
pub struct Driven<'a> {
    scene: &'a Scene,
    /// The settings of the firmware that drives.
    pub controller: &'a Controller,
    /// The power amplifier between DAC and transducer.
    pub amplifier: &'a Amplifier,
    /// The converters and the load cell.
    pub sensors: &'a Sensors,
    /// The transducer that the amplifier drives.
    pub transducer: Transducer<'a>,
}

/// What the firmware drives.
#[derive(Clone, Copy, Debug)]
pub enum Transducer<'a> {
    /// A stack, and the contact at its tip with what moves it, if there are any.
    Stack(&'a Stack, Option<(&'a Dahl, &'a Slider)>),
    /// The stator of a motor, and its rotor, if there is one.
    Stator(&'a Stator, Option<&'a Rotor>),
}

impl<'a> Driven<'a> {
    /// The contact at a stack's tip and what moves it.
    pub fn sliding(&self) -> Option<(&'a Dahl, &'a Slider)> {
        match self.transducer {
            Transducer::Stack(_, sliding) => sliding,
            Transducer::Stator(..) => None,
        }
    }

    /// When a fault brings the belt to a stand, s.
    pub fn belt_stops_s(&self) -> Option<f64> {
        let stops = |kind| matches!(kind, FaultKind::BeltStopped | FaultKind::EncoderLies);
        self.scene.fault.iter().filter(|fault| stops(fault.kind)).map(|fault| fault.at_s).reduce(f64::min)
    }

    /// The belt under a stack's horn, and how it rubs.
    pub fn belt(&self) -> Option<(&'a Empirical, &'a Belt)> {
        let contact = self.scene.contact.as_ref()?.empirical.as_ref()?;
        Some((contact, self.scene.rig.as_ref()?.belt.as_ref()?))
    }

    /// The carriage on a stack's tip, and how it rubs.
    pub fn carriage(&self) -> Option<(&'a Lugre, &'a Carriage)> {
        let contact = self.scene.contact.as_ref()?.lugre.as_ref()?;
        Some((contact, self.scene.rig.as_ref()?.carriage.as_ref()?))
    }

    /// The peak tip velocity that is ordered, m/s: by itself, or as an amplitude at the nominal frequency.
    pub fn ordered_velocity_m_per_s(&self) -> Option<f64> {
        let drive = &self.controller.drive;
        let of_belt = |(_, belt): (_, &Belt)| TAU * drive.frequency_hz * belt.amplitude_fraction * belt.full_amplitude_m;
        self.belt().map(of_belt).or(drive.velocity_m_per_s)
    }

    /// How much later than its burst says the drive is ON, s.
    pub fn trigger_delay_s(&self) -> f64 {
        self.belt().map_or(0.0, |(_, belt)| belt.trigger_delay_s)
    }

    /// The belt over a D-ring, whose friction a stack's drive lowers.
    pub fn dring(&self) -> Option<&'a Dring> {
        self.scene.rig.as_ref().and_then(|rig| rig.dring.as_ref())
    }

    /// The stator of a motor.
    pub fn stator(&self) -> Option<&'a Stator> {
        match self.transducer {
            Transducer::Stack(..) => None,
            Transducer::Stator(stator, _) => Some(stator),
        }
    }

    /// The rotor of a motor.
    pub fn rotor(&self) -> Option<&'a Rotor> {
        match self.transducer {
            Transducer::Stack(..) => None,
            Transducer::Stator(_, rotor) => rotor,
        }
    }
}

/// A scene in which a contact is studied by itself.
#[derive(Clone, Copy, Debug)]
pub struct Excited<'a> {
    scene: &'a Scene,
    /// What shakes the contact.
    pub excitation: &'a Excitation,
    /// The friction model of the contact.
    pub model: Model<'a>,
    /// What it is part of.
    pub body: Body<'a>,
}

/// What a studied contact is part of.
#[derive(Clone, Copy, Debug)]
pub enum Body<'a> {
    /// A vibration that is given, whatever the friction.
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
        let rotor = self.rig.as_ref().and_then(|rig| rig.rotor.as_ref());
        let stack = self.stack.as_ref().map(|stack| Transducer::Stack(stack, dahl.zip(slider)));
        let stator = || self.stator.as_ref().map(|stator| Transducer::Stator(stator, rotor));
        Some(Driven {
            scene: self,
            controller: self.controller.as_ref()?,
            amplifier: self.amplifier.as_ref()?,
            sensors: self.sensors.as_ref()?,
            transducer: stack.or_else(stator)?,
        })
    }

    /// The scene as a contact study.
    pub fn excited(&self) -> Option<Excited<'_>> {
        let rig = self.rig.as_ref()?;
        let kinematic = rig.kinematic.as_ref().map(Body::Kinematic);
        let body = kinematic.or_else(|| rig.sdof.as_ref().map(Body::Sdof))?;
        Some(Excited { scene: self, excitation: self.excitation.as_ref()?, model: self.contact.as_ref()?.model()?, body })
    }

    /// The scene that a tree is, with the defaults of its kind.
    pub(super) fn of_tree(root: &Node) -> Result<Self, toml::de::Error> {
        let mut scene: Scene = root.to_toml().try_into()?;
        for (index, overlay) in scene.overlay.iter_mut().enumerate() {
            let samples = |key: &str| root.at(&format!("overlay.{index}.{key}"))?.samples().cloned();
            (overlay.x, overlay.values) = (samples("x").unwrap_or_default(), samples("values").unwrap_or_default());
        }
        scene.profiles(|path, profile| {
            let samples = |key: &str| root.at(path)?.at(key)?.samples().cloned();
            profile.time_s = samples("time_s").unwrap_or_default();
            profile.values = samples("values").unwrap_or_default();
        });
        Ok(scene.complete())
    }

    /// Shows each profile, with its path.
    fn profiles(&mut self, mut show: impl FnMut(&str, &mut Profile)) {
        for (index, disturbance) in self.disturbance.iter_mut().enumerate() {
            disturbance.profile.iter_mut().for_each(|profile| show(&format!("disturbance.{index}.profile"), profile));
        }
        let excitation = self.excitation.iter_mut().filter_map(|excitation| excitation.profile.as_mut());
        excitation.for_each(|profile| show("excitation.profile", profile));
        let dring = self.rig.iter_mut().filter_map(|rig| rig.dring.as_mut()?.pulse.as_mut());
        dring.for_each(|profile| show("rig.dring.pulse", profile));
    }

    /// Writes out the defaults of the tables and keys that this kind of scene has, and no others.
    fn complete(mut self) -> Self {
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
