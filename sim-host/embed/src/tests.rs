//! The header in `include` is that of the code; C callers get failures with a text.

use std::ffi::CStr;
use std::{fs, ptr};

use crate::controller::{sonoglide_controller_free, sonoglide_controller_new, sonoglide_controller_process};
use crate::failure::sonoglide_failure;

fn failure() -> String {
    // SAFETY: the text ends with a zero byte, and no other call follows meanwhile.
    unsafe { CStr::from_ptr(sonoglide_failure()) }.to_string_lossy().into_owned()
}

#[test]
fn the_header_is_that_of_the_code() {
    let root = env!("CARGO_MANIFEST_DIR");
    let config = cbindgen::Config::from_root_or_default(root);
    let builder = ["failure", "controller", "plant"]
        .iter()
        .fold(cbindgen::Builder::new().with_config(config), |builder, name| builder.with_src(format!("{root}/src/{name}.rs")));
    let mut header = Vec::new();
    builder.generate().unwrap().write(&mut header);
    let path = format!("{root}/include/sonoglide.h");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        fs::write(&path, &header).unwrap();
    }
    assert!(fs::read(&path).is_ok_and(|present| present == header), "UPDATE_DOCS=1 cargo test -p sonoglide-embed");
}

#[test]
fn mistakes_have_a_text() {
    // SAFETY: texts end with a zero byte, and the others are null.
    unsafe {
        assert!(sonoglide_controller_new(c"no-such-scene".as_ptr(), ptr::null(), 0).is_null());
        assert!(failure().contains("no-such-scene"), "{}", failure());
        assert!(sonoglide_controller_new(c"contact".as_ptr(), ptr::null(), 0).is_null());
        assert!(failure().contains("no [controller]"), "{}", failure());
        assert!(sonoglide_controller_new(ptr::null(), ptr::null(), 0).is_null());
        assert!(failure().contains("a text is null"), "{}", failure());
        let change = c"controller.drive.amplitude_v=-1".as_ptr();
        assert!(sonoglide_controller_new(c"lock".as_ptr(), &change, 1).is_null());
        assert!(failure().contains("controller.drive.amplitude_v"), "{}", failure());
        let controller = sonoglide_controller_new(c"lock".as_ptr(), ptr::null(), 0);
        let none = ptr::null_mut();
        assert_eq!(sonoglide_controller_process(controller, ptr::null(), ptr::null(), ptr::null(), none, ptr::null_mut()), -1);
        assert!(failure().contains("an array is null"), "{}", failure());
        sonoglide_controller_free(controller);
    }
}
