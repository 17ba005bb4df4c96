//! Links that lead out of the book: to files of the repository, which the book does not hold.

use std::path::Path;

/// A page whose links to files outside of the folder of the book lead to the repository.
pub fn out_of_the_book(page: &str, docs: &Path, repository: &str) -> String {
    let mut out = String::with_capacity(page.len());
    let mut rest = page;
    while let Some((before, after)) = rest.split_once("](../") {
        let (target, next) = after.split_once(')').unwrap_or((after, ""));
        let file = target.split('#').next().unwrap_or(target);
        let kind = if docs.join("..").join(file).is_dir() { "tree" } else { "blob" };
        out += &format!("{before}]({repository}/{kind}/main/{target})");
        rest = next;
    }
    out + rest
}
