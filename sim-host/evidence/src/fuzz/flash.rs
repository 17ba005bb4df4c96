//! The settings in the flash: the board starts with any contents, and no limit in effect exceeds a
//! stored limit that can be read.
//!
//! Before the damage, the flash contains settings of two stores, of which the second may be cut
//! short. Or it contains arbitrary bytes in an entry with a valid checksum, which pass the checks
//! of the flash and reach the decoder of the record.

use embassy_embedded_hal::adapter::BlockingAsync;
use firmware::board::command::{Command, Reply, Verb};
use firmware::board::parameters::{Overrides, PARAMETERS, ParameterReport};
use firmware::board::settings::{Record, Settings};
use firmware::board::stored_state::StoredState;
use firmware::seam::config::keys::ENERGY_PER_METRE;
use firmware::seam::config::{LaneTrims, Trim, TrimPoint};
use hal_mock::bench::{Bench, Queues, Setup};
use hal_mock::chance::Chance;
use hal_mock::flash::{Flash, PAGE_BYTES};
use hal_mock::loop_back::LoopBack;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};

use super::frames::{key, value};
use super::target::{Tally, Target};

pub(super) const TARGET: Target = Target {
    name: "settings",
    what: "flash with the settings: reads, stores, starts of a board",
    seeds_per_million: 50,
    feed,
    corpus: |_| Ok(()),
};

/// Number of contents of the flash per seed; a board is started with the first.
const CONTENTS: usize = 40;
const PAGES: usize = 4;
/// Key of the record in the map.
const RECORD: u8 = 1;
/// Size of the buffer for an entry, bytes.
const MAX_ENTRY_BYTES: usize = 640;

fn feed(seed: u64, tally: &mut Tally) -> Result<(), String> {
    let mut chance = Chance::new(seed);
    for content in 0..CONTENTS {
        let (flash, stored) = match chance.below(3) {
            0 => (written(&mut chance), None),
            _ => damaged(&mut chance),
        };
        tally.input(flash.bytes().len());
        let read = read(&flash, stored.as_deref(), &mut chance, tally)?;
        if content == 0 {
            start(&mut chance, flash, &read, tally)?;
        }
    }
    Ok(())
}

/// Draws any record: parameters of any value, unknown keys, keys twice, and lane trims.
fn record(chance: &mut Chance) -> Record {
    let parameters = (0..chance.below(13)).map(|_| {
        let key = key(chance);
        (key, value(chance, key))
    });
    let parameters = Overrides::from_iter(parameters.collect::<Vec<_>>());
    let trims: LaneTrims = (0..chance.below(4))
        .map(|n| TrimPoint {
            hz: 39e3 + 1e3 * n as f32,
            lanes: std::array::from_fn(|_| Trim { gain: 0.5 + 1e-3 * chance.below(1000) as f32, ..Trim::default() }),
        })
        .collect();
    Record { trims, parameters }
}

fn settings(flash: Flash) -> Result<Settings<Flash>, String> {
    Settings::new(flash).map_err(|error| error.to_string())
}

/// Returns a flash written by boards and possibly damaged, with the records that may be read from
/// it. The damage can be detected by the checks.
fn damaged(chance: &mut Chance) -> (Flash, Option<Vec<Record>>) {
    let mut flash = Flash::new(PAGES, chance.below(1 << 32));
    let mut stored = vec![Record::default()];
    for _ in 0..=chance.below(3) {
        let record = record(chance);
        if chance.strikes(0.3) {
            flash.cut_power_after(chance.below(120));
        }
        let Ok(mut settings) = Settings::new(flash.clone()) else { continue };
        let _ = settings.store(&record);
        flash = settings.release();
        flash.restore_power();
        stored.push(record);
    }
    let length = flash.bytes().len() as u64;
    match chance.below(4) {
        0 => {}
        1 => {
            for _ in 0..=chance.below(8) {
                flash.turn_bits(chance.below(length) as usize, 1 << chance.below(8));
            }
        }
        // The beginning of a page and of its first entry.
        2 => {
            for _ in 0..=chance.below(6) {
                let at = chance.below(PAGES as u64) * PAGE_BYTES as u64 + chance.below(64);
                flash.turn_bits(at as usize, chance.byte());
            }
        }
        _ => {
            let from = chance.below(length);
            (from..(from + chance.below(600)).min(length)).for_each(|at| flash.turn_bits(at as usize, chance.byte()));
        }
    }
    (flash, Some(stored))
}

/// Returns a flash with an intact entry whose value has another version, is damaged or cut short,
/// or is arbitrary.
fn written(chance: &mut Chance) -> Flash {
    let mut flash = Flash::new(PAGES, 1);
    let half = (PAGES / 2 * PAGE_BYTES) as u32;
    for which in 0..=chance.below(2) as u32 {
        let number = [0, 1, u32::MAX, u32::MAX / 2, chance.below(1 << 32) as u32][chance.below(5) as usize];
        let version = [2, 2, 2, 1, 0, 3, 255][chance.below(7) as usize];
        let mut bytes = [0; MAX_ENTRY_BYTES];
        let body = match postcard::to_slice(&record(chance), &mut bytes) {
            Ok(body) => body.to_vec(),
            Err(_) => Vec::new(),
        };
        let mut entry = [&[version][..], &number.to_le_bytes(), &body].concat();
        match chance.below(4) {
            0 => {}
            1 => entry.truncate(chance.below(entry.len() as u64 + 1) as usize),
            2 => {
                for _ in 0..=chance.below(4) {
                    let at = chance.below(entry.len() as u64) as usize;
                    entry[at] = chance.byte();
                }
            }
            _ => entry.extend((0..chance.below(200)).map(|_| chance.byte())),
        }
        write(&mut flash, which % 2 * half..(which % 2 + 1) * half, &entry);
    }
    flash
}

/// Writes an entry in the same way as the board.
fn write(flash: &mut Flash, range: std::ops::Range<u32>, entry: &[u8]) {
    let Ok(config) = MapConfig::try_new(range) else { return };
    let cache: Cache<Uncached, Uncached, Uncached, u8> = Cache::new_uncached();
    let mut map = MapStorage::new(BlockingAsync::new(flash), config, cache);
    let _ = embassy_futures::block_on(map.store_item(&mut [0; MAX_ENTRY_BYTES + 256], &RECORD, &entry));
}

/// Reads the settings as a board does, and checks that another record can be stored over them.
fn read(
    flash: &Flash,
    may_be: Option<&[Record]>,
    chance: &mut Chance,
    tally: &mut Tally,
) -> Result<(Record, StoredState), String> {
    let mut store = settings(flash.clone())?;
    let found = store.record();
    tally.outcome(&format!("{:?}", found.1));
    // A record that passes the checks was stored once, with exactly these numbers.
    let bytes = |record: &Record| {
        let mut bytes = [0; MAX_ENTRY_BYTES];
        postcard::to_slice(record, &mut bytes).map(|bytes| bytes.to_vec()).map_err(|error| error.to_string())
    };
    if let Some(may_be) = may_be {
        let read = bytes(&found.0)?;
        let known = may_be.iter().map(bytes).collect::<Result<Vec<_>, _>>()?;
        if !known.contains(&read) {
            return Err(format!("a record was read that was never stored: {:?}", found.0));
        }
    }
    let next = record(chance);
    match store.store(&next) {
        Ok(()) => {
            if bytes(&store.record().0)? != bytes(&next)? {
                return Err(format!("stored {next:?}, but read {:?}", store.record()));
            }
            tally.outcome("overwritten");
        }
        Err(_) => tally.outcome("not overwritten"),
    }
    Ok(found)
}

/// Starts a board with the flash, and checks its limits.
fn start(chance: &mut Chance, flash: Flash, (record, state): &(Record, StoredState), tally: &mut Tally) -> Result<(), String> {
    let mut setup = Setup { flash, ..Setup::default() };
    setup.config.front_end.metre_per_count = chance.strikes(0.5).then_some(1e-6);
    let mut queues = Queues::default();
    let load = LoopBack::of(&setup.config);
    let mut bench = Bench::new(&mut queues, &setup, load).map_err(|error| format!("the board does not start: {error}"))?;
    bench.blocks(4);
    let mut reports = Vec::<ParameterReport>::new();
    for parameter in &PARAMETERS {
        match bench.ask(Command::Settings(Verb::Get(parameter.key))) {
            Some(Reply::Parameter(report)) => reports.push(report),
            other => return Err(format!("{}: {other:?}", parameter.name)),
        }
    }
    for (parameter, report) in PARAMETERS.iter().zip(&reports).filter(|(parameter, _)| parameter.is_limit()) {
        // Without an encoder the energy per metre of belt is unknown.
        let judged = parameter.key != ENERGY_PER_METRE || setup.config.front_end.metre_per_count.is_some();
        let stored = record.parameters.iter().filter(|(key, _)| *key == parameter.key && *state == StoredState::Stored);
        for &(_, stored) in stored.filter(|_| judged) {
            let most = if stored > report.min { stored } else { report.min };
            if report.acts > most {
                return Err(format!("{}: {stored} stored, {report:?}", parameter.name));
            }
        }
    }
    tally.outcome(&format!("started, {:?}", reports.first().map(|report| report.stored)));
    Ok(())
}
