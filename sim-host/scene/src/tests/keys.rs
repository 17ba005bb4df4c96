//! Messages about keys, types and ranges.

use super::{example, report, says, with_line};

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
    says(&with_line("load_n", "load = 0"), &["the unit of `load` is missing", "give it in N: `load_n`"]);
}

#[test]
fn misplaced_keys_are_reported_with_their_table() {
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
    says(
        &with_line("scan_v", "scan_v = 3\nshape = \"sqare\""),
        &["did you mean `square`?", "it must be `sine`, `square`, `sawtooth` or `noise`"],
    );
    says(&with_line("[controller.drive]", "[controller]\nblock_samples = 12.5\n[controller.drive]"), &["must be a whole number"]);
    says(&with_line("[contact.dahl]", "[[contact]]"), &["`contact` cannot be a list of tables", "write `[contact]`"]);
    says(&report("controller = \"on\"", &[]), &["`controller` cannot be a string", "write `[controller]`"]);
    says(&report("fault = 3", &[]), &["expected a list of tables"]);
}

#[test]
fn missing_keys_are_reported_at_their_table() {
    says(
        &with_line("frequency_hz", ""),
        &["`frequency_hz` is missing in [controller.drive]", "--> a.toml:5:1", "a number in Hz"],
    );
    says(&report("title = \"x\"\nduration_s = 1\n", &[]), &["a scene needs [controller], [excitation] or [design]", "1 problem"]);
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
fn syntax_errors_are_reported_alone() {
    says(&with_line("mu", "mu = 0,3"), &["decimals with a point", "1 problem"]);
    says(&with_line("mu", "mu ="), &["the value is missing", "1 problem"]);
    says(&with_line("mu", "mu = 0.3\nmu = 0.4"), &["this name is already used", "second occurrence", "a.toml:29:1"]);
    says(&report("µ = 1", &[]), &["invalid unquoted key"]);
    says(&report(&format!("a = {}", "[".repeat(10_000)), &[]), &["nested too deeply"]);
    says(&report("a = 1\r\n\tb = \r\n", &[]), &["a.toml:2:6"]);
}
