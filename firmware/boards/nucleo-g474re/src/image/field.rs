//! Updates over the link: the running image stores another image in the second bank and marks it
//! for the first stage.
#![expect(unsafe_code, reason = "a constant that the linker must keep")]

use cortex_m::singleton;
use firmware::board::link::VERSION;
use firmware::board::update::{UpdateReport, UpdateState, UpdateVerb, Updates};
use firmware::seam::refusal::Refusal;
use nucleo_g474re::slots::{BOARD, MANIFEST, ORIGIN, SLOT, STATE, STORE};
use update::check::Target;
use update::identity::{Identity, SIZE, board, number};
use update::key;
use update::receive::Receiver;

use super::button;
use super::flash::{Damage, Pages};
use super::watchdog;

/// Identity of this image for its manifest, read from the ELF file by symbol name.
// SAFETY: no other symbol has this name.
#[used]
#[unsafe(no_mangle)]
static SONOGLIDE_IDENTITY: [u8; SIZE] = Identity {
    board: board(BOARD),
    version: [
        number(env!("CARGO_PKG_VERSION_MAJOR")),
        number(env!("CARGO_PKG_VERSION_MINOR")),
        number(env!("CARGO_PKG_VERSION_PATCH")),
    ],
    protocol: VERSION,
}
.encode();

/// Receiver of updates of this board. It relaxes the watchdog while a signature is checked.
struct Field(Receiver<Pages, Pages>);

/// Starts the receiver of updates. Called once.
pub fn start() -> &'static mut dyn Updates {
    if key::PUBLIC.contains(&key::DEVELOPMENT) {
        defmt::warn!("this image accepts updates signed by the development key, which is public");
    }
    button::start();
    // SAFETY: reads a constant. The read is volatile, so that the constant is kept at the address
    // in the ELF file, and a change by a probe is read.
    let identity = Identity::decode(&unsafe { core::ptr::read_volatile(&raw const SONOGLIDE_IDENTITY) });
    let target = Target { board: board(BOARD), origin: ORIGIN, room: SLOT.size - MANIFEST, keys: &key::PUBLIC };
    let [slot, store, state] = [SLOT, STORE, STATE].map(|area| Pages::new(area, Damage::Zeros));
    let field = singleton!(: Field = Field(Receiver::new(store, state, slot, target, identity.protocol, button::is_held)));
    let Some(field) = field else { panic!("started twice") };
    field
}

impl Updates for Field {
    fn report(&mut self) -> UpdateReport {
        self.0.report()
    }

    fn obey(&mut self, verb: &UpdateVerb) -> Result<(), Refusal> {
        self.0.obey(verb)
    }

    fn work(&mut self) {
        if self.0.report().state == UpdateState::Checking {
            watchdog::relax();
            self.0.work();
            watchdog::tighten();
        }
    }

    fn confirm(&mut self) {
        self.0.confirm();
    }
}
