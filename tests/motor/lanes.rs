//! Watch of the lanes: a defect is identified before the motor turns the wrong way or soon after it
//! occurs, and healthy lanes cause no fault.

use std::thread;

use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use hal_mock::chance::Chance;
use scene::load::load;
use sim::record::{Record, Row};
use sim::run::{Watch, run};

/// Injected kind, affected lane, other affected lane, and expected fault.
type Case = (&'static str, u8, Option<u8>, Fault);

/// Returns an open, weak or reversed lane, for each of the three other than the first; and
/// exchanged pairs.
fn cases() -> Vec<Case> {
    let of_one = |lane| {
        [("lane_open", Fault::LaneOpen), ("lane_weak", Fault::LaneImplausible), ("lane_reversed", Fault::LaneImplausible)]
            .map(|(kind, fault)| (kind, lane, None, fault))
    };
    let pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    let exchanged = pairs.map(|(one, other)| ("lanes_exchanged", one, Some(other), Fault::LaneImplausible));
    // The first lane is the reference: if it is wrong, the others appear wrong.
    let first = [("lane_reversed", 0, None, Fault::LaneImplausible), ("lane_weak", 0, None, Fault::LaneImplausible)];
    (1..4).flat_map(of_one).chain(exchanged).chain(first).collect()
}

fn sets_of(&(kind, lane, other, _): &Case, at_s: f64) -> Vec<String> {
    let mut sets = vec![format!("fault.0.kind={kind}"), format!("fault.0.lane={lane}"), format!("fault.0.at_s={at_s}")];
    sets.extend(other.map(|other| format!("fault.0.other_lane={other}")));
    // A gain of the first lane below 2/3 is a defective sense channel for the self-test, and below
    // 1/2 for the guard: fault 20.
    sets.extend((kind == "lane_weak" && lane == 0).then(|| "fault.0.gain=0.68".to_owned()));
    sets
}

/// Runs the motor with changes and returns its record; the run begins at 0.19 s.
fn record(changes: &[String]) -> Record {
    let sets: Vec<String> =
        ["rig.rotor.torque_nm=0", "duration_s=0.35"].iter().map(|&set| set.to_owned()).chain(changes.iter().cloned()).collect();
    let scene = load("usm", &sets).unwrap_or_else(|error| panic!("{error}")).scene;
    run(&scene.driven().unwrap(), Watch::default()).unwrap()
}

/// Runs all cases on as many threads as there are processors.
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

/// Returns the time and the number of the fault.
fn faulted(record: &Record) -> Option<(f64, u8)> {
    record.rows.iter().find(|row| row.fault != 0).map(|row| (row.time_s, row.fault))
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

#[test]
fn a_wrong_lane_is_identified_before_a_run() {
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
            "{changes:?} from the start: {} cases, median {:.2} ms, at most {:.2}; the rotor turns with at most {turned:.4} rad/s",
            times.len(),
            median(&mut times),
            times[times.len() - 1]
        );
        // The tone of the self-test has half the voltage and is off resonance; a run has 6 rad/s.
        assert!(turned < 0.1, "{turned} rad/s");
    }
}

#[test]
fn a_lane_failure_in_a_run_is_identified_within_50_ms() {
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
            println!("{changes:?} {kind}: {} runs, median {:.1} ms, at most {most:.1}", times.len(), median(times));
        }
    }
}

/// Amplifiers with errors close to the plausible limit, with and without trims, under steps of load
/// and preload, with and without bursts.
#[test]
fn healthy_lanes_cause_no_fault() {
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
    println!("{} motors, {ran} reached a run; other faults: {other:?}", records.len());
    assert_eq!((ran, other.len()), (records.len(), 0));
}

/// The multiplexer selects one of the four lanes for ten blocks at a time; meanwhile frequency and
/// drive are held.
#[test]
fn a_visit_changes_neither_frequency_nor_drive() {
    let record = record(&["controller.burst.on_s=[0.22]".to_owned(), "controller.burst.off_s=[0.34]".to_owned()]);
    let steady: Vec<&Row> = record.rows.iter().filter(|row| row.time_s > 0.25 && row.time_s < 0.335).collect();
    let (least, most) = steady
        .iter()
        .fold((f64::INFINITY, 0.0_f64), |(least, most), row| (least.min(row.frequency_hz), most.max(row.frequency_hz)));
    let runs = record.rows.iter().find(|row| row.mode == Mode::Run).unwrap();
    println!("the run begins after {:.3} ms, and the frequency stays within {:.2} Hz", 1e3 * runs.time_s, most - least);
    assert!(steady.len() > 2500 && most - least < 2.0, "{}", most - least);
    // The reported current remains that of lane 0.
    let currents: Vec<f64> = steady.iter().map(|row| row.motional_current_a).collect();
    let mean = currents.iter().sum::<f64>() / currents.len() as f64;
    assert!(currents.iter().all(|current| (current / mean - 1.0).abs() < 0.05), "{mean}");
}
