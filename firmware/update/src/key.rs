//! The key by which updates are signed: that of whoever builds the board's images, or, without one, the development key.
//!
//! **The development key is no secret: its seed stands here.** Whoever has this source can sign with it. Images for boards that leave the laboratory are built with a key of one's own:
//! `SONOGLIDE_UPDATE_KEY` names its public half, as 64 hexadecimal digits, when first stage and image are built (docs/update.md).

/// Seed of the development key. Not secret, and never to be used for a board in the field.
pub const DEVELOPMENT_SEED: [u8; 32] = *b"SONOGLIDE-DEVELOPMENT-NOT-SECRET";
/// The public half of the development key.
pub const DEVELOPMENT: [u8; 32] = hex(b"9de894fab7e3f332106507ee4ac0729a22846816cae250d3f14f1149d1ed096e");

/// Public key of the images that this build accepts.
pub const PUBLIC: [u8; 32] = match option_env!("SONOGLIDE_UPDATE_KEY") {
    Some(digits) => hex(digits.as_bytes()),
    None => DEVELOPMENT,
};

/// Whether this build accepts what anybody can sign.
pub const IS_DEVELOPMENT: bool = option_env!("SONOGLIDE_UPDATE_KEY").is_none();

/// 32 bytes of 64 hexadecimal digits; does not compile with anything else.
const fn hex(digits: &[u8]) -> [u8; 32] {
    assert!(digits.len() == 64, "a key has 64 hexadecimal digits");
    let (mut key, mut n) = ([0; 32], 0);
    while n < 64 {
        let digit = match digits[n] {
            digit @ b'0'..=b'9' => digit - b'0',
            digit @ b'a'..=b'f' => digit - b'a' + 10,
            digit @ b'A'..=b'F' => digit - b'A' + 10,
            _ => panic!("a key has hexadecimal digits only"),
        };
        key[n / 2] = key[n / 2] << 4 | digit;
        n += 1;
    }
    key
}

/// The public half of the key with this seed.
pub fn public(seed: &[u8; 32]) -> [u8; 32] {
    *salty::Keypair::from(seed).public.as_bytes()
}
