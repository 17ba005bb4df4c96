//! The sine at compile time, for tables.

/// `(sin, cos)` of `turns` turns, in 0 to 1 and a little beyond: Taylor series of the angle folded into an eighth of a turn either
/// side of zero; the last term is below 1e-19.
pub const fn sine_and_cosine(turns: f64) -> (f64, f64) {
    // The nearest quarter turn, and what remains.
    let quarter = (4.0 * turns + 0.5) as i64;
    let x = core::f64::consts::TAU * (turns - 0.25 * quarter as f64);
    let (sin, cos) = (series(x, 1), series(x, 0));
    match quarter & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// `x^first / first! - x^(first + 2) / (first + 2)! + ...`.
const fn series(x: f64, first: u32) -> f64 {
    let mut term = if first == 0 { 1.0 } else { x };
    let mut sum = term;
    let mut k = first;
    while k < 18 {
        term = -term * x * x / ((k + 1) * (k + 2)) as f64;
        sum += term;
        k += 2;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_libm() {
        for n in 0..=4096 {
            let turns = f64::from(n) / 4096.0;
            let (sin, cos) = sine_and_cosine(turns);
            let angle = core::f64::consts::TAU * turns;
            // Both round the angle: a few units in the last place of 2 pi.
            assert!((sin - libm::sin(angle)).abs() < 2e-15 && (cos - libm::cos(angle)).abs() < 2e-15, "{n}");
        }
    }
}
