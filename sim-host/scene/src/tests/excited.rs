//! Contact studies: dependencies between their keys.

use super::{says, sets};
use crate::load::load_text;
use crate::resolved::{resolved_json, resolved_toml};
use crate::{Scene, Sign};
use contact::Method;

/// Returns a contact study for these tests only, so that its line numbers do not change.
fn example() -> &'static str {
    include_str!("excited.toml")
}

fn loaded(changes: &[&str]) -> Scene {
    load_text("a.toml", example(), &sets(changes)).unwrap_or_else(|error| panic!("{error}")).scene
}

fn report(changes: &[&str]) -> String {
    super::report(example(), changes)
}

/// Returns the report on the example with one line replaced.
fn with_line(old: &str, new: &str) -> String {
    let line = example().lines().find(|line| line.starts_with(old)).unwrap_or_else(|| panic!("no line `{old}`"));
    super::report(&example().replacen(line, new, 1), &[])
}

/// Returns the example with a prescribed motion.
fn kinematic(contact: &str) -> String {
    let text = example().replacen("force_n = 384.0\n", "", 1);
    let (head, _) = text.split_once("[contact.dahl]").unwrap();
    format!("{head}{contact}\n[rig.kinematic]\nvibration_m_per_s = 0.05\n")
}

#[test]
fn example_is_only_a_contact_study() {
    let scene = loaded(&[]);
    let study = scene.excited().unwrap();
    assert!(scene.driven().is_none() && scene.amplifier.is_none() && scene.sensors.is_none());
    assert_eq!((study.integrator.method, study.integrator.tolerance), (Some(Method::Auto), Some(1e-7)));
    assert_eq!(study.model.sign(), Sign::Passive);
}

#[test]
fn resolved_study_reads_back_the_same() {
    let rich = [
        "excitation.waveform=chirp",
        "excitation.start_hz=20e3",
        "excitation.stop_hz=200e3",
        "excitation.match=rms",
        "excitation.velocity_ratio_of=peak",
        "contact.dahl.sign=literal",
        "contact.dahl.normal_n=1",
        "integrator.method=rk4-events",
        "integrator.window_periods=[10, 20.5]",
        "disturbance.0.at_s=1e-3",
        "disturbance.0.key=contact.normal_n",
        "disturbance.0.to=2",
    ];
    for changes in [&[][..], &rich] {
        let scene = loaded(changes);
        let text = resolved_toml(&scene);
        let again = load_text("resolved", &text, &[]).unwrap_or_else(|error| panic!("{error}\n{text}"));
        assert_eq!(again.scene, scene, "{text}");
        assert_eq!(serde_json::from_value::<Scene>(resolved_json(&scene)).unwrap(), scene);
        for foreign in ["[controller.", "[amplifier]", "[sensors]", "[stack"] {
            assert!(!text.contains(foreign), "{foreign} in\n{text}");
        }
    }
}

#[test]
fn set_sliding_speed_replaces_the_ratio() {
    let excitation = loaded(&["excitation.sliding_m_per_s=0.1"]).excitation.unwrap();
    assert_eq!((excitation.velocity_ratio, excitation.sliding_m_per_s), (None, Some(0.1)));
    says(&with_line("velocity_ratio", ""), &["[excitation] is incomplete", "`velocity_ratio`, or `sliding_m_per_s`"]);
    let both = with_line("velocity_ratio", "velocity_ratio = 1\nsliding_m_per_s = 1");
    says(&both, &["`velocity_ratio` and `sliding_m_per_s` exclude each other in [excitation]", "a.toml:9:1"]);
}

#[test]
fn an_amplitude_is_a_velocity_at_the_frequency() {
    let text = kinematic("[contact.dahl]\nmu = 0.1\nnormal_n = 1\nstiffness_n_per_m = 1e6");
    let loaded = |changes: &[&str]| load_text("a.toml", &text, &sets(changes)).map(|loaded| loaded.scene);
    let peak = |scene: &Scene| {
        let hz = scene.excitation.as_ref().unwrap().frequency_hz;
        scene.rig.as_ref().unwrap().kinematic.as_ref().unwrap().vibration_m_per_s(hz)
    };
    let (by_velocity, by_amplitude) = (loaded(&[]).unwrap(), loaded(&["rig.kinematic.vibration_amplitude_m=1e-6"]).unwrap());
    let hz = by_velocity.excitation.as_ref().unwrap().frequency_hz;
    assert_eq!((peak(&by_velocity), peak(&by_amplitude)), (0.05, std::f64::consts::TAU * hz * 1e-6));
    for (change, said) in
        [("excitation.waveform=square", "only the displacement of a sine"), ("excitation.frequency_hz=1e7", "peak velocity")]
    {
        says(&super::report(&text, &["rig.kinematic.vibration_amplitude_m=1e-3", change]), &[said]);
    }
    // A velocity ratio ties the sliding speed to the vibration.
    let key = "rig.kinematic.vibration_amplitude_m";
    assert!(by_amplitude.coupled(&[key]).is_some_and(|note| note.contains("also changes the sliding speed")));
    assert_eq!(by_amplitude.coupled(&[key, "excitation.velocity_ratio"]), None);
    assert!(by_amplitude.coupled(&["excitation.frequency_hz"]).is_some());
    assert_eq!(by_velocity.coupled(&["excitation.frequency_hz"]), None);
    assert_eq!(loaded(&["excitation.sliding_m_per_s=0.01"]).unwrap().coupled(&["rig.kinematic.vibration_m_per_s"]), None);
}

#[test]
fn set_contact_replaces_the_scenes_contact() {
    let scene = loaded(&["contact.coulomb.mu=0.2"]);
    assert!(scene.contact.as_ref().unwrap().dahl.is_none() && scene.excited().unwrap().model.mu() == 0.2);
    let two = with_line("[rig.sdof]", "[contact.coulomb]\nmu = 1\n[rig.sdof]");
    says(&two, &["[contact.coulomb] and [contact.dahl] exclude each other in [contact]", "give either [contact.coulomb], or"]);
    says(&with_line("[contact.dahl]", "[contact]\n[expect]"), &["[contact] is incomplete"]);
    let mistake_inside = with_line("mu = 0.1", "mu = 9\n[contact.coulomb]\nmu = 1\n[contact.dahl.x]");
    says(&mistake_inside, &["out of range", "[contact.coulomb] and [contact.dahl] exclude each other"]);
}

#[test]
fn sdof_needs_a_force_and_kinematic_a_load() {
    says(&with_line("force_n", ""), &["`force_n` is missing in [excitation]", "a.toml:4:1"]);
    says(&report(&["rig.kinematic.vibration_m_per_s=1"]), &["a force has no effect on [rig.kinematic]", "a.toml:6:1"]);
    let weightless = kinematic("[contact.dahl]\nmu = 0.1\nstiffness_n_per_m = 1e5\n");
    says(&super::report(&weightless, &[]), &["`normal_n` is missing in [contact.dahl]", "has no mass whose weight"]);
    assert!(load_text("a.toml", &weightless, &sets(&["contact.dahl.normal_n=1"])).is_ok());
    let still = ["excitation.waveform=still", "excitation.sliding_m_per_s=0.01"];
    assert!(load_text("a.toml", &example().replacen("force_n = 384.0", "", 1), &sets(&still)).is_ok());
}

#[test]
fn waveforms_need_their_keys() {
    says(&report(&["excitation.waveform=random"]), &["a random excitation without `hold_time_s`", "--set:1:21"]);
    says(&report(&["excitation.waveform=random", "excitation.hold_time_s=1e-9", "duration_s=1"]), &["1e9 values", "1e-8 s"]);
    let chirp = report(&["excitation.waveform=chirp", "excitation.start_hz=1e4"]);
    says(&chirp, &["a chirp excitation without `stop_hz`", "1 problem"]);
    says(&report(&["rig.sdof.mass_kg=-1"]), &["`rig.sdof.mass_kg` is out of range", "from 1e-9 to 1e6 kg", "--set:1:18"]);
    says(&report(&["excitation.waveform=sqare"]), &["did you mean `square`?"]);
}

#[test]
fn velocity_ratio_needs_a_finite_vibration() {
    let resonance = "excitation.frequency_hz=12978.69";
    says(&report(&[resonance]), &["grows without bound", "`rig.sdof.damping_ratio`, or `sliding_m_per_s`", "--set:1:25"]);
    assert!(loaded(&[resonance, "rig.sdof.damping_ratio=0.01"]).excited().is_some());
    assert!(loaded(&[resonance, "excitation.sliding_m_per_s=0.1"]).excited().is_some());
    assert!(loaded(&[resonance, "excitation.velocity_ratio_of=peak"]).excited().is_some());
    assert!(loaded(&["excitation.frequency_hz=12990"]).excited().is_some());
    says(&report(&["excitation.force_n=0"]), &["the velocity ratio needs a vibration", "--set:1:20"]);
}

#[test]
fn friction_must_be_valid_and_positive() {
    says(&with_line("mu", "mu = 0"), &["`contact.dahl.mu` is 0", "a.toml:11:6", "must be more than 0"]);
    says(&report(&["contact.dahl.alpha=2"]), &["an exponent of 2 is not implemented", "--set:1:20", "must be 1", "thesis"]);
    let lugre =
        ["mu=0.2", "static_mu=0.1", "stiffness_n_per_m=1e5", "stribeck_m_per_s=0.1"].map(|key| format!("contact.lugre.{key}"));
    let lugre: Vec<_> = lugre.iter().map(String::as_str).collect();
    says(&report(&lugre), &["static friction of 0.1 is less than kinetic friction of 0.2", "must be at least 0.2"]);
}

#[test]
fn the_window_is_within_the_run() {
    says(&report(&["integrator.window_periods=[50, 200]"]), &["ends at period 200, but the run has 120", "at most 120"]);
    says(&report(&["integrator.window_periods=[50, 50]"]), &["ends at period 50, but begins at 50"]);
    says(&report(&["integrator.window_periods=[50]"]), &["has 1 entry", "needs at least 2"]);
    let shorter = with_line("duration_s", "integrator.window_periods = [1, 100]\nduration_s = 1e-3");
    says(&shorter, &["but the run has 60", "give a `duration_s` of at least 0.001666"]);
    let slower = report(&["integrator.window_periods=[10, 100]", "excitation.frequency_hz=20e3"]);
    says(&slower, &["ends at period 100, but the run has 40", "at most 40"]);
    assert!(loaded(&["integrator.window_periods=[0, 120]"]).excited().is_some());
}

#[test]
fn load_disturbances_are_steps_in_range() {
    let load = ["disturbance.0.at_s=1e-3", "disturbance.0.key=contact.normal_n"];
    let with = |more: &[&str]| report(&[&load[..], more].concat());
    says(&with(&["disturbance.0.rate_per_s=1"]), &["`contact.normal_n` changes only in steps", "--set:3:15", "give `to`"]);
    says(&with(&["disturbance.0.to=-1"]), &["`contact.dahl.normal_n` is out of range", "--set:3:18"]);
    says(&report(&["disturbance.0.at_s=1", load[1], "disturbance.0.to=1"]), &["is 1 s, but the run ends"]);
    says(&report(&[load[0], "disturbance.0.key=stack.bvd.q", "disturbance.0.to=9"]), &["the scene has no [stack]", "1 problem"]);
    says(&report(&[load[0], "disturbance.0.key=rig.slider.load_n", "disturbance.0.to=9"]), &["the scene has no [rig.slider]"]);
}

#[test]
fn hertzian_contact_needs_a_sine() {
    let hertz = "[contact.hertz]\nmu = 0.3\nnormal_n = 10\nstiffness_n_per_m15 = 1e9\n";
    assert!(load_text("a.toml", &kinematic(hertz), &[]).is_ok());
    says(&super::report(&kinematic(hertz), &["excitation.waveform=square"]), &["supports only a sine"]);
    let on_a_mass = ["contact.hertz.mu=0.3", "contact.hertz.stiffness_n_per_m15=1e9"];
    says(&report(&on_a_mass), &["not known in advance", "give `sliding_m_per_s` instead"]);
    let on_a_mass = [&on_a_mass[..], &["excitation.sliding_m_per_s=0.1"]].concat();
    assert!(loaded(&on_a_mass).excited().is_some());
    let by_steps = |method: &'static str| [&on_a_mass[..], &[method]].concat();
    says(&report(&by_steps("integrator.method=linexp")), &["linexp does not apply here", "rk4-events"]);
    assert!(loaded(&by_steps("integrator.method=rk4-events")).excited().is_some());
}

#[test]
fn methods_and_orders_must_suit_the_contact() {
    says(&report(&["integrator.order=5"]), &["no order 5", "its orders are `2`, `4`, `6` and `10`", "1 problem"]);
    says(&report(&["integrator.method=taylor", "integrator.order=6"]), &["no order 6", "`32`"]);
    says(&report(&["integrator.method=midpoint", "integrator.order=4"]), &["midpoint has no choice of order", "omit it"]);
    says(&report(&["integrator.method=closed"]), &["closed does not apply here", "no closed form", "1 problem"]);
    says(&report(&["contact.coulomb.mu=0.1", "integrator.method=rk4"]), &["rk4 does not apply here", "linexp solves it exactly"]);
    assert!(loaded(&["integrator.method=taylor", "integrator.order=28"]).excited().is_some());
}

#[test]
fn record_tolerance_needs_a_record() {
    let record = "integrator.tolerance_of=record";
    let study = loaded(&[record]).excited().map(|study| crate::problem::numerics(&study, Some(&["tolerance_met"])));
    // Also if only means are requested: a metric must be the same in every study of a scene.
    assert!(study.is_some_and(|numerics| numerics.tolerance_of == contact::ToleranceOf::Record && numerics.whole_run));
    assert_eq!(loaded(&[]).excited().and_then(|study| study.integrator.tolerance_of), None);
    says(&report(&["integrator.tolerance_of=trace"]), &["trace", "record", "1 problem"]);
    let hertz = ["contact.hertz.mu=0.3", "contact.hertz.stiffness_n_per_m15=1e9", "excitation.sliding_m_per_s=0.1", record];
    says(&report(&hertz), &["the record has no tolerance here", "Hertzian", "omit `integrator.tolerance_of`"]);
}

#[test]
fn a_law_of_ones_own_is_checked_and_resolved() {
    let law = r#"[contact.expression]
mu = 0.3
normal_n = 10
force = "k_n_per_m*z"
rate.z = "v - k_n_per_m*abs(v)*z/Fc*(1 - held)"
parameter.k_n_per_m = 2e6
relay.held = { on = "z", off = "-z" }
"#;
    let text = kinematic(law);
    for changes in [&[][..], &["contact.expression.parameter.k_n_per_m=3e6", "contact.expression.start.z=1e-9"]] {
        let scene = load_text("a.toml", &text, &sets(changes)).unwrap_or_else(|error| panic!("{error}")).scene;
        let again = load_text("resolved", &resolved_toml(&scene), &[]).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(again.scene, scene);
    }
    let varied = ["contact.expression.parameter.k_n_per_m={ value = 2e6, sd = 1e5 }"];
    let varied = load_text("a.toml", &text, &sets(&varied)).unwrap_or_else(|error| panic!("{error}")).scene;
    assert_eq!((varied.runs, varied.vary[0].key.as_str()), (256, "contact.expression.parameter.k_n_per_m"));
    let refused = |change: &str, parts: &[&str]| says(&super::report(&text, &[change]), parts);
    refused("contact.expression.rate.z=\"v*\"", &["`contact.expression.rate.z`", "missing at the end", "1 problem"]);
    refused("contact.expression.parameter.k_n_per_m=\"2e6\"", &["expected a number in N/m", "without the quotes"]);
    refused("contact.expression.parameters.k=1", &["did you mean `parameter`?"]);
    refused("contact.expression.start.y=1", &["`y` has a start, but no rate"]);
    refused("contact.expression.relay.held.on=\"u\"", &["`contact.expression.relay.held.on`", "`u` is not known"]);
    refused("integrator.method=linexp", &["linexp", "solved only by collocation", "1 problem"]);
    refused("integrator.tolerance_of=record", &["only the mean has a tolerance"]);
    refused("excitation.angle_deg=5", &["one direction of slip"]);
    refused("excitation.friction0_n=1", &["begins with the states"]);
    refused("contact.expression.parameter.typo=1", &["`typo` is not used in any text"]);
    // A whole law replaces that of the base, with its states; a part of one does not.
    let part = ["contact.expression.force=\"2*k_n_per_m*z\""];
    let part = load_text("a.toml", &text, &sets(&part)).unwrap_or_else(|error| panic!("{error}")).scene;
    assert_eq!(part.contact.unwrap().expression.unwrap().rate.len(), 1);
    let whole = ["contact.expression={ mu = 0.2, normal_n = 5, force = \"Fc*sign(v)\" }"];
    let whole = load_text("a.toml", &text, &sets(&whole)).unwrap_or_else(|error| panic!("{error}")).scene;
    assert!(whole.contact.unwrap().expression.unwrap().rate.is_empty());
    refused("contact.expression.mu=0", &["`contact.expression.mu` is 0"]);
    assert!(load_text("a.toml", &text, &sets(&["integrator.method=collocation"])).is_ok());
    // A name that a user chooses is not looked for in other tables.
    says(&report(&["rig.sdof.z=1"]), &["unknown key `z`"]);
}

#[test]
fn compliant_contact_needs_a_prescribed_sine() {
    let compliant = "[contact.compliant]\nmu = 0.3\nnormal_n = 10\nnormal_stiffness_n_per_m = 1e7\nstiffness_n_per_m = 8e6\n";
    let text = kinematic(compliant);
    let scene = load_text("a.toml", &text, &[]).unwrap_or_else(|error| panic!("{error}")).scene;
    let again = load_text("resolved", &resolved_toml(&scene), &[]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(again.scene, scene);
    let refused = |changes: &[&str], parts: &[&str]| says(&super::report(&text, changes), parts);
    refused(&["excitation.waveform=square"], &["supports only a sine", "[contact.compliant]"]);
    refused(&["contact.compliant.stiffness_n_per_m=0"], &["`contact.compliant.stiffness_n_per_m` is out of range"]);
    refused(
        &["contact.compliant.normal_stiffness_n_per_m=-1"],
        &["`contact.compliant.normal_stiffness_n_per_m` is out of range"],
    );
    refused(&["contact.compliant.normal_n=0"], &["`contact.compliant.normal_n` is out of range"]);
    refused(&["contact.compliant.mu=0"], &["`contact.compliant.mu` is 0"]);
    refused(&["contact.compliant.held=gap"], &["gap", "load", "indentation"]);
    refused(&["integrator.method=linexp"], &["linexp does not apply here", "solved piecewise"]);
    refused(&["integrator.tolerance_of=record"], &["the record has no tolerance here", "compliant"]);
    let step = ["disturbance.0.at_s=1e-4", "disturbance.0.key=contact.normal_n", "disturbance.0.to=2"];
    refused(&step, &["supports only a constant load", "[contact.compliant]"]);
    let weightless = text.replacen("normal_n = 10\n", "", 1);
    says(&super::report(&weightless, &[]), &["`normal_n` is missing in [contact.compliant]"]);
    let on_a_mass = ["mu=0.3", "normal_n=10", "normal_stiffness_n_per_m=1e7", "stiffness_n_per_m=8e6"];
    let on_a_mass: Vec<String> = on_a_mass.iter().map(|key| format!("contact.compliant.{key}")).collect();
    let on_a_mass: Vec<&str> = on_a_mass.iter().map(String::as_str).collect();
    says(
        &report(&on_a_mass),
        &["the vibration of a compliant contact must be prescribed", "must be [rig.kinematic]", "[contact.hertz]"],
    );
}
