//! Boosted edges with the plant at the converters: speed and overshoot at any Q and headroom, the
//! length of bursts at any rate, the exact cancellation of their voltage integral, and the tracking
//! through them.

use scene::load::{load, load_text};
use sim::instruments::measure;
use sim::metrics::Metrics;
use sim::record::Record;
use sim::run::{Watch, run};

/// Runs the scene `burst` with changes.
fn boosted(changes: &[String]) -> (Record, Metrics) {
    let loaded = load("burst", changes).unwrap_or_else(|error| panic!("{error}"));
    let scene = loaded.scene.driven().unwrap();
    let record = run(&scene, Watch::default()).unwrap();
    let metrics = measure(&scene, &record);
    (record, metrics)
}

fn sets(changes: &[&str]) -> Vec<String> {
    changes.iter().map(|&set| set.to_owned()).collect()
}

fn metric(metrics: &Metrics, name: &str) -> f64 {
    metrics.get(name).unwrap_or(f64::NAN)
}

/// Returns the settings of a stack with another Q, drive and limit. The nominal Q is one and a half
/// times the true one.
fn stack(q: f64, volts: f64, limit_v: f64) -> Vec<String> {
    // The windows are as many time constants apart as those of Q 65.
    let longer = (q / 65.0).max(1.0);
    let times = |times: [f64; 2]| times.map(|s| 0.07 + s * longer);
    vec![
        format!("stack.bvd.q={q}"),
        format!("controller.tracking.nominal_q={}", 1.5 * q),
        format!("controller.drive.amplitude_v={volts}"),
        format!("controller.limits.voltage_v={limit_v}"),
        format!("controller.burst.on_s={:?}", times([0.0, 0.03])),
        format!("controller.burst.off_s={:?}", times([0.025, 0.05])),
        format!("duration_s={}", 0.07 + 0.06 * longer),
    ]
}

/// Comparison with the time-optimal (bang-bang) edges of the same resonance, which the source damps
/// too: `-tau ln(1 - 0.95 / H)` and `tau ln((1 + H) / (0.05 + H))`. Half cycles, and the lag and
/// delay of the amplifier, add to these.
#[test]
fn edges_are_near_the_time_optimum_at_any_q() {
    println!("| Q | drive, limit V | rise ms | bang-bang | fall ms | bang-bang | overshoot % | residual % |");
    println!("|---|---|---|---|---|---|---|---|");
    let stacks =
        [(20.0, 3.0, 15.466), (65.0, 3.0, 15.466), (200.0, 1.0, 5.155), (500.0, 1.0, 5.155), (65.0, 3.0, 6.0), (65.0, 3.0, 4.5)];
    for (q, volts, limit_v) in stacks {
        let (_, metrics) = boosted(&stack(q, volts, limit_v));
        let lm_h = 0.779_057e-3;
        let rm_ohm = std::f64::consts::TAU * 40_320.0 * lm_h / q;
        let tau_ms = 1e3 * 2.0 * lm_h / (rm_ohm + 0.3);
        let headroom = limit_v / volts;
        let best = (-tau_ms * (1.0 - 0.95 / headroom).ln(), tau_ms * ((1.0 + headroom) / (0.05 + headroom)).ln());
        let names = ["rise_time_ms", "fall_time_ms", "overshoot_percent", "residual_percent"];
        let [rise, fall, over, left] = names.map(|name| metric(&metrics, name));
        println!("| {q} | {volts}, {limit_v} | {rise:.4} | {:.4} | {fall:.4} | {:.4} | {over:.2} | {left:.2} |", best.0, best.1);
        // Measured: at most 0.025 and 0.030 ms more, which is two and a half half cycles.
        assert!(rise < best.0 + 0.03 && fall < best.1 + 0.035, "Q {q}, {limit_v} V: {rise} ms, {fall} ms");
        // Measured: at most 0.35 % and 0.79 %; at Q 20 0.10 % and 1.31 %, and with a Q that is 0.2
        // % too high 0.23 % and 1.22 %.
        let most = if q > 20.0 { 1.0 } else { 1.4 };
        assert!(over < 0.5 && left < most, "Q {q}, {limit_v} V: {over} %, {left} %");
        assert_eq!((metric(&metrics, "fault_code"), metric(&metrics, "limit_code")), (0.0, 0.0), "Q {q}, {limit_v} V");
    }
}

/// Measures the mean of the true envelope, and of its square, for each duty of the gate.
#[test]
fn bursts_of_any_rate_are_as_long_as_they_are_ordered() {
    let mean = |hz: f64, duty: f64| {
        let periodic = [
            "controller.burst.on_s=[]".to_owned(),
            "controller.burst.off_s=[]".to_owned(),
            format!("controller.burst.period_s={}", 1.0 / hz),
            format!("controller.burst.duty={duty}"),
            "duration_s=0.1".to_owned(),
        ];
        let (record, metrics) = boosted(&periodic);
        assert_eq!(metric(&metrics, "fault_code"), 0.0, "{hz} Hz, {duty}");
        let rows = record.rows.iter().filter(|row| row.time_s > 0.06);
        let (sum, square, count) = rows.fold((0.0, 0.0, 0.0), |(sum, square, count), row| {
            let v = row.truth.tip_velocity_m_per_s;
            (sum + v, square + v * v, count + 1.0)
        });
        (sum / count, square / count, metric(&metrics, "limit_code"), record.rows.last().map_or(0.0, |row| row.frequency_hz))
    };
    let (level, square, ..) = mean(100.0, 1.0);
    println!("| bursts a second | duty | mean of the envelope | of its square | limit | frequency |");
    println!("|---|---|---|---|---|---|");
    for hz in [100.0, 500.0, 1000.0, 2000.0] {
        for duty in [0.1, 0.5, 0.9] {
            let (v, v2, limit, frequency) = mean(hz, duty);
            println!("| {hz} | {duty} | {:.3} | {:.3} | {limit} | {frequency:.1} |", v / level, v2 / square);
            // Measured: 0.005 as long as the edges do not meet, 0.022 if they do; and 2.2 Hz if the
            // bursts are too short to be measured.
            let bound = if hz > 1000.0 { 0.025 } else { 0.007 };
            assert!((v / level - duty).abs() < bound, "{hz} Hz, {duty}: {}", v / level);
            assert!((frequency - 40_320.0).abs() < 3.0, "{hz} Hz, {duty}: {frequency} Hz");
        }
    }
}

#[test]
fn the_voltage_integral_cancels_exactly_in_every_lane() {
    let (on, off) = ([0.09, 0.15, 0.2, 0.202, 0.2035, 0.2045, 0.205, 0.21], 0.23);
    let trace = sets(&[
        "controller.drive.lanes=4",
        "trace.signals=[\"drive_code_0\", \"drive_code_1\", \"drive_code_2\", \"drive_code_3\"]",
        "trace.every=1",
        "trace.from_s=0.0895",
    ]);
    let (record, _) = boosted(&trace);
    let rows = record.trace.as_ref().unwrap().rows().to_vec();
    for (n, begins) in on.iter().enumerate() {
        let ends = on.get(n + 1).copied().unwrap_or(off + 0.005);
        let played: Vec<_> = rows.iter().filter(|row| row[0] > begins + 0.5e-6 && row[0] < ends + 0.5e-6).collect();
        for lane in 1..=4 {
            let sum: f64 = played.iter().map(|row| row[lane] - 2048.0).sum();
            let most = played.iter().map(|row| (row[lane] - 2048.0).abs()).fold(0.0, f64::max);
            assert_eq!(sum, 0.0, "lane {} of the burst at {begins} s", lane - 1);
            assert!(most > 1000.0 && most <= 1548.0, "{most} codes in lane {}", lane - 1);
        }
    }
}

/// The resonance moves by 0.9 % during bursts of half a millisecond, 1000 per second.
#[test]
fn a_resonance_is_tracked_through_boosted_bursts() {
    let moved = sets(&[
        "controller.burst.on_s=[]",
        "controller.burst.off_s=[]",
        "controller.burst.period_s=1e-3",
        "controller.burst.duty=0.5",
        "duration_s=0.16",
        "disturbance.0.at_s=0.1",
        "disturbance.0.key=stack.bvd.series_resonance_hz",
        "disturbance.0.to=40680",
    ]);
    let (record, metrics) = boosted(&moved);
    let last = record.rows.last().unwrap();
    assert_eq!((metric(&metrics, "fault_code"), metric(&metrics, "limit_code")), (0.0, 0.0));
    // Measured: 0.5 Hz.
    assert!((last.frequency_hz - 40_680.0).abs() < 2.0, "{} Hz", last.frequency_hz);
}

/// A mode near the driven one, with a third of its motional capacitance, also responds to the
/// boost. Edges of whole beats leave it at rest.
#[test]
fn edges_near_another_mode_last_whole_beats() {
    println!("| distance, % | rise ms | fall ms | overshoot % | residual % | limit |");
    println!("|---|---|---|---|---|---|");
    for (other_mode, slowest_ms) in [(0.05, 1.0), (0.07, 0.8), (0.1, 0.25), (-0.07, 0.95)] {
        let hz = 40_320.0 * (1.0 + other_mode);
        let mode = [
            format!("stack.mode.0.series_resonance_hz={hz}"),
            "stack.mode.0.q=100".to_owned(),
            format!("stack.mode.0.lm_h={}", 1.0 / ((std::f64::consts::TAU * hz).powi(2) * 0.3 * 20e-9)),
        ];
        let (_, metrics) = boosted(&mode);
        let names = ["rise_time_ms", "fall_time_ms", "overshoot_percent", "residual_percent", "limit_code"];
        let [rise, fall, over, left, limit] = names.map(|name| metric(&metrics, name));
        println!("| {} | {rise:.3} | {fall:.3} | {over:.1} | {left:.1} | {limit} |", 100.0 * other_mode);
        // Measured: 0.9 to 2.2 % remain; without the beats, 17 to 58 %.
        assert!(rise < slowest_ms && fall < 0.5 && over < 4.0 && left < 3.0, "{other_mode}");
    }
}

#[test]
fn missing_headroom_is_reported_as_a_limit() {
    for (limit_v, limit) in [(3.0, 104.0), (3.1, 104.0), (3.3, 0.0)] {
        let (_, metrics) = boosted(&sets(&[&format!("controller.limits.voltage_v={limit_v}")]));
        assert_eq!((metric(&metrics, "fault_code"), metric(&metrics, "limit_code")), (0.0, limit), "{limit_v} V");
    }
}

/// Near the current limit there is no current left for a boost. The edge is then that of the drive
/// alone. Without a brake the vibration lasts longer and takes more power.
#[test]
fn bursts_near_the_current_limit_are_not_silent() {
    let mean_power_w = |edge: &str, volts: f64| {
        let edge = format!("controller.burst.edge={edge}");
        let volts = format!("controller.drive.amplitude_v={volts}");
        let bursts = ["controller.burst.period_s=1e-3", "controller.burst.duty=0.5", "duration_s=0.16"];
        let (record, metrics) = boosted(&sets(&[&bursts[..], &[&edge, &volts]].concat()));
        assert_eq!(metric(&metrics, "fault_code"), 0.0, "{edge}, {volts}");
        let played: Vec<f64> = record.rows.iter().filter(|row| row.time_s > 0.1).map(|row| row.truth.power_w).collect();
        played.iter().sum::<f64>() / played.len() as f64
    };
    for volts in [6.0, 9.0, 12.0] {
        let (boost, hard) = (mean_power_w("boost", volts), mean_power_w("hard", volts));
        assert!(boost > 0.3 * hard, "{volts} V: {boost} W with boost, {hard} W without");
    }
}

#[test]
fn boost_is_refused_with_conflicting_settings() {
    let refused = |changes: &[&str]| load("burst", &sets(changes)).err().map(|error| error.to_string()).unwrap_or_default();
    let says = |changes: &[&str], words: &[&str]| {
        let text = refused(changes);
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
    };
    says(&["controller.tracking.mode=off"], &["burst.edge = boost", "observer"]);
    says(&["controller.tracking.mode=zero_phase"], &["burst.edge = boost", "phase_lock"]);
    says(&["controller.drive.shape=square"], &["burst.edge = boost", "sine"]);
    says(&["controller.burst.edge=bost"], &["bost", "did you mean `boost`?"]);
    // The message has the position and the correction.
    let typed = |on: &str, off: &str| {
        let text = format!("base = \"burst\"\n\n[controller.burst]\non_s = {on}\noff_s = {off}\n");
        load_text("mine.toml", &text, &[]).err().map(|error| error.to_string()).unwrap_or_default()
    };
    let overlap = typed("[0.1, 0.12]", "[0.13, 0.14]");
    assert!(overlap.contains("begins at 0.12 s") && overlap.contains("mine.toml:4") && overlap.contains("0.13"), "{overlap}");
    let backwards = typed("[0.1]", "[0.09]");
    assert!(backwards.contains("ends at 0.09 s, but begins at 0.1 s") && backwards.contains("mine.toml:5"), "{backwards}");
}
