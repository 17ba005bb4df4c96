//! Tests of signals from files: formats, units, refusals.

use super::*;

fn columns(text: &str) -> Columns {
    Columns::parse(Path::new("a.csv"), text.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
}

fn table(step: impl Fn(usize) -> f64, rows: usize) -> String {
    let rows: String = (0..rows).map(|n| format!("{},{},Run\n", step(n), n * n)).collect();
    format!("time_ms,force_n,mode\n{rows}")
}

fn signal(text: &str, choice: &Choice) -> Result<Signal, SignalError> {
    Signal::from_columns(Path::new("a.csv"), &columns(text), choice)
}

fn force() -> Choice {
    Choice { column: Some("force_n".into()), ..Choice::default() }
}

#[test]
fn a_column_is_read_with_its_times() {
    let signal = signal(&table(|n| 2.0 + 0.5 * n as f64, 100), &force()).unwrap();
    assert_eq!((signal.name.as_str(), signal.samples.len(), signal.samples[3]), ("force_n", 100, 9.0));
    assert!((signal.start_s - 2e-3).abs() < 1e-15 && (signal.sample_s - 0.5e-3).abs() < 1e-15);
}

#[test]
fn a_part_is_cut_out() {
    let choice = Choice { from_s: Some(10e-3), to_s: Some(80e-3), ..force() };
    let signal = signal(&table(|n| n as f64, 100), &choice).unwrap();
    assert_eq!((signal.samples.len(), signal.samples[0]), (71, 100.0));
    assert!((signal.start_s - 10e-3).abs() < 1e-12);
}

#[test]
fn rounded_times_count_as_even() {
    // 781.25 ns, written with nine decimals.
    let text = |n: usize| (n as f64 * 0.78125e-3 * 1e6).round() / 1e6;
    let signal = signal(&table(text, 2000), &force()).unwrap();
    assert!((signal.sample_hz() - 1.28e6).abs() < 10.0, "{}", signal.sample_hz());
}

#[test]
fn refusals_state_the_reason_and_the_place() {
    let refused = |text: &str, choice: &Choice| signal(text, choice).unwrap_err().to_string();
    let even = table(|n| n as f64, 100);
    let named = |name: &str| Choice { column: Some(name.into()), ..Choice::default() };
    assert_eq!(
        refused(&even, &named("forc_n")),
        "a.csv has no column `forc_n`: did you mean `force_n`? It has time_ms, force_n, mode"
    );
    assert_eq!(refused(&even, &named("mode")), "a.csv, line 2: `mode` is `Run`, but a signal needs a number in every row");
    let jump = table(|n| n as f64 + if n > 50 { 0.5 } else { 0.0 }, 100);
    assert!(
        refused(&jump, &force()).starts_with("uneven sampling: a.csv, line 53: a step of 1.5e-3 s"),
        "{}",
        refused(&jump, &force())
    );
    let back = table(|n| if n == 10 { 8.0 } else { n as f64 }, 100);
    assert!(refused(&back, &force()).starts_with("a.csv: line 12: the time does not increase"), "{}", refused(&back, &force()));
    assert!(refused(&table(|n| n as f64, 63), &force()).starts_with("too few samples: 63; at least 64"));
    let late = Choice { from_s: Some(1.0), ..force() };
    assert_eq!(refused(&even, &late), "no samples from 1 s to 0.099 s: the samples are from 0 s to 0.099 s");
    assert!(refused("a,b\n1,2\n2,3\n", &named("b")).contains("--sample-hz (a, b)"));
    let bare = even.replace("time_ms", "time");
    assert!(refused(&bare, &force()).contains("unit missing: a.csv: the times `time` have no unit"));
    let given = Choice { time: Some("time [ms]".into()), ..force() };
    assert_eq!(signal(&bare, &given).unwrap().sample_s, signal(&even, &force()).unwrap().sample_s);
    let hole = even.replace("20,400,Run", "20,,Run");
    assert_eq!(refused(&hole, &force()), "a.csv, line 22: `force_n` is empty, but a signal needs a number in every row");
}

/// Layouts of Keysight, PicoScope, Digilent WaveForms, Tektronix (TDS, MSO) and Siglent, as in
/// public repositories.
#[test]
fn files_of_oscilloscopes_are_read() {
    type Row = fn(usize) -> String;
    let layouts: [(&str, Row, Choice); 6] = [
        ("x-axis,1,2\nsecond,Ampere,Volt\n", |n| format!("{:.6E},{n}.5,0\n", n as f64 * 1e-6), Choice::default()),
        ("Time,Channel A\n(ms),(V)\n\n", |n| format!("{:.8},{n}.5\n", n as f64 * 1e-3), Choice::default()),
        (
            "#Digilent WaveForms Oscilloscope Acquisition\n#Samples: 99\n\nTime (s),Channel 1 (V)\n",
            |n| format!("{:.3e},{n}.5\n", n as f64 * 1e-6),
            Choice::default(),
        ),
        (
            "Record Length,2.5e+03,,0,0.5,\nVertical Units,V,,1e-6,1.5,\n",
            |n| format!(",,,{:.9},{n}.5,\n", (n + 2) as f64 * 1e-6),
            Choice { time: Some("1".into()), ..Choice::default() },
        ),
        (
            "Model,MSO4034\n\nRecord Length,99\nVertical Units,V,\n\nTIME,CH1\n",
            |n| format!("{:.4e},{n}.5\n", n as f64 * 1e-6),
            Choice::default(),
        ),
        (
            "Sample Interval,CH1:1.00E-06\nModel Number,SDS1104X-E\nSource,CH1\nSecond,Volt\n",
            |n| format!("{:.11},{n}.5\n", n as f64 * 1e-6),
            Choice::default(),
        ),
    ];
    for (head, row, choice) in layouts {
        let rows: String = (0..99).map(row).collect();
        let found = signal(&format!("{head}{rows}"), &Choice { column: Some("2".into()), ..choice });
        let found = found.unwrap_or_else(|error| panic!("{head}: {error}"));
        assert!((found.sample_s - 1e-6).abs() < 1e-11, "{head}: {}", found.sample_s);
    }
    // The first samples of a channel may be missing.
    let missing: String = (0..99).map(|n| format!("{n}e-6,{}\n", if n < 3 { "" } else { "0.5" })).collect();
    let found = signal(&format!("x-axis,1\nsecond,Volt\n{missing}"), &Choice::default()).unwrap();
    assert_eq!((found.samples.len(), found.start_s), (96, 3e-6));
    assert!(found.remark.is_some_and(|remark| remark.starts_with("3 rows at the ends")));
}

#[test]
fn a_sampling_rate_replaces_the_times() {
    let text: String = (0..100).map(|n| format!("{n}\n")).collect();
    let signal = signal(&text, &Choice { sample_hz: Some(1e3), ..Choice::default() }).unwrap();
    assert_eq!((signal.sample_s, signal.samples[7]), (1e-3, 7.0));
}
