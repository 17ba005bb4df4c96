//! Merged texts, and the texts that messages point to.

use super::{driven, example, loaded, report, says, sets};
use crate::load::{LoadError, load, load_text};

#[test]
fn changes_replace_add_and_count() {
    assert_eq!(loaded(&["duration_s = 7"]).duration_s, 7.0);
    assert_eq!(loaded(&["title=No quotes: needed"]).title, "No quotes: needed");
    assert_eq!(loaded(&["expect.0.min=1"]).expect[0].min, Some(1.0));
    assert_eq!(driven(&["controller.block_samples=16.0"]).block_samples, 16);
    assert_eq!(driven(&["controller.burst.on_s.0=2"]).burst.unwrap().on_s, [2.0]);
    assert_eq!(driven(&["controller.tracking.nominal_c0_f=none"]).tracking.nominal_c0_f, None);
    says(&report(example(), &["controller.tracking.nominal_q=none"]), &["`controller.tracking.nominal_q` cannot be a string"]);
    let new = ["grid.set=[]", "disturbance.0.at_s=1", "disturbance.0.key=rig.slider.load_n", "disturbance.0.to=5"];
    assert_eq!(loaded(&new).disturbance[0].to, Some(5.0));
    let drive = driven(&["controller.drive.amplitude_v=3"]).drive;
    assert_eq!((drive.amplitude_v, drive.velocity_m_per_s), (Some(3.0), None));
    let burst = driven(&["controller.burst.period_s=0.01", "controller.burst.duty=0.5"]).burst.unwrap();
    assert_eq!((burst.period_s, burst.on_s.len()), (Some(0.01), 0));
}

#[test]
fn wrong_changes_are_reported_at_set() {
    says(
        &report(example(), &["seed=1", "rig.slider.sped_m_per_s=1"]),
        &["--set:2:12", "did you mean `speed_m_per_s`?", "in --set"],
    );
    says(&report(example(), &["seed=fast"]), &["`seed` cannot be a string"]);
    says(&report(example(), &["expect.7.min=1"]), &["`expect` has 1 entry", "there is no entry 7"]);
    says(&report(example(), &["controller.burst.on_s=[3"]), &["unclosed array"]);
    for change in ["", "=", "seed", "=3", "seed=", "a b=3", "#=1", "..=1"] {
        says(&report(example(), &[change]), &["for example `--set"]);
    }
    let both = ["controller.drive.amplitude_v=3", "controller.drive.velocity_m_per_s=1"];
    says(&report(example(), &both), &["exclude each other", "--set:2:18"]);
}

#[test]
fn invisible_characters_are_refused_in_every_text() {
    for (text, path) in
        [("title = \"a\\u001b[2J\"", "title"), ("source = \"a\u{202e}b\"", "source"), ("notes = [\"\\u009b\"]", "notes.0")]
    {
        says(
            &report(&format!("base = \"contact\"\n{text}"), &[]),
            &[&format!("`{path}` contains the invisible character \\u{{"), "remove"],
        );
    }
    says(&report("base = \"contact\"", &["title=a\\rb\u{7f}"]), &["`title` contains the invisible character \\u{7f}"]);
    assert_eq!(load_text("a", "base = \"contact\"\ntitle = \"\"\"a\r\n\tb\"\"\"", &[]).unwrap().scene.title.lines().count(), 2);
}

#[test]
fn false_removes_a_table_or_list_of_the_base() {
    let lugre = "[contact.lugre]\nmu = 0.2\nnormal_n = 1\nstatic_mu = 0.3\nstribeck_m_per_s = 0.1\nstiffness_n_per_m = 1e6\n";
    let text = |head: &str| format!("base = \"contact-kinematic\"\n{head}{lugre}");
    assert!(load_text("a.toml", &text("grid = false\n"), &[]).is_ok_and(|loaded| loaded.scene.grid.is_none()));
    says(&report(&text(""), &[]), &["grid"]);
    assert!(loaded(&["grid=false", "expect=false"]).grid.is_none());
    let unswitched = load_text("a.toml", "base = \"friction-burst\"\n[controller]\nfriction = false\n", &[]).unwrap().scene;
    assert!(unswitched.controller.unwrap().friction.is_none());
    assert!(loaded(&["controller.burst=false"]).controller.unwrap().burst.is_none());
    says(&report(example(), &["controller.drive=false"]), &["add [controller.drive]"]);
    says(&report(example(), &["grid=true"]), &["`grid` cannot be true or false"]);
}

#[test]
fn scenes_are_merged_over_their_base() {
    let scene = load_text("a.toml", "base = \"experiment-1\"\n[controller.drive]\namplitude_v = 3\n", &[]).unwrap().scene;
    let drive = &scene.controller.as_ref().unwrap().drive;
    assert_eq!((drive.amplitude_v, drive.velocity_m_per_s), (Some(3.0), None));
    assert_eq!(scene.stack, loaded(&[]).stack);
    says(&report("base = \"experimnt-1\"", &[]), &["no scene `experimnt-1` to start from", "try `experiment-1`"]);
    says(&report("base = 3", &[]), &["`base` cannot be a whole number"]);
    says(&report("base = \"a.toml\"", &[]), &["`base` is circular"]);
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
    assert_eq!(fixed.cell(&sets(&["seed=3"])).unwrap().scene.seed, 3);
    write("left.toml", b"base = \"right.toml\"");
    says(&refused(&write("right.toml", b"base = \"left.toml\"")), &["`base` is circular"]);
    says(&refused(&write("latin.toml", b"title = \"x\"\n\xff")), &["line 2 is not UTF-8 text"]);
    says(&refused(&write("wide.toml", b"\xff\xfet\0")), &["UTF-16"]);
    says(&refused(&write("nul.toml", b"t\0")), &["a binary file"]);
    says(&refused(&write("large.toml", &vec![b'#'; 2 << 20])), &["larger than 1 MiB"]);
    says(&refused(&folder.to_string_lossy()), &["cannot read", "it is a folder"]);
    for number in 0..=65 {
        write(&format!("{number}.toml"), format!("base = \"{}.toml\"", number + 1).as_bytes());
    }
    says(&refused(&write("0.toml", b"base = \"1.toml\"")), &["more than 64 scenes start from one another", "64.toml:1:8"]);
    #[cfg(unix)]
    says(&refused(&write("zero.toml", b"base = \"/dev/zero\"")), &["it is a device", "the scene to start from"]);
    write("manifest.json", b"{}");
    says(&refused(&folder.to_string_lossy()), &["the folder of a run", "/manifest.json` repeats the run"]);
    says(&refused("no-such-folder/scene.toml"), &["cannot read the scene `no-such-folder/scene.toml`"]);
    std::fs::remove_dir_all(folder).unwrap();
    let Err(LoadError::NotFound { nearest, .. }) = load("experment-1", &[]) else { panic!("found") };
    assert_eq!(nearest[0], "experiment-1");
}
