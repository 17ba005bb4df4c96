//! Scenes that are wrong in every way, and what a user reads about them.

use super::Scene;
use super::load::{LoadError, load, load_text};
use super::resolved::{resolved_json, resolved_toml};
use super::rules::EXCLUSIVE;
use super::schema::Schema;

/// A scene of these tests' own, so that line numbers stay what they are.
fn example() -> &'static str {
    include_str!("tests/example.toml")
}

fn sets(sets: &[&str]) -> Vec<String> {
    sets.iter().map(|set| (*set).to_owned()).collect()
}

fn loaded(changes: &[&str]) -> Scene {
    load_text("experiment-1", example(), &sets(changes)).unwrap_or_else(|error| panic!("{error}")).scene
}

/// The report on a text.
fn report(text: &str, changes: &[&str]) -> String {
    match load_text("a.toml", text, &sets(changes)) {
        Ok(_) => panic!("nothing is wrong with\n{text}\n{changes:?}"),
        Err(error) => error.to_string(),
    }
}

/// The report on the example with one line replaced.
fn with_line(old: &str, new: &str) -> String {
    let line = example().lines().find(|line| line.starts_with(old)).unwrap_or_else(|| panic!("no line `{old}`"));
    report(&example().replacen(line, new, 1), &[])
}

fn says(report: &str, parts: &[&str]) {
    for part in parts {
        assert!(report.contains(part), "`{part}` is missing in\n{report}");
    }
}

#[test]
fn unknown_keys_have_a_nearest_name() {
    let report = with_line("off_s", "of_s = [5.0]");
    says(
        &report,
        &["unknown key `of_s` in [controller.burst]", "--> a.toml:12:1", "did you mean `off_s`?", "\n1 problem in a.toml"],
    );
}

#[test]
fn another_unit_is_converted() {
    says(&with_line("speed_m", "speed_mm_per_s = 38"), &["is in mm/s, but m/s is expected", "write `speed_m_per_s = 0.038`"]);
    says(&with_line("frequency_hz", "frequency_khz = 40"), &["write `frequency_hz = 40000`", "1 problem"]);
    says(&with_line("on_s", "on_ms = [3000]"), &["write `on_s = [3]`"]);
    says(&with_line("scan_v", "scan_vpp = 6"), &["in V peak to peak", "write `scan_v = 3`"]);
    says(&with_line("load_n", "load = 0"), &["`load` lacks its unit", "give it in N: `load_n`"]);
}

#[test]
fn a_key_in_the_wrong_table_is_told_its_home() {
    says(&with_line("[contact", "[contact.dahl]\nseed = 3"), &["key `seed` is misplaced", "belongs at the top level"]);
    says(&with_line("scan_v", "scan_v = 3\nduty = 0.5"), &["belongs in [controller.burst]"]);
}

#[test]
fn types_ranges_and_choices_are_checked() {
    says(&with_line("mu", "mu = \"0.3\""), &["`contact.dahl.mu` cannot be a string", "without the quotes: 0.3"]);
    says(&with_line("mu", "mu = 7"), &["`contact.dahl.mu` is out of range", "must be from 0 to 5"]);
    says(&with_line("mu", "mu = nan"), &["must be a finite number"]);
    says(&with_line("mu", "mu = -inf"), &["must be a finite number"]);
    says(&with_line("mu", "mu = 1e999"), &["must be a finite number"]);
    says(&with_line("mu", &format!("mu = {}", "9".repeat(500))), &["must be a finite number"]);
    says(&with_line("on_s", "on_s = 3.0"), &["expected a list of numbers in s", "`[3]`"]);
    says(&with_line("off_s", "off_s = [5.0, \"six\"]"), &["`controller.burst.off_s.1` cannot be a string"]);
    says(&with_line("off_s", "off_s = [1,2,3,4,5,6,7,8,9]"), &["has 9 entries", "takes at most 8"]);
    says(&with_line("scan_v", "scan_v = 3\nshape = \"sqare\""), &["did you mean `square`?", "it is `sine` or `square`"]);
    says(&with_line("[controller.drive]", "[controller]\nblock_samples = 12.5\n[controller.drive]"), &["must be a whole number"]);
    says(&with_line("[contact.dahl]", "[[contact]]"), &["`contact` cannot be a list of tables", "write `[contact]`"]);
    says(&report("controller = \"on\"", &[]), &["`controller` cannot be a string", "write `[controller]`"]);
    says(&report("fault = 3", &[]), &["expected a list of tables"]);
}

#[test]
fn what_is_missing_is_named_where_it_belongs() {
    says(
        &with_line("frequency_hz", ""),
        &["`frequency_hz` is missing in [controller.drive]", "--> a.toml:5:1", "a number in Hz"],
    );
    says(&report("title = \"x\"\nduration_s = 1\n", &[]), &["the table [controller] is missing", "the table [stack] is missing"]);
    says(&report("", &[]), &["the scene is empty", "sim-host show experiment-1"]);
    says(&report("# nothing\n", &[]), &["the scene is empty"]);
}

#[test]
fn all_problems_are_reported_in_order() {
    let text = example().replacen("duration_s", "duraton_s", 1).replacen("mu = ", "nu = ", 1).replacen("min = 66", "min = 70", 1);
    let report = report(&text, &[]);
    says(&report, &["3 problems in a.toml"]);
    let places: Vec<_> = ["a.toml:3:1", "a.toml:28:1", "a.toml:48:7"].into_iter().map(|place| report.find(place)).collect();
    assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{report}");
}

#[test]
fn syntax_errors_stand_alone() {
    says(&with_line("mu", "mu = 0,3"), &["decimals have a point", "1 problem"]);
    says(&with_line("mu", "mu ="), &["the value is missing", "1 problem"]);
    says(&with_line("mu", "mu = 0.3\nmu = 0.4"), &["this name is already taken", "second time", "a.toml:29:1"]);
    says(&report("µ = 1", &[]), &["invalid unquoted key"]);
    says(&report(&format!("a = {}", "[".repeat(10_000)), &[]), &["nested too deeply"]);
    says(&report("a = 1\r\n\tb = \r\n", &[]), &["a.toml:2:6"]);
}

#[test]
fn the_drive_is_complete_and_within_its_limits() {
    says(&with_line("scan_v", "amplitude_v = 3"), &["`amplitude_v` and `velocity_m_per_s` exclude each other", "a.toml:8:1"]);
    says(&with_line("velocity", ""), &["[controller.drive] says too little"]);
    says(&with_line("scan_v", ""), &["needs `scan_v`"]);
    says(&with_line("nominal_force", ""), &["needs `controller.tracking.nominal_force_factor_n_per_v`"]);
    says(
        &with_line("scan_v", "scan_v = 16"),
        &["more than `controller.limits.voltage_v` allows", "at most 15.466 V, the default"],
    );
    says(&with_line("scan_v", "scan_v = 30"), &["more than `amplifier.full_scale_v` allows"]);
    says(&with_line("frequency_hz", "frequency_hz = 445e3"), &["too fast for the converters"]);
    says(&with_line("lm_h", ""), &["`cm_f` and `rm_ohm` need `lm_h`, too"]);
    says(&with_line("lm_h", "q = 50"), &["`cm_f` and `q` exclude each other"]);
}

#[test]
fn time_runs_forward_and_ends() {
    says(&with_line("off_s", "off_s = [5.0, 5.5]"), &["1 beginnings and 2 ends"]);
    says(&with_line("off_s", "off_s = [2.0]"), &["ends at 2 s, but begins at 3 s only"]);
    says(&with_line("off_s", "off_s = [4, 6]").replace("  ", " "), &["needs as many"]);
    says(&report(example(), &["controller.burst.on_s=[1,2]", "controller.burst.off_s=[3,4]"]), &["the one before ends at 3 s"]);
    says(&report(example(), &["duration_s=2"]), &["`controller.burst.on_s.0` is 3 s, but the run is over at 2 s", "--set:1:12"]);
    says(&report(example(), &["trace.signals=[\"v_code\"]", "trace.from_s=2", "trace.to_s=1"]), &["the trace ends at 1 s"]);
    says(&report(example(), &["fault.0.at_s=6", "fault.0.kind=open"]), &["`fault.0.at_s` is 6 s"]);
}

#[test]
fn disturbances_and_expectations_make_sense() {
    let load = ["disturbance.0.at_s=1", "disturbance.0.key=rig.slider.load_n"];
    says(&report(example(), &load), &["[[disturbance]] says too little"]);
    says(&report(example(), &[&load[..], &["disturbance.0.to=-1"]].concat()), &["`rig.slider.load_n` is out of range"]);
    says(&report(example(), &[&load[..], &["disturbance.0.sine_hz=1"]].concat()), &["`sine_hz` needs `sine_amplitude`, too"]);
    let without_contact: String = example().split_inclusive("\n\n").filter(|part| !part.contains("[contact")).collect();
    let (grid, rig) = (without_contact.find("[grid]").unwrap(), without_contact.find("[rig").unwrap());
    says(&report(&without_contact, &[]), &["[rig] without [contact]"]);
    let bare = format!("{}{}", &without_contact[..rig], &without_contact[grid..]);
    says(&report(&bare, &[&load[..], &["disturbance.0.to=1"]].concat()), &["cannot change: the scene has no [rig]"]);
    says(&with_line("min", "min = 70"), &["nothing is at least 70 and at most 69"]);
    says(&with_line("min", "tolerance = 1"), &["exclude each other in [[expect]]"]);
    says(&report(example(), &["expect.0.metric=reduction_percnt"]), &["did you mean `reduction_percent`?"]);
}

#[test]
fn the_cells_of_the_grid_are_scenes() {
    says(
        &with_line("row_key", "row_key = \"rig.slider.load\""),
        &["is no number of a scene", "did you mean `rig.slider.load_n`?"],
    );
    says(&with_line("row_key", "row_key = \"controller.drive.shape\""), &["is no number of a scene"]);
    says(&with_line("columns", "columns = [0.1, 1e9]"), &["`rig.slider.speed_m_per_s` is out of range", "a.toml:42:17"]);
    says(&with_line("set", "set = [\"duration_s=0.7\"]"), &["in the cells of the grid: `controller.burst.on_s.0` is 3 s"]);
    says(&with_line("set", "set = [\"a\"]"), &["in the cells of the grid: a change is written `key=value`", "a.toml:43:8"]);
}

#[test]
fn changes_replace_add_and_count() {
    assert_eq!(loaded(&["duration_s = 7"]).duration_s, 7.0);
    assert_eq!(loaded(&["title=No quotes: needed"]).title, "No quotes: needed");
    assert_eq!(loaded(&["expect.0.min=1"]).expect[0].min, Some(1.0));
    assert_eq!(loaded(&["controller.block_samples=16.0"]).controller.block_samples, 16);
    assert_eq!(loaded(&["controller.burst.on_s.0=2"]).controller.burst.unwrap().on_s, [2.0]);
    let new = ["grid.set=[]", "disturbance.0.at_s=1", "disturbance.0.key=rig.slider.load_n", "disturbance.0.to=5"];
    assert_eq!(loaded(&new).disturbance[0].to, Some(5.0));
    let drive = loaded(&["controller.drive.amplitude_v=3"]).controller.drive;
    assert_eq!((drive.amplitude_v, drive.velocity_m_per_s), (Some(3.0), None));
    let burst = loaded(&["controller.burst.period_s=0.01", "controller.burst.duty=0.5"]).controller.burst.unwrap();
    assert_eq!((burst.period_s, burst.on_s.len()), (Some(0.01), 0));
}

#[test]
fn wrong_changes_are_reported_in_their_own_text() {
    says(
        &report(example(), &["seed=1", "rig.slider.sped_m_per_s=1"]),
        &["--set:2:12", "did you mean `speed_m_per_s`?", "in --set"],
    );
    says(&report(example(), &["seed=fast"]), &["`seed` cannot be a string"]);
    says(&report(example(), &["expect.7.min=1"]), &["`expect` has 1 entry", "there is no number 7"]);
    says(&report(example(), &["controller.burst.on_s=[3"]), &["unclosed array"]);
    for change in ["", "=", "seed", "=3", "seed=", "a b=3", "#=1", "..=1"] {
        says(&report(example(), &[change]), &["for example `--set"]);
    }
    let both = ["controller.drive.amplitude_v=3", "controller.drive.velocity_m_per_s=1"];
    says(&report(example(), &both), &["exclude each other", "--set:2:18"]);
}

#[test]
fn a_base_is_laid_under() {
    let scene = load_text("a.toml", "base = \"experiment-1\"\n[controller.drive]\namplitude_v = 3\n", &[]).unwrap().scene;
    assert_eq!(scene.controller.drive.amplitude_v, Some(3.0));
    assert_eq!(scene.controller.drive.velocity_m_per_s, None);
    assert_eq!(scene.stack, loaded(&[]).stack);
    says(&report("base = \"experimnt-1\"", &[]), &["no scene `experimnt-1` to start from", "try `experiment-1`"]);
    says(&report("base = 3", &[]), &["`base` cannot be a whole number"]);
    says(&report("base = \"a.toml\"", &[]), &["`base` goes in a circle"]);
    says(&report(example(), &["base=x"]), &["`base` cannot be set"]);
}

#[test]
fn files_are_found_read_or_refused() {
    let folder = std::env::temp_dir().join(format!("scene-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        path.to_string_lossy().into_owned()
    };
    let refused = |path: &str| load(path, &[]).unwrap_err().to_string();
    write("under.toml", example().replacen("mu = 0.3", "mu = -1", 1).as_bytes());
    let derived = write("my-scene.toml", b"base = \"under.toml\"\nseed = 2\n");
    says(&refused(&derived), &["under.toml:28:6", "under.toml", "1 problem in"]);
    let fixed = load(&derived, &sets(&["contact.dahl.mu=0.2"])).unwrap();
    assert_eq!((fixed.name.as_str(), fixed.scene.seed), ("my-scene", 2));
    assert_eq!(fixed.with(&sets(&["seed=3"])).unwrap().scene.seed, 3);
    write("left.toml", b"base = \"right.toml\"");
    says(&refused(&write("right.toml", b"base = \"left.toml\"")), &["`base` goes in a circle"]);
    says(&refused(&write("latin.toml", b"title = \"x\"\n\xff")), &["line 2 is not UTF-8 text"]);
    says(&refused(&write("wide.toml", b"\xff\xfet\0")), &["UTF-16"]);
    says(&refused(&write("nul.toml", b"t\0")), &["a binary file"]);
    says(&refused(&write("large.toml", &vec![b'#'; 2 << 20])), &["larger than 1 MiB"]);
    says(&refused(&folder.to_string_lossy()), &["cannot read"]);
    says(&refused("no-such-folder/scene.toml"), &["cannot read the scene `no-such-folder/scene.toml`"]);
    std::fs::remove_dir_all(folder).unwrap();
    let Err(LoadError::NotFound { nearest, .. }) = load("experment-1", &[]) else { panic!("found") };
    assert_eq!(nearest[0], "experiment-1");
}

#[test]
fn resolved_scenes_read_back_the_same() {
    let rich = [
        "grid.set=[]",
        "title=\"\"\"two\nlines, \\\"quotes\\\" # and ä\"\"\"",
        "controller.phasing.phase_trim_turns=[0.1, -0.25]",
        "disturbance.0.at_s=1",
        "disturbance.0.key=rig.slider.load_n",
        "disturbance.0.rate_per_s=-1e-7",
        "fault.0.at_s=1",
        "fault.0.kind=late_block",
        "trace.signals=[\"v_code\", \"friction_n\"]",
        "stack.bvd.cm_f=1.2345678901234567e-8",
    ];
    for changes in [&[][..], &rich] {
        let scene = loaded(changes);
        let text = resolved_toml(&scene);
        let again = load_text("resolved", &text, &[]).unwrap_or_else(|error| panic!("{error}\n{text}"));
        assert_eq!(again.scene, scene, "{text}");
        assert_eq!(resolved_toml(&again.scene), text);
        assert_eq!(serde_json::from_value::<Scene>(resolved_json(&scene)).unwrap(), scene);
    }
    says(
        &resolved_toml(&loaded(&[])),
        &["c0_f = 3e-7 ", "# Clamped capacitance, F.", "shape = \"sine\"", "sine | square", "\n[sensors]\n"],
    );
}

#[test]
fn exclusive_keys_exist() {
    for group in EXCLUSIVE {
        let (_, table) = Schema::tables().into_iter().find(|(path, _)| path == group.table).unwrap();
        for key in group.alternatives.iter().flat_map(|way| way.keys) {
            assert!(table.property(key).is_some(), "{}.{key}", group.table);
        }
    }
}

#[test]
fn nothing_panics_whatever_the_text() {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut below = |bound: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % bound.max(1) as u64) as usize
    };
    let bits = [
        "=", "[", "]", "[[", "]]", ".", "\"", "'", "\"\"\"", "{", "}", "-", "e9", "inf", "nan", "ä", "\r\n", "\t", "\0", "#",
        "0.", ",",
    ];
    for round in 0..2000 {
        let mut lines: Vec<_> = example().lines().map(str::to_owned).collect();
        for _ in 0..=below(4) {
            let at = below(lines.len());
            match below(5) {
                0 => drop(lines.remove(at)),
                1 => lines.insert(at, lines[below(lines.len())].clone()),
                2 => {
                    let other = below(lines.len());
                    lines.swap(at, other);
                }
                3 => {
                    let line = &mut lines[at];
                    let cut = line.floor_char_boundary(below(line.len() + 1));
                    line.insert_str(cut, bits[below(bits.len())]);
                }
                _ => {
                    let line = &mut lines[at];
                    let cut = line.floor_char_boundary(below(line.len() + 1));
                    line.truncate(cut);
                }
            }
        }
        let text = lines.join(if below(2) == 0 { "\n" } else { "\r\n" });
        let line = lines[below(lines.len())].clone();
        let changes = if round % 2 == 0 { vec![] } else { vec![line] };
        match load_text("fuzz", &text, &changes) {
            Ok(found) => assert_eq!(load_text("again", &resolved_toml(&found.scene), &[]).unwrap().scene, found.scene),
            Err(LoadError::Invalid(report)) => {
                assert!(report.count() > 0 && !report.render(false).is_empty() && !report.render(true).is_empty(), "{text}");
            }
            Err(error) => panic!("{error}"),
        }
    }
}
