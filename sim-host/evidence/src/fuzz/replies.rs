//! The host's end of the link: for any bytes of a board or its substitute, the host's reader
//! returns frames or reports an error.

use std::cell::RefCell;

use firmware::board::command::Reply;
use firmware::board::link::{FrameError, MAX_FRAME, Receiver, VERSION, encode};
use hal_mock::bench::{Bench, Queues, Setup};
use hal_mock::chance::Chance;
use hal_mock::loop_back::LoopBack;

use super::frames::{framed, valid};
use super::target::{Tally, Target};

pub(super) const TARGET: Target =
    Target { name: "replies", what: "bytes from a board: the host's decoder", seeds_per_million: 20, feed, corpus: |_| Ok(()) };

/// Number of questions to the board that makes the answers.
const ASKED: usize = 60;
/// Number of frames of each seed.
const FRAMES: usize = 600;

fn feed(seed: u64, tally: &mut Tally) -> Result<(), String> {
    thread_local! {
        // The answers of one board serve all seeds; the damage differs.
        static WHOLE: RefCell<Vec<Reply>> = RefCell::new(answers());
    }
    let mut chance = Chance::new(seed);
    let (mut receiver, mut raw) = (Receiver::default(), ::link::raw_frame::RawFrame::default());
    for _ in 0..FRAMES {
        let pick = chance.below(1 << 20) as usize;
        let reply = WHOLE.with_borrow(|whole| whole[pick % whole.len()]);
        let whole = encode(chance.below(1 << 16) as u16, chance.below(1 << 32) as u32, reply)
            .map_err(|error| format!("{error:?}"))?
            .to_vec();
        let mut bytes = whole.clone();
        match chance.below(4) {
            0 => {}
            1 => {
                let at = chance.below(bytes.len() as u64 - 1) as usize;
                bytes[at] ^= 1 << chance.below(8);
            }
            // A valid checksum over arbitrary bytes.
            2 => {
                bytes =
                    framed(VERSION, 1, 7, &(0..chance.below(MAX_FRAME as u64 - 14)).map(|_| chance.byte()).collect::<Vec<_>>())
            }
            _ => bytes = (0..chance.below(400)).map(|_| chance.byte()).chain([0]).collect(),
        }
        tally.input(bytes.len());
        let mut last = None;
        for &byte in &bytes {
            raw.take(byte);
            if let Some(frame) = receiver.take::<Reply>(byte) {
                tally.outcome(match &frame {
                    Ok(_) => "a frame",
                    Err(FrameError::TooLong) => "too long",
                    Err(FrameError::Damaged) => "damaged",
                    Err(FrameError::Version(_)) => "another version",
                    Err(FrameError::Unknown(..)) => "unknown",
                });
                last = Some(frame);
            }
        }
        if raw.shown().is_empty() {
            return Err("the raw view of the received bytes is empty".into());
        }
        // An undamaged frame is understood after any earlier bytes.
        let is_whole = |again: &[u8]| again == &whole[..];
        let understood = matches!(&last, Some(Ok(frame))
            if encode(frame.sequence, frame.session, frame.body).is_ok_and(|again| is_whole(&again)));
        if (bytes == whole) != understood {
            return Err(format!("{bytes:02x?} is decoded as {last:?}"));
        }
    }
    Ok(())
}

/// Returns answers of a board, of every kind.
fn answers() -> Vec<Reply> {
    let (mut chance, mut queues, setup) = (Chance::new(1), Queues::default(), Setup::default());
    let mut replies = vec![Reply::Ack];
    if let Ok(mut bench) = Bench::new(&mut queues, &setup, LoopBack::of(&setup.config)) {
        for _ in 0..ASKED {
            let _ = bench.ask(valid(&mut chance));
            bench.blocks(20);
        }
        bench.host.receive(usize::MAX);
        replies.extend(bench.host.answers().map(|(_, reply)| *reply));
        replies.extend(bench.host.telemetry().map(|(_, report)| Reply::Telemetry(*report)));
    }
    replies
}
