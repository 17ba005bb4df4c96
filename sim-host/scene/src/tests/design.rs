//! Designs: their own scenes, and stacks that follow from one.

use std::fs;

use crate::load::{load, load_text};

const ROD: &str = "title = \"rod\"\n[design]\n[[design.element]]\nkind = \"cylinder\"\nmaterial = \"steel\"\nlength_m = 0.1\ndiameter_m = 0.02\n";

fn problem(text: &str) -> String {
    load_text("x.toml", text, &[]).map_or_else(|error| error.to_string(), |_| "accepted".to_owned())
}

#[test]
fn a_design_needs_no_duration_and_no_run() {
    let loaded = load_text("rod.toml", ROD, &[]).unwrap_or_else(|error| panic!("{error}"));
    assert!(loaded.scene.designed().is_some() && loaded.scene.duration_s == 0.0);
    for (more, said) in [
        ("duration_s = 1\n", "`duration_s` cannot be used in a design"),
        ("[contact.dahl]\nmu = 0.1\nnormal_n = 1\nstiffness_n_per_m = 1e5\n", "[contact] cannot be used in a design"),
        ("[amplifier]\nsource_ohm = 1\n", "[amplifier] cannot be used in a design"),
        ("[controller.drive]\nfrequency_hz = 40e3\n", "[controller] and [design] exclude each other"),
    ] {
        let text = if more.starts_with('[') { format!("{ROD}{more}") } else { format!("{more}{ROD}") };
        assert!(problem(&text).contains(said), "{more}: {}", problem(&text));
    }
}

#[test]
fn mistakes_of_a_design_are_shown_at_their_place() {
    for (from, to, said) in [
        ("steel", "steal", "there is no material `steal`"),
        ("cylinder", "cone", "`end_diameter_m` is missing"),
        ("diameter_m = 0.02", "diameter_m = 0.02\nbore_m = 0.03", "the hole is not smaller than the part"),
        ("[design]", "[design]\nhighest_hz = 1000", "there is no mode below 1000 Hz"),
        ("[design]", "[design]\ndrive_v = 1", "there are no rings to drive"),
    ] {
        let said_of = problem(&ROD.replacen(from, to, 1));
        assert!(said_of.contains(said) && said_of.contains("x.toml:"), "{said_of}");
    }
}

/// The circuit replaces that of a base; a newer value replaces that of the design; two values in
/// one text are refused.
#[test]
fn a_stack_has_one_source() {
    let folder = std::env::temp_dir().join(format!("sonoglide-design-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let at = |name: &str, text: &str| {
        let path = folder.join(name);
        fs::write(&path, text).unwrap();
        path.to_string_lossy().into_owned()
    };
    let base = at("base.toml", "base = \"transducer-smbltd45f28h\"\n[stack.design]\nfile = \"langevin\"\n");
    let bvd = |sets: &[String]| load(&base, sets).unwrap_or_else(|error| panic!("{error}")).scene.stack.unwrap();
    let stack = bvd(&[]);
    assert!((stack.bvd.series_resonance_hz.unwrap() / 28e3 - 1.0).abs() < 1e-3 && stack.mode.len() == 3);
    assert!(stack.bvd.cm_f.is_none() && (stack.bvd.q.unwrap() / 500.0 - 1.0).abs() < 1e-2);
    assert_eq!(bvd(&["stack.bvd.q=300".to_owned()]).bvd.q, Some(300.0));
    let over = |text: &str| load(&at("over.toml", text), &[]).map_or_else(|error| error.to_string(), |_| "accepted".to_owned());
    let both = "base = \"base.toml\"\n[stack.design]\nfile = \"langevin\"\n[stack.bvd]\nq = 3\n";
    assert!(over(both).contains("`stack.bvd.q` and `stack.design` both give this value"), "{}", over(both));
    at("rod.toml", ROD);
    let rod = "base = \"base.toml\"\n[stack.design]\nfile = \"rod.toml\"\n";
    assert!(over(rod).contains("has no piezoelectric rings"), "{}", over(rod));
    let wrong = "base = \"base.toml\"\n[stack.design]\nfile = \"lock\"\n";
    assert!(over(wrong).contains("`lock` is not a design"), "{}", over(wrong));
    let own = "base = \"base.toml\"\n[stack.design]\nfile = \"over.toml\"\n";
    assert!(over(own).contains("`over.toml` is not a design"), "{}", over(own));
    let both = format!("{ROD}[stack.design]\nfile = \"over.toml\"\n");
    assert!(over(&both).contains("cannot be used in a design"), "{}", over(&both));
    fs::remove_dir_all(&folder).unwrap();
}
