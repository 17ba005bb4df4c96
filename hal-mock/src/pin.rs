//! Digital pins whose other end belongs to a test.
//!
//! [`output`] returns a pin to drive and its [`Probe`], which records every change with its time.
//! [`input`] returns a pin to read and a [`Switch`] that sets it. Both can be made to fail, like a
//! port expander that does not answer.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use embedded_hal::digital::{self, ErrorType, InputPin, OutputPin, StatefulOutputPin};

use crate::time::Clock;

/// The pin does not answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PinFailed;

impl digital::Error for PinFailed {
    fn kind(&self) -> digital::ErrorKind {
        digital::ErrorKind::Other
    }
}

/// Change of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// Time of the change.
    pub at: Duration,
    /// Level after the change.
    pub high: bool,
}

#[derive(Debug, Default)]
struct OutputState {
    changes: Vec<Change>,
    fails: bool,
}

/// Output pin for its driver.
#[derive(Debug)]
pub struct Output {
    state: Rc<RefCell<OutputState>>,
    clock: Clock,
}

/// Test's end of an [`Output`].
#[derive(Clone, Debug)]
pub struct Probe(Rc<RefCell<OutputState>>);

/// Creates an output that has not been driven yet, and its probe.
pub fn output(clock: &Clock) -> (Output, Probe) {
    let state = Rc::<RefCell<OutputState>>::default();
    (Output { state: state.clone(), clock: clock.clone() }, Probe(state))
}

impl Output {
    fn set(&mut self, high: bool) -> Result<(), PinFailed> {
        let mut state = self.state.borrow_mut();
        if state.fails {
            return Err(PinFailed);
        }
        if state.changes.last().is_none_or(|last| last.high != high) {
            state.changes.push(Change { at: self.clock.now(), high });
        }
        Ok(())
    }

    fn level(&self) -> Result<bool, PinFailed> {
        let state = self.state.borrow();
        if state.fails { Err(PinFailed) } else { Ok(state.changes.last().is_some_and(|last| last.high)) }
    }
}

impl ErrorType for Output {
    type Error = PinFailed;
}

impl OutputPin for Output {
    fn set_low(&mut self) -> Result<(), PinFailed> {
        self.set(false)
    }

    fn set_high(&mut self) -> Result<(), PinFailed> {
        self.set(true)
    }
}

impl StatefulOutputPin for Output {
    fn is_set_high(&mut self) -> Result<bool, PinFailed> {
        self.level()
    }

    fn is_set_low(&mut self) -> Result<bool, PinFailed> {
        self.level().map(|high| !high)
    }
}

impl Probe {
    /// Returns `true` if the pin is high. A pin that was never driven floats and reads low, because
    /// the enable has a pull-down.
    pub fn is_high(&self) -> bool {
        self.0.borrow().changes.last().is_some_and(|last| last.high)
    }

    /// Returns `true` if the pin has been driven.
    pub fn is_driven(&self) -> bool {
        !self.0.borrow().changes.is_empty()
    }

    /// Returns all changes, the oldest first; the first is the first drive of the pin.
    pub fn changes(&self) -> Vec<Change> {
        self.0.borrow().changes.clone()
    }

    /// Makes driving the pin fail or succeed from now on. While it fails, the pin keeps its level.
    pub fn set_failing(&self, fails: bool) {
        self.0.borrow_mut().fails = fails;
    }
}

#[derive(Debug)]
struct InputState {
    high: bool,
    fails: bool,
}

/// Input pin for its reader.
#[derive(Debug)]
pub struct Input(Rc<RefCell<InputState>>);

/// Test's end of an [`Input`].
#[derive(Clone, Debug)]
pub struct Switch(Rc<RefCell<InputState>>);

/// Creates an input at this level, and the switch that sets it.
pub fn input(high: bool) -> (Input, Switch) {
    let state = Rc::new(RefCell::new(InputState { high, fails: false }));
    (Input(state.clone()), Switch(state))
}

impl Switch {
    /// Sets the level of the input.
    pub fn set(&self, high: bool) {
        self.0.borrow_mut().high = high;
    }

    /// Makes reading the pin fail or succeed from now on.
    pub fn set_failing(&self, fails: bool) {
        self.0.borrow_mut().fails = fails;
    }
}

impl ErrorType for Input {
    type Error = PinFailed;
}

impl InputPin for Input {
    fn is_high(&mut self) -> Result<bool, PinFailed> {
        let state = self.0.borrow();
        if state.fails { Err(PinFailed) } else { Ok(state.high) }
    }

    fn is_low(&mut self) -> Result<bool, PinFailed> {
        self.is_high().map(|high| !high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_output_records_its_changes_with_their_times() {
        let clock = Clock::new(1_000_000);
        let (mut pin, probe) = output(&clock);
        assert!(!probe.is_driven() && !probe.is_high());
        pin.set_low().unwrap();
        clock.advance(5);
        pin.set_low().unwrap();
        pin.set_high().unwrap();
        clock.advance(2);
        pin.toggle().unwrap();
        let changes: Vec<_> = probe.changes().iter().map(|change| (change.at.as_micros(), change.high)).collect();
        assert_eq!(changes, [(0, false), (5, true), (7, false)]);
    }

    #[test]
    fn a_failing_output_keeps_its_level() {
        let (mut pin, probe) = output(&Clock::new(1));
        pin.set_high().unwrap();
        probe.set_failing(true);
        assert_eq!((pin.set_low(), pin.is_set_high()), (Err(PinFailed), Err(PinFailed)));
        assert!(probe.is_high());
        probe.set_failing(false);
        pin.set_low().unwrap();
        assert!(!probe.is_high());
    }

    #[test]
    fn an_input_has_the_level_of_its_switch() {
        let (mut pin, switch) = input(true);
        assert_eq!((pin.is_high(), pin.is_low()), (Ok(true), Ok(false)));
        switch.set(false);
        assert_eq!((pin.is_high(), pin.is_low()), (Ok(false), Ok(true)));
        switch.set_failing(true);
        assert_eq!(pin.is_low(), Err(PinFailed));
    }
}
