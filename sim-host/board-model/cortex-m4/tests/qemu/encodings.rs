//! Encodings by class, as the manual prints them: fixed bits, letters of a register field, and any
//! other letter for free bits.

/// Class of encodings: name, patterns, and the condition for a predictable instance.
pub struct Class {
    pub name: &'static str,
    pub patterns: &'static [&'static str],
    /// Returns `true` if an encoding is predictable.
    pub allowed: fn(u32) -> bool,
}

fn field(code: u32, low: u32, width: u32) -> u32 {
    code >> low & ((1 << width) - 1)
}

fn any(_: u32) -> bool {
    true
}

/// Rejects a repeated byte of zero, which is unpredictable.
fn immediate(code: u32) -> bool {
    field(code, 26, 1) != 0 || field(code, 14, 1) != 0 || field(code, 12, 2) == 0 || field(code, 0, 8) != 0
}

fn lsb(code: u32) -> u32 {
    field(code, 12, 3) << 2 | field(code, 6, 2)
}

fn extract(code: u32) -> bool {
    lsb(code) + field(code, 0, 5) < 32
}

fn insert(code: u32) -> bool {
    field(code, 0, 5) >= lsb(code)
}

/// Rejects more than four bits of width for `SSAT16`.
fn saturate(code: u32) -> bool {
    field(code, 21, 1) == 0 || lsb(code) != 0 || field(code, 4, 1) == 0
}

fn long(code: u32) -> bool {
    field(code, 8, 4) != field(code, 12, 4)
}

/// Rejects a compare of two low registers, which has another encoding.
fn high(code: u32) -> bool {
    field(code, 7, 1) == 1 || field(code, 3, 4) > 7
}

fn fixed_point(code: u32) -> bool {
    let bits = field(code, 0, 4) << 1 | field(code, 5, 1);
    bits <= if field(code, 7, 1) == 0 { 16 } else { 32 }
}

fn two_floats(code: u32) -> bool {
    (field(code, 0, 4) << 1 | field(code, 5, 1)) != 31 && field(code, 12, 4) != field(code, 16, 4)
}

pub const CLASSES: &[Class] = &[
    Class {
        name: "immediate",
        allowed: immediate,
        patterns: &[
            "11110i00000Snnnn0iiiddddiiiiiiii",
            "11110i00001Snnnn0iiiddddiiiiiiii",
            "11110i00010Snnnn0iiiddddiiiiiiii",
            "11110i00011Snnnn0iiiddddiiiiiiii",
            "11110i00100Snnnn0iiiddddiiiiiiii",
            "11110i01000Snnnn0iiiddddiiiiiiii",
            "11110i01010Snnnn0iiiddddiiiiiiii",
            "11110i01011Snnnn0iiiddddiiiiiiii",
            "11110i01101Snnnn0iiiddddiiiiiiii",
            "11110i01110Snnnn0iiiddddiiiiiiii",
            "11110i00010S11110iiiddddiiiiiiii",
            "11110i00011S11110iiiddddiiiiiiii",
            "11110i000001nnnn0iii1111iiiiiiii",
            "11110i001001nnnn0iii1111iiiiiiii",
            "11110i010001nnnn0iii1111iiiiiiii",
            "11110i011011nnnn0iii1111iiiiiiii",
        ],
    },
    Class {
        name: "plain immediate",
        allowed: any,
        patterns: &[
            "11110i100000nnnn0iiiddddiiiiiiii",
            "11110i101010nnnn0iiiddddiiiiiiii",
            "11110i100100iiii0iiiddddiiiiiiii",
            "11110i101100iiii0iiiddddiiiiiiii",
            "11110i10000011110iiiddddiiiiiiii",
            "11110i10101011110iiiddddiiiiiiii",
        ],
    },
    Class {
        name: "shifted register",
        allowed: any,
        patterns: &[
            "11101010000Snnnn0iiiddddiiyymmmm",
            "11101010001Snnnn0iiiddddiiyymmmm",
            "11101010010Snnnn0iiiddddiiyymmmm",
            "11101010011Snnnn0iiiddddiiyymmmm",
            "11101010100Snnnn0iiiddddiiyymmmm",
            "11101011000Snnnn0iiiddddiiyymmmm",
            "11101011010Snnnn0iiiddddiiyymmmm",
            "11101011011Snnnn0iiiddddiiyymmmm",
            "11101011101Snnnn0iiiddddiiyymmmm",
            "11101011110Snnnn0iiiddddiiyymmmm",
            "11101010010S11110iiiddddiiyymmmm",
            "11101010011S11110iiiddddiiyymmmm",
            "111010100001nnnn0iii1111iiyymmmm",
            "111010101001nnnn0iii1111iiyymmmm",
            "111010110001nnnn0iii1111iiyymmmm",
            "111010111011nnnn0iii1111iiyymmmm",
            "111010101100nnnn0iiiddddiiy0mmmm",
            "111110100yySnnnn1111dddd0000mmmm",
        ],
    },
    Class { name: "extract", allowed: extract, patterns: &["11110011u100nnnn0iiiddddii0wwwww"] },
    Class {
        name: "insert",
        allowed: insert,
        patterns: &["111100110110nnnn0iiiddddii0wwwww", "11110011011011110iiiddddii0wwwww"],
    },
    Class { name: "saturate", allowed: saturate, patterns: &["11110011u0s0nnnn0iiiddddii0wwwww"] },
    Class {
        name: "extend, reverse, select",
        allowed: any,
        patterns: &[
            "11111010000unnnn1111dddd10rrmmmm",
            "11111010001unnnn1111dddd10rrmmmm",
            "11111010010unnnn1111dddd10rrmmmm",
            "11111010000u11111111dddd10rrmmmm",
            "11111010001u11111111dddd10rrmmmm",
            "11111010010u11111111dddd10rrmmmm",
            "111110101001mmmm1111dddd10yymmmm",
            "111110101011mmmm1111dddd1000mmmm",
            "111110101010nnnn1111dddd1000mmmm",
        ],
    },
    Class {
        name: "parallel",
        allowed: any,
        patterns: &[
            "111110101y00nnnn1111dddd0u00mmmm",
            "111110101y00nnnn1111dddd0u01mmmm",
            "111110101y00nnnn1111dddd0u10mmmm",
            "111110101y01nnnn1111dddd0u00mmmm",
            "111110101y01nnnn1111dddd0u01mmmm",
            "111110101y01nnnn1111dddd0u10mmmm",
            "111110101y10nnnn1111dddd0u00mmmm",
            "111110101y10nnnn1111dddd0u01mmmm",
            "111110101y10nnnn1111dddd0u10mmmm",
        ],
    },
    Class { name: "saturating add", allowed: any, patterns: &["111110101000nnnn1111dddd10yymmmm"] },
    Class {
        name: "multiply",
        allowed: any,
        patterns: &[
            "111110110000nnnnaaaadddd000ymmmm",
            "111110110000nnnn1111dddd0000mmmm",
            "111110110001nnnnaaaadddd00yymmmm",
            "111110110001nnnn1111dddd00yymmmm",
            "111110110010nnnnaaaadddd000ymmmm",
            "111110110010nnnn1111dddd000ymmmm",
            "111110110011nnnnaaaadddd000ymmmm",
            "111110110011nnnn1111dddd000ymmmm",
            "111110110100nnnnaaaadddd000ymmmm",
            "111110110100nnnn1111dddd000ymmmm",
            "111110110101nnnnaaaadddd000ymmmm",
            "111110110101nnnn1111dddd000ymmmm",
            "111110110110nnnnaaaadddd000ymmmm",
            "111110110111nnnnaaaadddd0000mmmm",
            "111110110111nnnn1111dddd0000mmmm",
        ],
    },
    Class {
        name: "long multiply, divide",
        allowed: long,
        patterns: &[
            "111110111000nnnnllllhhhh0000mmmm",
            "111110111010nnnnllllhhhh0000mmmm",
            "111110111100nnnnllllhhhh0000mmmm",
            "111110111100nnnnllllhhhh10yymmmm",
            "111110111100nnnnllllhhhh110ymmmm",
            "111110111101nnnnllllhhhh110ymmmm",
            "111110111110nnnnllllhhhh0000mmmm",
            "111110111110nnnnllllhhhh0110mmmm",
            "111110111001nnnn1111dddd1111mmmm",
            "111110111011nnnn1111dddd1111mmmm",
        ],
    },
    Class {
        name: "16 bits",
        allowed: any,
        patterns: &[
            "00000iiiiimmmddd",
            "00001iiiiimmmddd",
            "00010iiiiimmmddd",
            "00011yymmmnnnddd",
            "001yydddiiiiiiii",
            "010000yyyymmmddd",
            "010001000mmmmddd",
            "010001001mmmm0ii",
            "010001001mmmm100",
            "010001001mmmm110",
            "010001100mmmmddd",
            "010001101mmmm0ii",
            "010001101mmmm100",
            "010001101mmmm110",
            "10110010yymmmddd",
            "101110100ymmmddd",
            "1011101011mmmddd",
            "10101dddiiiiiiii",
            "10100dddiiiiiiii",
        ],
    },
    Class { name: "compare of high registers", allowed: high, patterns: &["010001010mmmmddd", "010001011mmmm0ii"] },
    Class {
        name: "float arithmetic",
        allowed: any,
        patterns: &[
            "111011100i00iiiiiiii1010iyi0iiii",
            "111011100i01iiiiiiii1010iyi0iiii",
            "111011100i10iiiiiiii1010iyi0iiii",
            "111011100i11iiiiiiii1010iyi0iiii",
            "111011101i00iiiiiiii1010i0i0iiii",
            "111011101i01iiiiiiii1010iyi0iiii",
            "111011101i10iiiiiiii1010iyi0iiii",
            "111011101i110001iiii101011i0iiii",
        ],
    },
    Class {
        name: "float move, compare",
        allowed: any,
        patterns: &[
            "111011101i11iiiiiiii10100000iiii",
            "111011101i110000iiii1010y1i0iiii",
            "111011101i110001iiii101001i0iiii",
            "111011101i110100iiii1010y1i0iiii",
            "111011101i110101iiii1010y1000000",
            "11101110000yiiiitttt1010i0010000",
            "1110111000x00iiitttt101100010000",
            "1110111000x10iiitttt101100010000",
            "1110111011110001tttt101000010000",
            "1110111011100001tttt101000010000",
            "11101110111100011111101000010000",
        ],
    },
    Class {
        name: "float move of two",
        allowed: two_floats,
        patterns: &["11101100010ynnnntttt101000i1iiii", "11101100010ynnnntttt101100010iii"],
    },
    Class {
        name: "float convert",
        allowed: any,
        patterns: &[
            "111011101i110010iiii1010y1i0iiii",
            "111011101i110011iiii1010y1i0iiii",
            "111011101i111000iiii1010y1i0iiii",
            "111011101i11110yiiii1010y1i0iiii",
        ],
    },
    Class { name: "float fixed point", allowed: fixed_point, patterns: &["111011101i111p1uiiii1010y1i0iiii"] },
];
