//! Sliders and choices of a scene: the values that a reader may want to change. Each is a key of
//! the scene, and only keys that the scene has are offered.

use plant::circuit_of;
use scene::Scene;
use scene::schema::{Schema, last_name, unit_of};
use serde::Serialize;
use serde_json::Value;

/// Range of a slider.
#[derive(Clone, Copy)]
enum Span {
    /// From the value less this fraction to the value plus this fraction.
    Around(f64),
    /// From the value divided by this factor to the value times it, in equal ratios.
    Times(f64),
    /// From zero to this, or to three times the value if that is more.
    Upto(f64),
    /// Between these two values.
    Between(f64, f64),
}

/// Keys with sliders, in the order of the page: key, label, range.
const SLIDERS: [(&str, &str, Span); 40] = [
    ("stack.bvd.series_resonance_hz", "Resonance of the stack", Span::Around(0.02)),
    ("stator.series_resonance_hz", "Resonance of the stator", Span::Around(0.01)),
    ("stack.bvd.q", "Quality factor Q of the stack", Span::Times(5.0)),
    ("stator.q", "Quality factor Q of the stator", Span::Times(4.0)),
    ("controller.drive.amplitude_v", "Drive amplitude", Span::Times(4.0)),
    ("controller.drive.velocity_m_per_s", "Tip velocity set point", Span::Times(4.0)),
    ("controller.drive.frequency_hz", "Nominal frequency of the controller", Span::Around(0.02)),
    ("controller.friction.target_ratio", "Friction ratio set point", Span::Between(0.1, 1.0)),
    ("rig.slider.load_n", "Load on the slider", Span::Upto(20.0)),
    ("rig.slider.speed_m_per_s", "Speed of the slider", Span::Upto(0.2)),
    ("rig.belt.load_n", "Force of the horn on the belt", Span::Times(3.0)),
    ("rig.belt.speed_m_per_s", "Speed of the belt", Span::Upto(0.1)),
    ("rig.belt.amplitude_fraction", "Amplitude of the horn", Span::Between(0.05, 1.0)),
    ("contact.coulomb.mu", "Coefficient of friction", Span::Between(0.02, 1.0)),
    ("contact.dahl.mu", "Coefficient of friction", Span::Between(0.02, 1.0)),
    ("contact.compliant.mu", "Coefficient of friction", Span::Between(0.02, 1.0)),
    ("contact.lugre.mu", "Coefficient of sliding friction", Span::Between(0.02, 0.02)),
    ("contact.lugre.static_mu", "Coefficient of static friction", Span::Times(1.5)),
    ("contact.lugre.stribeck_m_per_s", "Stribeck velocity", Span::Times(10.0)),
    ("contact.lugre.stiffness_n_per_m", "Stiffness of the contact", Span::Times(30.0)),
    ("contact.dahl.stiffness_n_per_m", "Stiffness of the contact", Span::Times(30.0)),
    ("rig.carriage.normal_n", "Normal force on the carriage", Span::Times(3.0)),
    ("rig.carriage.pull_m_per_s", "Pull speed of the carriage", Span::Times(10.0)),
    ("rig.rotor.preload_n", "Preload of the rotor", Span::Times(4.0)),
    ("rig.rotor.torque_nm", "Load torque of the rotor", Span::Upto(5e-3)),
    ("rig.rotor.mu", "Coefficient of friction", Span::Between(0.05, 0.6)),
    ("rig.dring.mu_high", "Friction at the ring, drive OFF", Span::Between(0.05, 0.6)),
    ("rig.dring.mu_low", "Friction at the ring, drive ON", Span::Between(0.02, 0.3)),
    ("rig.dring.pulse_g", "Deceleration of the car, in g", Span::Between(5.0, 40.0)),
    ("rig.dring.limiter_n", "Force at which the reel yields", Span::Between(500.0, 6000.0)),
    ("excitation.velocity_ratio", "Sliding speed over vibration velocity", Span::Between(0.02, 1.5)),
    ("excitation.sliding_m_per_s", "Sliding speed", Span::Times(10.0)),
    ("excitation.angle_deg", "Angle of the vibration to the sliding", Span::Between(0.0, 90.0)),
    ("excitation.force_n", "Amplitude of the force", Span::Times(5.0)),
    ("controller.burst.on_s", "Time of drive ON", Span::Between(0.0, 0.0)),
    ("controller.burst.off_s", "Time of drive OFF", Span::Times(1.5)),
    ("controller.burst.edge_cycles", "Length of a soft edge", Span::Between(0.5, 100.0)),
    ("design.tip_velocity_m_per_s", "Velocity of the tip", Span::Times(4.0)),
    ("design.q", "Quality factor Q of the design", Span::Times(4.0)),
    ("runs", "Number of runs", Span::Between(1.0, 200.0)),
];

/// Keys with a list of choices.
const CHOICES: [(&str, &str); 5] = [
    ("rig.dring.occupant", "Occupant"),
    ("controller.burst.edge", "Edges of bursts"),
    ("controller.tracking.mode", "Tracker"),
    ("controller.drive.shape", "Waveform"),
    ("controller.phasing.direction", "Direction"),
];

/// A slider of the page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Slider {
    key: &'static str,
    label: &'static str,
    unit: String,
    meaning: &'static str,
    min: f64,
    max: f64,
    /// `true` for equal ratios instead of equal steps.
    log: bool,
    whole: bool,
    /// `true` if the key has a list with this one value.
    list: bool,
    value: f64,
    /// Keys and values that must be given with this one, as the scene describes the stack by other
    /// values.
    with: Vec<(&'static str, f64)>,
}

/// A list of choices of the page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Choice {
    key: &'static str,
    label: &'static str,
    meaning: &'static str,
    value: String,
    choices: Vec<(&'static str, &'static str)>,
}

/// Returns the sliders of a scene with the resolved values `resolved`.
pub fn sliders(scene: &Scene, resolved: &Value) -> Vec<Slider> {
    let circuit = circuit(scene);
    SLIDERS
        .iter()
        .filter_map(|&(key, label, span)| {
            let schema = Schema::root().at(key)?;
            let found = at(resolved, key);
            let only = found.and_then(Value::as_array).and_then(|list| if let [only] = &list[..] { Some(only) } else { None });
            let own = only.or(found).and_then(Value::as_f64);
            let derived = || circuit.iter().find(|(known, _)| *known == key).map(|&(_, value)| value);
            // The resolved values of a scene with a single run do not contain `runs`.
            let runs = || (key == "runs" && scene.runs > 1).then(|| f64::from(scene.runs));
            let value = own.or_else(derived).or_else(runs)?;
            let with = if own.is_none() || !circuit.is_empty() && key.starts_with("stack.bvd.") {
                circuit.iter().copied().filter(|(known, _)| *known != key).collect()
            } else {
                Vec::new()
            };
            let (min, max, log) = span.about(value);
            let (least, most) = schema.range();
            Some(Slider {
                key,
                label,
                unit: unit_of(last_name(key)).unwrap_or_default(),
                meaning: schema.description().unwrap_or_default(),
                min: min.max(least.unwrap_or(f64::NEG_INFINITY)),
                max: max.min(most.unwrap_or(f64::INFINITY)),
                log,
                whole: key == "runs",
                list: only.is_some(),
                value,
                with,
            })
        })
        .filter(|slider| slider.min < slider.max)
        .filter(|slider| {
            slider.key != "controller.burst.edge_cycles" || at(resolved, "controller.burst.edge") == Some(&"soft".into())
        })
        .collect()
}

/// Returns the choices of a scene.
pub fn choices(resolved: &Value) -> Vec<Choice> {
    let choice = |&(key, label): &(&'static str, &'static str)| {
        let schema = Schema::root().at(key)?;
        let value = at(resolved, key)?.as_str()?.to_owned();
        Some(Choice { key, label, meaning: schema.description().unwrap_or_default(), value, choices: schema.described_choices() })
    };
    CHOICES.iter().filter_map(choice).collect()
}

impl Span {
    /// Returns the smallest and largest value around one, and `true` for equal ratios.
    fn about(self, value: f64) -> (f64, f64, bool) {
        match self {
            Span::Around(part) => (value * (1.0 - part), value * (1.0 + part), false),
            Span::Times(factor) if value > 0.0 => (value / factor, value * factor, true),
            Span::Times(factor) => (0.0, factor, false),
            Span::Upto(most) => (0.0, most.max(3.0 * value), false),
            Span::Between(least, most) => (least.min(value), most.max(value), false),
        }
    }
}

/// Returns resonance, Q and coupling of a stack that is described by other values; empty if it is
/// described by these.
fn circuit(scene: &Scene) -> Vec<(&'static str, f64)> {
    let Some((driven, stack)) = scene.driven().zip(scene.stack.as_ref()) else { return Vec::new() };
    if stack.bvd.series_resonance_hz.is_some() && stack.bvd.q.is_some() {
        return Vec::new();
    }
    let circuit = circuit_of(&driven);
    let coupling = (circuit.cm_f / (circuit.c0_f + circuit.cm_f)).sqrt();
    vec![
        ("stack.bvd.series_resonance_hz", circuit.series_resonance_hz()),
        ("stack.bvd.q", circuit.q()),
        ("stack.bvd.coupling", coupling),
    ]
}

/// Returns the value at a dotted path.
pub(crate) fn at<'a>(value: &'a Value, path: &str) -> Option<&'a Value> {
    path.split('.').try_fold(value, |value, name| value.get(name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::builtin;
    use scene::load::load;
    use scene::resolved::resolved_json;

    fn sliders_of(name: &str) -> Vec<Slider> {
        let loaded = load(name, &[]).unwrap_or_else(|error| panic!("{error}"));
        sliders(&loaded.scene, &resolved_json(&loaded.scene))
    }

    #[test]
    fn every_key_is_one_of_a_scene() {
        let keys = SLIDERS.iter().map(|(key, ..)| key).chain(CHOICES.iter().map(|(key, _)| key));
        for key in keys {
            assert!(Schema::root().at(key).is_some(), "{key}");
        }
    }

    /// Every slider of every scene gives a valid scene at the middle of its range.
    #[test]
    fn sliders_give_valid_scenes() {
        for (name, _) in builtin::all() {
            let sliders = sliders_of(name);
            assert!(!sliders.is_empty(), "{name} has no sliders");
            for slider in sliders {
                assert!(slider.min < slider.max && (slider.min..=slider.max).contains(&slider.value), "{name}: {slider:?}");
                let with = slider.with.iter().map(|(key, value)| format!("{key}={value:e}"));
                let half = if slider.log { (slider.min * slider.max).sqrt() } else { 0.5 * (slider.min + slider.max) };
                let half = if slider.whole { half.round() } else { half };
                let half = if slider.list { format!("[{half}]") } else { half.to_string() };
                let sets: Vec<String> = with.chain([format!("{}={half}", slider.key)]).collect();
                load(name, &sets).unwrap_or_else(|error| panic!("{name}: {error}"));
            }
        }
    }

    #[test]
    fn a_stack_by_its_elements_has_resonance_and_q() {
        let sliders = sliders_of("experiment-1");
        let q = sliders.iter().find(|slider| slider.key == "stack.bvd.q").expect("a slider of Q");
        assert!((q.value - 64.6).abs() < 0.1 && q.with.len() == 2);
    }
}
