//! The corpus: inputs that reach deep, one a file, in the folder of their target. A failure that was found stays here when it is gone.

/// Files of a folder of the corpus: name and text.
macro_rules! folder {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../corpus/", $name)))),*]
    };
}

/// A name, and a text.
pub(super) type File = (&'static str, &'static str);

/// Traffic to the board, as hexadecimal digits: after a plus a frame that an honest host sends, after a minus anything else; one line before each 200 blocks. The frames
/// have the session that a board gives the host of a bench before its first block.
pub(super) const LINK: &[File] = folder!["link/boundaries.txt", "link/drive-and-store.txt"];
/// Scenes, which are also mutated.
pub(super) const SCENES: &[File] = folder!["scenes/deep.toml", "scenes/empty-tables.toml", "scenes/huge-numbers.toml"];
/// Suites, which are also mutated.
pub(super) const SUITES: &[File] = folder!["suites/nothing-fits.toml", "suites/small.toml"];
/// Scripts of the link, which are also mutated.
pub(super) const SCRIPTS: &[File] = folder!["scripts/every-order.txt", "scripts/quotes.txt"];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::path::Path;

    #[test]
    fn every_file_of_the_folder_is_listed() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
        let mut there = BTreeSet::new();
        for target in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            for file in std::fs::read_dir(&target).unwrap().map(|entry| entry.unwrap().path()) {
                let [target, file] = [&target, &file].map(|path| path.file_name().unwrap().to_string_lossy().into_owned());
                there.insert(format!("{target}/{file}"));
            }
        }
        let listed = [LINK, SCENES, SUITES, SCRIPTS].concat();
        assert_eq!(listed.iter().map(|(name, _)| (*name).to_owned()).collect::<BTreeSet<_>>(), there);
    }
}
