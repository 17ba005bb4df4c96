//! Option bytes: detection of wrong values.

use nucleo_g474re::options::{NAMES, mismatches, names};

/// FLASH_OPTR and FLASH_WRP1AR as delivered.
const DELIVERED: (u32, u32) = (0xffef_f8aa, 0xff80_ffff);
/// FLASH_OPTR and FLASH_WRP1AR as a board requires them.
const REQUIRED: (u32, u32) = (0xfbef_fcbb, 0xff87_ff80);

fn wrong((options, protected): (u32, u32)) -> Vec<&'static str> {
    names(mismatches(options, protected, true)).collect()
}

#[test]
fn wrong_option_bytes_as_delivered_are_named() {
    assert_eq!(wrong(DELIVERED), ["BOR_LEV", "nSWBOOT0 and nBOOT0", "RDP", "WRP1A"]);
    assert_eq!(wrong(REQUIRED), [""; 0]);
    // Without a first stage, write protection is not required.
    assert_eq!(mismatches(REQUIRED.0, DELIVERED.1, false), 0);
}

#[test]
fn each_option_is_named_alone() {
    let changed = |bits: u32| (REQUIRED.0 ^ bits, REQUIRED.1);
    let cases = [
        (changed(1 << 8), "BOR_LEV"),
        (changed(1 << 22), "DBANK"),
        (changed(1 << 20), "BFB2"),
        (changed(1 << 26), "nSWBOOT0 and nBOOT0"),
        (changed(1 << 27), "nSWBOOT0 and nBOOT0"),
        (changed(0xaa ^ 0xbb), "RDP"),
        // Protection of the pages 0 to 6, and of the pages 1 to 7.
        ((REQUIRED.0, 0xff86_ff80), "WRP1A"),
        ((REQUIRED.0, 0xff87_ff81), "WRP1A"),
        (changed(1 << 24), "SRAM_PE"),
        (changed(1 << 16), "IWDG_SW, IWDG_STOP, IWDG_STDBY"),
        (changed(1 << 18), "IWDG_SW, IWDG_STOP, IWDG_STDBY"),
    ];
    for (value, name) in cases {
        assert_eq!(wrong(value), [name], "{value:x?}");
    }
    assert!(NAMES.iter().all(|name| cases.iter().any(|(_, named)| named == name)), "every name must be tested");
    // RDP level 2 is also accepted.
    assert_eq!(wrong(changed(0xcc ^ 0xbb)), [""; 0]);
}

#[test]
fn docs_list_each_option() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/board.md")).expect("the page");
    for name in NAMES.iter().flat_map(|names| names.split(", ").flat_map(|names| names.split(" and "))) {
        assert!(page.contains(&format!("`{name}`")), "{name}");
    }
}
