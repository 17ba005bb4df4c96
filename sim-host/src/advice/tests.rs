use super::case::*;
use super::*;
use crate::scene::load::load;

#[test]
fn explore() {
    for (hz, q, c0, lm, v) in [
        (40e3, 20.0, 300e-9, 0.7916e-3, 3.0),
        (40e3, 65.0, 300e-9, 0.7916e-3, 3.0),
        (40e3, 200.0, 300e-9, 0.7916e-3, 3.0),
        (40e3, 500.0, 300e-9, 0.7916e-3, 3.0),
        (20e3, 1592.0, 300e-9, 1.5832e-3, 0.5),
    ] {
        let began = std::time::Instant::now();
        let case = Case::of(
            &load("lock-cold", &[]).unwrap(),
            Some(Numbers { frequency_hz: hz, q, c0_f: c0, lm_h: lm }),
            &Wishes { volts: Some(v), ..Wishes::default() },
        )
        .unwrap();
        let (mut advice, advised) = advise(&case).unwrap();
        println!("{q} {:?}", began.elapsed());
        advice.verified = Some(super::verification::verify(&advised, 100, &mut |_| ()).unwrap());
        for t in table::tables(&advice) {
            println!("{}", t.title);
            for r in t.rows {
                println!("   {}", r.join(" | "));
            }
            println!("{}", t.caption);
        }
        println!("{:?}\n{}{:?}", advice.warnings, advice.settings.snippet, began.elapsed());
    }
}
