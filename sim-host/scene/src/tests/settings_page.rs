//! The page of settings is what the settings say.

use std::path::Path;

use crate::settings_page::page;

/// `UPDATE_DOCS=1 cargo test -p sonoglide-scene settings_page` writes the page anew.
#[test]
fn the_page_of_settings_is_generated_from_them() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/settings.md");
    let expected = page();
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, expected).expect("the page can be written");
        return;
    }
    let found = std::fs::read_to_string(&path).expect("the page is there");
    assert!(found == expected, "docs/settings.md says something else than the settings; run with UPDATE_DOCS=1");
}
