//! scratch
use sonoglide_import::synthetic::{Example, NAMES};
fn main() {
    let n: u64 = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(600);
    let verbose = std::env::args().nth(2).is_some();
    let mut within = [0usize; 8];
    let mut ratios: Vec<Vec<f64>> = vec![vec![]; 8];
    let mut zs: Vec<Vec<f64>> = vec![vec![]; 8];
    let (mut ok, mut wrong) = (0, vec![]);
    let start = std::time::Instant::now();
    for i in 0..n {
        let e = Example::draw(i);
        match e.import() {
            Err(x) => wrong.push(format!("{i} {:?} modes {} noise {:.1e}: {x}", e.kind, e.truth.branches.len(), e.noise.first)),
            Ok(a) => {
                ok += 1;
                let c = a.circuit;
                let v = [c.series_resonance_hz, c.parallel_resonance_hz, c.q, c.rm_ohm, c.lm_h, c.cm_f, c.c0_f, c.coupling];
                let (t, b) = (e.true_values(), e.bounds().unwrap());
                let mut worst: f64 = 0.0;
                for k in 0..8 {
                    let z = (v[k].value - t[k]) / v[k].sd;
                    zs[k].push(z);
                    worst = worst.max(z.abs());
                    within[k] += (z.abs() <= 2.0) as usize;
                    ratios[k].push(v[k].sd / b[k]);
                }
                if verbose && (worst > 3.5 || a.modes.len() != e.truth.branches.len()) {
                    println!("{i} {:?} worst {worst:.1} modes {}/{} corr {:.2} infl {:.2} ratio {:.2} {} noise {:?}", e.kind, a.modes.len(), e.truth.branches.len(), a.correlation, a.inflation, v[0].sd / b[0], e.hz.len(), e.noise); for k in 0..8 { println!("      {} {:.7e} {:.2e} z {:.2} ratio {:.2}", NAMES[k], t[k], v[k].sd, (v[k].value-t[k])/v[k].sd, v[k].sd/b[k]); } println!("{:?} {:?}", e.truth, a.equivalent);
                }
            }
        }
    }
    println!("{ok} ok, {} failed, {:?}", wrong.len(), start.elapsed());
    for w in &wrong { println!("  {w}"); }
    for k in 0..8 {
        ratios[k].sort_by(f64::total_cmp);
        let m = ratios[k][ratios[k].len() / 2];
        println!("{:24} {:.1} %  median ratio {m:.3} p95 {:.2} rmsz {:.2}", NAMES[k], 100.0 * within[k] as f64 / ok as f64, ratios[k][ratios[k].len() * 95 / 100], (zs[k].iter().map(|z| z*z).sum::<f64>()/ok as f64).sqrt());
    }
}
