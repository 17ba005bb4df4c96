//! Random loads and stores, all within the memory of their state.

use rand_core::Rng;

use crate::cases::{Case, SCRATCH, SCRATCH_LEN, halfwords, place, register, state};

/// Returns a random number below `end`.
fn below(rng: &mut impl Rng, end: u32) -> u32 {
    rng.next_u32() % end
}

/// Returns a random register that is not in `taken`.
fn other(rng: &mut impl Rng, taken: &[u32]) -> u32 {
    loop {
        let register = register(rng);
        if !taken.contains(&register) {
            return register;
        }
    }
}

/// Returns a load or store of one value. `at` is the address of the state.
pub fn single(at: u32, rng: &mut impl Rng) -> Case {
    let mut state = state(rng);
    let (n, size, load) = (register(rng), below(rng, 3), below(rng, 2));
    // A word is never sign-extended.
    let sign = if load == 1 && size != 2 { below(rng, 2) } else { 0 };
    let target = at + SCRATCH + below(rng, SCRATCH_LEN - 4);
    let head = 0xF800_0000 | sign << 24 | size << 21 | load << 20 | n << 16;
    let (code, base) = match below(rng, 5) {
        0 => {
            let offset = below(rng, 4096);
            (head | 1 << 23 | register(rng) << 12 | offset, target - offset)
        }
        1 => {
            let offset = below(rng, 256);
            (head | register(rng) << 12 | 0xC00 | offset, target + offset)
        }
        2 => {
            let (offset, up, before) = (below(rng, 256), below(rng, 2), below(rng, 2));
            let code = head | other(rng, &[n]) << 12 | 0x900 | before << 10 | up << 9 | offset;
            let base = if up == 1 { target.wrapping_sub(offset) } else { target + offset };
            (code, if before == 1 { base } else { target })
        }
        3 => {
            let (m, shift) = (other(rng, &[n]), below(rng, 4));
            let index = below(rng, 1000);
            state[place(m)] = index;
            (head | register(rng) << 12 | shift << 4 | m, target - (index << shift))
        }
        _ => {
            let offset = below(rng, 256);
            (head | register(rng) << 12 | 0xE00 | offset, target - offset)
        }
    };
    state[place(n)] = base;
    Case { code: halfwords(code), state }
}

/// Returns a load or store in a 16-bit form.
pub fn narrow(at: u32, rng: &mut impl Rng) -> Case {
    let mut state = state(rng);
    let (n, t) = (below(rng, 8), below(rng, 8));
    let target = at + SCRATCH + 4 * below(rng, SCRATCH_LEN / 4);
    let imm = below(rng, 32);
    let (code, base) = match below(rng, 6) {
        0 => (0x6000 | below(rng, 2) << 11 | imm << 6 | n << 3 | t, target - 4 * imm),
        1 => (0x7000 | below(rng, 2) << 11 | imm << 6 | n << 3 | t, target - imm),
        2 => (0x8000 | below(rng, 2) << 11 | imm << 6 | n << 3 | t, target - 2 * imm),
        3 => (0x9000 | below(rng, 2) << 11 | t << 8 | (SCRATCH / 4) | below(rng, SCRATCH_LEN / 4), target),
        4 => {
            let m = (n + 1 + below(rng, 7)) % 8;
            let index = below(rng, 1000);
            state[place(m)] = index;
            (0x5000 | below(rng, 8) << 9 | m << 6 | n << 3 | t, target - index)
        }
        _ => {
            // LDM with the base in the list does not write back; STM without it.
            let load = below(rng, 2);
            let list = (below(rng, 255) + 1) & if load == 1 { 0xFF } else { !(1 << n) };
            let list = if list == 0 { 1 << ((n + 1) % 8) } else { list };
            (0xC000 | load << 11 | n << 8 | list, at + SCRATCH)
        }
    };
    state[place(n)] = base;
    Case { code: vec![code as u16], state }
}

/// Returns a load or store of several words, of two words, or an exclusive one.
pub fn several(at: u32, rng: &mut impl Rng) -> Case {
    let mut state = state(rng);
    let n = register(rng);
    let load = below(rng, 2);
    let (code, base) = match below(rng, 5) {
        0 | 1 => {
            let mut list = rng.next_u32() & 0x5FFF & !(1 << n);
            while list.count_ones() > 12 {
                list &= list - 1;
            }
            while list.count_ones() < 2 {
                list |= 1 << other(rng, &[n]);
            }
            let (before, back) = (below(rng, 2), below(rng, 2));
            let head = if before == 1 { 0xE900_0000 } else { 0xE880_0000 };
            let base = if before == 1 { at + SCRATCH + 4 * list.count_ones() } else { at + SCRATCH };
            (halfwords(head | back << 21 | load << 20 | n << 16 | list), base)
        }
        2 | 3 => {
            let t = other(rng, &[n]);
            let t2 = other(rng, &[n, t]);
            let (index, up, back) = (below(rng, 2), below(rng, 2), below(rng, 2));
            let back = if index == 0 { 1 } else { back };
            let (target, offset) = (at + SCRATCH + 4 * below(rng, 8), below(rng, 64));
            let code = 0xE840_0000 | index << 24 | up << 23 | back << 21 | load << 20 | n << 16 | t << 12 | t2 << 8 | offset;
            let base = if up == 1 { target - 4 * offset } else { target + 4 * offset };
            (halfwords(code), if index == 1 { base } else { target })
        }
        _ => {
            let (t, offset) = (other(rng, &[n]), below(rng, 16));
            let (d, t2) = (other(rng, &[n, t]), t);
            let exclusive = halfwords(0xE850_0F00 | n << 16 | t << 12 | offset);
            let add = vec![0xF100 | t as u16, (t << 8) as u16 | 0x11];
            let store = halfwords(0xE840_0000 | n << 16 | t2 << 12 | d << 8 | offset);
            ([exclusive, add, store].concat(), at + SCRATCH)
        }
    };
    state[place(n)] = base;
    Case { code, state }
}

/// Returns a `PUSH` with a `POP` of as many registers, which restores the stack pointer.
pub fn stack(rng: &mut impl Rng) -> Case {
    let list = 1 + below(rng, 255);
    let mut other = 1 + below(rng, 255);
    while other.count_ones() != list.count_ones() {
        other = 1 + below(rng, 255);
    }
    Case { code: vec![(0xB400 | list) as u16, (0xBC00 | other) as u16], state: state(rng) }
}

/// Returns a `VLDR`, `VSTR`, `VLDM` or `VSTM`.
pub fn float(at: u32, rng: &mut impl Rng) -> Case {
    let mut state = state(rng);
    let (n, load, double) = (register(rng), below(rng, 2), below(rng, 2));
    let head = 0xEC00_0A00 | load << 20 | n << 16 | double << 8;
    let (code, base) = match below(rng, 2) {
        0 => {
            let (offset, up, d) = (below(rng, 256), below(rng, 2), below(rng, 16));
            let target = at + SCRATCH + 4 * below(rng, 8);
            let base = if up == 1 { target - 4 * offset } else { target + 4 * offset };
            (head | 1 << 24 | up << 23 | d << 12 | if double == 0 { below(rng, 2) << 22 } else { 0 } | offset, base)
        }
        _ => {
            let (count, d, before) = (2 * (1 + below(rng, 4)), below(rng, 12), below(rng, 2));
            let base = if before == 1 { at + SCRATCH + 4 * count } else { at + SCRATCH };
            let mode = if before == 1 { 1 << 24 | 1 << 21 } else { 1 << 23 | below(rng, 2) << 21 };
            (head | mode | d << 12 | count, base)
        }
    };
    state[place(n)] = base;
    Case { code: halfwords(code), state }
}
