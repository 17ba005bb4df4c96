//! scratch
use sonoglide_import::synthetic::Example;
fn main() {
    for i in std::env::args().skip(1).map(|a| a.parse::<u64>().unwrap()) {
        let e = Example::draw(i);
        println!("{:?}\n{} .. {} n {} {:?} q {}", e.truth, e.hz[0], e.hz[e.hz.len()-1], e.hz.len(), e.noise, e.options.series_ohm);
        std::fs::write(format!("/tmp/ex{i}-{}", e.name), &e.bytes).unwrap();
        for m in [None, Some(1), Some(2), Some(3)] {
            let mut o = e.clone(); o.options.modes = m;
            match o.import() { Ok(a) => println!("{m:?} {:?} corr {} {:?}", a.equivalent, a.correlation, a.noise), Err(x) => println!("{m:?} {x}") }
        }
    }
}
