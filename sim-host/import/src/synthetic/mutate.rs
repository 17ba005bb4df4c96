//! Damaged files: bytes, lines and numbers of an example are changed as mail programs, editors and
//! faulty exporters change them.

use super::random::Random;

/// Bytes with a meaning in tables.
const TELLING: &[u8] = b"0123456789.,;-+eE \t\n!#\"[]()/xnN\xff\x00\xc3";
/// Fields that instruments print instead of a number, and extreme numbers.
const ODD: [&str; 12] =
    ["nan", "inf", "-", "", "1e999", "0", "-0", "9.9e37", "overload", "1,5", "1e-320", "99999999999999999999"];

/// Returns the damaged content of a file, by a seed.
pub fn mutated(bytes: &[u8], seed: u64) -> Vec<u8> {
    let mut random = Random::new(seed ^ 0x00da_3a9e);
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + random.below(6) {
        mutate(&mut bytes, &mut random);
    }
    bytes
}

fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    if bytes.is_empty() {
        return;
    }
    let at = random.below(bytes.len());
    match random.below(9) {
        0 => bytes[at] = random.one(TELLING),
        1 => bytes.insert(at, random.one(TELLING)),
        2 => drop(bytes.remove(at)),
        3 => bytes.truncate(at),
        4 => drop(bytes.drain(..at)),
        5 => {
            let sign = random.one(b".,;\t ");
            let other = random.one(b".,;\t \n");
            bytes.iter_mut().filter(|byte| **byte == sign).for_each(|byte| *byte = other);
        }
        _ => {
            let mut lines: Vec<Vec<u8>> = bytes.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
            let (at, other) = (random.below(lines.len()), random.below(lines.len()));
            match random.below(6) {
                0 => lines.swap(at, other),
                1 => drop(lines.remove(at)),
                2 => lines.insert(other, lines[at].clone()),
                3 => lines.truncate(1 + at % 12),
                _ => {
                    let mut fields: Vec<Vec<u8>> = lines[at].split(|byte| b",;\t ".contains(byte)).map(<[u8]>::to_vec).collect();
                    let field = random.below(fields.len());
                    fields[field] = random.one(&ODD).into();
                    let joint = random.one(b",;\t ");
                    lines[at] = fields.join(&joint);
                }
            }
            *bytes = lines.join(&b'\n');
        }
    }
}
