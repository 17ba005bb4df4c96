//! Opening and closing of the gate, to the sample.

use super::*;

#[test]
fn windows_and_periods_open_and_close_to_the_sample() {
    let schedule = |config: ScheduleConfig| Schedule::build(&config, 1e6).unwrap();
    let mut windows = schedule(ScheduleConfig::Windows([(10e-6, 20e-6), (20e-6, 30e-6), (40e-6, 50e-6)].into_iter().collect()));
    for begins in [0, 100, 250] {
        windows.begin(begins);
        let expected =
            [(0, false, 10), (9, false, 1), (10, true, 10), (19, true, 1), (20, true, 10), (30, false, 10), (49, true, 1)];
        for (now, open, stays) in expected {
            assert_eq!(windows.gate(begins + now), (open, stays), "{begins} {now}");
        }
        assert_eq!(windows.gate(begins + 50), (false, u64::MAX));
    }
    let mut periodic = schedule(ScheduleConfig::Periodic { period_s: 1e-3, duty: 0.25 });
    for begins in [0, 77] {
        periodic.begin(begins);
        let expected = [
            (0, true, 250),
            (249, true, 1),
            (250, false, 750),
            (999, false, 1),
            (1000, true, 250),
            (5300, false, 700),
            (5999, false, 1),
        ];
        for (now, open, stays) in expected {
            assert_eq!(periodic.gate(begins + now), (open, stays), "{begins} {now}");
        }
        // Exactly two periods later, and much later.
        assert_eq!(periodic.gate(begins + 7000), (true, 250));
        assert_eq!(periodic.gate(begins + 9_000_123), (true, 127));
    }
    assert_eq!(schedule(ScheduleConfig::Continuous).gate(5), (true, u64::MAX));
}

#[test]
fn empty_windows_and_periods_below_a_sample_are_refused() {
    // A sample takes 20 us.
    let build = |schedule: ScheduleConfig| Schedule::build(&schedule, 50e3).map(drop);
    assert_eq!(build(window(1e-3, 1e-3)), Err(Error::BurstWindows));
    let overlap = [(1e-3, 3e-3), (2e-3, 4e-3)].into_iter().collect();
    assert_eq!(build(ScheduleConfig::Windows(overlap)), Err(Error::BurstWindows));
    assert_eq!(build(ScheduleConfig::Periodic { period_s: 20.1e-6, duty: 0.5 }), Ok(()));
    assert!(build(ScheduleConfig::Periodic { period_s: 19.9e-6, duty: 0.5 }).is_err());
}

#[test]
fn a_set_duty_acts_from_the_next_period_and_is_spread() {
    let mut periodic = burst(ScheduleConfig::Periodic { period_s: 1e-3, duty: 0.25 }, Edge::Hard);
    assert!(periodic.repeats() && !configured(Edge::Hard, false).repeats());
    assert_eq!(periodic.schedule.gate(3), (true, 247));
    periodic.set_on(600.0);
    assert_eq!(periodic.schedule.gate(10), (true, 240));
    let on: std::vec::Vec<u64> = (1..200).map(|n| periodic.schedule.gate(1000 * n).1).collect();
    let (least, most) = (on.iter().min().unwrap(), on.iter().max().unwrap());
    assert!((587..590).contains(least) && (610..=613).contains(most), "{least} {most}");
}
