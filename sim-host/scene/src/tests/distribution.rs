//! Distributions instead of numbers, and messages about mistakes in them.

use super::{example, load_text, loaded, report, says};

/// Returns the report on the example with this value of `contact.dahl.mu`.
fn refused(value: &str) -> String {
    report(example(), &[&format!("contact.dahl.mu={value}")])
}

#[test]
fn a_distribution_is_an_entry_of_vary() {
    let scene =
        loaded(&["contact.dahl.mu={ low = 0.1, high = 0.3 }", "rig.slider.speed_m_per_s={ log_low = 0.02, log_high = 0.08 }"]);
    let keys: Vec<&str> = scene.vary.iter().map(|vary| vary.key.as_str()).collect();
    assert_eq!(keys, ["contact.dahl.mu", "rig.slider.speed_m_per_s"]);
    assert_eq!((scene.vary[0].from, scene.vary[0].to), (Some(0.1), Some(0.3)));
    assert_eq!((scene.vary[1].from, scene.vary[1].to, scene.vary[1].log), (Some(0.02), Some(0.08), Some(true)));
    // The runs of a driven scene take long: their number must be given.
    assert_eq!(scene.runs, 1);
    let scene = loaded(&["contact.dahl.mu={ value = 0.2, sd = 0.01 }"]);
    assert_eq!(scene.vary[0].sd, Some(0.01));
    let study =
        load_text("a.toml", "base = \"contact-kinematic\"\ngrid = false\ncontact.dahl.mu = { samples = [0.3, 0.1, 0.2] }", &[]);
    let scene = study.unwrap_or_else(|error| panic!("{error}")).scene;
    assert_eq!((scene.runs, scene.vary[0].samples.as_deref()), (256, Some([0.3, 0.1, 0.2].as_slice())));
}

#[test]
fn the_newer_value_replaces_a_distribution() {
    let scene = loaded(&["contact.dahl.mu={ low = 0.1, high = 0.3 }", "contact.dahl.mu={ value = 0.2, sd = 0.01 }"]);
    assert_eq!((scene.vary.len(), scene.vary[0].sd), (1, Some(0.01)));
    assert!(loaded(&["contact.dahl.mu={ low = 0.1, high = 0.3 }", "contact.dahl.mu=0.25"]).vary.is_empty());
}

#[test]
fn wrong_distributions_are_named() {
    says(&refused("{ low = 0.3, high = 0.1 }"), &["the distribution of `contact.dahl.mu` from 0.3 to 0.1 is empty"]);
    says(&refused("{ value = 0.3, sd = 0 }"), &["the standard deviation of `contact.dahl.mu` is 0"]);
    says(&refused("{ log_low = 0, log_high = 1 }"), &["logarithmic, but begins at 0", "`log_low` must be above zero"]);
    says(
        &refused("{ mean = 0.3, sd = 0.1 }"),
        &[
            "`contact.dahl.mu` with `mean` and `sd` is not a distribution",
            "a distribution is `{ value = …, sd = … }`",
            "1 problem",
        ],
    );
    says(&refused("{ low = \"0.1\", high = 0.3 }"), &["`low` of the distribution of `contact.dahl.mu` is not a number"]);
    says(&refused("{ samples = \"nowhere.csv\" }"), &["the file `nowhere.csv` cannot be read"]);
    says(&refused("{ samples = [0.1, \"x\"] }"), &["`samples` of `contact.dahl.mu` are not numbers"]);
    says(&refused("{ samples = [] }"), &["the distribution of `contact.dahl.mu` has no samples"]);
    says(&refused("{ samples = [0.1], column = \"mu\" }"), &["`column` of `contact.dahl.mu` has no file"]);
    says(&refused("{}"), &["`contact.dahl.mu` is an empty table"]);
    // Zero is the end of the range, but no valid value: the cut excludes it.
    assert_eq!(loaded(&["contact.dahl.mu={ value = 0.3, sd = 0.2 }"]).vary.len(), 1);
    // Both ends must be valid.
    says(&refused("{ low = 0.1, high = 9 }"), &["`contact.dahl.mu` varied to 9", "out of range"]);
    says(&report(example(), &["seed={ low = 1, high = 5 }"]), &["`seed` cannot be varied"]);
}

#[test]
fn columns_of_one_file_are_drawn_together() {
    let folder = std::env::temp_dir().join(format!("sonoglide-distribution-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("fit.csv"), "mu,stiffness [N/mm]\n0.1,1000\n0.2,2000\n0.3,3000\n").unwrap();
    let scene = folder.join("a.toml");
    let text = "base = \"contact-kinematic\"\ngrid = false\n[contact.dahl]\nmu = { samples = \"fit.csv\", column = \"mu\" }\n\
                stiffness_n_per_m = { samples = \"fit.csv\", column = \"stiffness\" }\n";
    let loaded = load_text(&scene.to_string_lossy(), text, &[]).unwrap_or_else(|error| panic!("{error}"));
    let [mu, stiffness] = loaded.scene.vary.as_slice() else { panic!("{:?}", loaded.scene.vary) };
    assert_eq!((mu.set.as_deref(), stiffness.set.as_deref()), (Some("fit.csv"), Some("fit.csv")));
    assert_eq!(stiffness.samples.as_deref(), Some([1e6, 2e6, 3e6].as_slice()));
    assert!(loaded.files().iter().any(|file| file.ends_with("fit.csv")));
}
