//! Flash interface: unlock, erase, program, errors, ECC. RM0440 3.3, flash of category 3 with two
//! banks of 128 pages of 2 KiB.

use cortex_m4::{Access, Cycle, Fault, Ports, Width};
use stm32_metapac::flash::regs::{Acr, Cr, Eccr, Optr, Sr};

use crate::finding::Rule;
use crate::map::base::FLASH;
use crate::map::{at, line};
use crate::part::{Now, Stm32g474};
use crate::time::{Event, Ps, US};
use crate::wires::Wires;

const BASE: u32 = 0x0800_0000;
const BANK: u32 = 0x4_0000;
const PAGE: u32 = 2048;
/// Typical time of a page erase (DS12288, flash memory characteristics), ps.
const ERASE_TIME: Ps = 22_000 * US;
/// Typical time to program a double word (DS12288, flash memory characteristics), ps.
const PROGRAM_TIME: Ps = 82 * US;
/// FLASH_KEYR (3.7.3).
const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];
/// Flags of FLASH_SR that a one clears.
const SR_FLAGS: u32 = 0xc3fb;

/// Erase of a page, or programming of a double word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FlashOperation {
    /// `true` for an erase.
    pub erases: bool,
    /// Address of the page or the double word.
    pub address: u32,
    /// First cycle.
    pub first: Cycle,
    /// Last cycle, unless a power loss or a reset comes before.
    pub last: Cycle,
}

/// Operation in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Work {
    Erase { page: u32 },
    Program { address: u32, word: [u8; 8] },
}

/// State of the interface besides its registers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Flash {
    /// Number of correct keys so far; three after a wrong one, which locks the flash until a reset.
    keys: u8,
    work: Option<Work>,
    until: Cycle,
    /// First half of a double word: address and value.
    half: Option<(u32, u32)>,
    /// Double words with one flipped bit, which a read corrects.
    single: Vec<u32>,
    /// Operations so far, if they are recorded.
    log: Option<Vec<FlashOperation>>,
}

impl Flash {
    /// Returns the state after a reset.
    pub fn after_reset(&self) -> Self {
        Flash { single: self.single.clone(), log: self.log.clone(), ..Flash::default() }
    }
}

impl<W: Wires> Stm32g474<W> {
    /// Starts to record the operations of the flash.
    pub fn record_flash(&mut self) {
        self.flash.log = Some(Vec::new());
    }

    /// Returns the recorded operations of the flash, in order.
    pub fn flash_operations(&self) -> &[FlashOperation] {
        self.flash.log.as_deref().unwrap_or_default()
    }

    fn flash_sr(&mut self) -> &mut u32 {
        &mut self.regs[FLASH + at::flash::SR]
    }

    /// Returns the cycles until the bank of an address can be read again after its erase or
    /// programming (3.3.1, read while write).
    pub(crate) fn flash_stall(&self, address: u32, at: Cycle) -> u32 {
        let place = match self.flash.work {
            None => return 0,
            Some(Work::Erase { page }) => page,
            Some(Work::Program { address, .. }) => address,
        };
        let same = (address - BASE.min(address)) / BANK == (place - BASE) / BANK;
        if same { self.flash.until.saturating_sub(at).min(u64::from(u32::MAX)) as u32 } else { 0 }
    }

    pub(crate) fn write_flash_register(&mut self, now: Now, address: u32, value: u32, ports: &mut Ports) -> Result<(), Fault> {
        let old = self.regs[address];
        match address - FLASH {
            at::flash::ACR => self.write_acr(now, Acr(old), Acr(value)),
            at::flash::KEYR => self.write_key(now, address, value),
            at::flash::SR => {
                self.regs[address] = old & !(value & SR_FLAGS);
                self.flash_line(ports);
                Ok(())
            }
            at::flash::CR => self.write_flash_cr(now, Cr(old), Cr(value)),
            at::flash::ECCR => {
                let mut kept = Eccr(old & !(value & 0xf << 28));
                kept.set_eccie(Eccr(value).eccie());
                self.regs[address] = kept.0;
                self.flash_line(ports);
                Ok(())
            }
            _ => self.refuse(now, address, "a change of the option bytes"),
        }
    }

    fn write_acr(&mut self, now: Now, old: Acr, new: Acr) -> Result<(), Fault> {
        let address = FLASH + at::flash::ACR;
        self.refuse_bits(now, address, new.0, 3 << 13)?;
        if self.wait_states(self.time.hz()) > new.latency().to_bits() {
            self.report(now, address, 0xf, new.0, Rule::WaitStates)?;
        }
        for (reset, on, bit) in [(new.icrst(), old.icen() || new.icen(), 11), (new.dcrst(), old.dcen() || new.dcen(), 12)] {
            if reset && on {
                self.report(now, address, 1 << bit, new.0, Rule::CacheReset)?;
            }
        }
        if new.dcen() && self.flash.work.is_some() {
            self.report(now, address, 1 << 10, new.0, Rule::FlashDataCache)?;
        }
        self.art.set(new);
        self.regs[address] = new.0;
        Ok(())
    }

    fn write_key(&mut self, now: Now, address: u32, value: u32) -> Result<(), Fault> {
        let mut cr = Cr(self.regs[FLASH + at::flash::CR]);
        let wanted = KEYS.get(usize::from(self.flash.keys)).copied();
        if wanted != Some(value) || !cr.lock() {
            // A wrong key is a bus error, and locks until the next reset (3.3.5).
            self.flash.keys = 3;
            self.report(now, address, u32::MAX, value, Rule::FlashLocked)?;
            return Err(Fault::Bus);
        }
        self.flash.keys += 1;
        if self.flash.keys == 2 {
            self.flash.keys = 0;
            cr.set_lock(false);
            self.regs[FLASH + at::flash::CR] = cr.0;
        }
        Ok(())
    }

    fn write_flash_cr(&mut self, now: Now, old: Cr, new: Cr) -> Result<(), Fault> {
        let address = FLASH + at::flash::CR;
        if old.lock() {
            return self.report(now, address, new.0 ^ old.0, new.0, Rule::FlashLocked);
        }
        if self.flash.work.is_some() {
            return self.report(now, address, new.0 ^ old.0, new.0, Rule::FlashBusy);
        }
        // Mass erase, fast programming, option bytes, secured area.
        self.refuse_bits(now, address, new.0 & !old.0, 1 << 2 | 1 << 15 | 1 << 17 | 1 << 18 | 7 << 26)?;
        let mut kept = new;
        kept.set_strt(false);
        self.regs[address] = kept.0;
        if !new.strt() {
            return Ok(());
        }
        if !new.per() || new.pg() || *self.flash_sr() & 0xfa != 0 {
            *self.flash_sr() |= 1 << 7;
            return self.report(now, address, 1 << 16, new.0, Rule::FlashSequence);
        }
        if !Optr(self.regs[FLASH + at::flash::OPTR]).dbank() {
            return self.refuse(now, address, "an erase with one bank");
        }
        let page = BASE + u32::from(new.bker()) * BANK + u32::from(new.pnb()) * PAGE;
        self.begin(now, Work::Erase { page }, ERASE_TIME)
    }

    fn begin(&mut self, now: Now, work: Work, time: Ps) -> Result<(), Fault> {
        if self.art.caches_data() {
            let acr = FLASH + at::flash::ACR;
            self.report(now, acr, 1 << 10, self.regs[acr], Rule::FlashDataCache)?;
        }
        self.flash.work = Some(work);
        self.flash.until = self.time.cycle(self.time.ps(now.at) + time);
        self.agenda.set(Event::Flash, self.flash.until);
        if let Some(log) = &mut self.flash.log {
            let (erases, address) = match work {
                Work::Erase { page } => (true, page),
                Work::Program { address, .. } => (false, address),
            };
            log.push(FlashOperation { erases, address, first: now.at, last: self.flash.until });
        }
        *self.flash_sr() |= 1 << 16;
        Ok(())
    }

    /// Stores half of a double word to the flash (3.3.7).
    pub(crate) fn program(&mut self, now: Now, access: Access, value: u32, ports: &mut Ports) -> Result<(), Fault> {
        let address = access.address;
        let cr = Cr(self.regs[FLASH + at::flash::CR]);
        let mut flags = Sr(0);
        if self.flash.work.is_some() {
            // Hardware would stall the bus; a program that does not wait is still wrong.
            return self.report(now, FLASH + at::flash::SR, 1 << 16, value, Rule::FlashBusy);
        }
        let second = self.flash.half.take();
        flags.set_pgserr(!cr.pg() || cr.per() || *self.flash_sr() & 0xfa != 0 || second.is_some_and(|(at, _)| at + 4 != address));
        flags.set_sizerr(access.width != Width::Word);
        flags.set_pgaerr(second.is_none() && !address.is_multiple_of(8));
        if flags.0 != 0 {
            *self.flash_sr() |= flags.0;
            self.flash_line(ports);
            return self.report(now, FLASH + at::flash::SR, flags.0, value, Rule::FlashSequence);
        }
        let Some((first, low)) = second else {
            self.flash.half = Some((address, value));
            return Ok(());
        };
        let mut word = [0; 8];
        word[..4].copy_from_slice(&low.to_le_bytes());
        word[4..].copy_from_slice(&value.to_le_bytes());
        let erased = ports.memory.get(first, 8).is_some_and(|old| old.iter().all(|byte| *byte == 0xff));
        if !erased && word != [0; 8] {
            *self.flash_sr() |= 1 << 3;
            self.flash_line(ports);
            return self.report(now, FLASH + at::flash::SR, 1 << 3, value, Rule::FlashNotErased);
        }
        self.begin(now, Work::Program { address: first, word }, PROGRAM_TIME)
    }

    /// Ends an erase or programming.
    pub(crate) fn flash_done(&mut self, _at: Cycle, ports: &mut Ports) {
        match self.flash.work.take() {
            Some(Work::Erase { page }) => {
                if let Some(bytes) = ports.memory.get_mut(page, PAGE as usize) {
                    bytes.fill(0xff);
                }
                for word in (page..page + PAGE).step_by(8) {
                    ports.memory.clear_damage(word);
                }
                self.flash.single.retain(|word| !(page..page + PAGE).contains(word));
            }
            Some(Work::Program { address, word }) => {
                if let Some(bytes) = ports.memory.get_mut(address, 8) {
                    bytes.copy_from_slice(&word);
                }
            }
            None => {}
        }
        let done = u32::from(Cr(self.regs[FLASH + at::flash::CR]).eopie());
        let sr = self.flash_sr();
        *sr = *sr & !(1 << 16) | done;
        self.flash_line(ports);
    }

    /// Interrupts an operation by a reset or a supply dip: its data read as damaged (3.3.6, 3.3.7).
    pub(crate) fn flash_loses_power(&mut self, ports: &mut Ports) {
        match self.flash.work.take() {
            Some(Work::Erase { page }) => (page..page + PAGE).step_by(8).for_each(|word| ports.memory.damage(word)),
            Some(Work::Program { address, word }) => {
                if let Some(bytes) = ports.memory.get_mut(address, 8) {
                    bytes[..4].copy_from_slice(&word[..4]);
                }
                ports.memory.damage(address);
            }
            None => {}
        }
        self.agenda.clear(Event::Flash);
    }

    /// Flips bits in a double word.
    pub(crate) fn flip_flash(&mut self, address: u32, bits: u8, ports: &mut Ports) {
        let word = address & !7;
        if bits == 1 {
            // Reads are corrected, so the bytes do not change.
            self.flash.single.push(word);
        } else if let Some(bytes) = ports.memory.get_mut(word, 8) {
            self.flash.single.retain(|single| *single != word);
            bytes[0] ^= 3;
        }
        ports.memory.damage(word);
    }

    /// Sets FLASH_ECCR after a read of a damaged word (3.7.6).
    pub(crate) fn ecc(&mut self, address: u32, ports: &mut Ports) -> Result<(), Fault> {
        let word = address & !7;
        let single = self.flash.single.contains(&word);
        let mut eccr = Eccr(self.regs[FLASH + at::flash::ECCR]);
        // The address of the first error stays until it is cleared.
        if !eccr.eccd() && !eccr.eccc() {
            eccr.set_addr_ecc((word - BASE) % BANK);
            eccr.set_bk_ecc((word - BASE) / BANK != 0);
        }
        if single {
            eccr.set_eccc(true)
        } else {
            eccr.set_eccd(true)
        }
        self.regs[FLASH + at::flash::ECCR] = eccr.0;
        self.flash_line(ports);
        if single {
            return Ok(());
        }
        ports.interrupts.pend_nmi();
        self.tim1.ecc = true;
        let now = self.now(self.last);
        self.update_breaks(now.at, ports);
        self.report(now, FLASH + at::flash::ECCR, 1 << 31, eccr.0, Rule::EccDouble)
    }

    fn flash_line(&mut self, ports: &mut Ports) {
        let (sr, cr) = (*self.flash_sr(), Cr(self.regs[FLASH + at::flash::CR]));
        let eccr = Eccr(self.regs[FLASH + at::flash::ECCR]);
        let high = (cr.eopie() && sr & 1 != 0) || (cr.errie() && sr & 2 != 0) || (eccr.eccie() && eccr.eccc());
        ports.interrupts.set(line::FLASH, high);
    }
}
