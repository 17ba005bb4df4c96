//! Settings over the link: what is out of range is told with its range, and what is stored acts after a reset.

use super::{board, run, session};

fn refused(line: &str) -> String {
    let board = board("lock", &[], 0);
    run(line, &mut session(&board)).unwrap_err().to_string()
}

#[test]
fn what_is_stored_acts_after_a_reset_and_limits_the_drive() {
    let board = board("lock", &[], 0);
    let text = "settings set limits.voltage_v 2\nsettings set drive.amplitude_v 1.5\nsettings set drive.scan_volts 1\n\
        settings get limits.voltage_v\nexpect acts > 10\nexpect set = 2\nexpect kept = changed\n\
        settings store\nreset\nexpect last_start = \"reset by order\"\nsettings get limits.voltage_v\nexpect acts = 2\nexpect kept = stored\n\
        drive --volts 9\nstatus\nexpect limit = 96\nexpect drive_v <= 2\nstop\nwait 0.01\n\
        settings defaults\nsettings store\nreset\nsettings get limits.voltage_v\nexpect acts > 10\n";
    run(text, &mut session(&board)).unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn what_cannot_be_set_says_what_can() {
    let too_much = refused("settings set limits.voltage_v 1000");
    assert!(too_much.contains("limits.voltage_v can be 0.001 to 15.466, not 1000"), "{too_much}");
    let unknown = refused("settings set limits.volt 3");
    assert!(unknown.contains("there is no setting `limits.volt`; did you mean `limits.voltage_v`?"), "{unknown}");
    let no_number = refused("settings set limits.voltage_v nan");
    assert!(no_number.contains("limits.voltage_v can be"), "{no_number}");
    let lane = refused("capture --lane 3");
    assert!(lane.contains("the board refuses `capture arm`: a number in it is beyond its range"), "{lane}");
    let silent = refused("burst --on");
    assert!(silent.contains("`lock` or `drive` first"), "{silent}");
    let folder = refused("capture -o /proc/none");
    assert!(folder.contains("cannot write /proc/none"), "{folder}");
}
