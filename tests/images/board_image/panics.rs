//! Which functions of the flashed image can panic: the callers of `core::panicking` by its instructions, against the list of docs/evidence/panics.md.
//!
//! `UPDATE_DOCS=1 cargo test -p image-scenarios docs_name_every_panic` writes the list; the reasons stand here. A function without one fails the test.

use std::collections::{BTreeMap, BTreeSet};

use super::branches::{Function, functions};
use super::size::image;

/// The interrupt of a block; what it calls is the block path, and so is all of the core-coupled RAM.
const BLOCK_INTERRUPT: &str = "DMA1_CHANNEL1";
const CORE_COUPLED: u32 = 0x10;

/// What panics, by parts of names, and what it says.
const ENDS: [(&str, &str); 12] = [
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

/// Why these do not come to it, by how their names begin: functions, and the reason. The first that fits counts.
const REASONS: [(&str, &str); 23] = [
    (
        "sequential_storage::",
        "the flash's geometry: words and pages of constant size, and cuts of a buffer by lengths that were checked before; damaged flash is fed by `evidence fuzz`",
    ),
    ("<sonoglide_firmware::board::settings::", "words and pages of the flash have a constant size, and none is zero"),
    (
        "sonoglide_firmware::board::settings::",
        "there are two halves, by their type; a record is shorter than its buffer, by its type",
    ),
    ("core::slice::copy_from_slice_impl", "both sides are cut to one length before"),
    (
        "nucleo_g474re::image::__cortex_m_rt_main",
        "the background task: started once; places of rings are remainders by their length; a frame is cut by what `cobs` has counted, which `evidence fuzz` feeds",
    ),
    ("nucleo_g474re::image::build", "before the first block: constants of the board, which tests build on the host"),
    (
        "nucleo_g474re::image::",
        "before the first block: numbers of pins, channels and conversions are constants within the register",
    ),
    ("DMA1_CHANNEL1", "pins are constants within the register"),
    ("_defmt_", "the log's lock is taken with interrupts masked, and given back before"),
    ("cobs::", "the buffer is `max_encoding_length` long"),
    ("sonoglide_firmware::board::app::outbox", "a frame is as long as its buffer at most, by its type"),
    ("sonoglide_firmware::board::app::App", "a ring's length is a constant above one"),
    ("sonoglide_firmware::board::block_task", "a ring's length is a constant above one"),
    ("sonoglide_firmware::board::capture", "a ring's length is a constant above one"),
    ("sonoglide_firmware::board::parameters", "places are those of the list of parameters"),
    ("sonoglide_firmware::generate::burst::Burst::build", "as many windows as the configuration has room for"),
    ("sonoglide_firmware::generate::burst::Burst::gate", "a period of no samples is refused when it is built"),
    ("sonoglide_firmware::generate::shaper", "the largest code step is one at least"),
    (
        "sonoglide_firmware::generate::sweep::chirp",
        "legs are two, and are counted by 0 and 1; a chirp of no blocks is refused when it is built",
    ),
    ("sonoglide_firmware::find::scan::Scan::tune", "a pass has blocks: at least `FEWEST_BLOCKS`"),
    ("sonoglide_firmware::controller::stages::scan", "places are those of a list that was just asked for its length"),
    ("sonoglide_firmware::controller::stages::clamped", "tones have blocks"),
    ("<heapless::", "what is collected has room by its type"),
];

/// The end that a function is, if it is one.
fn end(name: &str) -> Option<&'static str> {
    let begins = ["core::", "<core::", "_R"].iter().any(|begin| name.starts_with(begin));
    ENDS.iter().find(|(part, _)| begins && name.contains(part)).map(|(_, said)| *said)
}

/// Place of the reason why a function does not panic.
fn place(name: &str) -> Option<usize> {
    // A trait's method belongs to the type that has it, a closure or an adapter to what it is in.
    let begins = |(part, _): &(&str, _)| name.starts_with(part);
    REASONS.iter().position(begins).or_else(|| REASONS.iter().position(|(part, _)| name.contains(part.trim_start_matches('<'))))
}

/// Why a function does not panic.
fn reason(name: &str) -> Option<&'static str> {
    place(name).map(|place| REASONS[place].1)
}

/// Places of what the block interrupt calls, as far as direct branches show, and of all code in the core-coupled RAM. What panics is not followed.
fn block_path(functions: &[Function]) -> BTreeSet<usize> {
    let begins = |function: &Function| function.name == BLOCK_INTERRUPT || function.address >> 24 == CORE_COUPLED;
    let mut open: Vec<usize> = (0..functions.len()).filter(|&place| begins(&functions[place])).collect();
    let mut path = BTreeSet::new();
    while let Some(place) = open.pop() {
        if end(&functions[place].name).is_none() && path.insert(place) {
            open.extend(functions[place].branches.keys());
        }
    }
    path
}

/// A function that can panic, and by what how often.
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

/// Tables for the page.
fn markdown(functions: &[Function], panics: &[Panics]) -> String {
    let row = |of: &Panics| {
        let by: Vec<String> = of.by.iter().map(|(said, count)| format!("{said}: {count}")).collect();
        let place = if of.function.address >> 24 == CORE_COUPLED { "core-coupled RAM" } else { "flash" };
        format!("| `{}` | {place} | {} | {} |\n", of.function.name, by.join(", "), reason(&of.function.name).unwrap_or_default())
    };
    let count = |panics: &mut dyn Iterator<Item = &Panics>| {
        let (mut functions, mut places) = (0, 0);
        panics.for_each(|of| (functions, places) = (functions + 1, places + of.by.values().sum::<u32>()));
        format!("{functions} functions, {places} places")
    };
    let path = block_path(functions);
    let indirect: u32 = path.iter().map(|&place| functions[place].indirect).sum();
    let (block, rest) = (panics.iter().filter(|of| of.in_block), panics.iter().filter(|of| !of.in_block));
    let head = "| function | in | by what | why not |\n|---|---|---|---|\n";
    format!(
        "The block path has {} functions, with {indirect} calls by an address in a register. Of them can panic: {}.\n\n{head}{}\nElsewhere: {}.\n\n{head}{}",
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
    // What is known to be there is found: else this looks at nothing.
    assert!(panics.iter().any(|of| of.function.name.contains("_defmt_acquire")) && block_path(&functions).len() > 50);
    let checked = |of: &&Panics| of.in_block && ["index", "range"].iter().any(|by| of.by.contains_key(by));
    let checked: Vec<_> = panics.iter().filter(checked).map(|of| &of.function.name).collect();
    assert!(checked.is_empty(), "bounds are checked in the block path: {checked:#?}");
    let unreasoned: Vec<_> = panics.iter().map(|of| &of.function.name).filter(|name| reason(name).is_none()).collect();
    assert!(unreasoned.is_empty(), "without a reason: {unreasoned:#?}");
    let named = |part: &str| panics.iter().any(|of| place(&of.function.name).is_some_and(|place| REASONS[place].0 == part));
    let idle: Vec<_> = REASONS.iter().map(|(part, _)| part).filter(|part| !named(part)).collect();
    assert!(idle.is_empty(), "reasons for what does not panic: {idle:#?}");
    report::docs::block(
        "evidence/panics.md",
        "cargo test -p image-scenarios docs_name_every_panic",
        &markdown(&functions, &panics),
    );
}
