//! Assembly of the parts into one HTML file.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use lzma_rust2::{LzmaOptions, LzmaWriter};

use crate::compile::Core;

/// Parts of the page.
pub struct Parts<'a> {
    /// Folder of the package `sonoglide-web`.
    pub web: &'a Path,
    /// The simulator.
    pub core: &'a Core,
}

/// Modules of the page, each after those that it imports.
const MODULES: [&str; 22] = [
    "format.js",
    "dom.js",
    "lzma.js",
    "core.js",
    "request.js",
    "controls.js",
    "path.js",
    "curve.js",
    "scope.js",
    "live.js",
    "figures.js",
    "motor.js",
    "crash.js",
    "files.js",
    "board/connection.js",
    "board/recorder.js",
    "board/settings.js",
    "board/tabs.js",
    "board/live-view.js",
    "board/bursts.js",
    "board/board.js",
    "main.js",
];
const STYLES: [&str; 5] =
    ["../../report/assets/uPlot.min.css", "../../report/assets/crash.css", "page.css", "result.css", "board/board.css"];

/// Compresses as a server would.
pub fn gzip(bytes: &[u8]) -> Result<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes)?;
    Ok(encoder.finish()?)
}

/// Preset of LZMA with the smallest result.
const LZMA_PRESET: u32 = 9;

/// Packs the module to two thirds of the size by gzip; `page/lzma.js` unpacks it.
fn lzma(bytes: &[u8]) -> Result<Vec<u8>> {
    // Instructions have no fixed length, so that bits of the position predict nothing.
    let options = LzmaOptions { lc: 4, pb: 0, nice_len: LzmaOptions::NICE_LEN_MAX, ..LzmaOptions::with_preset(LZMA_PRESET) };
    let mut encoder = LzmaWriter::new_use_header(Vec::new(), &options, Some(bytes.len() as u64))?;
    encoder.write_all(bytes)?;
    Ok(encoder.finish()?)
}

/// Returns the page with everything in it.
pub fn page(parts: &Parts) -> Result<String> {
    let read = |name: &str| {
        let path = parts.web.join("page").join(name);
        fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))
    };
    let styles = STYLES.iter().map(|name| read(name)).collect::<Result<Vec<_>>>()?.concat();
    let script_of = |name: &str| Ok::<_, anyhow::Error>(module(&read(name)?));
    let modules = MODULES.iter().map(|name| script_of(name)).collect::<Result<Vec<_>>>()?.concat();
    let library =
        format!("/*\n{}*/\n{}", read("../../report/assets/uPlot.LICENSE")?, read("../../report/assets/uPlot.iife.min.js")?);
    let plots = [library, script_of("../../report/assets/report.js")?, script_of("../../report/assets/crash.js")?].join("\n");
    let worker = [parts.core.glue.clone(), script_of("worker.js")?, script_of("board/link-worker.js")?].join("\n");
    let firmware = &parts.core.firmware;
    let firmware = if firmware.is_empty() { String::new() } else { STANDARD.encode(lzma(firmware)?) };
    let mut page = read("index.html")?;
    for (mark, text) in [
        ("<!-- board -->\n", &read("board/board.html")?),
        ("/* style */", &styles),
        ("/* plots */", &script(&plots)),
        ("/* worker */", &script(&worker)),
        ("/* hosts */", &script(parts.core.hosts.trim())),
        ("/* wasm */", &STANDARD.encode(lzma(&parts.core.wasm)?)),
        ("/* firmware */", &firmware),
        ("/* page */", &script(&modules)),
        ("/* commit */", &commit()),
    ] {
        ensure!(page.matches(mark).count() == 1, "index.html must contain `{mark}` exactly once");
        page = page.replacen(mark, text, 1);
    }
    Ok(page)
}

/// Converts a module to a part of the single script of the page, in which exported names are
/// global. Lines of comments and indentation, 8 kB gzipped, are left out; so no literal may have
/// several lines.
fn module(text: &str) -> String {
    let is_kept = |line: &&str| !["import ", "//", "/**"].iter().any(|start| line.starts_with(start));
    let kept = text.lines().map(str::trim_start).filter(is_kept);
    kept.map(|line| line.strip_prefix("export ").unwrap_or(line)).flat_map(|line| [line, "\n"]).collect()
}

/// Escapes a text so that it cannot end its script element.
fn script(text: &str) -> String {
    text.replace("</script", "<\\/script").replace("<!--", "<\\!--")
}

/// Returns the commit that the page is packed from, with `+` if files were changed; empty outside a
/// checkout.
fn commit() -> String {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").arg("-C").arg(env!("CARGO_MANIFEST_DIR")).args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let changed = git(&["status", "--porcelain", "--untracked-files=no"]).is_some_and(|changes| !changes.is_empty());
    git(&["rev-parse", "--short=12", "HEAD"]).map(|commit| if changed { commit + "+" } else { commit }).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_become_one_script() {
        assert_eq!(module("import { a } from \"./a.js\";\n/** B. */\nexport const b =\n  // A.\n  a;\n"), "const b =\na;\n");
        assert_eq!(script("x = \"</script><!--\""), "x = \"<\\/script><\\!--\"");
    }
}
