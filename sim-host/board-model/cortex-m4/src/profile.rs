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

impl Spent {
    /// Returns the cost since an earlier state.
    fn since(&self, before: &Spent) -> Spent {
        Spent {
            instructions: self.instructions - before.instructions,
            cycles: self.cycles - before.cycles,
            fetches: self.fetches - before.fetches,
        }
    }
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
    /// The same until the last entry of `only`, and in its longest execution.
    before: Vec<Spent>,
    longest: Vec<Spent>,
    /// Exception in which functions are counted; `None` counts everywhere.
    only: Option<u16>,
    /// Cost by exception number.
    handled: std::collections::BTreeMap<u16, Handled>,
    /// Active exceptions, with the cycle of their entry.
    active: Vec<(u16, Cycle)>,
    /// Index and addresses of the function of the last instruction.
    last: (usize, std::ops::Range<u32>),
}

/// Cost of a function in a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InFunction<'a> {
    /// Name; `None` for code without a symbol.
    pub name: Option<&'a str>,
    /// Total cost.
    pub all: Spent,
    /// Cost in the longest execution of the only exception; zero if there is none.
    pub longest: Spent,
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

    /// Returns the functions with cycles in a profile of this image, those with the most cycles in
    /// the longest execution first.
    pub fn functions_of(&self, profile: &Profile) -> Vec<InFunction<'_>> {
        let functions = self.symbols.functions();
        let of = |(index, all): (usize, &Spent)| InFunction {
            name: functions.get(index).map(|function| function.name.as_str()),
            all: *all,
            longest: profile.longest.get(index).copied().unwrap_or_default(),
        };
        let mut all: Vec<_> = profile.spent.iter().enumerate().filter(|(_, spent)| spent.cycles > 0).map(of).collect();
        all.sort_by_key(|function| std::cmp::Reverse((function.longest.cycles, function.all.cycles)));
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
            if profile.only == Some(exception) {
                profile.before.clone_from(&profile.spent);
            }
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
        if profile.only == Some(exception) && cycles > handled.longest {
            let taken = |(after, before): (&Spent, &Spent)| after.since(before);
            profile.longest = profile.spent.iter().zip(&profile.before).map(taken).collect();
        }
        handled.longest = handled.longest.max(cycles);
    }
}
