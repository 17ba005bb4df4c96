//! The commit that the program is built from, where it is built in a checkout.

use std::path::Path;
use std::process::Command;

fn git(arguments: &[&str]) -> Option<String> {
    let folder = std::env::var("CARGO_MANIFEST_DIR").ok()?;
    let output = Command::new("git").arg("-C").arg(folder).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

/// The commit, if this package is one that the checkout has, and not one that was unpacked into
/// another.
fn commit() -> Option<String> {
    git(&["ls-files", "--error-unmatch", "build.rs"])?;
    let commit = git(&["rev-parse", "--short=12", "HEAD"])?;
    let changed = git(&["status", "--porcelain", "--untracked-files=no"]).is_some_and(|changes| !changes.is_empty());
    Some(if changed { format!("{commit}+") } else { commit })
}

fn main() {
    let version = env!("CARGO_PKG_VERSION");
    println!("cargo::rerun-if-changed=build.rs");
    // A commit moves the one or the other.
    let head = git(&["symbolic-ref", "--quiet", "HEAD"]).unwrap_or_else(|| "HEAD".to_owned());
    for file in ["HEAD", "index", &head] {
        if let Some(path) =
            git(&["rev-parse", "--path-format=absolute", "--git-path", file]).filter(|path| Path::new(path).exists())
        {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    match commit() {
        Some(commit) => {
            println!("cargo::rustc-env=SIM_HOST_COMMIT={commit}");
            println!("cargo::rustc-env=SIM_HOST_VERSION={version} ({commit})");
        }
        None => println!("cargo::rustc-env=SIM_HOST_VERSION={version}"),
    }
}
