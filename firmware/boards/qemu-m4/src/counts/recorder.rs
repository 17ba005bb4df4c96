//! The recorder of raw codes: what it adds to a block.

use core::hint::black_box;

use firmware::block::{DriveBlock, SenseBlock};
use firmware::capture::recorder::{Answer, Memory, Recorder};
use firmware::capture::{Arm, CaptureState, CaptureVerb, Trigger};
use firmware::telemetry::Telemetry;
use heapless::spsc::Queue;
use qemu_m4::bench::SAMPLES;
use qemu_m4::counter::Counter;

use crate::csv::line;
use crate::repeat::repeat;

const REPETITIONS: u32 = 500;
/// The code of zero.
const MID_CODE: u16 = 2048;

/// Counts a block of the recorder, net of a loop that does nothing.
pub fn count(counter: &Counter) {
    let empty = repeat(counter, REPETITIONS, || ());
    let print = |kernel: &str, work: &mut dyn FnMut()| {
        line("stage", kernel, SAMPLES, REPETITIONS, repeat(counter, REPETITIONS, work) - empty);
    };
    let drive = DriveBlock::silent(4, SAMPLES, MID_CODE);
    let lane = drive.lanes.first().cloned().unwrap_or_default();
    let sense = SenseBlock { v: lane.clone(), i: lane, ..SenseBlock::default() };
    let report = Telemetry::default();

    let mut memory = Memory::new();
    let (mut wishes, mut answers): (Queue<_, 2>, Queue<_, 2>) = (Queue::new(), Queue::new());
    let ((mut ask, wishes), (answers, mut answered)) = (wishes.split(), answers.split());
    let mut recorder = Recorder::new(&mut memory, wishes, answers);
    let mut follow = || recorder.follow(black_box(&sense), black_box(&drive), black_box(&report));
    print("recorder, disarmed", &mut follow);
    let arm = CaptureVerb::Arm(Arm { trigger: Trigger::Fault, before: 512, lane: 3 });
    assert!(ask.enqueue(arm).is_ok());
    print("recorder, armed", &mut follow);
    assert!(answered.dequeue().is_some());
    let now = CaptureVerb::Arm(Arm { trigger: Trigger::Now, before: 0, lane: 3 });
    assert!(ask.enqueue(now).is_ok());
    (0..40).for_each(|_| follow());
    assert!(answered.dequeue().is_some());
    print("recorder, full and asked for a part", &mut || {
        assert!(ask.enqueue(CaptureVerb::Read(7)).is_ok());
        follow();
        assert!(black_box(answered.dequeue()).is_some());
    });
    assert!(ask.enqueue(CaptureVerb::State).is_ok());
    follow();
    let Some(Answer::Report(state)) = answered.dequeue() else { panic!("no report") };
    assert!(state.state == CaptureState::Full);
}
