//! Blocks of the documentation that commands write: each stands in its page between two marks that name the command,
//!
//! ```text
//! <!-- begin: evidence tracking -->
//! ...
//! <!-- end -->
//! ```
//!
//! and a test with `docs` in its name compares it with the output of the command. `UPDATE_DOCS=1 cargo test docs -- --include-ignored` regenerates
//! them; those of the evidence and of thumb images with `-p sonoglide-evidence -p image-scenarios`.

use std::fs;
use std::path::{Path, PathBuf};

/// Whether pages are to be written, rather than compared.
pub fn is_update() -> bool {
    std::env::var_os("UPDATE_DOCS").is_some()
}

/// A file in the folder of the documentation.
pub fn path(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(file)
}

/// Compares the block of `command` in a page with what the command prints, or writes it.
///
/// # Panics
/// If the page lacks the block, or has another text in it.
pub fn block(page: &str, command: &str, text: &str) {
    let found = fs::read_to_string(path(page)).unwrap_or_else(|error| panic!("docs/{page}: {error}"));
    let expected = spliced(&found, command, text).unwrap_or_else(|| panic!("docs/{page} has no block of `{command}`"));
    compare(page, &found, &expected);
}

/// Compares a page that is generated as a whole, or writes it.
///
/// # Panics
/// If the page says something else.
pub fn page(page: &str, text: &str) {
    compare(page, &fs::read_to_string(path(page)).unwrap_or_default(), text);
}

fn compare(page: &str, found: &str, expected: &str) {
    if found == expected {
        return;
    }
    if is_update() {
        fs::write(path(page), expected).unwrap_or_else(|error| panic!("docs/{page}: {error}"));
        return;
    }
    let differ = found.lines().zip(expected.lines()).find(|(found, expected)| found != expected);
    let (found, expected) = differ.unwrap_or(("an end", "another end"));
    panic!(
        "docs/{page} differs from its command: it has\n  {found}\nin place of\n  {expected}\nrun `UPDATE_DOCS=1 cargo test docs -- --include-ignored`, with `-p sonoglide-evidence -p image-scenarios` for their pages"
    );
}

/// The page with another text in a block.
fn spliced(page: &str, command: &str, text: &str) -> Option<String> {
    let begin = format!("<!-- begin: {command} -->\n");
    let (head, rest) = page.split_once(&begin)?;
    let (_, tail) = rest.split_once("<!-- end -->")?;
    Some(format!("{head}{begin}\n{}\n\n<!-- end -->{tail}", text.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_is_replaced_and_nothing_else() {
        let page = "a\n<!-- begin: x -->\n\nold\n\n<!-- end -->\nb\n<!-- begin: y -->\n<!-- end -->\n";
        let spliced = |command: &str| spliced(page, command, "new\n");
        assert_eq!(spliced("x").unwrap(), page.replace("old", "new"));
        assert_eq!(spliced("y").unwrap(), page.replace("y -->\n<!-- end", "y -->\n\nnew\n\n<!-- end"));
        assert_eq!(spliced("z"), None);
    }
}
