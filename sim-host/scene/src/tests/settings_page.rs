//! The page of settings is what the settings say.

use crate::settings_page::page;

/// `UPDATE_DOCS=1 cargo test docs -- --include-ignored` regenerates the page.
#[test]
fn docs_of_the_settings_are_generated_from_them() {
    report::docs::page("settings.md", &page());
}
