//! Exit codes: the same for the same kind of error in every command.

use super::{Folder, code, sim_host, stderr};

#[test]
fn an_error_has_the_same_exit_code_in_every_command() {
    let folder = Folder::new("exits");
    let scene = folder.write("metric.toml", "base = \"lock\"\n[[expect]]\nmetric = \"frictoin_ratio\"\nmax = 1\n");
    let measured = folder.write("measured.csv", "metric,value\nfriction_ratio,0.9\n");
    let axis = ["--over", "contact.dahl.mu=0.1:0.4:4"];
    let kinds: [(&str, i32, Vec<Vec<&str>>); 4] = [
        (
            "an unknown metric",
            3,
            vec![
                vec!["run", &scene, "--no-report"],
                [&["sweep", "contact-kinematic", "--metric", "frictoin_ratio"], &axis[..]].concat(),
                vec!["compare", &measured, &measured, "--metric", "frictoin_ratio"],
            ],
        ),
        (
            "a missing file or folder",
            3,
            vec![
                vec!["run", "none.toml"],
                vec!["validate", "none.toml"],
                vec!["sweep", "contact-kinematic", "--points", "none.csv"],
                vec!["merge", "none"],
                vec!["compare", "none", "none"],
                vec!["import", "admittance", "none.s1p"],
                vec!["spectrum", "none.csv"],
                vec!["link", "sim:lock", "script", "none.txt"],
                vec!["link", "file:none.update", "update", "none.elf"],
            ],
        ),
        (
            "a scene without a controller",
            3,
            vec![
                vec!["run", "contact", "--pil", "--no-report"],
                vec!["link", "sim:contact", "status"],
                vec!["advise", "contact"],
            ],
        ),
        (
            "arguments that contradict each other",
            2,
            vec![
                vec!["run"],
                vec!["advise"],
                vec!["sweep", "contact-kinematic"],
                vec!["compare", &measured, &measured, "--tolerance", "much"],
                vec!["validate", "tracking", "guard"],
                vec!["link", "sim:lock", "status", "--slot"],
            ],
        ),
    ];
    for (kind, expected, commands) in kinds {
        for arguments in commands {
            let output = sim_host(&arguments);
            assert_eq!(code(&output), expected, "{kind}: {arguments:?}\n{}", stderr(&output));
        }
    }
}
