//! Packing of DMA words: two converters share one transfer, so that they stay in step.
//!
//! The ADC pair writes `V` to the lower half-word and `I` to the upper one. A DAC pair takes its
//! first lane from the lower half-word and its second lane from the upper one.
//!
//! Two converters of an STM32 work like this (RM0440 21.4.30: the master's data is in the lower
//! half of `ADC_CDR`; 22.7.9, `DAC_DHR12RD`). Half-words that alternate in memory, `V` first, form
//! the same words on a little-endian processor.

use firmware::seam::block::{DriveBlock, SenseBlock};

/// Separates a block of words from the ADC pair into voltage and current.
#[inline]
pub fn sense<Place>(places: &[Place], read: impl Fn(&Place) -> u32, sense: &mut SenseBlock) {
    let SenseBlock { v, i, .. } = sense;
    for channel in [&mut *v, &mut *i] {
        if channel.len() != places.len() {
            // Cannot fail: the capacity is at least one block.
            let _ = channel.resize_default(places.len());
        }
    }
    let separate = |place: &Place| {
        let word = read(place);
        (word as u16, (word >> 16) as u16)
    };
    let four = |[p0, p1, p2, p3]: &[Place; 4], [v0, v1, v2, v3]: &mut [u16; 4], [i0, i1, i2, i3]: &mut [u16; 4]| {
        (*v0, *i0) = separate(p0);
        (*v1, *i1) = separate(p1);
        (*v2, *i2) = separate(p2);
        (*v3, *i3) = separate(p3);
    };
    let ((fours, rest), (v_fours, v_rest), (i_fours, i_rest)) =
        (places.as_chunks::<4>(), v.as_chunks_mut::<4>(), i.as_chunks_mut::<4>());
    let ((places, fours), (v, v_fours), (i, i_fours)) =
        (fours.as_chunks::<4>(), v_fours.as_chunks_mut::<4>(), i_fours.as_chunks_mut::<4>());
    // Unrolled to sixteen by hand: a compiler that optimizes for size does not unroll this loop.
    for (([p0, p1, p2, p3], [v0, v1, v2, v3]), [i0, i1, i2, i3]) in places.iter().zip(v).zip(i) {
        four(p0, v0, i0);
        four(p1, v1, i1);
        four(p2, v2, i2);
        four(p3, v3, i3);
    }
    for ((places, v), i) in fours.iter().zip(v_fours).zip(i_fours) {
        four(places, v, i);
    }
    for ((place, v), i) in rest.iter().zip(v_rest).zip(i_rest) {
        (*v, *i) = separate(place);
    }
}

/// Writes lanes `2 * pair` and `2 * pair + 1` as words for a DAC pair.
///
/// The first `AHEAD` words go to `head` and the others to `tail`
/// ([`Half::played`](crate::half::Half::played)). A missing lane, or one of another length, is
/// replaced by silence.
#[inline]
pub fn drive<const AHEAD: usize, Place>(
    block: &DriveBlock,
    pair: usize,
    silence: u16,
    (head, tail): (&[Place; AHEAD], &[Place]),
    put: impl Fn(&Place, u32),
) {
    let lane = |number: usize| {
        let codes = block.lanes.get(number).filter(|codes| codes.len() == tail.len() + AHEAD);
        codes.and_then(|codes| codes.split_first_chunk::<AHEAD>())
    };
    match (lane(2 * pair), lane(2 * pair + 1)) {
        (Some((first, firsts)), Some((second, seconds))) => {
            for ((place, first), second) in head.iter().zip(first).zip(second) {
                put(place, word(*first, *second));
            }
            let four = |[p0, p1, p2, p3]: &[Place; 4], [a0, a1, a2, a3]: &[u16; 4], [b0, b1, b2, b3]: &[u16; 4]| {
                put(p0, word(*a0, *b0));
                put(p1, word(*a1, *b1));
                put(p2, word(*a2, *b2));
                put(p3, word(*a3, *b3));
            };
            let ((fours, rest), (firsts, first_rest)) = (tail.as_chunks::<4>(), firsts.as_chunks::<4>());
            let (seconds, second_rest) = seconds.as_chunks::<4>();
            let ((places, fours), (firsts, first_fours)) = (fours.as_chunks::<4>(), firsts.as_chunks::<4>());
            let (seconds, second_fours) = seconds.as_chunks::<4>();
            // Unrolled to sixteen by hand: a compiler that optimizes for size does not unroll this
            // loop.
            for (([p0, p1, p2, p3], [a0, a1, a2, a3]), [b0, b1, b2, b3]) in places.iter().zip(firsts).zip(seconds) {
                four(p0, a0, b0);
                four(p1, a1, b1);
                four(p2, a2, b2);
                four(p3, a3, b3);
            }
            for ((places, firsts), seconds) in fours.iter().zip(first_fours).zip(second_fours) {
                four(places, firsts, seconds);
            }
            for ((place, first), second) in rest.iter().zip(first_rest).zip(second_rest) {
                put(place, word(*first, *second));
            }
        }
        (Some((first, firsts)), None) => {
            head.iter().zip(first).for_each(|(place, first)| put(place, word(*first, silence)));
            let four = |[p0, p1, p2, p3]: &[Place; 4], [a0, a1, a2, a3]: &[u16; 4]| {
                put(p0, word(*a0, silence));
                put(p1, word(*a1, silence));
                put(p2, word(*a2, silence));
                put(p3, word(*a3, silence));
            };
            let ((fours, rest), (firsts, first_rest)) = (tail.as_chunks::<4>(), firsts.as_chunks::<4>());
            let ((places, fours), (firsts, first_fours)) = (fours.as_chunks::<4>(), firsts.as_chunks::<4>());
            for ([p0, p1, p2, p3], [a0, a1, a2, a3]) in places.iter().zip(firsts) {
                four(p0, a0);
                four(p1, a1);
                four(p2, a2);
                four(p3, a3);
            }
            for (places, firsts) in fours.iter().zip(first_fours) {
                four(places, firsts);
            }
            for (place, first) in rest.iter().zip(first_rest) {
                put(place, word(*first, silence));
            }
        }
        _ => fill(head.iter().chain(tail), word(silence, silence), put),
    }
}

/// Writes the same word to every place.
#[cold]
#[inline(never)]
fn fill<'a, Place: 'a>(places: impl Iterator<Item = &'a Place>, word: u32, put: impl Fn(&Place, u32)) {
    places.for_each(|place| put(place, word));
}

/// Packs two codes into one word.
#[inline]
pub const fn word(first: u16, second: u16) -> u32 {
    (second as u32) << 16 | first as u32
}
