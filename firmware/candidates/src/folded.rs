//! No table: the phase is folded to within an eighth of a turn of the nearest quarter turn, where two short polynomials give sine and
//! cosine; the quarter says which is which, and their signs.
//!
//! Coefficients: Remez exchange for the least largest error of `sin(pi u / 4)` and `cos(pi u / 4)`, `|u| <= 1`. The largest errors are
//! those of the cosine, `1.0e-5` (degrees 5 and 4), `2.8e-8` (7 and 6) and `4.7e-11` (9 and 8): the last two are below what f32 rounds.

use crate::generator::{Generator, Pair};

/// The nearest quarter turn (modulo 4), and what is left from it, `2^29` an eighth of a turn.
#[inline]
fn fold(phase: u64) -> (u32, i32) {
    let phase = (phase >> 32) as u32;
    let quarter = phase.wrapping_add(1 << 29) >> 30;
    (quarter, phase.wrapping_sub(quarter << 30) as i32)
}

/// A value with the sign turned where `bit` is set.
#[inline]
fn turned(value: f32, bit: u32) -> f32 {
    f32::from_bits(value.to_bits() ^ (bit << 31))
}

/// Coefficients in single precision.
const fn single<const N: usize>(coefficients: [f64; N]) -> [f32; N] {
    let mut rounded = [0.0; N];
    let mut n = 0;
    while n < N {
        rounded[n] = coefficients[n] as f32;
        n += 1;
    }
    rounded
}

/// `((c3 x + c2) x + c1) x + c0`, of any length.
#[inline]
fn horner<const N: usize>(coefficients: &[f32; N], x: f32) -> f32 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

#[inline]
fn folded<const N: usize>(sine: &[f32; N], cosine: &[f32; N], phase: u64) -> Pair<f32> {
    let (quarter, rest) = fold(phase);
    let u = rest as f32 * (1.0 / (1u32 << 29) as f32);
    let (s, c) = (u * horner(sine, u * u), horner(cosine, u * u));
    let (sin, cos) = if quarter & 1 == 0 { (s, c) } else { (c, s) };
    Pair { sin: turned(sin, quarter >> 1), cos: turned(cos, quarter.wrapping_add(1) >> 1) }
}

/// Sine of degree 5, cosine of degree 4.
pub struct Degree5;

impl Generator for Degree5 {
    type Number = f32;
    const ONE: f64 = 1.0;
    const NAME: &'static str = "polynomial 5";
    const FAMILY: &'static str = "polynomials of degree 5, 7, 9";
    const HOW: &'static str = "folded, degrees 5 and 4";

    #[inline]
    fn pair(phase: u64) -> Pair<f32> {
        const SINE: [f32; 3] = single([0.785_394_234_491, -0.080_713_998_773, 0.002_427_106_051]);
        const COSINE: [f32; 3] = single([0.999_990_034_959, -0.308_245_103_867, 0.015_371_815_135]);
        folded(&SINE, &COSINE, phase)
    }
}

/// Sine of degree 7, cosine of degree 6.
pub struct Degree7;

impl Generator for Degree7 {
    type Number = f32;
    const ONE: f64 = 1.0;
    const NAME: &'static str = "polynomial 7";
    const FAMILY: &'static str = "polynomials of degree 5, 7, 9";
    const HOW: &'static str = "folded, degrees 7 and 6";

    #[inline]
    fn pair(phase: u64) -> Pair<f32> {
        const SINE: [f32; 4] = single([0.785_398_152_543, -0.080_745_367_271, 0.002_489_871_968, -3.587_725_85e-5]);
        const COSINE: [f32; 4] = single([0.999_999_972_423, -0.308_424_253_562, 0.015_849_915_257, -3.188_805_084e-4]);
        folded(&SINE, &COSINE, phase)
    }
}

/// Sine of degree 9, cosine of degree 8.
pub struct Degree9;

impl Generator for Degree9 {
    type Number = f32;
    const ONE: f64 = 1.0;
    const NAME: &'static str = "polynomial 9";
    const FAMILY: &'static str = "polynomials of degree 5, 7, 9";
    const HOW: &'static str = "folded, degrees 9 and 8";

    #[inline]
    fn pair(phase: u64) -> Pair<f32> {
        const SINE: [f32; 5] =
            single([0.785_398_163_379, -0.080_745_511_815, 0.002_490_392_479, -3.657_141_767e-5, 3.085_634_17e-7]);
        const COSINE: [f32; 5] =
            single([0.999_999_999_953, -0.308_425_135_162, 0.015_854_325_246, -3.259_386_144e-4, 3.529_811_341e-6]);
        folded(&SINE, &COSINE, phase)
    }
}

/// The same in integers, degrees 7 and 6, Q30.
pub struct Integer;

impl Generator for Integer {
    type Number = i32;
    const ONE: f64 = (1u32 << 30) as f64;
    const NAME: &'static str = "polynomial 7, integer";
    const FAMILY: &'static str = "polynomial 7, integer";
    const HOW: &'static str = "folded, degrees 7 and 6, Q30";

    #[inline]
    fn pair(phase: u64) -> Pair<i32> {
        const SINE: [i32; 4] = [843_314_845, 86_699_678, 2_673_480, 38_523];
        const COSINE: [i32; 4] = [1_073_741_794, 331_168_021, 17_018_717, 342_395];
        let (quarter, rest) = fold(phase);
        // The high word of a product.
        let times = |a: i32, b: i32| ((i64::from(a) * i64::from(b)) >> 32) as i32;
        // Q31: an eighth of a turn itself would overflow. Its square is Q30, here less than zero: of a number that cannot be,
        // the compiler makes an unsigned product, which takes twice as long.
        let u = (rest << 2).max(-i32::MAX);
        let minus_square = -times(u, u);
        // Q30 times Q30 is Q28 in the high word.
        let horner = |c: &[i32; 4]| c.iter().rev().fold(0, |sum, c| (times(sum, minus_square) << 2) + c);
        // Q30 times Q31 is Q29.
        let (s, c) = (times(horner(&SINE), u) << 1, horner(&COSINE));
        let (sin, cos) = if quarter & 1 == 0 { (s, c) } else { (c, s) };
        let turned = |value: i32, bit: u32| {
            let mask = -((bit & 1) as i32);
            (value ^ mask) - mask
        };
        Pair { sin: turned(sin, quarter >> 1), cos: turned(cos, quarter.wrapping_add(1) >> 1) }
    }
}
