//! Instructions that the recorder of raw codes adds to a block.

use core::hint::black_box;

use cortex_m::singleton;
use firmware::board::capture::memory::Memory;
use firmware::board::capture::recorder::{CaptureReply, CaptureRequest, Recorder};
use firmware::board::capture::{Arm, Trigger};
use firmware::seam::block::{DriveBlock, SenseBlock};
use firmware::seam::telemetry::Telemetry;
use heapless::spsc::Queue;
use qemu_m4::bench::SAMPLES;
use qemu_m4::counter::Counter;

use crate::csv::line;
use crate::repeat::repeat;

const REPETITIONS: u32 = 500;
/// Code of zero.
const MID_CODE: u16 = 2048;

/// Counts a block of the recorder, net of an empty loop.
pub fn count(counter: &Counter) {
    let empty = repeat(counter, REPETITIONS, || ());
    let print = |kernel: &str, work: &mut dyn FnMut()| {
        line("stage", kernel, SAMPLES, REPETITIONS, repeat(counter, REPETITIONS, work) - empty);
    };
    let drive = DriveBlock::silent(4, SAMPLES, MID_CODE);
    let lane = drive.lanes.first().cloned().unwrap_or_default();
    let sense = SenseBlock { v: lane.clone(), i: lane, ..SenseBlock::default() };
    let report = Telemetry::default();

    let Some(memory) = singleton!(: Memory = Memory::new()) else { panic!("counted twice") };
    let (mut requests, mut replies): (Queue<_, 2>, Queue<_, 2>) = (Queue::new(), Queue::new());
    let ((mut ask, requests), (replies, mut answered)) = (requests.split(), replies.split());
    let mut recorder = Recorder::new(requests, replies);
    let mut follow = || recorder.follow(black_box(&sense), black_box(&drive), black_box(&report));
    print("recorder, disarmed", &mut follow);
    let arm = Arm { trigger: Trigger::Fault, before: 512, lane: 3 };
    assert!(ask.enqueue(CaptureRequest::Record(arm, Some(memory))).is_ok());
    print("recorder, armed", &mut follow);
    assert!(matches!(answered.dequeue(), Some(CaptureReply::Records)));
    print("recorder, status request", &mut || {
        assert!(ask.enqueue(CaptureRequest::Look).is_ok());
        follow();
        assert!(matches!(black_box(answered.dequeue()), Some(CaptureReply::Not(_))));
    });
}
