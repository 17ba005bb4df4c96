//! The corpus: inputs that reach deep, one per file, in the folder of their target. The input of a
//! failure stays here after the fix.

/// Lists files of the corpus with their names and texts.
macro_rules! folder {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../corpus/", $name)))),*]
    };
}

/// Name and text of a file.
pub(super) type File = (&'static str, &'static str);

/// Traffic to the board, as hexadecimal digits; one line is sent before each 200 blocks. A line
/// with a plus is a valid frame of a host, a line with a minus anything else. The frames have the
/// session that a board gives the host of a bench before its first block.
pub(super) const LINK: &[File] = folder!["link/boundaries.txt", "link/drive-and-store.txt"];
/// Scenes; they are mutated too.
pub(super) const SCENES: &[File] = folder!["scenes/deep.toml", "scenes/empty-tables.toml", "scenes/huge-numbers.toml"];
/// Suites; they are mutated too.
pub(super) const SUITES: &[File] = folder!["suites/nothing-fits.toml", "suites/small.toml"];
/// Scripts of the link; they are mutated too.
pub(super) const SCRIPTS: &[File] = folder!["scripts/every-order.txt", "scripts/quotes.txt"];
/// Files of measured data that no generator writes; they are mutated too.
pub(super) const TABLES: &[(&str, &[u8])] = &[
    ("tables/labels.parquet", include_bytes!("../../corpus/tables/labels.parquet")),
    ("tables/one-row.csv", include_bytes!("../../corpus/tables/one-row.csv")),
];

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
        let texts = [LINK, SCENES, SUITES, SCRIPTS].concat();
        let listed = texts.iter().map(|(name, _)| *name).chain(TABLES.iter().map(|(name, _)| *name));
        assert_eq!(listed.map(str::to_owned).collect::<BTreeSet<_>>(), there);
    }
}
