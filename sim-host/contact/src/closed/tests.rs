//! Comparison with 16-digit values, with another kind of quadrature, and with exact properties.

use std::f64::consts::{FRAC_2_PI, PI, TAU};

use super::gauss::HALF_RULES;
use super::*;

/// 1 - 2^-30.
const NEAR_ONE: f64 = 1.0 - 1.0 / 1_073_741_824.0;

/// Velocity ratio, kappa, friction ratio, power ratio: computed with mpmath in 40 to 60 digits,
/// rounded to f64, from the two-exponential form
///
/// r = [2 ta + (f0 - 1) I1 - (2 pi - 2 ta) + (f1 + 1) I2] / (2 pi),
/// phi = [S+ + (f0 - 1)(1 - a) / kappa + S- - (f1 + 1)(1 - b) / kappa] / (2 pi xi),
///
/// ta = pi - acos xi, S+ = 2 (xi ta + sin ta), S- = S+ - 2 pi xi, a = exp(-kappa S+), b =
/// exp(-kappa S-), f1 = (1 - 2 a + a b) / (1 - a b), f0 = -1 + 2 b (1 - a) / (1 - a b), I1 and I2
/// the integrals of exp(-kappa slip) over the phase.
#[rustfmt::skip]
const DIGITS: [(f64, f64, f64, f64); 35] = [
    (0.001, 1e-6, 0.001_570_795_541_396_554_8, 0.001_570_795_753_602_922_3),
    (0.001, 0.40452, 0.001_493_692_023_985_424_8, 32.594_475_946_630_44),
    (0.001, 4.0, 0.000_708_922_673_808_982_2, 477.571_900_851_795_76),
    (0.001, 20.0, 0.000_647_684_663_484_357_4, 604.789_102_059_115),
    (0.001, 100.0, 0.000_638_759_145_314_305_3, 630.253_892_953_818_2),
    (0.001, 1e4, 0.000_636_641_100_849_099_5, 636.556_428_700_257_2),
    (0.001, 1e12, 0.000_636_619_878_471_136_7, 636.620_090_676_857_4),
    (0.1, 1e-6, 0.156_297_492_017_314_88, 0.156_297_492_019_414_5),
    (0.1, 0.40452, 0.148_749_769_872_655_62, 0.471_150_551_278_565_03),
    (0.1, 4.0, 0.071_159_087_787_653_58, 4.808_453_854_101_476),
    (0.1, 20.0, 0.064_887_050_282_695_91, 6.079_745_431_868_925),
    (0.1, 100.0, 0.063_984_677_119_348_24, 6.334_393_340_815_957),
    (0.1, 1e4, 0.063_770_704_533_738_1, 6.397_418_698_280_347),
    (0.1, 1e12, 0.063_768_560_858_541_28, 6.398_055_318_046_349),
    (0.5, 1e-6, 0.696_383_134_382_518_1, 0.696_383_134_382_820_6),
    (0.5, 0.40452, 0.674_948_643_034_450_1, 0.721_105_815_505_136_7),
    (0.5, 4.0, 0.398_152_242_832_815_4, 1.138_246_748_365_870_7),
    (0.5, 20.0, 0.340_923_294_104_370_9, 1.372_329_218_607_34),
    (0.5, 100.0, 0.334_766_402_947_453_13, 1.423_258_728_729_565_7),
    (0.5, 1e4, 0.333_347_482_230_692_77, 1.435_863_800_222_444),
    (0.5, 1e12, 0.333_333_333_333_474_8, 1.435_991_124_175_644_2),
    (0.9, 1e-6, 0.979_243_521_610_679_1, 0.979_243_521_610_703_2),
    (0.9, 0.40452, 0.975_847_155_027_002_4, 0.979_423_352_680_561_9),
    (0.9, 4.0, 0.916_263_747_143_156_7, 0.983_502_068_470_423_1),
    (0.9, 20.0, 0.801_565_449_097_947_8, 0.996_495_841_046_912_8),
    (0.9, 100.0, 0.724_625_823_398_304_7, 1.014_140_542_904_556_7),
    (0.9, 1e4, 0.712_968_038_766_330_1, 1.021_125_706_346_786),
    (0.9, 1e12, 0.712_867_413_743_592_6, 1.021_196_441_876_341_7),
    (NEAR_ONE, 1e-6, 0.999_999_999_999_982_9, 0.999_999_999_999_982_9),
    (NEAR_ONE, 0.40452, 0.999_999_999_999_979_8, 0.999_999_999_999_982_9),
    (NEAR_ONE, 4.0, 0.999_999_999_999_928_4, 0.999_999_999_999_982_9),
    (NEAR_ONE, 20.0, 0.999_999_999_999_794_3, 0.999_999_999_999_982_9),
    (NEAR_ONE, 100.0, 0.999_999_999_999_401_9, 0.999_999_999_999_982_9),
    (NEAR_ONE, 1e4, 0.999_999_999_987_15, 0.999_999_999_999_982_9),
    (NEAR_ONE, 1e12, 0.999_997_124_741_496_5, 0.999_999_999_999_983_8),
];

#[test]
fn sixteen_digits() {
    let (mut worst_friction, mut worst_power) = (0.0f64, 0.0f64);
    for (xi, kappa, friction, power) in DIGITS {
        worst_friction = worst_friction.max((friction_ratio(xi, kappa) - friction).abs());
        worst_power = worst_power.max((power_ratio(xi, kappa).unwrap() / power - 1.0).abs());
    }
    println!("worst friction {worst_friction:e}, power {worst_power:e} (relative)");
    assert!(worst_friction < 1e-15 && worst_power < 3e-15, "{worst_friction:e} {worst_power:e}");
}

/// Table of the thesis's contact, kappa = 0.404517: friction computed in 40 digits, printed to
/// nine.
#[test]
fn thesis_contact() {
    let kappa = crate::table_4_1::table_4_1(0.5, 1.0).kappa();
    let table =
        [0.148749778, 0.293831556, 0.431811610, 0.559678336, 0.674948667, 0.775674567, 0.860340906, 0.927626168, 0.975847159];
    for (step, ratio) in (1..).zip(table) {
        let got = friction_ratio(0.1 * f64::from(step), kappa);
        assert!((got - ratio).abs() < 6e-10, "{step}: {got} {ratio}");
    }
    let power = [0.471150, 0.449643, 0.529512, 0.626244, 0.721106, 0.806847, 0.879849, 0.937972, 0.979423];
    for (step, ratio) in (1..).zip(power) {
        let got = power_ratio(0.1 * f64::from(step), kappa).unwrap();
        assert!((got - ratio).abs() < 6e-7, "{step}: {got} {ratio}");
    }
}

/// Computes the mean over a steady period by the tanh-sinh rule (Takahasi and Mori 1974) over each
/// stroke, independent of the exponent.
fn tanh_sinh_mean(xi: f64, kappa: f64, of: impl Fn(f64, f64) -> f64) -> f64 {
    let steady = Steady::new(xi, kappa);
    let turn = PI - xi.acos();
    let step = 1.0 / 64.0;
    let over = |from: f64, to: f64| -> f64 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let sum: f64 = (-230..=230)
            .map(|i| {
                let t = f64::from(i) * step;
                let u = 0.5 * PI * t.sinh();
                let weight = 0.5 * PI * t.cosh() / u.cosh().powi(2);
                let p = middle + half * u.tanh();
                weight * of(steady.force(p / TAU), p)
            })
            .sum();
        half * step * sum
    };
    (over(-turn, 0.0) + over(0.0, turn) + over(turn, PI) + over(PI, TAU - turn)) / TAU
}

#[test]
fn another_quadrature_agrees() {
    let (mut worst, mut worst_input) = (0.0f64, 0.0f64);
    for xi in [1e-4, 0.03, 0.1, 0.37, 0.5, 0.77, 0.93, 0.999] {
        for kappa in [1e-9, 1e-3, 0.1, 0.3, 0.7, 1.5, 3.0, 7.0, 12.0, 35.0, 200.0, 1e4, 1e6, 1e8] {
            let other = tanh_sinh_mean(xi, kappa, |force, _| force);
            worst = worst.max((friction_ratio(xi, kappa) - other).abs());
            let other = tanh_sinh_mean(xi, kappa, |force, p| force * p.cos());
            worst_input = worst_input.max((input_ratio(xi, kappa).unwrap() * xi - other).abs());
        }
    }
    println!("worst friction {worst:e}, input {worst_input:e} (of Fc Vv)");
    assert!(worst < 3e-15 && worst_input < 3e-15, "{worst:e} {worst_input:e}");
}

/// Power from the elementary form, friction and input by two quadratures: phi = r + phi_iu, kappa
/// from 1e-12 to 1e12.
#[test]
fn energy_closes_at_every_kappa() {
    let mut worst = 0.0f64;
    for i in 1..=200 {
        let xi = f64::from(i) / 201.0;
        for j in 0..=120 {
            let kappa = 10f64.powf(f64::from(j) * 0.2 - 12.0);
            let residual = power_ratio(xi, kappa).unwrap() - friction_ratio(xi, kappa) - input_ratio(xi, kappa).unwrap();
            worst = worst.max((residual * xi).abs());
        }
    }
    println!("worst residual {worst:e} of Fc Vv");
    assert!(worst < 3e-15, "{worst:e}");
}

/// Compares each rule with the one of 20 nodes, at the largest exponent for which it is used.
#[test]
fn node_counts_suffice() {
    for (nodes, exponent) in HALF_RULES.into_iter().take(6) {
        let mut worst = 0.0f64;
        for xi in [0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 0.9999] {
            // kappa at which the forward exponent is the largest one allowed
            let kappa = exponent * (1.0 - 1e-12) / Stroke::both(xi, 1.0)[0].exponent();
            let of = |stroke: &Stroke| (stroke.integral(), stroke.integral_by(f64::INFINITY));
            for (few, many) in Stroke::both(xi, kappa).map(|stroke| of(&stroke)) {
                worst = worst.max((few - many).abs());
            }
        }
        println!("{nodes} nodes up to A = {exponent}: {worst:e}");
        assert!(worst < 1e-14, "{nodes}: {worst:e}");
    }
}

#[test]
fn limits() {
    for xi in [1e-3, 0.2, 0.5, 0.8, 0.99] {
        assert!((friction_ratio(xi, 0.0) - limit_ratio(xi)).abs() < 1e-16);
        assert!((friction_ratio(xi, 2e-17) - limit_ratio(xi)).abs() < 5e-16);
        assert!((power_ratio(xi, 2e-17).unwrap() / limit_ratio(xi) - 1.0).abs() < 2e-15);
        assert!((friction_ratio(xi, 1e30) - coulomb_friction_ratio(xi)).abs() < 5e-16);
        assert!((power_ratio(xi, 1e30).unwrap() / coulomb_power_ratio(xi).unwrap() - 1.0).abs() < 5e-16);
        // Layer of thickness 1 / kappa after each reversal: at xi = 0.5, r - 1/3 tends to 0.1415 /
        // kappa.
        let layer = |kappa: f64| kappa * (friction_ratio(xi, kappa) - coulomb_friction_ratio(xi));
        assert!((layer(1e7) / layer(2e7) - 1.0).abs() < 5e-5, "{xi}: {} {}", layer(1e7), layer(2e7));
    }
    for kappa in [0.0, 0.4, 1e6, f64::INFINITY] {
        for xi in [1.0, 1.5, 1e9] {
            assert_eq!((friction_ratio(xi, kappa), friction_ratio(-xi, kappa)), (1.0, -1.0));
            assert_eq!((power_ratio(xi, kappa), input_ratio(xi, kappa)), (Some(1.0), Some(0.0)));
        }
        assert_eq!(friction_ratio(0.0, kappa), 0.0);
        assert_eq!((power_ratio(0.0, kappa), input_ratio(0.0, kappa)), (None, None));
    }
    assert!(
        friction_ratio(0.5, -1.0).is_nan() && friction_ratio(f64::NAN, 1.0).is_nan() && friction_ratio(0.5, f64::NAN).is_nan()
    );
    assert!((coulomb_power_ratio(0.5).unwrap() - FRAC_2_PI * (PI / 6.0 + 3.0f64.sqrt())).abs() < 1e-15);
}
