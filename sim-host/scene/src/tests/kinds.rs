//! The two kinds of scene: required and excluded tables.

use super::{example, report, says, with_line};

const STUDY: &str = include_str!("excited.toml");

#[test]
fn a_scene_has_exactly_one_kind() {
    let both = format!("{}\n{}", example(), STUDY.split_once("[excitation]").unwrap().1);
    let both = both.replacen("waveform = ", "[excitation]\nwaveform = ", 1);
    let (both, _) = both.split_once("[contact.dahl]\nmu = 0.1").unwrap();
    says(&report(both, &[]), &["[controller] and [excitation] exclude each other", "[controller] is already given"]);
    says(&report(example(), &["excitation.force_n=1"]), &["[controller] and [excitation] exclude each other", "--set:1:1"]);
    // The missing keys of a table that must go are of no interest.
    says(&report(STUDY, &["controller.drive.frequency_hz=3e4"]), &["[excitation] is already given", "--set:1:1", "1 problem"]);
    let neither = report("title = \"x\"\nduration_s = 1\n", &[]);
    says(
        &neither,
        &["a scene needs [controller], [excitation] or [design]", "with at least `drive` and `tracking`", "1 problem"],
    );
    says(&report(&STUDY.replacen("[excitation]", "[excitaton]", 1), &[]), &["did you mean `excitation`?", "1 problem"]);
}

#[test]
fn each_kind_needs_its_own_tables() {
    let without_stack: String = example().split_inclusive("\n\n").filter(|part| !part.contains("[stack")).collect();
    says(&report(&without_stack, &[]), &["[controller] without [stack]", "needs [stack]", "1 problem"]);
    let (head, _) = STUDY.split_once("[contact.dahl]").unwrap();
    says(&report(head, &[]), &["[excitation] without [contact]", "[excitation] without [rig]", "2 problems"]);
}

#[test]
fn contact_studies_refuse_tables_of_driven_scenes() {
    for (table, header) in [
        ("[amplifier]\nbandwidth_hz = 1e5", "[amplifier]"),
        ("[sensors]\nadc_bits = 14", "[sensors]"),
        ("[trace]\nsignals = [\"v_code\"]", "[trace]"),
        ("[[fault]]\nat_s = 1e-3\nkind = \"open\"", "[[fault]]"),
        ("[stack.bvd]\nc0_f = 3e-7\nseries_resonance_hz = 4e4\nq = 60\ncoupling = 0.25", "[stack]"),
    ] {
        let problems = report(&format!("{STUDY}\n{table}\n"), &[]);
        says(
            &problems,
            &[&format!("{header} cannot be used in a contact study"), "belongs to [controller]", "a.toml:18:", "1 problem"],
        );
    }
    let slider = STUDY.replacen(
        "[rig.sdof]\nmass_kg = 0.02\nstiffness_n_per_m = 133e6",
        "[rig.slider]\nself_weight_n = 1\nspeed_m_per_s = 1",
        1,
    );
    says(&report(&slider, &[]), &["[rig.slider] cannot be used in a contact study", "a.toml:14:6", "1 problem"]);
}

#[test]
fn driven_scenes_refuse_tables_of_contact_studies() {
    let rig = with_line("[rig.slider]", "[rig.sdof]\nmass_kg = 1\nstiffness_n_per_m = 1\n[rig.slider]");
    says(&rig, &["[rig.sdof] cannot be used in a scene with [controller]", "belongs to [excitation]", "1 problem"]);
    says(
        &report(
            example(),
            &[
                "grid.set=[]",
                "grid.over.0.key=duration_s",
                "grid.over.1.key=controller.drive.frequency_hz",
                "rig.kinematic.vibration_m_per_s=1",
            ],
        ),
        &["[rig.kinematic] cannot be used in a scene with [controller]", "belongs to [excitation]"],
    );
    says(&report(example(), &["contact.coulomb.mu=0.2"]), &["[contact.coulomb] cannot be used", "[contact.dahl]"]);
    says(&report(example(), &["contact.dahl.normal_n=1"]), &["`normal_n` cannot be used", "rig.slider.load_n"]);
    says(&report(example(), &["contact.dahl.sign=literal"]), &["friction that feeds energy into a stack", "must be `passive`"]);
    says(
        &report(example(), &["integrator.method=rk4"]),
        &["`integrator.method` cannot be used", "belongs to [excitation]", "1 problem"],
    );
    says(&report(example(), &["integrator.steps_per_period=5000"]), &["must be at most 4096 with [controller]"]);
    let load = ["disturbance.0.at_s=1", "disturbance.0.key=contact.normal_n", "disturbance.0.to=1"];
    says(&report(example(), &load), &["`contact.normal_n` cannot be used", "rig.slider.load_n"]);
    assert!(crate::load::load_text("a.toml", example(), &["contact.dahl.mu=0".to_owned()]).is_ok());
}
