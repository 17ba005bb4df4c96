//! try
use sim_host::run::{Watch, run};
fn main() {
    let text = std::fs::read_to_string(std::env::args().nth(1).unwrap()).unwrap();
    let scene: sim_host::scene::Scene = toml::from_str(&text).unwrap();
    let r = run(&scene, Watch::default()).unwrap();
    println!("wall {} ratio {}", r.wall_s, scene.duration_s / r.wall_s);
    println!("{:?}\n{:?}", r.last, r.energy);
    println!("residual {}", r.energy.residual());
    let mut last = None;
    for row in &r.rows {
        if Some((row.mode, row.fault)) != last {
            println!(
                "{:.6} {:?} {} f {:.2} est {:.2} fs {:.2} F {:.4}",
                row.time_s,
                row.mode,
                row.fault,
                row.frequency_hz,
                row.resonance_estimate_hz,
                row.truth.series_resonance_hz,
                row.truth.friction_mean_n
            );
            last = Some((row.mode, row.fault));
        }
    }
    let mean = |a: f64, b: f64| {
        let v: Vec<f64> = r.rows.iter().filter(|x| x.time_s > a && x.time_s < b).map(|x| x.truth.friction_mean_n).collect();
        v.iter().sum::<f64>() / v.len() as f64
    };
    println!("off {} on {} red {}", mean(2.0, 3.0), mean(3.02, 5.0), 1.0 - mean(3.02, 5.0) / mean(2.0, 3.0));
    for row in r.rows.iter().filter(|x| x.time_s > 3.0 - 1e-4).step_by(4).take(40) {
        println!(
            "{:.5} f {:.3} v {:.3} tip {:.4} Im {:.4} ph {:.2} true ph {:.2}",
            row.time_s,
            row.frequency_hz,
            row.drive_v,
            row.truth.tip_velocity_m_per_s,
            row.motional_current_a,
            row.phase_deg,
            row.truth.motional_phase_deg
        );
    }
}
