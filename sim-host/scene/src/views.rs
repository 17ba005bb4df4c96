//! The kinds of scene, driven, excited and designed, with their required tables.

use std::f64::consts::TAU;
use std::ops::Deref;

use contact::Method;

use super::contact::Model;
use super::tree::Node;
use super::{
    Amplifier, Belt, Carriage, Controller, Dahl, Design, Dring, Empirical, Excitation, FaultKind, Kinematic, Lugre, Profile,
    Rotor, Scene, Sdof, Sensors, Slider, Stack, Stator,
};

/// Default of `integrator.tolerance`: largest error of the mean friction ratio of a contact study.
const DEFAULT_TOLERANCE: f64 = 1e-7;

/// A scene, by its kind.
#[derive(Clone, Copy, Debug)]
pub enum Kind<'a> {
    /// A scene in which the firmware drives.
    Driven(Driven<'a>),
    /// A scene of a contact study.
    Excited(Excited<'a>),
    /// A scene of a design.
    Designed(Designed<'a>),
}

/// A scene in which a transducer or horn is designed.
#[derive(Clone, Copy, Debug)]
pub struct Designed<'a> {
    scene: &'a Scene,
    /// The design.
    pub design: &'a Design,
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

/// The transducer that the firmware drives.
#[derive(Clone, Copy, Debug)]
pub enum Transducer<'a> {
    /// A stack, with the optional contact at its tip and the slider that moves it.
    Stack(&'a Stack, Option<(&'a Dahl, &'a Slider)>),
    /// The stator of a motor, with the optional rotor.
    Stator(&'a Stator, Option<&'a Rotor>),
}

impl<'a> Driven<'a> {
    /// Returns the contact at a stack's tip and the slider that moves it.
    pub fn sliding(&self) -> Option<(&'a Dahl, &'a Slider)> {
        match self.transducer {
            Transducer::Stack(_, sliding) => sliding,
            Transducer::Stator(..) => None,
        }
    }

    /// Returns the time at which a fault stops the belt, s.
    pub fn belt_stops_s(&self) -> Option<f64> {
        let stops = |kind| matches!(kind, FaultKind::BeltStopped | FaultKind::EncoderLies);
        self.scene.fault.iter().filter(|fault| stops(fault.kind)).map(|fault| fault.at_s).reduce(f64::min)
    }

    /// Returns the belt under a stack's horn and its friction law.
    pub fn belt(&self) -> Option<(&'a Empirical, &'a Belt)> {
        let contact = self.scene.contact.as_ref()?.empirical.as_ref()?;
        Some((contact, self.scene.rig.as_ref()?.belt.as_ref()?))
    }

    /// Returns the carriage on a stack's tip and its friction law.
    pub fn carriage(&self) -> Option<(&'a Lugre, &'a Carriage)> {
        let contact = self.scene.contact.as_ref()?.lugre.as_ref()?;
        Some((contact, self.scene.rig.as_ref()?.carriage.as_ref()?))
    }

    /// Returns the set point of the peak tip velocity, m/s: given directly, or as an amplitude at
    /// the nominal frequency.
    pub fn ordered_velocity_m_per_s(&self) -> Option<f64> {
        let drive = &self.controller.drive;
        let of_belt = |(_, belt): (_, &Belt)| TAU * drive.frequency_hz * belt.amplitude_fraction * belt.full_amplitude_m;
        self.belt().map(of_belt).or(drive.velocity_m_per_s)
    }

    /// Returns the delay from the start of a burst window to the drive, s.
    pub fn trigger_delay_s(&self) -> f64 {
        self.belt().map_or(0.0, |(_, belt)| belt.trigger_delay_s)
    }

    /// Returns the belt over a D-ring, whose friction the stack reduces.
    pub fn dring(&self) -> Option<&'a Dring> {
        self.scene.rig.as_ref().and_then(|rig| rig.dring.as_ref())
    }

    /// Returns the stator of a motor.
    pub fn stator(&self) -> Option<&'a Stator> {
        match self.transducer {
            Transducer::Stack(..) => None,
            Transducer::Stator(stator, _) => Some(stator),
        }
    }

    /// Returns the rotor of a motor.
    pub fn rotor(&self) -> Option<&'a Rotor> {
        match self.transducer {
            Transducer::Stack(..) => None,
            Transducer::Stator(_, rotor) => rotor,
        }
    }
}

/// A scene in which a contact is studied alone.
#[derive(Clone, Copy, Debug)]
pub struct Excited<'a> {
    scene: &'a Scene,
    /// The excitation of the contact.
    pub excitation: &'a Excitation,
    /// The friction model of the contact.
    pub model: Model<'a>,
    /// The body that the contact belongs to.
    pub body: Body<'a>,
}

/// The body that a studied contact belongs to.
#[derive(Clone, Copy, Debug)]
pub enum Body<'a> {
    /// A prescribed vibration, independent of the friction.
    Kinematic(&'a Kinematic),
    /// One mass on a spring.
    Sdof(&'a Sdof),
}

impl Scene {
    /// Returns the scene by its kind, or `None` if a required table is missing.
    pub fn kind(&self) -> Option<Kind<'_>> {
        let designed = || self.designed().map(Kind::Designed);
        self.driven().map(Kind::Driven).or_else(|| self.excited().map(Kind::Excited)).or_else(designed)
    }

    /// Returns the scene as a design.
    pub fn designed(&self) -> Option<Designed<'_>> {
        Some(Designed { scene: self, design: self.design.as_ref()? })
    }

    /// Returns the scene as one in which the firmware drives.
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

    /// Returns the scene as a contact study.
    pub fn excited(&self) -> Option<Excited<'_>> {
        let rig = self.rig.as_ref()?;
        let kinematic = rig.kinematic.as_ref().map(Body::Kinematic);
        let body = kinematic.or_else(|| rig.sdof.as_ref().map(Body::Sdof))?;
        Some(Excited { scene: self, excitation: self.excitation.as_ref()?, model: self.contact.as_ref()?.model()?, body })
    }

    /// Converts a tree to a scene, with the defaults of its kind.
    pub(super) fn from_tree(root: &Node) -> Result<Self, toml::de::Error> {
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

    /// Calls `show` with the path of each profile and the profile.
    fn profiles(&mut self, mut show: impl FnMut(&str, &mut Profile)) {
        for (index, disturbance) in self.disturbance.iter_mut().enumerate() {
            disturbance.profile.iter_mut().for_each(|profile| show(&format!("disturbance.{index}.profile"), profile));
        }
        let excitation = self.excitation.iter_mut().filter_map(|excitation| excitation.profile.as_mut());
        excitation.for_each(|profile| show("excitation.profile", profile));
        let dring = self.rig.iter_mut().filter_map(|rig| rig.dring.as_mut()?.pulse.as_mut());
        dring.for_each(|profile| show("rig.dring.pulse", profile));
    }

    /// Fills in the defaults of the tables and keys that this kind of scene has, and of no others.
    fn complete(mut self) -> Self {
        if self.controller.is_some() {
            self.amplifier.get_or_insert_default();
            self.sensors.get_or_insert_default();
        } else if self.excitation.is_some() {
            self.integrator.method.get_or_insert(Method::Auto);
            self.integrator.tolerance.get_or_insert(DEFAULT_TOLERANCE);
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

impl Deref for Designed<'_> {
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
