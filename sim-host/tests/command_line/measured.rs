//! Measured time series and curves in scenes: from a file to metrics, files of the run, and a
//! repetition of the run without the file.

use super::{Folder, code, sim_host, stderr, stdout};
use serde_json::Value;

const SCENE: &str = "base = \"belt-stop-slow\"\ntitle = \"a belt as measured\"\nduration_s = 0.25\n\n[[disturbance]]\nat_s = 0\nkey = \"rig.slider.speed_m_per_s\"\n\
                     profile = { file = \"speed.csv\" }\n\n[[overlay]]\nquantity = \"load_cell_n\"\nfile = \"cell.csv\"\nname = \"load cell of the rig\"\n\n\
                     [[expect]]\nmetric = \"overlay_max_n\"\nmax = 5\n";

fn measured(name: &str) -> (Folder, String) {
    let folder = Folder::new(name);
    folder.write("speed.csv", "t [ms],v [mm/s]\n0,38\n100,30\n150,34\n300,34\n");
    folder.write("cell.csv", "t [ms];F [mN]\n50;1600\n120;1200\n200,5;1000,5\n900;1\n");
    let scene = folder.write("belt.toml", SCENE);
    (folder, scene)
}

#[test]
fn a_run_follows_a_file_and_is_repeated_without_it() {
    let (folder, scene) = measured("profile");
    let out = format!("{}/out", folder.text());
    let first = sim_host(&["run", &scene, "-o", &out, "--format", "json"]);
    assert_eq!(code(&first), 0, "{}", stderr(&first));
    let json: Value = serde_json::from_str(&stdout(&first)).expect("JSON");
    let (rms, max) = (json["metrics"]["overlay_rms_n"].as_f64().unwrap(), json["metrics"]["overlay_max_n"].as_f64().unwrap());
    assert!(rms > 0.0 && rms <= max && max < 5.0, "{rms} {max}");
    // Of the four points, the last is after the end of the run.
    assert!(
        folder.read("out/report.html").contains("Measured and simulated")
            && folder.read("out/report.html").contains("load cell of the rig")
    );
    let figure = folder.read("out/friction.csv");
    assert!(figure.lines().filter(|line| line.starts_with("measured_load_cell_n,")).count() == 4, "{figure:.200}");
    let speed = folder.read("out/trace.csv");
    assert!(speed.lines().count() > 100);
    for file in ["speed.csv", "cell.csv"] {
        std::fs::remove_file(folder.0.join(file)).expect("the file");
    }
    let manifest = format!("{out}/manifest.json");
    let again = sim_host(&["run", &manifest, "--no-report", "--format", "json"]);
    let repeated: Value = serde_json::from_str(&stdout(&again)).expect("JSON");
    assert_eq!((&repeated["metrics"], &repeated["drive_hash"]), (&json["metrics"], &json["drive_hash"]), "{}", stderr(&again));
    let gone = sim_host(&["run", &scene, "--no-report"]);
    assert!(code(&gone) == 3 && stderr(&gone).contains("the file `speed.csv` cannot be read"), "{}", stderr(&gone));
}

#[test]
fn sweeps_and_draws_follow_a_file() {
    let (folder, scene) = measured("profile-sweep");
    let atlas = format!("{}/atlas", folder.text());
    let key = "disturbance.0.profile.from_s=0:0.05:2";
    let sweep = sim_host(&["sweep", &scene, "--over", key, "--metric", "overlay_rms_n,friction_on_n", "-o", &atlas, "-q"]);
    assert_eq!(code(&sweep), 0, "{}", stderr(&sweep));
    let rows = folder.read("atlas/sweep.csv");
    let rms: Vec<&str> = rows.lines().skip(1).map(|row| row.split(',').nth(2).unwrap()).collect();
    assert!(rms.len() == 2 && rms[0] != rms[1] && rms.iter().all(|value| value.parse::<f64>().is_ok()), "{rows}");
    let draws = ["--set", "runs=2", "--set", "vary.0.key=contact.dahl.mu", "--set", "vary.0.spread=0.1", "--set", "expect=[]"];
    let many = sim_host(&[&["run", &scene, "--no-report", "--format", "json"], &draws[..]].concat());
    let json: Value = serde_json::from_str(&stdout(&many)).expect("JSON");
    assert!(json["metrics"]["overlay_rms_n"].is_number() && json["metrics"]["overlay_rms_n_p95"].is_number(), "{json}");
}

#[test]
fn a_curve_lies_over_a_contact_study() {
    let folder = Folder::new("overlay");
    folder.write("loop.csv", "x [um],F [N]\n-0.1,0.1\n0.1,0.15\n");
    folder.write("time.csv", "t [us],F [N]\n3310,0.1\n3320,0.15\n");
    let head = "base = \"contact\"\ntitle = \"over\"\n";
    let over = "[[overlay]]\nquantity = \"friction_n\"\nfile = ";
    let scene = folder.write(
        "a.toml",
        &format!("{head}\n{over}\"time.csv\"\n\n{over}\"loop.csv\"\nfigure = \"hysteresis\"\nx_column = \"x\"\n"),
    );
    let out = format!("{}/out", folder.text());
    let run = sim_host(&["run", &scene, "-o", &out, "--format", "json"]);
    let json: Value = serde_json::from_str(&stdout(&run)).unwrap_or_else(|_| panic!("{}", stderr(&run)));
    assert!(json["metrics"]["overlay_rms_n"].as_f64().is_some_and(|rms| rms < 1.0), "{json}");
    let [time, hysteresis] = ["friction", "hysteresis"].map(|id| folder.read(&format!("out/{id}.csv")));
    assert!(
        time.contains("measured_friction_n,198.6") && hysteresis.contains("measured_friction_n,-0.1,0.1"),
        "{time:.300} {hysteresis:.300}"
    );
    for (change, why) in [
        ("overlay.0.quantity=frction_n", "no figure has a curve `frction_n`"),
        ("overlay.0.figure=frictoin", "there is no figure `frictoin`"),
        ("overlay.1.figure=slip-loop", "the figure `slip-loop` has no curve `friction_n`"),
    ] {
        let refused = sim_host(&["check", &scene, "--set", change]);
        assert!(code(&refused) == 3 && stderr(&refused).contains(why), "{}", stderr(&refused));
    }
    let axis = folder.write(
        "b.toml",
        &format!("{head}\n{over}\"loop.csv\"\nfigure = \"slip-loop\"\nx_column = \"x\"\n")
            .replace("\"friction_n\"", "\"friction_against_slip_n\""),
    );
    let refused = sim_host(&["check", &axis]);
    assert!(code(&refused) == 3 && stderr(&refused).contains("the points are over um"), "{}", stderr(&refused));
}

#[test]
fn a_curve_outside_the_run_is_named() {
    let folder = Folder::new("overlay-missing");
    folder.write("time.csv", "t [us],F [N]\n3310,0.1\n3320,0.15\n");
    let over = "[[overlay]]\nquantity = \"friction_n\"\nfile = \"time.csv\"\nname = \"the rig\"\n";
    let scene = folder.write("a.toml", &format!("base = \"contact-kinematic\"\ntitle = \"closed\"\n\n{over}"));
    let out = format!("{}/out", folder.text());
    let run = sim_host(&["run", &scene, "-o", &out, "--format", "json"]);
    let why = "The curve `the rig` is not drawn and not compared: its points range from 198.6 to 199.2, but the curve of figure `friction` ranges from 0 to 1, time [periods of the excitation].";
    assert!(code(&run) == 0 && stderr(&run).contains(&format!("warning: {why}")), "{}", stderr(&run));
    assert!(stderr(&run).contains("`--set integrator.method=linexp`"), "{}", stderr(&run));
    for file in ["summary.json", "manifest.json"] {
        let json: Value = serde_json::from_str(&folder.read(&format!("out/{file}"))).expect("JSON");
        assert!(json["overlays_not_drawn"][0].as_str().is_some_and(|said| said.starts_with(why)), "{json}");
    }
    assert!(folder.read("out/report.html").contains("is not drawn and not compared"));
    // With time steps the run contains these moments, and the remark disappears.
    let steps = sim_host(&["run", &scene, "--no-report", "--format", "json", "--set", "integrator.method=linexp"]);
    let json: Value = serde_json::from_str(&stdout(&steps)).unwrap_or_else(|_| panic!("{}", stderr(&steps)));
    assert!(json["metrics"]["overlay_rms_n"].is_number() && json["overlays_not_drawn"].is_null(), "{json}");
    // Figures of several runs have no time axis of a single run.
    let many = ["integrator.method=linexp", "runs=2", "vary.0.key=contact.dahl.mu", "vary.0.spread=0.1", "expect=[]"];
    let many: Vec<&str> = many.into_iter().flat_map(|set| ["--set", set]).collect();
    let many = sim_host(&[&["run", &scene, "--no-report"], &many[..]].concat());
    assert!(stdout(&many).contains("Figures of several runs show all of them"), "{}{}", stdout(&many), stderr(&many));
}
