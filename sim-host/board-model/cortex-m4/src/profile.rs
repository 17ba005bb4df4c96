//! Profile of cycles by function and by exception.

use crate::chip::{Chip, Cycle};
use crate::machine::Machine;

/// Cost of a function.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spent {
    /// Executed instructions.
    pub instructions: u64,
    /// Cycles, including wait states.
    pub cycles: Cycle,
    /// Fetches of aligned 8 bytes from a memory with wait states.
    pub fetches: u64,
}

/// Cost of an exception.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Handled {
    /// Number of entries.
    pub entries: u64,
    /// Total cycles from entry to return, including nested exceptions.
    pub cycles: Cycle,
    /// Cycles of the longest execution.
    pub longest: Cycle,
}

/// Profile of a run.
#[derive(Clone, Debug, Default)]
pub struct Profile {
    /// Cost by the index of the function; the last entry is code without a symbol.
    spent: Vec<Spent>,
    /// Exception in which functions are counted; `None` counts everywhere.
    only: Option<u16>,
    /// Cost by exception number.
    handled: std::collections::BTreeMap<u16, Handled>,
    /// Active exceptions, with the cycle of their entry.
    active: Vec<(u16, Cycle)>,
    /// Index and addresses of the function of the last instruction.
    last: (usize, std::ops::Range<u32>),
}

impl Profile {
    /// Returns the cost of each exception by its number.
    pub fn handled(&self) -> impl Iterator<Item = (u16, Handled)> {
        self.handled.iter().map(|(number, handled)| (*number, *handled))
    }
}

impl<C: Chip> Machine<C> {
    /// Begins a profile and drops an earlier one. Functions are counted only in the exception
    /// `only`, or always. The run becomes slower by about a third.
    pub fn start_profile(&mut self, only: Option<u16>) {
        let spent = vec![Spent::default(); self.symbols.functions().len() + 1];
        self.profile = Some(Box::new(Profile { spent, only, ..Profile::default() }));
    }

    /// Ends the profile and returns it.
    pub fn take_profile(&mut self) -> Option<Profile> {
        self.profile.take().map(|profile| *profile)
    }

    /// Returns the functions with cycles in a profile of this image, the most expensive first. Code
    /// without a symbol has no name.
    pub fn functions_of(&self, profile: &Profile) -> Vec<(Option<&str>, Spent)> {
        let functions = self.symbols.functions();
        let name = |index: usize| functions.get(index).map(|function| function.name.as_str());
        let mut all: Vec<_> = profile
            .spent
            .iter()
            .enumerate()
            .filter(|(_, spent)| spent.cycles > 0)
            .map(|(index, spent)| (name(index), *spent))
            .collect();
        all.sort_by_key(|(_, spent)| std::cmp::Reverse(spent.cycles));
        all
    }

    /// Counts the instruction at `pc` that has just run.
    pub(crate) fn profile_instruction(&mut self, pc: u32, cycles: u32, fetches: u32) {
        let handled = self.cpu.ipsr;
        let Some(profile) = self.profile.as_mut().filter(|profile| profile.only.is_none_or(|only| only == handled)) else {
            return;
        };
        if !profile.last.1.contains(&pc) {
            profile.last = match self.symbols.index(pc) {
                Some(index) => {
                    let function = &self.symbols.functions()[index];
                    (index, function.address..function.address + function.size.max(2))
                }
                None => (self.symbols.functions().len(), pc..pc + 2),
            };
        }
        if let Some(spent) = profile.spent.get_mut(profile.last.0) {
            spent.instructions += 1;
            spent.cycles += Cycle::from(cycles);
            spent.fetches += u64::from(fetches);
        }
    }

    pub(crate) fn profile_entry(&mut self, exception: u16) {
        if let Some(profile) = &mut self.profile {
            profile.active.push((exception, self.cpu.cycle));
        }
    }

    pub(crate) fn profile_return(&mut self, exception: u16) {
        let Some(profile) = &mut self.profile else { return };
        // Exceptions that were entered before the profile began have no start.
        let Some(at) = profile.active.iter().rposition(|(number, _)| *number == exception) else { return };
        let (_, since) = profile.active.remove(at);
        let cycles = self.cpu.cycle - since;
        let handled = profile.handled.entry(exception).or_default();
        handled.entries += 1;
        handled.cycles += cycles;
        handled.longest = handled.longest.max(cycles);
    }
}
