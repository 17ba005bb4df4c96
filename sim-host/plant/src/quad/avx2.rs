//! Registers of 256 bits of an x86-64 processor with AVX2.

use std::arch::x86_64::{__m256d, __m256i, _CMP_EQ_OQ, _CMP_LT_OQ};

use pulp::x86::V3;
use pulp::{Simd, WithSimd, cast};

use super::four::Registers;
use super::{Kernel, LANES, Quad};

/// A kernel to be run in these registers.
pub(super) struct In<W>(pub(super) V3, pub(super) W);

impl<W: Kernel> WithSimd for In<W> {
    type Output = W::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> W::Output {
        self.1.with(self.0)
    }
}

impl Registers for V3 {
    type Numbers = __m256d;
    type Words = __m256i;

    #[inline(always)]
    fn load(self, quad: Quad) -> __m256d {
        cast(quad.0)
    }
    #[inline(always)]
    fn store(self, numbers: __m256d) -> Quad {
        Quad(cast(numbers))
    }
    #[inline(always)]
    fn add(self, a: __m256d, b: __m256d) -> __m256d {
        self.avx._mm256_add_pd(a, b)
    }
    #[inline(always)]
    fn sub(self, a: __m256d, b: __m256d) -> __m256d {
        self.avx._mm256_sub_pd(a, b)
    }
    #[inline(always)]
    fn mul(self, a: __m256d, b: __m256d) -> __m256d {
        self.avx._mm256_mul_pd(a, b)
    }
    #[inline(always)]
    fn abs(self, a: __m256d) -> __m256d {
        self.avx._mm256_andnot_pd(self.avx._mm256_set1_pd(-0.0), a)
    }
    #[inline(always)]
    fn larger(self, a: __m256d, b: __m256d) -> __m256d {
        self.avx._mm256_max_pd(a, b)
    }
    #[inline(always)]
    fn smaller(self, a: __m256d, b: __m256d) -> __m256d {
        self.avx._mm256_min_pd(a, b)
    }
    #[inline(always)]
    fn are_below(self, a: __m256d, b: __m256d) -> bool {
        self.avx._mm256_movemask_pd(self.avx._mm256_cmp_pd::<_CMP_LT_OQ>(a, b)) == 0b1111
    }
    #[inline(always)]
    fn any_equal(self, a: __m256d, b: __m256d) -> bool {
        self.avx._mm256_movemask_pd(self.avx._mm256_cmp_pd::<_CMP_EQ_OQ>(a, b)) != 0
    }
    #[inline(always)]
    fn truncated(self, a: __m256d) -> [i32; LANES] {
        cast(self.avx._mm256_cvttpd_epi32(a))
    }

    #[inline(always)]
    fn words(self, words: [u64; LANES]) -> __m256i {
        cast(words)
    }
    #[inline(always)]
    fn array(self, words: __m256i) -> [u64; LANES] {
        cast(words)
    }
    #[inline(always)]
    fn wrapping_sum(self, a: __m256i, b: __m256i) -> __m256i {
        self.avx2._mm256_add_epi64(a, b)
    }
    #[inline(always)]
    fn xor(self, a: __m256i, b: __m256i) -> __m256i {
        self.avx2._mm256_xor_si256(a, b)
    }
    #[inline(always)]
    fn left<const BITS: i32>(self, a: __m256i) -> __m256i {
        self.avx2._mm256_slli_epi64::<BITS>(a)
    }
    #[inline(always)]
    fn right<const BITS: i32>(self, a: __m256i) -> __m256i {
        self.avx2._mm256_srli_epi64::<BITS>(a)
    }
    #[inline(always)]
    fn numbers(self, bits: __m256i) -> __m256d {
        self.avx._mm256_castsi256_pd(bits)
    }
}
