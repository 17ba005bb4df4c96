//! A simulated board that records the largest voltage and current of all blocks.

use std::io;
use std::time::Duration;

use link::port::InProcess;
use link::simulated_board::SimulatedBoard;

/// A board, with the largest voltage and current at its amplifier.
pub(super) struct WatchedBoard {
    board: SimulatedBoard,
    /// Largest code played, from mid-code, and largest code read by the current's converter.
    largest: (u16, u16),
}

impl WatchedBoard {
    /// Watches a board, which must keep the last block at its converters.
    pub(super) fn new(board: SimulatedBoard) -> Self {
        WatchedBoard { board, largest: (0, 0) }
    }

    /// Returns the time since power-on, s.
    pub(super) fn seconds(&self) -> f64 {
        self.board.now().as_secs_f64()
    }

    /// Returns the largest peak voltage played, V, and the largest peak current measured, A, both
    /// within one code.
    pub(super) fn largest(&self) -> (f64, f64) {
        let front_end = &self.board.config().front_end;
        let of = |codes: u16, per_lsb: f32| f64::from(codes) * f64::from(per_lsb);
        (of(self.largest.0, front_end.drive_volt_per_lsb), of(self.largest.1, front_end.ampere_per_lsb))
    }
}

impl InProcess for WatchedBoard {
    fn send(&mut self, bytes: &[u8]) {
        self.board.send(bytes);
    }

    fn waiting(&self) -> usize {
        self.board.waiting()
    }

    fn receive(&mut self, into: &mut [u8]) -> usize {
        self.board.receive(into)
    }

    fn now(&self) -> Duration {
        self.board.now()
    }

    fn block(&mut self) -> io::Result<()> {
        self.board.block();
        let (drive_mid, sense_mid) = {
            let front_end = &self.board.config().front_end;
            (front_end.drive_mid_code, front_end.sense_mid_code)
        };
        let (volts, amperes) = self.board.with_rig(|rig| {
            let Some(last) = rig.blocks().next_back() else { return (0, 0) };
            let most = |codes: &[u16], mid: u16| codes.iter().map(|code| code.abs_diff(mid)).max().unwrap_or(0);
            (last.drive.lanes.iter().map(|lane| most(lane, drive_mid)).max().unwrap_or(0), most(&last.sense.i, sense_mid))
        });
        self.largest = (self.largest.0.max(volts), self.largest.1.max(amperes));
        Ok(())
    }
}
