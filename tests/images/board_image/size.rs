//! Size of the image: the sections of its ELF file, compared with budgets.
//!
//!     cargo test -p image-scenarios size -- --nocapture
//!
//! prints the tables of docs/board.md. The test is skipped, with a message, if the target's core
//! library is not installed. In continuous integration (`CI=true`) this is a failure, unless
//! `SONOGLIDE_PIL_UNAVAILABLE` is set, which means that the installation has failed.

use std::collections::BTreeMap;
use std::env;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Mutex, PoisonError};

use firmware::board::command::{Command as Order, Verb};
use firmware::seam::config::keys;
use firmware::seam::refusal::Refusal;
use link::link_error::LinkError;
use object::{Object as _, ObjectSection as _, ObjectSymbol as _, SectionFlags, SectionKind, elf};

use crate::flashed_image::{connected, powered};

const TARGET: &str = "thumbv7em-none-eabihf";
const WORKSPACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Flash budget of the image, bytes: the first bank of 256 KiB minus a loader of 16 KiB. The second
/// bank has the settings.
const FLASH_BUDGET: u64 = 240 << 10;
/// Flash target of the image, bytes.
const FLASH_TARGET: u64 = 200 << 10;
/// Budget of static RAM, bytes.
const RAM_BUDGET: u64 = 29 << 10;
/// Budget of core-coupled RAM, bytes.
const CCMRAM_BUDGET: u64 = 32 << 10;

/// Profile of `cargo fw`.
const PROFILE: &str = "board";

/// Number of listed symbols.
const LISTED_SYMBOLS: usize = 10;

/// Builds the image with these arguments of `cargo fw`. Returns `None` if it cannot be built, after
/// a message.
pub fn image(options: &[&str]) -> Option<Vec<u8>> {
    let asked = run("RUSTC", "rustc", &["--print", "target-libdir", "--target", TARGET]);
    let folder = String::from_utf8_lossy(&asked.stdout).trim().to_owned();
    if !asked.status.success() || !Path::new(&folder).is_dir() {
        let in_ci = env::var("CI").is_ok_and(|ci| ci == "true");
        let excused = env::var_os("SONOGLIDE_PIL_UNAVAILABLE").is_some();
        assert!(!in_ci || excused, "no thumb target in continuous integration");
        let text = format!("\nSKIPPED, size of the board's image: install the target with `rustup target add {TARGET}`\n");
        std::io::stderr().write_all(text.as_bytes()).expect("standard error");
        return None;
    }
    // A separate target directory, so that it does not wait for other builds.
    let target = env::var_os("CARGO_TARGET_DIR").map_or_else(|| Path::new(WORKSPACE).join("target"), PathBuf::from).join("fw");
    // One build at a time, because all write to the same file.
    static ONE: Mutex<()> = Mutex::new(());
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let target_dir = target.to_string_lossy();
    let arguments = [&["fw", "--quiet", "--locked", "--target-dir", &target_dir], options].concat();
    let built = run("CARGO", "cargo", &arguments);
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    Some(std::fs::read(target.join(TARGET).join(PROFILE).join("nucleo-g474re")).expect("the image"))
}

fn run(variable: &str, name: &str, arguments: &[&str]) -> Output {
    let mut command = Command::new(env::var_os(variable).unwrap_or_else(|| name.into()));
    for inherited in ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_RUSTFLAGS", "CARGO_BUILD_TARGET"] {
        command.env_remove(inherited);
    }
    command.current_dir(WORKSPACE).args(arguments).output().expect("the toolchain")
}

/// Section that takes memory: name, address, size, and `true` if its contents are stored in the
/// flash.
struct Section {
    name: String,
    address: u64,
    size: u64,
    loaded: bool,
}

/// Memory use of an image, bytes.
struct MemoryUse {
    flash: u64,
    ram: u64,
    ccmram: u64,
}

impl MemoryUse {
    fn by(sections: &[Section]) -> Self {
        let sum = |counts: &dyn Fn(&Section) -> bool| {
            sections.iter().filter(|section| counts(section)).map(|section| section.size).sum::<u64>()
        };
        MemoryUse {
            flash: sum(&|section| section.loaded),
            ram: sum(&|section| section.address >> 24 == 0x20),
            ccmram: sum(&|section| section.address >> 24 == 0x10),
        }
    }
}

fn sections(file: &object::File) -> Vec<Section> {
    let allocated = |section: &object::Section| match section.flags() {
        SectionFlags::Elf { sh_flags, .. } => (sh_flags & elf::SHF_ALLOC).0 != 0,
        _ => false,
    };
    let taken = file.sections().filter(|section| allocated(section) && section.size() > 0);
    taken
        .map(|section| Section {
            name: section.name().expect("a name").to_owned(),
            address: section.address(),
            size: section.size(),
            loaded: section.kind() != SectionKind::UninitializedData,
        })
        .collect()
}

#[test]
fn docs_of_the_size_within_its_budgets() {
    let Some(bytes) = image(&[]) else { return };
    let file = object::File::parse(&*bytes).expect("an ELF file");
    let sections = sections(&file);
    println!("| section | address | bytes | |\n|---|---|---|---|");
    for Section { name, address, size, loaded } in &sections {
        let place = match address >> 24 {
            0x08 => "flash",
            0x10 => "core-coupled RAM, loaded from flash",
            0x20 if *loaded => "RAM, loaded from flash",
            _ => "RAM",
        };
        println!("| `{name}` | {address:#010x} | {size} | {place} |");
    }
    let MemoryUse { flash, ram, ccmram } = MemoryUse::by(&sections);
    // In KiB: the names of files in panics depend on the folder of the dependencies.
    let mut table = "| memory | used, KiB | budget | target |\n|---|---|---|---|\n".to_owned();
    let rows = [
        ("flash", flash, FLASH_BUDGET, FLASH_TARGET),
        ("static RAM", ram, RAM_BUDGET, RAM_BUDGET),
        ("core-coupled RAM", ccmram, CCMRAM_BUDGET, CCMRAM_BUDGET),
    ];
    for (memory, taken, budget, aim) in rows {
        let met = if taken <= aim { "met" } else { "missed" };
        table += &format!("| {memory} | {} | {} | {}: {met} |\n", taken.div_ceil(1 << 10), budget >> 10, aim >> 10);
    }
    report::docs::block("board.md", "cargo test -p image-scenarios docs_of_the_size", &table);
    largest(&file);
    by_part(&file);
    assert!(
        sections.iter().any(|section| section.name == ".ccmram") && ccmram > 0,
        "the hot code is not in the core-coupled RAM"
    );
    assert!(ram <= RAM_BUDGET && ccmram <= CCMRAM_BUDGET, "{ram} {ccmram}");
    assert!(flash <= FLASH_BUDGET, "{flash}");
}

/// Parts that a smaller image leaves out are not linked; each saves more than 4 KiB.
#[test]
fn parts_that_are_left_out_take_no_flash() {
    let options: [&[&str]; 4] = [
        &[],
        &["--no-default-features", "--features", "waveforms"],
        &["--no-default-features", "--features", "friction"],
        &["--no-default-features"],
    ];
    let (mut sizes, mut smallest) = (Vec::new(), Vec::new());
    println!("\n| `cargo fw …` | flash |\n|---|---|");
    for options in options {
        let Some(bytes) = image(options) else { return };
        let taken = MemoryUse::by(&sections(&object::File::parse(&*bytes).expect("an ELF file")));
        println!("| `{}` | {} |", options.join(" "), taken.flash);
        sizes.push(taken.flash);
        smallest = bytes;
    }
    // Parameters of parts that are left out are refused, on the model of the microcontroller.
    let (_board, mut client) = connected(powered(&smallest, &[]));
    client.connect().expect("an answer");
    for key in [keys::SHAPE, keys::SWEEP_TIME, keys::FRICTION_ENABLED] {
        let refused = client.order(Order::Settings(Verb::Set(key, 1.0)));
        assert!(matches!(refused, Err(LinkError::Refused { refusal: Refusal::LeftOut, .. })), "{key}: {refused:?}");
    }
    assert!(sizes.is_sorted_by(|larger, smaller| larger > &(smaller + 4096)), "{sizes:?}");
}

/// Prints the largest symbols in RAM.
fn largest(file: &object::File) {
    println!("\n| in RAM | bytes |\n|---|---|");
    for (size, name) in symbols(file, &[0x20]).into_iter().take(LISTED_SYMBOLS) {
        println!("| `{name}` | {size} |");
    }
}

/// Prints the largest parts of the flash: modules of the controller, and other packages.
fn by_part(file: &object::File) {
    let mut parts = BTreeMap::<String, u64>::new();
    for (size, name) in symbols(file, &[0x08, 0x10]) {
        // A method of a trait counts for its type: `_$LT$firmware..a..B$u20$as$u20$…`.
        let name = name.strip_prefix("_$LT$").map_or(name.clone(), |of| of.replace("..", "::"));
        let name = name.strip_prefix("sonoglide_").unwrap_or(&name);
        let depth = if name.starts_with("firmware::") { 2 } else { 1 };
        *parts.entry(name.split("::").take(depth).collect::<Vec<_>>().join("::")).or_default() += size;
    }
    let mut parts: Vec<_> = parts.into_iter().map(|(part, size)| (size, part)).collect();
    parts.sort_by(|a, b| b.cmp(a));
    println!("\n| in flash and core-coupled RAM, code and named tables | bytes |\n|---|---|");
    for (size, part) in parts.into_iter().take(LISTED_SYMBOLS) {
        println!("| `{part}` | {size} |");
    }
}

/// Returns sizes and names of the symbols in these memories, the largest first.
fn symbols(file: &object::File, memories: &[u64]) -> Vec<(u64, String)> {
    let there = file.symbols().filter(|symbol| memories.contains(&(symbol.address() >> 24)) && symbol.size() > 0);
    let mut symbols: Vec<_> = there.map(|symbol| (symbol.size(), symbol.name().map_or_else(|_| "?".to_owned(), plain))).collect();
    symbols.sort_by(|a, b| b.cmp(a));
    symbols
}

/// Removes the hash from a mangled name: the parts of `_ZN8firmware10controller...17h0123E`, each
/// preceded by its length.
fn plain(mangled: &str) -> String {
    let Some(mut rest) = mangled.strip_prefix("_ZN") else { return mangled.to_owned() };
    let mut parts = Vec::new();
    while let Some(digits) = rest.find(|c: char| !c.is_ascii_digit()).filter(|&digits| digits > 0) {
        let Ok(length) = rest[..digits].parse::<usize>() else { break };
        let Some(part) = rest.get(digits..digits + length) else { break };
        parts.push(part);
        rest = &rest[digits + length..];
    }
    if parts.last().is_some_and(|last| last.len() == 17 && last.starts_with('h')) {
        parts.pop();
    }
    parts.join("::").replace("_$u7b$$u7b$", "{").replace("$u7d$$u7d$", "}")
}
