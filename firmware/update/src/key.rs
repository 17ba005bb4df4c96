//! Keys by which updates are signed: the key of the builder of the board's images, or the
//! development key by default.
//!
//! **The development key is not secret: its seed is in this file.** Anyone with this source can
//! sign with it. Images for boards that leave the laboratory must be built with a private key.
//! `SONOGLIDE_UPDATE_KEY` sets its public half, as 64 hexadecimal digits, when the first stage and
//! the image are built. Further keys follow after commas: spare keys, for the time after the first
//! one has leaked (docs/dev/update.md).

/// Seed of the development key. It is not secret and must never be used for a board in the field.
pub const DEVELOPMENT_SEED: [u8; 32] = *b"SONOGLIDE-DEVELOPMENT-NOT-SECRET";
/// Public half of the development key, as digits.
const DEVELOPMENT_DIGITS: &str = "9de894fab7e3f332106507ee4ac0729a22846816cae250d3f14f1149d1ed096e";
/// Public half of the development key.
pub const DEVELOPMENT: [u8; 32] = keys::<1>(DEVELOPMENT_DIGITS.as_bytes())[0];

/// Public keys of this build, as digits.
const DIGITS: &str = match option_env!("SONOGLIDE_UPDATE_KEY") {
    Some(digits) => digits,
    None => DEVELOPMENT_DIGITS,
};
/// Public keys that this build accepts for images.
pub const PUBLIC: [[u8; 32]; (DIGITS.len() + 1) / 65] = keys(DIGITS.as_bytes());

/// Decodes keys of 64 hexadecimal digits, separated by commas. Any other text is a compile error in
/// a constant.
const fn keys<const N: usize>(text: &[u8]) -> [[u8; 32]; N] {
    assert!(N > 0 && text.len() + 1 == 65 * N, "SONOGLIDE_UPDATE_KEY must have 64 hexadecimal digits for each key");
    let (mut keys, mut n) = ([[0; 32]; N], 0);
    while n < text.len() {
        let (key, place) = (n / 65, n % 65);
        if place == 64 {
            assert!(text[n] == b',', "SONOGLIDE_UPDATE_KEY must have a comma between two keys");
            n += 1;
            continue;
        }
        let digit = match text[n] {
            digit @ b'0'..=b'9' => digit - b'0',
            digit @ b'a'..=b'f' => digit - b'a' + 10,
            digit @ b'A'..=b'F' => digit - b'A' + 10,
            _ => panic!("SONOGLIDE_UPDATE_KEY must have only hexadecimal digits in a key"),
        };
        keys[key][place / 2] = keys[key][place / 2] << 4 | digit;
        n += 1;
    }
    keys
}

/// Returns the public half of the key with this seed.
pub fn public(seed: &[u8; 32]) -> [u8; 32] {
    *salty::Keypair::from(seed).public.as_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn several_keys_are_separated_by_commas() {
        let text = [DEVELOPMENT_DIGITS, &"0F".repeat(32)].join(",");
        assert_eq!(keys::<2>(text.as_bytes()), [DEVELOPMENT, [15; 32]]);
    }

    #[test]
    fn the_development_key_is_the_one_that_is_published() {
        assert_eq!(public(&DEVELOPMENT_SEED), DEVELOPMENT);
    }
}
