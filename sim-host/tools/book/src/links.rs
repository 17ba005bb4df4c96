//! Links out of the book, to files of the repository that are not part of the book.

use std::path::{Component, Path, PathBuf};

/// Rewrites the links of a page in `folder`, a folder of the book: those to files outside `docs`
/// lead to the repository.
pub fn out_of_the_book(page: &str, docs: &Path, folder: &Path, repository: &str) -> String {
    let mut out = String::with_capacity(page.len());
    let mut rest = page;
    while let Some((before, after)) = rest.split_once("](../") {
        let (target, next) = after.split_once(')').unwrap_or((after, ""));
        let (file, anchor) = target.split_once('#').map_or((target, String::new()), |(file, at)| (file, format!("#{at}")));
        out += before;
        out += &match outside(&folder.join("..").join(file)) {
            None => format!("](../{target})"),
            Some(file) => {
                let kind = if docs.join("..").join(&file).is_dir() { "tree" } else { "blob" };
                format!("]({repository}/{kind}/main/{}{anchor})", file.display())
            }
        };
        rest = next;
    }
    out + rest
}

/// Returns the path from the root of the repository if this one, relative to `docs`, is outside
/// `docs`.
fn outside(path: &Path) -> Option<PathBuf> {
    let mut found = PathBuf::from("docs");
    for component in path.components() {
        match component {
            Component::ParentDir => drop(found.pop()),
            component => found.push(component),
        }
    }
    (!found.starts_with("docs")).then_some(found)
}
