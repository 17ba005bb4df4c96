//! ON windows that a scene commands; they are not necessarily played.

use scene::{Burst, Driven};

/// Returns the first ON window, from and to in seconds, that begins after a time.
pub fn first_window(burst: &Burst, after_s: f64) -> Option<(f64, f64)> {
    if let (Some(period_s), Some(duty)) = (burst.period_s, burst.duty) {
        let on_s = period_s * ((after_s / period_s).floor() + 1.0);
        return Some((on_s, on_s + duty * period_s));
    }
    burst.on_s.iter().copied().zip(burst.off_s.iter().copied()).find(|window| window.0 > after_s)
}

/// Returns the first ON window of a scene, from and to in seconds, that begins after a time, with
/// the delay of its trigger.
pub fn first_on(scene: &Driven, after_s: f64) -> Option<(f64, f64)> {
    let delay_s = scene.trigger_delay_s();
    let (on_s, off_s) = first_window(scene.controller.burst.as_ref()?, after_s - delay_s)?;
    Some((on_s + delay_s, off_s + delay_s))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_listed_or_repeat() {
        let listed = Burst { on_s: vec![0.0, 2.0], off_s: vec![1.0, 3.0], ..Burst::default() };
        assert_eq!((first_window(&listed, 0.5), first_window(&listed, 2.5)), (Some((2.0, 3.0)), None));
        let repeated = Burst { period_s: Some(0.5), duty: Some(0.5), ..Burst::default() };
        assert_eq!(first_window(&repeated, 1.1), Some((1.5, 1.75)));
    }
}
