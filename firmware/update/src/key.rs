//! Keys by which updates are signed: the key of the builder of the board's images, or the
//! development key by default.
//!
//! **The development key is not secret: its seed is in this file.** Anyone with this source can
//! sign with it. Images for boards that leave the laboratory must be built with a private key.
//! `SONOGLIDE_UPDATE_KEY` sets its public half, as 64 hexadecimal digits, when the first stage and
//! the image are built (docs/link.md).

/// Seed of the development key. It is not secret and must never be used for a board in the field.
pub const DEVELOPMENT_SEED: [u8; 32] = *b"SONOGLIDE-DEVELOPMENT-NOT-SECRET";
/// Public half of the development key.
pub const DEVELOPMENT: [u8; 32] = hex(b"9de894fab7e3f332106507ee4ac0729a22846816cae250d3f14f1149d1ed096e");

/// Public key that this build accepts for images.
pub const PUBLIC: [u8; 32] = match option_env!("SONOGLIDE_UPDATE_KEY") {
    Some(digits) => hex(digits.as_bytes()),
    None => DEVELOPMENT,
};

/// `true` if this build accepts the development key, with which anyone can sign.
pub const IS_DEVELOPMENT: bool = option_env!("SONOGLIDE_UPDATE_KEY").is_none();

/// Decodes 64 hexadecimal digits to 32 bytes. Any other text is a compile error in a constant.
const fn hex(digits: &[u8]) -> [u8; 32] {
    assert!(digits.len() == 64, "a key must have 64 hexadecimal digits");
    let (mut key, mut n) = ([0; 32], 0);
    while n < 64 {
        let digit = match digits[n] {
            digit @ b'0'..=b'9' => digit - b'0',
            digit @ b'a'..=b'f' => digit - b'a' + 10,
            digit @ b'A'..=b'F' => digit - b'A' + 10,
            _ => panic!("a key must have only hexadecimal digits"),
        };
        key[n / 2] = key[n / 2] << 4 | digit;
        n += 1;
    }
    key
}

/// Returns the public half of the key with this seed.
pub fn public(seed: &[u8; 32]) -> [u8; 32] {
    *salty::Keypair::from(seed).public.as_bytes()
}
