//! `sim-host spectrum`: traces of a run in each format, foreign tables, and errors.

use serde_json::Value;

use super::{Folder, code, sim_host, stderr, stdout};

/// Returns a tone of 5 kHz, sampled at 100 kHz, in the format of an oscilloscope.
fn table() -> String {
    let row = |n: i32| {
        format!("{:.2};{:.6}\n", f64::from(n) * 0.01, (std::f64::consts::TAU * 0.05 * f64::from(n)).sin()).replace('.', ",")
    };
    format!("Oscilloscope\nt [ms];U [V]\n{}", (0..2000).map(row).collect::<String>())
}

fn found(arguments: &[&str]) -> Value {
    let output = sim_host(&[arguments, &["--format", "json"]].concat());
    assert_eq!(code(&output), 0, "{arguments:?}: {}", stderr(&output));
    serde_json::from_str(&stdout(&output)).expect("JSON")
}

#[test]
fn a_trace_is_analysed_in_each_format() {
    let folder = Folder::new("spectrum-trace");
    let mut strongest = Vec::new();
    for format in ["csv", "npy", "parquet"] {
        let set = format!("trace.format=\"{format}\"");
        let sets = [
            "--set",
            "trace.signals=[\"tip_velocity_m_per_s\"]",
            "--set",
            "trace.from_s=0.2",
            "--set",
            "trace.to_s=0.202",
            "--set",
            &set,
        ];
        let run = folder.0.join(format);
        let output = sim_host(&[&["run", "lock", "-q", "-o", run.to_str().expect("a path")][..], &sets].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let file = run.join(format!("trace.{format}"));
        let said = found(&["spectrum", file.to_str().expect("a path"), "--column", "tip_velocity_m_per_s", "--no-report"]);
        let hz = said["strongest"]["frequency_hz"].as_f64().expect("a frequency");
        assert!((hz - 40.5e3).abs() < 2e3, "{format}: {hz}");
        strongest.push(said["strongest"].clone());
    }
    assert!(strongest.windows(2).all(|pair| pair[0] == pair[1]), "{strongest:?}");
}

#[test]
fn a_foreign_table_gives_figure_table_and_arrays() {
    let folder = Folder::new("spectrum-table");
    let file = folder.write("scope.csv", &table());
    for method in ["stft", "wavelet", "wigner-ville"] {
        let out = folder.0.join(method);
        let said = found(&["spectrum", &file, "--method", method, "-q", "-o", out.to_str().expect("a path")]);
        let hz = said["strongest"]["frequency_hz"].as_f64().expect("a frequency");
        assert!((hz / 5e3 - 1.0).abs() < 0.05, "{method}: {hz}");
        for name in ["report.html", "manifest.json", "time_s.npy", "frequency_hz.npy"] {
            assert!(out.join(name).exists(), "{method}: {name}");
        }
        assert!(out.join(format!("spectrum-{method}.png")).exists() && out.join(format!("spectrum-{method}.csv")).exists());
        let power = std::fs::metadata(out.join("power.npy")).expect("an array").len();
        let cells = said["times"].as_u64().zip(said["frequencies"].as_u64()).map(|(times, rows)| times * rows);
        assert_eq!(Some((power - 128) / 8), cells.filter(|_| power > 128), "{method}");
    }
}

#[test]
fn unusable_signals_are_refused_with_a_reason() {
    let folder = Folder::new("spectrum-refused");
    let file = folder.write("scope.csv", &table());
    let uneven = folder.write("uneven.csv", &table().replace("5,00;", "5,004;"));
    let few = folder.write("few.csv", &table().lines().take(40).map(|line| format!("{line}\n")).collect::<String>());
    for (kind, arguments, says) in [
        (3, &["spectrum", &file, "--column", "U [A]"][..], "did you mean `U [V]`? It has t [ms], U [V]"),
        (3, &["spectrum", &uneven], "uneven sampling: "),
        (3, &["spectrum", &few], "too few samples: 38; at least 64"),
        (3, &["spectrum", "nothing.csv"], "nothing.csv cannot be read"),
        (2, &["spectrum", &file, "--band", "60k:70k"], "the frequencies go up to 50000 Hz"),
        (2, &["spectrum", &file, "--cycles", "3"], "--cycles belongs to --method wavelet"),
        (2, &["spectrum", &file, "--sample-hz", "-1"], "must be above zero"),
    ] {
        let output = sim_host(arguments);
        assert_eq!(code(&output), kind, "{arguments:?}");
        assert!(stderr(&output).contains(says), "{arguments:?}: {}", stderr(&output));
        assert!(stdout(&output).is_empty());
    }
}
