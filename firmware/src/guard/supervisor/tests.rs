//! Tests of the modes that each order leads through, and of the faults that stay.

use super::*;

const MODES: [Mode; 8] =
    [Mode::Idle, Mode::SelfTest, Mode::Scan, Mode::Clamped, Mode::Calibrate, Mode::Lock, Mode::Run, Mode::Fault];

fn asks(request: Request) -> Orders {
    Orders { request, attempt: 1, sequence: 1, ..Orders::default() }
}

/// Returns a supervisor in this mode.
fn within(mode: Mode) -> Supervisor {
    Supervisor { mode, fault: (mode == Mode::Fault).then_some(Fault::OverCurrent), ..Supervisor::new(Acquisition::Scanned) }
}

/// Returns the modes from an order to the last one, if every stage completes.
fn way(supervisor: &mut Supervisor, orders: &Orders) -> std::vec::Vec<Mode> {
    assert!(supervisor.judge(orders, None));
    let mut modes = std::vec![supervisor.mode()];
    loop {
        supervisor.advance(orders, Progress::Done);
        if modes.last() == Some(&supervisor.mode()) {
            return modes;
        }
        modes.push(supervisor.mode());
    }
}

#[test]
fn each_tracking_mode_reaches_run_through_its_stages() {
    let runs = |mode: TrackingMode| way(&mut Supervisor::new(Acquisition::from_tracking(mode)), &asks(Request::Run));
    assert_eq!(runs(TrackingMode::Off), [Mode::SelfTest, Mode::Run]);
    assert_eq!(runs(TrackingMode::PhaseLock), [Mode::SelfTest, Mode::Scan, Mode::Lock, Mode::Run]);
    assert_eq!(runs(TrackingMode::ZeroPhase), [Mode::SelfTest, Mode::Scan, Mode::Lock, Mode::Run]);
    assert_eq!(runs(TrackingMode::Observer), [Mode::SelfTest, Mode::Clamped, Mode::Lock, Mode::Run]);
}

#[test]
fn a_scan_or_calibration_is_done_once_per_attempt() {
    for (request, mode) in [(Request::Scan, Mode::Scan), (Request::Calibrate, Mode::Calibrate)] {
        for acquisition in [Acquisition::Nominal, Acquisition::Scanned, Acquisition::Observed] {
            let mut supervisor = Supervisor::new(acquisition);
            assert_eq!(way(&mut supervisor, &asks(request)), [Mode::SelfTest, mode, Mode::Idle]);
            assert!(!supervisor.judge(&Orders { sequence: 2, ..asks(request) }, None));
            assert_eq!(supervisor.mode(), Mode::Idle);
            // A new attempt number repeats the scan or calibration. Afterwards an order to run is
            // accepted.
            assert_eq!(way(&mut supervisor, &Orders { attempt: 2, ..asks(request) }), [Mode::SelfTest, mode, Mode::Idle]);
            assert!(supervisor.judge(&Orders { attempt: 2, ..asks(Request::Run) }, None));
        }
    }
}

#[test]
fn an_order_ends_a_stage_of_another_request() {
    use Request::{Calibrate, Idle, Run, Scan};
    for mode in MODES {
        for request in [Idle, Scan, Run, Calibrate] {
            let mut supervisor = within(mode);
            let begins = supervisor.judge(&asks(request), None);
            let expected = match (mode, request) {
                (Mode::Fault, _) | (_, Idle) => false,
                (Mode::Idle, _) => true,
                // A self-test leads to any of them.
                (Mode::SelfTest, _) => false,
                (Mode::Scan, _) => request == Calibrate,
                (Mode::Calibrate, _) => request != Calibrate,
                (Mode::Clamped | Mode::Lock | Mode::Run, _) => request != Run,
            };
            assert_eq!(begins, expected, "{mode:?} {request:?}");
            let then = match (mode, request) {
                (Mode::Fault, _) => Mode::Fault,
                (_, Idle) => Mode::Idle,
                _ if begins => Mode::SelfTest,
                _ => mode,
            };
            assert_eq!(supervisor.mode(), then, "{mode:?} {request:?}");
        }
    }
}

#[test]
fn a_found_fault_counts_only_under_drive() {
    for mode in MODES {
        let mut supervisor = within(mode);
        supervisor.judge(&asks(Request::Run), Some(Fault::LoadOpen));
        let expected = match mode {
            Mode::Idle => None,
            Mode::Fault => Some(Fault::OverCurrent),
            _ => Some(Fault::LoadOpen),
        };
        assert_eq!(
            (supervisor.fault(), supervisor.take_raised()),
            (expected, !matches!(mode, Mode::Idle | Mode::Fault)),
            "{mode:?}"
        );
    }
}

#[test]
fn emergency_stop_precedes_host_loss_precedes_other_faults() {
    let of = |emergency_stop: bool, host_lost: bool| {
        let mut supervisor = within(Mode::Run);
        supervisor.judge(&Orders { emergency_stop, host_lost, ..asks(Request::Run) }, Some(Fault::LoadOpen));
        (supervisor.mode(), supervisor.fault())
    };
    assert_eq!(of(true, true), (Mode::Fault, Some(Fault::EmergencyStop)));
    assert_eq!(of(false, true), (Mode::Fault, Some(Fault::HostLost)));
    assert_eq!(of(false, false), (Mode::Fault, Some(Fault::LoadOpen)));
    // An emergency stop also counts in silence.
    let mut idle = within(Mode::Idle);
    idle.judge(&Orders { emergency_stop: true, ..asks(Request::Idle) }, None);
    assert_eq!((idle.mode(), idle.fault()), (Mode::Fault, Some(Fault::EmergencyStop)));
}

#[test]
fn the_first_fault_stays_until_a_new_order_clears_it() {
    let mut supervisor = within(Mode::Run);
    supervisor.judge(&asks(Request::Run), Some(Fault::LoadOpen));
    assert!(supervisor.take_raised() && !supervisor.take_raised());
    let mut judge = |orders: Orders, found: Option<Fault>| {
        let begins = supervisor.judge(&orders, found);
        supervisor.advance(&orders, Progress::Done);
        (begins, supervisor.mode(), supervisor.fault(), supervisor.take_raised())
    };
    let stays = (false, Mode::Fault, Some(Fault::LoadOpen), false);
    assert_eq!(judge(asks(Request::Run), Some(Fault::OverCurrent)), stays);
    assert_eq!(judge(Orders { emergency_stop: true, ..asks(Request::Idle) }, None), stays);
    // An order obeyed before does not clear the fault, nor does a new order without `clear_fault`.
    assert_eq!(judge(Orders { clear_fault: true, ..asks(Request::Idle) }, None), stays);
    assert_eq!(judge(Orders { sequence: 2, ..asks(Request::Idle) }, None), stays);
    let clears = Orders { sequence: 3, clear_fault: true, ..asks(Request::Idle) };
    // While the stop is pressed, a new order clears the fault and raises it again.
    let pressed = judge(Orders { emergency_stop: true, ..clears }, None);
    assert_eq!(pressed, (false, Mode::Fault, Some(Fault::EmergencyStop), true));
    assert_eq!(judge(Orders { sequence: 4, ..clears }, None), (false, Mode::Idle, None, false));
}

#[test]
fn clearing_a_fault_does_not_disturb_a_run() {
    let mut supervisor = within(Mode::Run);
    assert!(!supervisor.judge(&Orders { sequence: 9, clear_fault: true, ..asks(Request::Run) }, None));
    assert_eq!(supervisor.mode(), Mode::Run);
}

#[test]
fn a_stage_continues_goes_back_or_fails() {
    let after = |progress: Progress| {
        let mut supervisor = within(Mode::Lock);
        supervisor.advance(&asks(Request::Run), progress);
        (supervisor.mode(), supervisor.fault(), supervisor.take_raised())
    };
    assert_eq!(after(Progress::Busy), (Mode::Lock, None, false));
    assert_eq!(after(Progress::Back(Mode::Scan)), (Mode::Scan, None, false));
    assert_eq!(after(Progress::Failed(Fault::NoLock)), (Mode::Fault, Some(Fault::NoLock), true));
}
