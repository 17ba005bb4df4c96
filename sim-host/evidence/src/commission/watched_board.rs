//! A simulated board whose loudest voltage and current are recorded block by block.

use std::io;
use std::time::Duration;

use link::port::InProcess;
use link::simulated_board::SimulatedBoard;

/// A board, and what has been the loudest at its amplifier.
pub(super) struct WatchedBoard {
    board: SimulatedBoard,
    /// Largest code that was played, from the middle, and largest that the current's converter has read.
    loudest: (u16, u16),
}

impl WatchedBoard {
    /// Watches a board that keeps the last block at its converters.
    pub(super) fn new(board: SimulatedBoard) -> Self {
        WatchedBoard { board, loudest: (0, 0) }
    }

    /// Time since the power came, s.
    pub(super) fn seconds(&self) -> f64 {
        self.board.now().as_secs_f64()
    }

    /// Largest peak voltage that was played, V, and largest peak current that was measured, A, both within one code.
    pub(super) fn loudest(&self) -> (f64, f64) {
        let front_end = &self.board.config().front_end;
        let of = |codes: u16, per_lsb: f32| f64::from(codes) * f64::from(per_lsb);
        (of(self.loudest.0, front_end.drive_volt_per_lsb), of(self.loudest.1, front_end.ampere_per_lsb))
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
        self.loudest = (self.loudest.0.max(volts), self.loudest.1.max(amperes));
        Ok(())
    }
}
