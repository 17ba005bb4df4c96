use super::*;
use crate::output::Presentation;
use crate::study::sweep::design::Design;
use scene::load::load;

fn with_sweep(name: &str, points: &str, test: impl FnOnce(&Path, &Sweep)) {
    let dir = std::env::temp_dir().join(format!("{name}-{}", std::process::id()));
    let loaded = load("contact-kinematic", &[]).expect("a scene");
    let axis = format!("contact.dahl.mu={points}").parse().expect("an axis");
    let design = Design::product(vec![axis]).expect("a design");
    test(&dir, &Sweep::new(&loaded, design, &["friction_ratio".to_owned()]).expect("a sweep"));
    fs::remove_dir_all(&dir).expect("removed");
}

fn open(dir: &Path, sweep: &Sweep, shard: &str) -> Result<SweepFolder, FolderError> {
    SweepFolder::open(dir, sweep, shard.parse().expect("a shard"), &[])
}

/// A change of any bit is detected before the file is parsed. A resumed sweep replaces damaged
/// parts, and its result is identical.
#[test]
fn damaged_parts_are_detected_and_replaced() {
    with_sweep("damaged", "0.1,0.2,0.3", |dir, sweep| {
        let result = || {
            let joined = join(&[dir.to_owned()], dir, &Presentation::default());
            joined.map(|_| [TABLE, ROWS, PAGE].map(|name| fs::read(dir.join(name)).expect("a file")))
        };
        let run = || {
            let folder = open(dir, sweep, "1/1").expect("a folder");
            assert!(folder.run(sweep, &AtomicBool::new(false), &|| ()).expect("all points"));
            folder.damaged().join(", ")
        };
        assert_eq!(run(), "");
        let sound = result().expect("a result");
        let plan = PlanFile::new(sweep);
        let part = parts::list(dir).expect("a folder").remove(0);
        let bytes = fs::read(&part.path).expect("a part");
        let mut flipped = bytes.clone();
        for bit in (0..8 * bytes.len()).step_by(7) {
            flipped[bit / 8] ^= 1 << (bit % 8);
            fs::write(&part.path, &flipped).expect("written");
            assert!(matches!(plan.check(&part), Err(FolderError::Damaged { .. })), "bit {bit}");
            flipped[bit / 8] = bytes[bit / 8];
        }
        flipped[100] ^= 1;
        let tail = bytes[..bytes.len() - 1].to_vec();
        for damaged in [flipped, vec![0; bytes.len()], Vec::new(), tail, bytes[..8].to_vec(), b"PAR1PAR1".to_vec()] {
            fs::write(&part.path, &damaged).expect("written");
            assert!(result().is_err_and(|error| matches!(error, FolderError::Damaged { .. })));
            assert!(run().contains("does not match the checksum in its name"));
            assert!(fs::read(&part.path).expect("a part") == bytes);
        }
        // A sound part without a checksum in its name.
        fs::rename(&part.path, Part::new(dir, part.points.clone(), None).path).expect("renamed");
        assert!(result().is_err() && run().contains("has no checksum in its name"));
        assert!(result().expect("a result") == sound && parts::list(dir).expect("a folder") == [part]);
    });
}

/// The points in a part must be those in its name.
#[test]
fn part_with_other_points_is_refused() {
    with_sweep("other-points", "0.1,0.2,0.3,0.4", |dir, sweep| {
        let plan = open(dir, sweep, "1/1").expect("a folder").plan.clone();
        let part = plan.write_part(sweep, 0..2, dir, (&AtomicBool::new(false), &|| ())).expect("written").expect("a part");
        let sum = part.path.file_stem().and_then(|name| Some(name.to_str()?.rsplit('-').next()?.to_owned()));
        fs::copy(&part.path, Part::new(dir, 2..4, sum).path).expect("copied");
        let refused = join(&[dir.to_owned()], dir, &Presentation::default());
        assert!(matches!(&refused, Err(FolderError::Part { path }) if *path != part.path), "{refused:?}");
    });
}

/// Shards with a common point are refused while one of them runs, all others are accepted.
#[test]
fn overlapping_shards_are_refused_while_one_runs() {
    with_sweep("overlap", "0.1:0.5:40", |dir, sweep| {
        let shards = ["1/1", "1/2", "2/2", "1/3", "3/3", "1/4", "2/4", "4/4", "40/40"];
        let points = |shard: &str| -> Vec<u64> {
            let shard: Shard = shard.parse().expect("a shard");
            shard.missing(40, &[]).into_iter().flatten().collect()
        };
        for running in shards {
            let held = open(dir, sweep, running).expect("a free folder");
            for other in shards {
                let overlap = points(running).iter().any(|point| points(other).contains(point));
                match open(dir, sweep, other) {
                    Ok(_) => assert!(!overlap, "{running}, {other}"),
                    Err(error) => {
                        let says = format!("another process runs shard {running} of the sweep");
                        assert!(overlap && error.to_string().contains(&says), "{running}, {other}: {error}");
                    }
                }
            }
            drop(held);
        }
        assert_eq!(running(dir, Shard::WHOLE, 40).expect("a folder"), None);
    });
}

#[test]
fn result_without_disk_space_is_refused() {
    let dir = std::env::temp_dir();
    assert!(has_room(&dir, 1000, 2).is_ok());
    // 1e20 bytes, a hundred thousand petabytes.
    let refused = has_room(&dir, 6_250_000_000_000_000_000, 2).map_err(|error| error.to_string());
    let begins = "6250000000000000000 points take at least 18446744073709.6 MB, but `";
    assert!(refused.is_err_and(|error| error.starts_with(begins)));
}
