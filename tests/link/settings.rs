//! Settings over the link: a value out of range is refused with its range, and a stored value is
//! active after a reset.

use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

use firmware::board::settings::{Record, Settings};
use hal_mock::flash::{Damage, Flash, PAGE_BYTES, WORD_BYTES};
use link::client::Client;
use link::commands::settings::{self, SettingsOrder};
use link::session::Session;

use super::{board, run, session};

fn refused(line: &str) -> String {
    let board = board("lock", &[], 0);
    run(line, &mut session(&board)).unwrap_err().to_string()
}

#[test]
fn stored_limits_act_after_a_reset() {
    let board = board("lock", &[], 0);
    let text = "settings set limits.voltage_v 2\nsettings set drive.amplitude_v 1.5\nsettings set drive.scan_volts 1\n\
        settings get limits.voltage_v\nexpect acts > 10\nexpect set = 2\nexpect kept = changed\n\
        settings store\nreset\nexpect last_start = \"reset by order\"\n\
         settings get limits.voltage_v\nexpect acts = 2\nexpect kept = stored\n\
        drive --volts 9\nstatus\nexpect limit = 96\nexpect drive_v <= 2\nstop\nwait 0.01\n\
        settings defaults\nsettings store\nreset\nsettings get limits.voltage_v\nexpect acts > 10\n";
    run(text, &mut session(&board)).unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn a_stored_limit_acts_whatever_else_is_stored() {
    let board = board("lock", &[], 0);
    // A limit below the built-in drive, as stored by another image; and a limit that cannot be
    // checked on this board.
    board.borrow_mut().power_cycle(|flash| leave(flash, &[(8, 0.5)]));
    let text = "! settings set limits.energy_j_per_m 1000\n\
        settings get limits.voltage_v\nexpect acts = 0.5\nexpect kept = refused\n\
        settings get drive.amplitude_v\nexpect acts <= 0.5\n\
        drive --volts 12\nstatus\nexpect limit = 96\nexpect drive_v <= 0.5\nstop\n";
    run(text, &mut session(&board)).unwrap_or_else(|error| panic!("{error}"));
    let refused = refused("settings set limits.energy_j_per_m 1000");
    assert!(
        refused.contains("limits.energy_j_per_m") && refused.contains("without front_end.metre_per_count: set that first"),
        "{refused}"
    );
    // A host is informed as soon as it connects.
    static NOTES: Mutex<Vec<String>> = Mutex::new(Vec::new());
    static NEVER: AtomicBool = AtomicBool::new(false);
    let note: fn(&str) = |line| NOTES.lock().unwrap().push(line.to_owned());
    let client = Client::new(super::port(&board), &NEVER, note);
    let mut session = Session::begin(client, Default::default()).unwrap();
    assert!(NOTES.lock().unwrap().iter().any(|line| line.contains("their limits are active")), "{:?}", NOTES.lock().unwrap());
    let shown = shown_settings(&mut session);
    assert!(shown.contains("(not active as set)"), "{shown}");
}

/// Stores parameters in a flash, like an image with other built-in values.
fn leave(flash: &mut Flash, parameters: &[(u8, f32)]) {
    let mut settings = Settings::new(flash.clone()).unwrap();
    settings.store(&Record { parameters: parameters.iter().copied().collect(), ..Record::default() }).unwrap();
    *flash = settings.release();
}

#[test]
fn conflicting_settings_are_not_stored() {
    let board = board("lock", &[], 0);
    let mut session = session(&board);
    let said = run("settings set limits.voltage_v 0.5\nsettings store", &mut session).unwrap_err().to_string();
    assert!(said.contains("nothing is stored: drive.") && said.contains("conflicts with the other values"), "{said}");
    run("reset\nsettings get limits.voltage_v\nexpect acts > 10\nexpect kept = nothing", &mut session).unwrap();
}

#[test]
fn unreadable_settings_are_reported_and_prevent_a_drive() {
    let board = board("lock", &[], 4);
    board.borrow_mut().power_cycle(|flash| {
        leave(flash, &[(8, 5.0), (5, 1.0), (7, 1.0)]);
        [1, 3].into_iter().for_each(|page| flash.damage(page * PAGE_BYTES / WORD_BYTES + 2, Damage::Unreadable));
    });
    let mut session = session(&board);
    for order in ["lock", "scan", "calibrate", "drive"] {
        let said = run(order, &mut session).unwrap_err().to_string();
        assert!(said.contains("a stored limit may be inactive") && said.contains("settings clear"), "{said}");
    }
    run("settings get limits.voltage_v\nexpect kept = damaged\nsettings clear\nreset\nlock\nstop", &mut session).unwrap();
    // A single damaged copy is reported, together with the number of stores.
    board.borrow_mut().power_cycle(|flash| {
        leave(flash, &[(8, 14.0)]);
        flash.damage(PAGE_BYTES / WORD_BYTES + 2, Damage::Unreadable);
    });
    let mut session = super::session(&board);
    run("settings get limits.voltage_v\nexpect acts = 14\nexpect kept = one_copy\nlock\nstop", &mut session).unwrap();
    let shown = shown_settings(&mut session);
    assert!(shown.contains("one of the two copies") && shown.contains("settings were stored"), "{shown}");
}

/// Returns the output of `settings get`.
fn shown_settings(session: &mut Session) -> String {
    settings::run(&SettingsOrder::Get { name: None }, session).unwrap().text
}

#[test]
fn refusals_state_the_permitted_values() {
    let too_much = refused("settings set limits.voltage_v 1000");
    assert!(too_much.contains("limits.voltage_v must be 0.001 to 15.466, not 1000"), "{too_much}");
    let unknown = refused("settings set limits.volt 3");
    assert!(unknown.contains("there is no setting `limits.volt`; did you mean `limits.voltage_v`?"), "{unknown}");
    let idle = refused("settings set friction.speed_m_per_s 0.05");
    assert!(idle.contains("friction.speed_m_per_s has no effect without friction.enabled: set that first"), "{idle}");
    let no_number = refused("settings set limits.voltage_v nan");
    assert!(no_number.contains("limits.voltage_v must be"), "{no_number}");
    let lane = refused("capture --lane 3");
    assert!(lane.contains("the board refuses `capture arm`: a number in it is beyond its range"), "{lane}");
    let silent = refused("burst --on");
    assert!(silent.contains("`lock` or `drive` first"), "{silent}");
    let folder = refused("capture -o /proc/none");
    assert!(folder.contains("cannot write `/proc/none`"), "{folder}");
}
