//! Dependencies between keys.

use super::{driven, example, loaded, report, says, with_line};
use crate::load::load_text;

#[test]
fn drive_keys_and_limits_are_checked() {
    says(&with_line("scan_v", "amplitude_v = 3"), &["`amplitude_v` and `velocity_m_per_s` exclude each other", "a.toml:8:1"]);
    says(&with_line("velocity", ""), &["[controller.drive] is incomplete"]);
    says(&with_line("scan_v", ""), &["needs `scan_v`"]);
    says(&with_line("nominal_force", ""), &["needs `controller.tracking.nominal_force_factor_n_per_v`"]);
    says(
        &with_line("scan_v", "scan_v = 16"),
        &["more than `controller.limits.voltage_v` allows", "at most 15.466 V, the default"],
    );
    says(&with_line("scan_v", "scan_v = 30"), &["more than `amplifier.full_scale_v` allows"]);
    says(&with_line("frequency_hz", "frequency_hz = 445e3"), &["too high for the converters"]);
    says(&with_line("lm_h", ""), &["`cm_f` and `rm_ohm` need `lm_h` as well"]);
    let coupled = ["stack.bvd.coupling=1.2", "stack.bvd.q=50", "stack.bvd.series_resonance_hz=4e4"];
    says(&report(example(), &coupled), &["`stack.bvd.coupling` is out of range", "from 1e-4 to 0.99", "a source of energy"]);
}

#[test]
fn complete_circuit_sets_give_the_same_stack() {
    let stack = |lines: &str| {
        let head = example().find("cm_f").expect("the stack");
        let tail = example().find("\nforce_factor_n_per_v = 5").expect("its end") + 1;
        format!("{}{lines}{}", &example()[..head], &example()[tail..])
    };
    let bvd = |text: &str| load_text("a.toml", text, &[]).unwrap_or_else(|error| panic!("{error}")).scene.stack.unwrap().bvd;
    let usual = bvd(&stack("series_resonance_hz = 40e3\nq = 65\ncoupling = 0.25\n"));
    let (cm, fp) = (300e-9 * 0.0625 / 0.9375, 40e3 / f64::sqrt(0.9375));
    let rm = 1.0 / (std::f64::consts::TAU * 40e3 * 65.0 * cm);
    for set in [
        format!("series_resonance_hz = 40e3\nparallel_resonance_hz = {fp:e}\nq = 65\n"),
        format!("series_resonance_hz = 40e3\nq = 65\nrm_ohm = {rm:e}\ncm_f = {cm:e}\n"),
        // As printed by an analyser.
        format!("series_resonance_hz = 40e3\nq = 65\nrm_ohm = {rm:e}\n"),
        format!("series_resonance_hz = 40e3\nrm_ohm = {rm:e}\ncoupling = 0.25\n"),
    ] {
        let own = bvd(&stack(&set));
        let near = |a: Option<f64>, b: Option<f64>| a.zip(b).is_some_and(|(a, b)| (a / b - 1.0).abs() < 1e-9);
        assert!(near(own.series_resonance_hz, usual.series_resonance_hz) && near(own.q, usual.q), "{set}: {own:?}");
        assert!(
            near(own.coupling, usual.coupling) && own.parallel_resonance_hz.is_none() && own.rm_ohm.is_none(),
            "{set}: {own:?}"
        );
    }
    says(&report(&stack("series_resonance_hz = 40e3\nrm_ohm = 3\n"), &[]), &["the circuit is incomplete: two of"]);
    let contradicting = stack("series_resonance_hz = 40e3\nrm_ohm = 9\nq = 65\ncoupling = 0.25\n");
    says(&report(&contradicting, &[]), &["the circuit contradicts itself: `q` is 6.5e1, but"]);
    // The value of a base that has the same meaning is replaced.
    let by = |set: &str| {
        load_text("a.toml", "base = \"lock\"\nexpect = []\n", &[set.to_owned()]).map(|loaded| loaded.scene.stack.unwrap().bvd)
    };
    let own = by(&format!("stack.bvd.parallel_resonance_hz={}", 41e3)).unwrap_or_else(|error| panic!("{error}"));
    assert!(own.coupling.is_some_and(|k| k < 0.24), "{own:?}");
}

#[test]
fn total_capacitance_includes_all_branches() {
    let by = |sets: &[&str]| loaded(sets).stack.unwrap().bvd;
    let usual = by(&["stack.bvd.c0_f=4e-9", "stack.bvd.series_resonance_hz=40e3", "stack.bvd.q=90", "stack.bvd.coupling=0.3"]);
    let total = format!("stack.bvd.ct_f={:e}", 4e-9 / (1.0 - 0.09));
    let same = by(&[&total, "stack.bvd.series_resonance_hz=40e3", "stack.bvd.q=90", "stack.bvd.coupling=0.3"]);
    assert!((same.c0_f / usual.c0_f - 1.0).abs() < 1e-12 && same.ct_f.is_none(), "{same:?}");
    let mode = ["stack.mode.0.series_resonance_hz=50e3", "stack.mode.0.q=100", "stack.mode.0.lm_h=0.1"];
    let further = 1.0 / ((std::f64::consts::TAU * 50e3).powi(2) * 0.1);
    let three = by(&[&[&*total, "stack.bvd.cm_f=1e-10", "stack.bvd.lm_h=0.158", "stack.bvd.rm_ohm=40"], &mode[..]].concat());
    assert!((three.c0_f - (4e-9 / 0.91 - 1e-10 - further)).abs() < 1e-20, "{three:?}");
    let wrong = ["stack.bvd.ct_f=1e-12", "stack.bvd.cm_f=1e-10", "stack.bvd.lm_h=0.158", "stack.bvd.rm_ohm=40"];
    says(&report(example(), &wrong), &["the circuit contradicts itself: `ct_f` is 1e-12", "--set:1:11", "1 problem"]);
    let open = ["stack.bvd.ct_f=1e-9", "stack.bvd.lm_h=0.158", "stack.bvd.parallel_resonance_hz=41e3", "stack.bvd.rm_ohm=40"];
    says(&report(example(), &open), &["the circuit is incomplete: in addition to `ct_f`", "1 problem"]);
    let both = ["stack.bvd.c0_f=4e-9", "stack.bvd.ct_f=9e-9"];
    says(&report(example(), &both), &["the circuit contradicts itself: `ct_f` is 9e-9"]);
}

#[test]
fn times_must_be_in_order_and_in_the_run() {
    says(&with_line("off_s", "off_s = [5.0, 5.5]"), &["`on_s` has length 1, `off_s` has length 2"]);
    says(&with_line("off_s", "off_s = [2.0]"), &["ends at 2 s, but begins at 3 s"]);
    says(&with_line("off_s", "off_s = [4, 6]").replace("  ", " "), &["needs as many values"]);
    says(&report(example(), &["controller.burst.on_s=[1,2]", "controller.burst.off_s=[3,4]"]), &["the one before ends at 3 s"]);
    says(&report(example(), &["duration_s=2"]), &["`controller.burst.on_s.0` is 3 s, but the run ends at 2 s", "--set:1:12"]);
    says(&report(example(), &["trace.signals=[\"v_code\"]", "trace.from_s=2", "trace.to_s=1"]), &["the trace ends at 1 s"]);
    says(&report(example(), &["fault.0.at_s=6", "fault.0.kind=open"]), &["`fault.0.at_s` is 6 s"]);
}

#[test]
fn disturbances_and_expectations_are_checked() {
    let load = ["disturbance.0.at_s=1", "disturbance.0.key=rig.slider.load_n"];
    says(&report(example(), &load), &["[[disturbance]] is incomplete"]);
    says(&report(example(), &[&load[..], &["disturbance.0.to=-1"]].concat()), &["`rig.slider.load_n` is out of range"]);
    says(&report(example(), &[&load[..], &["disturbance.0.sine_hz=1"]].concat()), &["`sine_hz` needs `sine_amplitude` as well"]);
    let without_contact: String = example().split_inclusive("\n\n").filter(|part| !part.contains("[contact")).collect();
    let (grid, rig) = (without_contact.find("[grid]").unwrap(), without_contact.find("[rig").unwrap());
    says(&report(&without_contact, &[]), &["[rig] without [contact]"]);
    let bare = format!("{}{}", &without_contact[..rig], &without_contact[grid..]);
    says(&report(&bare, &[&load[..], &["disturbance.0.to=1"]].concat()), &["cannot change: the scene has no [rig]"]);
    says(&with_line("min", "min = 70"), &["no value is at least 70 and at most 69"]);
    says(&with_line("min", "tolerance = 1"), &["exclude each other in [[expect]]"]);
    says(&report(example(), &["expect.0.metric=reduction_percnt"]), &["did you mean `reduction_percent`?"]);
}

#[test]
fn belt_sensors_and_limits_are_checked() {
    let lies = ["fault.0.at_s=1", "fault.0.kind=encoder_lies"];
    says(&report(example(), &lies), &["the sensor that fails does not exist", "needs `sensors.encoder_counts_per_mm`"]);
    says(&report(example(), &["fault.0.at_s=1", "fault.0.kind=force_stuck"]), &["needs `sensors.force_hz`"]);
    says(&report(example(), &["sensors.encoder_counts_per_mm=0"]), &["`sensors.encoder_counts_per_mm` is out of range"]);
    says(&report(example(), &["controller.limits.energy_j_per_m=10"]), &["needs `sensors.encoder_counts_per_mm`"]);
    for limit in ["energy_j_per_m=0", "on_time_s=-1", "temperature_c=1e3", "power_w=0", "belt_stop_ms=0"] {
        let key = limit.split('=').next().unwrap();
        let expected = format!("`controller.limits.{key}` is out of range");
        says(&report(example(), &[&format!("controller.limits.{limit}")]), &[expected.as_str()]);
    }
    let without_rig = load_text("lock", crate::builtin::text("lock").unwrap(), &["sensors.force_hz=500".to_owned()]);
    says(&without_rig.unwrap_err().to_string(), &["`sensors.force_hz` in a scene without a moving belt"]);
}

#[test]
fn grid_cells_must_be_valid_scenes() {
    let key = |key: &str| report(example(), &[&format!("grid.over.0.key={key}")]);
    says(&key("rig.slider.load"), &["is not a number of a scene", "did you mean `rig.slider.load_n`?"]);
    says(&key("controller.drive.shape"), &["is not a number of a scene"]);
    says(&key("seed"), &["`seed` is the same at every point"]);
    says(&key("rig.slider.speed_m_per_s"), &["two axes of the grid change the same key"]);
    says(
        &report(&example().replace("[0.038, 0.068]", "[0.038, 1e9]"), &[]),
        &["`rig.slider.speed_m_per_s` is out of range", "a.toml:41:58"],
    );
    let range =
        |more: &[&str]| report(example(), &[&["grid.over.0.from=1", "grid.over.0.to=9", "grid.over.0.points=3"], more].concat());
    says(&range(&["grid.over.0.from=10"]), &["the range from 10 to 9 is empty"]);
    says(&range(&["grid.over.0.from=0", "grid.over.0.log=true"]), &["with equal ratios, all values are above zero"]);
    says(&range(&["grid.over.0.to=1e9"]), &["`rig.slider.load_n` is out of range"]);
    says(&range(&["grid.over.0.points=9999"]), &["a grid of 19998 points", "`sim-host sweep` has no such limit"]);
    says(&report(example(), &["grid.over.0.log=true"]), &["`log` needs a range"]);
    says(&report(example(), &["grid.over.0.points=3"]), &["`points` needs `from` and `to` as well"]);
    says(&report(example(), &["grid.metrics=[\"friction_on_n\",\"friction_on_n\"]"]), &["a metric appears twice"]);
    says(&report(example(), &["grid.contours=[nan]"]), &["`grid.contours.0`"]);
    says(&with_line("set", "set = [\"duration_s=0.7\"]"), &["in the cells of the grid: `controller.burst.on_s.0` is 3 s"]);
    says(&with_line("set", "set = [\"a\"]"), &["in the cells of the grid: a change has the form `key=value`", "a.toml:43:8"]);
}

/// Checks that the messages `parts` also appear if there are other mistakes.
fn reported_despite(other: &str, changes: &[&str], parts: &[&str]) {
    let text = format!("colour = \"red\"\n{}", example().replacen("frequency_hz", &format!("{other}\nfrequency_hz"), 1));
    let report = report(&text, changes);
    says(&report, &["unknown key `colour`"]);
    says(&report, parts);
}

#[test]
fn one_mistake_does_not_hide_another() {
    let both = ["controller.drive.amplitude_v=3", "controller.drive.velocity_m_per_s=1"];
    reported_despite("flavour = 3", &both, &["unknown key `flavour`", "exclude each other", "2 problems in a.toml"]);
    reported_despite(
        "lanes = 9",
        &["controller.drive.scan_v=30"],
        &["`controller.drive.lanes` is out of range", "30 V, more than"],
    );
    reported_despite("flavour = 3", &["controller.drive.frequency_hz=445e3"], &["too high for the converters"]);
    reported_despite(
        "",
        &["controller.tracking.flavour=1", "controller.drive.frequency_hz=445e3"],
        &["too high for the converters"],
    );
    reported_despite("", &["controller.burst.flavour=1", "controller.burst.off_s=[1]"], &["ends at 1 s, but begins at 3 s"]);
    reported_despite("", &["controller.burst.edge=hrd", "controller.burst.period_s=1"], &["`period_s` needs `duty` as well"]);
    reported_despite("", &["expect.0.flavour=1", "expect.0.min=70"], &["no value is at least 70 and at most 69"]);
    reported_despite(
        "",
        &["expect.0.min=70", "expect.0.metric=q_percent"],
        &["no value is at least 70", "no metric `q_percent`"],
    );
    reported_despite("", &["fault.0.at_s=9", "fault.0.kind=opn"], &["did you mean `open`?", "`fault.0.at_s` is 9 s"]);
    reported_despite("", &["grid.flavour=1", "grid.metrics=[\"redction_percent\"]"], &["did you mean `reduction_percent`?"]);
    let without_rig: String = example().split_inclusive("\n\n").filter(|part| !part.contains("[rig")).collect();
    says(&report(&format!("colour = \"red\"\n{without_rig}"), &[]), &["[contact] without [rig]", "unknown key `colour`"]);
    says(
        &report(&without_rig.replacen("mu =", "nu =", 1), &[]),
        &["[contact] without [rig]", "did you mean `mu`?", "2 problems"],
    );
}

#[test]
fn one_mistake_is_reported_once() {
    says(&with_line("[rig.slider]", "[rg.slider]"), &["did you mean `rig`?", "1 problem"]);
    says(&with_line("[rig.slider]", "[slider]"), &["belongs in [rig]", "1 problem"]);
    says(&with_line("off_s", "of_s = [5.0]"), &["1 problem"]);
    says(&with_line("scan_v", "scan_vv = 3"), &["did you mean `scan_v`?", "1 problem"]);
    says(
        &with_line("nominal_force", "nominal_force_factor = 5.566"),
        &["the unit of `nominal_force_factor` is missing", "1 problem"],
    );
    says(&with_line("velocity", "velocity_m_per_s = \"fast\""), &["cannot be a string", "1 problem"]);
    says(&with_line("scan_v", "amplitude_v = 30"), &["exclude each other", "1 problem"]);
    says(&with_line("duration_s", "duration_s = \"6\""), &["without the quotes: 6", "1 problem"]);
}

#[test]
fn sample_sums_must_fit_16_bits() {
    let bits = |bits: u8, conversions: u8| [format!("sensors.adc_bits={bits}"), format!("sensors.oversample={conversions}")];
    for (adc_bits, oversample) in (6..=16).flat_map(|bits| (1..=4).map(move |conversions| (bits, conversions))) {
        let fits = ((1u32 << adc_bits) - 1) * u32::from(oversample) <= 65535;
        let sets = bits(adc_bits, oversample);
        assert_eq!(load_text("a.toml", example(), &sets).is_ok(), fits, "{sets:?}");
    }
    says(&report(example(), &["sensors.adc_bits=16"]), &["--set:1:18", "must be at most 15 with `oversample` 2, the default"]);
    says(&report(example(), &["sensors.adc_bits=16", "sensors.oversample=1", "sensors.flavour=1"]), &["1 problem"]);
    let sixteen = format!("{}\n[sensors]\nadc_bits = 15\n", example());
    says(&report(&sixteen, &["sensors.oversample=3"]), &["--set:1:20", "must be at most 2 with 15 bits"]);
    assert_eq!(loaded(&["sensors.dac_bits=16"]).sensors.unwrap().dac_bits, 16);
}

#[test]
fn scan_and_lock_in_limits_are_checked() {
    says(
        &with_line("nominal_q", "nominal_q = 8001"),
        &["a.toml:15:13", "401 steps", "at most 8000 with a span of 0.025", "0.0249968"],
    );
    assert_eq!(driven(&["controller.tracking.nominal_q=8000"]).tracking.nominal_q, 8000.0);
    let off = ["controller.tracking.nominal_q=9000", "controller.tracking.mode=off", "controller.drive.amplitude_v=3"];
    assert_eq!(driven(&off).tracking.nominal_q, 9000.0);
    says(
        &with_line("frequency_hz", "frequency_hz = 10e3"),
        &[
            "less than half a period of 9750 Hz",
            "must be at least 16025.7 Hz",
            "or set `controller.block_samples` to at least 52",
        ],
    );
    says(
        &with_line("frequency_hz", "frequency_hz = 2e3"),
        &["the longest block, `controller.block_samples` = 100, is too short"],
    );
    says(
        &report(example(), &["controller.block_samples=8"]),
        &["--set:1:26", "must be at least 13", "`controller.drive.frequency_hz`"],
    );
}

#[test]
fn firmware_refusals_are_reported_at_their_key() {
    says(
        &report(example(), &["controller.tracking.bandwidth_hz=800"]),
        &["refuses `controller.tracking.bandwidth_hz` = 800 Hz", "--set:1:34", "must be from 0.1 to 625 Hz", "block_samples"],
    );
    says(
        &report(example(), &["sensors.sample_hz=2e5"]),
        &["bandwidth_hz` = 200 Hz, the default", "--> a.toml:14:1", "must be from 0.1 to 125 Hz"],
    );
    says(
        &with_line("velocity", "velocity_m_per_s = 0.6"),
        &["refuses `controller.drive.velocity_m_per_s` = 0.6 m/s", "0.538986 m/s", "force factor x velocity"],
    );
    says(&report(example(), &["controller.tracking.mode=off"]), &["needs tracking", "--set:1:26", "cannot be `off`"]);
    says(&report(example(), &["sensors.i_full_scale_a=1e-6"]), &["refuses `sensors.i_full_scale_a`", "to 1000 A"]);
    says(&report(example(), &["controller.drive.amplitude_v=0"]), &["--set:1:30", "must be from 0.001 to 10000 V"]);
    says(
        &report(example(), &["controller.burst.off_s=[3.0000001]"]),
        &["refuses the burst", "a.toml:11:8", "at least one sample, 1e-6 s"],
    );
    says(
        &with_line("set", "set = [\"controller.tracking.bandwidth_hz=800\"]"),
        &["in the cells of the grid: the firmware refuses"],
    );
}

#[test]
fn disturbances_stay_in_range() {
    let load = ["disturbance.0.at_s=1", "disturbance.0.key=rig.slider.load_n"];
    let with = |more: &[&str]| report(example(), &[&load[..], more].concat());
    says(
        &with(&["disturbance.0.rate_per_s=-0.2", "rig.slider.load_n=0.5"]),
        &[
            "`rig.slider.load_n` may leave its range at 3.5 s",
            "--set:3:26",
            "must stay from 0 to 10000 N",
            "a slope of at least -0.1 per second",
        ],
    );
    says(
        &with(&["disturbance.0.sine_amplitude=3", "disturbance.0.sine_hz=1", "rig.slider.load_n=2"]),
        &["may leave its range at 1 s", "an amplitude of at most 2"],
    );
    let resonance = ["disturbance.0.at_s=1", "disturbance.0.key=stack.bvd.q", "disturbance.0.rate_per_s=-20", "grid.set=[]"];
    says(
        &report(example(), &resonance),
        &["`stack.bvd.q` may leave its range at 4.1", "must stay from 1 to 1e6", "a slope of at least -12."],
    );
    let added = [
        "disturbance.0.sine_amplitude=2",
        "disturbance.0.sine_hz=1",
        "rig.slider.load_n=3",
        "disturbance.1.at_s=2",
        "disturbance.1.key=rig.slider.load_n",
        "disturbance.1.rate_per_s=-0.5",
    ];
    says(&with(&added), &["may leave its range at 4 s", "--set:8:26", "add up"]);
    says(&with(&["disturbance.0.rate_per_s=-1", "disturbance.1.rate_per_s=1"]), &["`at_s` is missing", "`key` is missing"]);
}

/// Numbers that are each possible, but not together.
#[test]
fn a_circuit_that_follows_is_in_its_range() {
    let base = "base = \"transducer-smbltd45f40h-2\"\n";
    let wrong = report(base, &["stack.bvd.parallel_resonance_hz=1e6", "stack.bvd.cm_f=6e-4"]);
    says(&wrong, &["follows as", "out of range"]);
}
