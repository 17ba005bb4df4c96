//! Functions of the flashed image that can panic: the callers of `core::panicking`, found by its
//! instructions, compared with the list of docs/evidence/panics.md.
//!
//! `UPDATE_DOCS=1 cargo test -p image-scenarios docs_name_every_panic` writes the list. The reasons
//! are in this file. The test fails if a function has no reason.

use std::collections::{BTreeMap, BTreeSet};

use super::branches::{Function, functions};
use super::size::image;

/// Interrupt of a block. The block path consists of all functions that it calls, and of all code in
/// the core-coupled RAM.
const BLOCK_INTERRUPT: &str = "DMA1_CHANNEL1";
/// Top byte of the addresses of the core-coupled RAM.
const CCMRAM_TOP_BYTE: u32 = 0x10;

/// Panicking functions, by parts of their names, and their cause in the list.
const PANIC_FUNCTIONS: [(&str, &str); 12] = [
    ("panicking::panic_bounds_check", "index"),
    ("slice::index::slice_index_fail", "range"),
    ("panic_const_div_by_zero", "division by zero"),
    ("panic_const_div_overflow", "division overflow"),
    ("panic_const", "arithmetic"),
    ("option::unwrap_failed", "unwrap"),
    ("option::expect_failed", "expect"),
    ("result::unwrap_failed", "unwrap"),
    ("len_mismatch_fail", "length"),
    ("panicking::assert_failed", "assert"),
    ("panicking::panic_fmt", "message"),
    ("panicking::panic", "unreachable"),
];

/// Functions, by the beginning of their names, and the reason why they never panic. The first match
/// counts.
const REASONS: [(&str, &str); 23] = [
    (
        "sequential_storage::",
        "the geometry of the flash: words and pages have constant sizes, and lengths are checked before a buffer is cut; \
         `evidence fuzz` tests damaged flash",
    ),
    ("<sonoglide_firmware::board::settings::", "words and pages of the flash have a constant size, and none is zero"),
    (
        "sonoglide_firmware::board::settings::",
        "the number of halves is two by its type; a record is shorter than its buffer by its type",
    ),
    ("core::slice::copy_from_slice_impl", "both sides are cut to the same length before"),
    (
        "nucleo_g474re::image::__cortex_m_rt_main",
        "the background task: it is started once; places in rings are remainders by the length; \
         a frame is cut by the length that `cobs` returns, which `evidence fuzz` tests",
    ),
    ("nucleo_g474re::image::build", "before the first block: constants of the board, which tests check on the host"),
    (
        "nucleo_g474re::image::",
        "before the first block: numbers of pins, channels and conversions are constants within the range of the register",
    ),
    ("DMA1_CHANNEL1", "numbers of pins are constants within the range of the register"),
    ("_defmt_", "the lock of the log is taken with interrupts masked, and released before they are enabled"),
    ("cobs::", "the length of the buffer is `max_encoding_length`"),
    ("sonoglide_firmware::board::app::outbox", "a frame is never longer than its buffer, by its type"),
    ("sonoglide_firmware::board::app::App", "the length of a ring is a constant above one"),
    ("sonoglide_firmware::board::block_task", "the length of a ring is a constant above one"),
    ("sonoglide_firmware::board::capture", "the length of a ring is a constant above one"),
    ("sonoglide_firmware::board::parameters", "places are those of the list of parameters"),
    ("sonoglide_firmware::generate::burst::Burst::build", "there are never more windows than the configuration has room for"),
    ("sonoglide_firmware::generate::burst::Burst::gate", "a configuration with a period of no samples is refused"),
    ("sonoglide_firmware::generate::shaper", "the largest code step is at least one"),
    (
        "sonoglide_firmware::generate::sweep::chirp",
        "the two legs have the indices 0 and 1; a configuration with a chirp of no blocks is refused",
    ),
    ("sonoglide_firmware::find::scan::modes::Modes::add", "a place is one of the list, or its end"),
    ("sonoglide_firmware::find::scan::modes::Modes::choose", "the list of deviations has room for all resonances"),
    ("sonoglide_firmware::find::scan::pass::Pass::offset_hz", "a pass has at least `FEWEST_BLOCKS` blocks"),
    ("sonoglide_firmware::controller::stages::clamped", "every tone has blocks"),
];

/// Returns the cause of a panic, if this function is a panicking function.
fn end(name: &str) -> Option<&'static str> {
    let begins = ["core::", "<core::", "_R"].iter().any(|begin| name.starts_with(begin));
    PANIC_FUNCTIONS.iter().find(|(part, _)| begins && name.contains(part)).map(|(_, said)| *said)
}

/// Returns the index of the reason why a function does not panic.
fn place(name: &str) -> Option<usize> {
    // A method of a trait counts for its type, a closure or an adapter for the function that
    // contains it.
    let begins = |(part, _): &(&str, _)| name.starts_with(part);
    REASONS.iter().position(begins).or_else(|| REASONS.iter().position(|(part, _)| name.contains(part.trim_start_matches('<'))))
}

/// Returns the reason why a function does not panic.
fn reason(name: &str) -> Option<&'static str> {
    place(name).map(|place| REASONS[place].1)
}

/// Returns the indices of the functions of the block path: those that the block interrupt reaches
/// by direct branches, and all code in the core-coupled RAM. Panicking functions are not followed.
fn block_path(functions: &[Function]) -> BTreeSet<usize> {
    let begins = |function: &Function| function.name == BLOCK_INTERRUPT || function.address >> 24 == CCMRAM_TOP_BYTE;
    let mut open: Vec<usize> = (0..functions.len()).filter(|&place| begins(&functions[place])).collect();
    let mut path = BTreeSet::new();
    while let Some(place) = open.pop() {
        if end(&functions[place].name).is_none() && path.insert(place) {
            open.extend(functions[place].branches.keys());
        }
    }
    path
}

/// Function that can panic, with the number of places per cause.
struct Panics<'a> {
    function: &'a Function,
    in_block: bool,
    by: BTreeMap<&'static str, u32>,
}

fn panics(functions: &[Function]) -> Vec<Panics<'_>> {
    let path = block_path(functions);
    let mut found = Vec::new();
    for (place, function) in functions.iter().enumerate().filter(|(_, function)| end(&function.name).is_none()) {
        let mut by = BTreeMap::new();
        for (&to, count) in &function.branches {
            end(&functions[to].name).into_iter().for_each(|said| *by.entry(said).or_default() += count);
        }
        if !by.is_empty() {
            found.push(Panics { function, in_block: path.contains(&place), by });
        }
    }
    found.sort_by(|a, b| (!a.in_block, &a.function.name).cmp(&(!b.in_block, &b.function.name)));
    found
}

/// Returns the tables for the page.
fn markdown(functions: &[Function], panics: &[Panics]) -> String {
    let row = |of: &Panics| {
        let by: Vec<String> = of.by.iter().map(|(said, count)| format!("{said}: {count}")).collect();
        let place = if of.function.address >> 24 == CCMRAM_TOP_BYTE { "core-coupled RAM" } else { "flash" };
        format!("| `{}` | {place} | {} | {} |\n", of.function.name, by.join(", "), reason(&of.function.name).unwrap_or_default())
    };
    let count = |panics: &mut dyn Iterator<Item = &Panics>| {
        let (mut functions, mut places) = (0, 0);
        panics.for_each(|of| (functions, places) = (functions + 1, places + of.by.values().sum::<u32>()));
        format!("{functions} functions, at {places} places")
    };
    let path = block_path(functions);
    let indirect: u32 = path.iter().map(|&place| functions[place].indirect).sum();
    let (block, rest) = (panics.iter().filter(|of| of.in_block), panics.iter().filter(|of| !of.in_block));
    let head = "| function | memory | causes | reason why it does not panic |\n|---|---|---|---|\n";
    format!(
        "The block path has {} functions, with {indirect} calls to an address in a register. \
         Panics are possible in {}.\n\n{head}{}\nElsewhere: {}.\n\n{head}{}",
        path.len(),
        count(&mut block.clone()),
        block.map(row).collect::<String>(),
        count(&mut rest.clone()),
        rest.map(row).collect::<String>()
    )
}

#[test]
fn docs_name_every_panic_of_the_flashed_image() {
    let Some(elf) = image(&[]) else { return };
    let functions = functions(&elf);
    let panics = panics(&functions);
    // Functions that are known to exist must be found; otherwise the test checks nothing.
    assert!(panics.iter().any(|of| of.function.name.contains("_defmt_acquire")) && block_path(&functions).len() > 50);
    let checked = |of: &&Panics| of.in_block && ["index", "range"].iter().any(|by| of.by.contains_key(by));
    let checked: Vec<_> = panics.iter().filter(checked).map(|of| &of.function.name).collect();
    assert!(checked.is_empty(), "the block path checks bounds in: {checked:#?}");
    let unreasoned: Vec<_> = panics.iter().map(|of| &of.function.name).filter(|name| reason(name).is_none()).collect();
    assert!(unreasoned.is_empty(), "without a reason: {unreasoned:#?}");
    let named = |part: &str| panics.iter().any(|of| place(&of.function.name).is_some_and(|place| REASONS[place].0 == part));
    let idle: Vec<_> = REASONS.iter().map(|(part, _)| part).filter(|part| !named(part)).collect();
    assert!(idle.is_empty(), "reasons without a function that can panic: {idle:#?}");
    report::docs::block(
        "evidence/panics.md",
        "cargo test -p image-scenarios docs_name_every_panic",
        &markdown(&functions, &panics),
    );
}
