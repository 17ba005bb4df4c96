//! Tests that the book is complete: it contains every page, every link has a target, and nothing is
//! fetched.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::{build, docs, links, math};

/// Files of `docs` that are not pages.
const NO_PAGE: [&str; 1] = ["SUMMARY.md"];

#[test]
fn equations_become_mathml() {
    let page = math::typeset("one $`x^2`$ and\n\n```math\nE = m c^2\n```\n\n```sh\necho $`date`$\n```\n").expect("LaTeX");
    assert!(
        page.contains("<msup><mi>x</mi><mn>2</mn></msup>") && page.contains("<div class=\"equation\"><math display=\"block\">")
    );
    assert!(page.contains("echo $`date`$"), "code is unchanged: {page}");
    for (wrong, says) in [("$`\\frac{1}`$", "\\frac"), ("$`x", "no end")] {
        let error = math::typeset(wrong).expect_err(wrong);
        assert!(format!("{error:#}").contains(says), "{error:#}");
    }
}

#[test]
fn links_out_of_the_book_lead_to_the_repository() {
    let of = |page: &str, folder: &str| links::out_of_the_book(page, &docs(), Path::new(folder), "R");
    let page = of("[a](../README.md#run-it), [b](../firmware), [c](board.md)", "");
    assert_eq!(page, "[a](R/blob/main/README.md#run-it), [b](R/tree/main/firmware), [c](board.md)");
    assert_eq!(of("[a](../../memory.x), [b](../board.md#pins)", "evidence"), "[a](R/blob/main/memory.x), [b](../board.md#pins)");
}

#[test]
fn every_page_is_in_the_book() {
    let summary = fs::read_to_string(docs().join("SUMMARY.md")).expect("the summary");
    let folders = [("", docs()), ("evidence/", docs().join("evidence"))];
    let names = folders.iter().flat_map(|(folder, path)| {
        let entries = fs::read_dir(path).expect("docs").map(|entry| entry.expect("a page").file_name());
        entries.map(move |name| format!("{folder}{}", name.to_string_lossy()))
    });
    let missing: Vec<String> = names
        .filter(|name| name.ends_with(".md") && !NO_PAGE.contains(&name.as_str()))
        .filter(|name| !summary.contains(&format!("({name})")))
        .collect();
    assert!(missing.is_empty(), "docs/SUMMARY.md does not list {missing:?}");
}

#[test]
fn links_have_targets_and_nothing_is_fetched() {
    let output = std::env::temp_dir().join(format!("sonoglide-book-{}", std::process::id()));
    build(&output).expect("the book is built");
    let pages = [html(&output), html(&output.join("evidence"))].concat();
    let wrong: Vec<String> = pages.iter().flat_map(|page| wrong(page)).collect();
    fs::remove_dir_all(&output).expect("the folder is removed");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Returns the pages of a built book.
fn html(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    // mdBook shows this page for any unknown address; its links are relative to the root of a
    // server.
    entries.filter(|path| path.extension().is_some_and(|end| end == "html") && !path.ends_with("404.html")).collect()
}

/// Returns the broken links of a page, and the resources that it fetches from elsewhere.
fn wrong(page: &Path) -> Vec<String> {
    let text = fs::read_to_string(page).expect("a page");
    let folder = page.parent().expect("a folder");
    let mut wrong = Vec::new();
    for (attribute, target) in values(&text, "href").map(|to| ("href", to)).chain(values(&text, "src").map(|to| ("src", to))) {
        let elsewhere = target.contains("://") || target.starts_with("mailto:");
        if elsewhere && attribute == "src" {
            wrong.push(format!("{}: fetches {target}", page.display()));
        }
        if elsewhere || target.is_empty() {
            continue;
        }
        let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
        let there = if file.is_empty() { page.to_owned() } else { folder.join(file) };
        let found = there.exists() && (anchor.is_empty() || ids(&there).contains(anchor));
        if !found {
            wrong.push(format!("{}: broken link: {target}", page.display()));
        }
    }
    wrong
}

/// Returns the values of an attribute.
fn values<'a>(text: &'a str, attribute: &str) -> impl Iterator<Item = &'a str> {
    let opens = format!(" {attribute}=\"");
    text.match_indices(&opens)
        .map(|(at, _)| at + opens.len())
        .collect::<Vec<_>>()
        .into_iter()
        .filter_map(|at| text[at..].split('"').next())
}

fn ids(page: &Path) -> BTreeSet<String> {
    let text = fs::read_to_string(page).unwrap_or_default();
    values(&text, "id").map(str::to_owned).collect()
}
