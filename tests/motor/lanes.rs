//! The lanes are watched: what is wrong with one is named, before the motor turns the wrong way or soon after it happens; a healthy one never is.

use std::thread;

use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use hal_mock::chance::Chance;
use scene::load::load;
use sim::record::{Record, Row};
use sim::run::{Watch, run};

/// What is injected, which lanes it happens to, and what it is called.
type Case = (&'static str, u8, Option<u8>, Fault);

/// A lane that is open, weak or reversed, each of the three beside the first; and pairs that are exchanged.
fn cases() -> Vec<Case> {
    let of_one = |lane| {
        [("lane_open", Fault::LaneOpen), ("lane_weak", Fault::LaneImplausible), ("lane_reversed", Fault::LaneImplausible)]
            .map(|(kind, fault)| (kind, lane, None, fault))
    };
    let pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    let exchanged = pairs.map(|(one, other)| ("lanes_exchanged", one, Some(other), Fault::LaneImplausible));
    // The first lane is what the others are compared with: where it is wrong, they are.
    let first = [("lane_reversed", 0, None, Fault::LaneImplausible), ("lane_weak", 0, None, Fault::LaneImplausible)];
    (1..4).flat_map(of_one).chain(exchanged).chain(first).collect()
}

fn sets_of(&(kind, lane, other, _): &Case, at_s: f64) -> Vec<String> {
    let mut sets = vec![format!("fault.0.kind={kind}"), format!("fault.0.lane={lane}"), format!("fault.0.at_s={at_s}")];
    sets.extend(other.map(|other| format!("fault.0.other_lane={other}")));
    // Less than two thirds of the first lane is a sense channel for the self-test, and less than a half for the guard: fault 20.
    sets.extend((kind == "lane_weak" && lane == 0).then(|| "fault.0.gain=0.68".to_owned()));
    sets
}

/// The record of the motor, which begins to run at 0.19 s, with changes.
fn record(changes: &[String]) -> Record {
    let sets: Vec<String> =
        ["rig.rotor.torque_nm=0", "duration_s=0.35"].iter().map(|&set| set.to_owned()).chain(changes.iter().cloned()).collect();
    let scene = load("usm", &sets).unwrap_or_else(|error| panic!("{error}")).scene;
    run(&scene.driven().unwrap(), Watch::default()).unwrap()
}

/// Runs these in as many threads as there are processors.
fn all<T: Send, R: Send>(cases: Vec<T>, one: impl Fn(T) -> R + Sync) -> Vec<R> {
    let threads = thread::available_parallelism().map_or(1, |count| count.get());
    let cases = std::sync::Mutex::new(cases.into_iter().enumerate());
    let results = std::sync::Mutex::new(Vec::new());
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let next = cases.lock().unwrap().next();
                    let Some((index, case)) = next else { break };
                    let result = one(case);
                    results.lock().unwrap().push((index, result));
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap();
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// The fault's time and number.
fn faulted(record: &Record) -> Option<(f64, u8)> {
    record.rows.iter().find(|row| row.fault != 0).map(|row| (row.time_s, row.fault))
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

#[test]
fn a_wrong_lane_is_named_before_anything_runs() {
    for changes in [
        &[][..],
        &["controller.phasing.direction=reverse"],
        &["controller.tracking.mode=observer"],
        &["controller.tracking.mode=off"],
    ] {
        let cases = cases();
        let records = all(cases.clone(), |case| {
            let changes = changes.iter().map(|&change| change.to_owned());
            record(&sets_of(&case, 0.0).into_iter().chain(changes).chain(["duration_s=0.25".to_owned()]).collect::<Vec<_>>())
        });
        let (mut times, mut turned) = (Vec::new(), 0.0_f64);
        for (case, record) in cases.iter().zip(&records) {
            let (time_s, fault) = faulted(record).unwrap_or_else(|| panic!("{changes:?} {case:?}: no fault"));
            assert_eq!(fault, case.3.code(), "{changes:?} {case:?} at {time_s} s");
            assert!(time_s < 0.05, "{changes:?} {case:?}: {time_s} s");
            assert!(record.rows.iter().all(|row| row.mode != Mode::Run), "{changes:?} {case:?}");
            turned = record.motors.iter().fold(turned, |most, motor| most.max(motor.rotor_rad_per_s.abs()));
            times.push(1e3 * time_s);
        }
        println!(
            "{changes:?} from the start: {} cases, median {:.2} ms, {:.2} at most; the rotor turns with {turned:.4} rad/s at most",
            times.len(),
            median(&mut times),
            times[times.len() - 1]
        );
        // The tone of the self-test, of half the voltage and beside the resonance; a run has 6 rad/s.
        assert!(turned < 0.1, "{turned} rad/s");
    }
}

#[test]
fn a_lane_that_fails_in_a_run_is_named_within_50_ms() {
    for changes in [&[][..], &["controller.tracking.mode=observer"], &["controller.tracking.mode=off"]] {
        let moments = [0.2301, 0.2417, 0.2533, 0.2649];
        let cases: Vec<(Case, f64)> = cases().into_iter().flat_map(|case| moments.map(|at_s| (case, at_s))).collect();
        let records = all(cases.clone(), |(case, at_s)| {
            let changes = changes.iter().map(|&change| change.to_owned());
            record(&sets_of(&case, at_s).into_iter().chain(changes).collect::<Vec<_>>())
        });
        let mut of_kinds: Vec<(&str, Vec<f64>)> = Vec::new();
        for ((case, at_s), record) in cases.iter().zip(&records) {
            let (time_s, fault) = faulted(record).unwrap_or_else(|| panic!("{changes:?} {case:?} {at_s}: no fault"));
            assert_eq!(fault, case.3.code(), "{changes:?} {case:?} {at_s}: after {} ms", 1e3 * (time_s - at_s));
            assert!((0.0..0.05).contains(&(time_s - at_s)), "{changes:?} {case:?}: {} ms", 1e3 * (time_s - at_s));
            let silent = record.rows.iter().skip_while(|row| row.fault == 0).skip(3);
            assert!(silent.clone().count() > 1000 && silent.clone().all(|row| row.drive_v == 0.0), "{changes:?} {case:?}");
            let kind = of_kinds.iter().position(|(kind, _)| *kind == case.0).unwrap_or_else(|| {
                of_kinds.push((case.0, Vec::new()));
                of_kinds.len() - 1
            });
            of_kinds[kind].1.push(1e3 * (time_s - at_s));
        }
        for (kind, times) in &mut of_kinds {
            let most = times.iter().copied().fold(0.0, f64::max);
            println!("{changes:?} {kind}: {} runs, median {:.1} ms, {most:.1} at most", times.len(), median(times));
        }
    }
}

/// Amplifiers that are nearly as far off as is plausible, as they are and trimmed, under steps of load and preload, in bursts and without.
#[test]
fn healthy_lanes_are_never_accused() {
    let seeds: Vec<u64> = (1..=36).collect();
    let records = all(seeds, |seed| {
        let mut chance = Chance::new(seed);
        let mut within = |least: f64, most: f64| least + (most - least) * chance.below(1 << 20) as f64 / f64::from(1 << 20);
        let list = |values: [f64; 4]| values.map(|value| format!("{value:.5}")).join(", ");
        let phase = [0.0, within(-40.0, 40.0), within(-40.0, 40.0), within(-40.0, 40.0)];
        let gain: [f64; 4] = std::array::from_fn(|_| within(-0.14, 0.14));
        let mut sets = vec![
            format!("seed={seed}"),
            format!("amplifier.lane_phase_error_deg=[{}]", list(phase)),
            format!("amplifier.lane_gain_error=[{}]", list(gain)),
            format!("controller.drive.amplitude_v={:.3}", within(8.0, 11.0)),
        ];
        if seed % 2 == 0 {
            let weakest = gain.into_iter().fold(f64::INFINITY, f64::min);
            sets.push(format!("controller.phasing.phase_trim_turns=[{}]", list(phase.map(|degrees| -degrees / 360.0))));
            sets.push(format!("controller.phasing.gain_trim=[{}]", list(gain.map(|gain| (1.0 + weakest) / (1.0 + gain)))));
        }
        let begins = 0.21;
        sets.push(format!("duration_s={}", begins + 0.25));
        for (n, (key, to)) in [
            ("rig.rotor.torque_nm", 3e-3),
            ("rig.rotor.preload_n", 7.0),
            ("rig.rotor.torque_nm", -1e-3),
            ("rig.rotor.preload_n", 2.0),
        ]
        .into_iter()
        .enumerate()
        {
            let at_s = begins + 0.02 + 0.04 * n as f64 + within(0.0, 0.03);
            sets.push(format!("disturbance.{n}.key={key}"));
            sets.push(format!("disturbance.{n}.at_s={at_s}"));
            sets.push(format!("disturbance.{n}.to={to}"));
        }
        if seed % 3 == 0 {
            sets.push("controller.burst.on_s=[]".to_owned());
            sets.push("controller.burst.off_s=[]".to_owned());
            sets.push(format!("controller.burst.period_s={}", within(1e-3, 8e-3)));
            sets.push(format!("controller.burst.duty={}", within(0.3, 0.9)));
        } else {
            sets.push(format!("controller.burst.on_s=[{begins}]"));
            sets.push(format!("controller.burst.off_s=[{}]", begins + 0.24));
        }
        (sets.clone(), record(&sets))
    });
    for (sets, record) in &records {
        let accused = [Fault::LaneImplausible.code(), Fault::LaneOpen.code()];
        let found = faulted(record);
        assert!(!found.is_some_and(|(_, fault)| accused.contains(&fault)), "{found:?}: {sets:?}");
    }
    let ran = records.iter().filter(|(_, record)| record.rows.iter().any(|row| row.mode == Mode::Run)).count();
    let other = records.iter().filter_map(|(_, record)| faulted(record)).collect::<Vec<_>>();
    println!("{} motors, {ran} have run; other faults: {other:?}", records.len());
    assert_eq!((ran, other.len()), (records.len(), 0));
}

/// One lane of the four is behind the multiplexer for ten blocks at a time; meanwhile frequency and drive are held.
#[test]
fn a_visit_moves_neither_frequency_nor_drive() {
    let record = record(&["controller.burst.on_s=[0.22]".to_owned(), "controller.burst.off_s=[0.34]".to_owned()]);
    let steady: Vec<&Row> = record.rows.iter().filter(|row| row.time_s > 0.25 && row.time_s < 0.335).collect();
    let (least, most) = steady
        .iter()
        .fold((f64::INFINITY, 0.0_f64), |(least, most), row| (least.min(row.frequency_hz), most.max(row.frequency_hz)));
    let runs = record.rows.iter().find(|row| row.mode == Mode::Run).unwrap();
    println!("it runs after {:.3} ms, and the frequency stays within {:.2} Hz", 1e3 * runs.time_s, most - least);
    assert!(steady.len() > 2500 && most - least < 2.0, "{}", most - least);
    // What is reported stays that of lane 0.
    let currents: Vec<f64> = steady.iter().map(|row| row.motional_current_a).collect();
    let mean = currents.iter().sum::<f64>() / currents.len() as f64;
    assert!(currents.iter().all(|current| (current / mean - 1.0).abs() < 0.05), "{mean}");
}
