//! Setting numbers in a scene gives the same scene as reading its text.

use crate::load::load;
use crate::numbers::Numbers;

/// Every key, at values in and out of its range, with both kinds of rig: a scene that is set
/// without its text is valid and equal.
#[test]
fn setting_numbers_equals_reading_the_text() {
    let cases: [(&str, &[&str], &[&str]); 5] = [
        ("contact-kinematic", &[], &["contact.dahl.mu", "excitation.velocity_ratio"]),
        (
            "contact-kinematic",
            &["excitation.sliding_m_per_s=0.01", "contact.dahl.normal_n=2"],
            &["contact.dahl.normal_n", "rig.kinematic.vibration_m_per_s"],
        ),
        (
            "contact-kinematic",
            &["contact.coulomb.mu=0.1", "contact.coulomb.normal_n=1", "grid.over.0.key=contact.coulomb.mu"],
            &["contact.coulomb.mu", "contact.coulomb.normal_n"],
        ),
        ("contact", &[], &["contact.dahl.stiffness_n_per_m", "excitation.velocity_ratio"]),
        (
            "contact",
            &["excitation.sliding_m_per_s=0.01", "rig.sdof.damping_ratio=0.0"],
            &[
                "rig.sdof.mass_kg",
                "rig.sdof.stiffness_n_per_m",
                "rig.sdof.damping_ratio",
                "excitation.force_n",
                "excitation.sliding_m_per_s",
            ],
        ),
    ];
    let (mut set, mut judged) = (0, 0);
    for (scene, changes, keys) in cases {
        let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
        let loaded = load(scene, &changes).unwrap_or_else(|error| panic!("{error}"));
        let template = loaded.template().expect("a template");
        let of = |values: &[f64]| {
            let sets: Vec<String> = keys.iter().zip(values).map(|(key, value)| format!("{key}={value:?}")).collect();
            template.scene(&sets)
        };
        let ones = vec![1.0; keys.len()];
        let base = of(&ones).expect("valid");
        let mut numbers = Numbers::of(base, keys).expect("numbers that can be set");
        for (place, _) in keys.iter().enumerate() {
            for value in [1e-20, 1e-9, 3e-4, 0.02, 0.1 + 0.2, 1.0, 7.5, 133e6, 1e12, 1e17, 0.0, -0.1, f64::INFINITY, f64::NAN] {
                let mut values = ones.clone();
                values[place] = value;
                match numbers.set(&values) {
                    Some(made) => {
                        assert_eq!(*made, of(&values).expect("valid"), "{scene} {keys:?} {values:?}");
                        set += 1;
                    }
                    None => judged += 1,
                }
            }
        }
    }
    assert!(set > 70 && judged > 40, "{set} {judged}");
}

/// A mass without damping at its resonance must be checked by the rules, and so must other scenes
/// than contact studies with constant load.
#[test]
fn numbers_that_need_rules_are_not_set() {
    let loaded = load("contact", &[]).expect("built in");
    let template = loaded.template().expect("a template");
    let keys = ["rig.sdof.mass_kg", "rig.sdof.stiffness_n_per_m"];
    let mut numbers = Numbers::of(template.scene(&[]).expect("valid"), &keys).expect("numbers");
    let stiffness = 0.02 * (std::f64::consts::TAU * 60e3).powi(2);
    assert!(numbers.set(&[0.02, stiffness]).is_none() && numbers.set(&[0.02, 1.1 * stiffness]).is_some());
    let of = |scene: &str, key: &str| Numbers::of(load(scene, &[]).expect("built in").scene, &[key]);
    assert!(of("contact", "integrator.tolerance").is_none());
    assert!(of("contact", "contact.coulomb.mu").is_none());
    assert!(of("lock", "controller.drive.frequency_hz").is_none());
}
