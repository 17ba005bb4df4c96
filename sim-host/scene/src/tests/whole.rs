//! Whole scenes: written and read again, and corrupted at random.

use super::{example, loaded, says};
use crate::Scene;
use crate::exclusive::EXCLUSIVE;
use crate::load::{LoadError, load_text};
use crate::resolved::{resolved_json, resolved_toml};
use crate::schema::Schema;

#[test]
fn resolved_scenes_read_back_the_same() {
    let rich = [
        "grid.set=[]",
        "title=\"\"\"two\nlines, \\\"quotes\\\" # and ä\"\"\"",
        "controller.phasing.phase_trim_turns=[0.1, -0.25]",
        "disturbance.0.at_s=1",
        "disturbance.0.key=rig.slider.speed_m_per_s",
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
        &["c0_f = 3e-7 ", "# Clamped capacitance, F, accurate to a third.", "shape = \"sine\"", "sine | square", "\n[sensors]\n"],
    );
}

#[test]
fn long_runs_are_valid() {
    let scene = loaded(&["duration_s=99999"]);
    says(&resolved_toml(&scene), &["duration_s = 99999"]);
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
fn corrupted_texts_never_panic() {
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
