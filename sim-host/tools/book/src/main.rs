//! The documentation as a book, by mdBook: the pages of `docs` in the order of `docs/SUMMARY.md`,
//! with typeset equations. Links out of the book lead to the repository. Everything is in the
//! folder: it opens from a disk, without a server or a network.

mod links;
mod math;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use clap::Parser;
use mdbook_driver::MDBook;
use mdbook_preprocessor::book::{Book, BookItem};
use mdbook_preprocessor::{Preprocessor, PreprocessorContext};

/// Build the book
#[derive(Parser)]
struct Arguments {
    /// Folder of the book
    #[arg(short, long, default_value = "out/book")]
    output: PathBuf,
}

/// Processing of each page before mdBook renders it.
struct Pages;

impl Preprocessor for Pages {
    fn name(&self) -> &str {
        "pages"
    }

    fn run(&self, context: &PreprocessorContext, mut book: Book) -> anyhow::Result<Book> {
        let repository = env!("CARGO_PKG_REPOSITORY");
        let mut failed = None;
        book.for_each_mut(|item| {
            let BookItem::Chapter(chapter) = item else { return };
            let folder = chapter.path.as_deref().and_then(Path::parent).unwrap_or(Path::new("")).to_owned();
            let text = math::typeset(&chapter.content);
            let text = text.map(|text| links::out_of_the_book(&text, &context.root, &folder, repository));
            match text {
                Ok(text) => chapter.content = text,
                Err(error) => failed = Some(error.context(format!("the page {}", chapter.name))),
            }
        });
        failed.map_or(Ok(book), Err)
    }
}

/// Returns the folder `docs` of the repository.
fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../docs")
}

/// Builds the book into a folder.
fn build(output: &Path) -> anyhow::Result<()> {
    let mut book = MDBook::load(docs())?;
    book.config.build.build_dir = output.to_owned();
    book.with_preprocessor(Pages);
    book.build()
}

fn main() -> anyhow::Result<()> {
    let Arguments { output } = Arguments::parse();
    let output = std::path::absolute(output)?;
    build(&output)?;
    println!("{}", output.join("index.html").display());
    Ok(())
}
